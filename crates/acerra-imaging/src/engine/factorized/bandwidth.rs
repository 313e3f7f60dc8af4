//! Bandwidth of the images of sub-apertures.

use super::aperture::centre_m;
use crate::grid::terrain::Terrain;
use crate::grid::tilted::TiltedGrid;
use crate::pulses::Pulses;
use crate::vector::{dot, norm};
use rayon::prelude::*;
use std::cell::RefCell;
use std::ops::Range;

/// Cells of the lattice of pixels, per axis.
const LATTICE: usize = 12;
/// Places about a pixel of the lattice where slopes of the ground are computed, per axis.
const SLOPES: usize = 3;

/// Bound of the spatial frequencies of all sub-apertures along the grid's axes, cycles/m, from a lattice of
/// pixels that includes the edges and the pixels nearest to each sub-aperture; `band_hz` is lowest, carrier
/// and highest frequency. Frequencies are counted in the plane also where the ground is steep.
pub(crate) fn bandwidth_per_m(
    pulses: &Pulses,
    (grid, terrain): (&TiltedGrid, Terrain),
    [low, carrier, high]: [f64; 3],
    parts: &[Range<usize>],
) -> [f64; 2] {
    let scale = 2.0 / pulses.light_speed_m_s();
    let last = [grid.columns, grid.rows].map(|n| (n - 1) as f64);
    let at = |k: usize, axis: usize| last[axis] * k as f64 / LATTICE as f64;
    let whole: Vec<Facet> = (0..=LATTICE)
        .flat_map(|j| (0..=LATTICE).map(move |i| [i, j]))
        .map(|[i, j]| Facet::at(grid, terrain, [at(i, 0), at(j, 1)]))
        .collect();
    let found: Vec<[f64; 2]> = parts
        .par_iter()
        .map(|part| {
            let centre = centre_m(pulses, part.clone());
            // Directions change fastest under the antenna.
            let (i, j) = grid.nearest(centre, [0.0, last[0]], [0.0, last[1]]);
            let near = (-2..=2).flat_map(|dj| (-2..=2).map(move |di| [di, dj]));
            let near = near.map(|[di, dj]| {
                let at = |x: f64, d: i32, last: f64| {
                    (x + f64::from(d) * 0.5 * last / LATTICE as f64).clamp(0.0, last)
                };
                Facet::at(grid, terrain, [at(i, di, last[0]), at(j, dj, last[1])])
            });
            let stride = (part.len() / 6).max(1);
            let members: Vec<usize> = part.clone().step_by(stride).chain([part.end - 1]).collect();
            let mut most = [0f64; 2];
            for facet in whole.iter().copied().chain(near) {
                for axes in &facet.axes[..facet.kinds] {
                    let of_centre = facet.slopes(axes, centre).map(|slope| carrier * slope);
                    for &m in &members {
                        let slopes = facet.way_slopes(axes, pulses, m);
                        for axis in 0..2 {
                            let [low, high] =
                                [low, high].map(|f| f * slopes[axis] - of_centre[axis]);
                            most[axis] = most[axis].max(low.abs()).max(high.abs());
                        }
                    }
                }
            }
            most
        })
        .collect();
    [0, 1].map(|axis| 1.04 * scale * found.iter().map(|f| f[axis]).fold(0.0, f64::max))
}

/// Cache of the bandwidths on the image's grid, by the number of pulses of a sub-aperture.
#[derive(Debug, Default)]
pub(crate) struct Bandwidths(RefCell<Vec<(usize, [f64; 2])>>);

impl Bandwidths {
    /// The bandwidth of sub-apertures of `count` pulses, computed by `of` the first time.
    pub fn of(&self, count: usize, of: impl FnOnce() -> [f64; 2]) -> [f64; 2] {
        let known = self.0.borrow().iter().find(|k| k.0 == count).map(|k| k.1);
        known.unwrap_or_else(|| {
            let found = of();
            self.0.borrow_mut().push((count, found));
            found
        })
    }
}

/// The ground about a pixel.
#[derive(Debug, Clone, Copy)]
struct Facet {
    point_m: [f64; 3],
    /// Vectors along row and column, as [`Terrain::axes`] gives them: with the least slopes near the pixel,
    /// and with the greatest; a plane has only one pair.
    axes: [[[f64; 3]; 2]; 2],
    kinds: usize,
}

impl Facet {
    fn at(grid: &TiltedGrid, terrain: Terrain, [i, j]: [f64; 2]) -> Self {
        let axes = terrain.axes(grid, i, j);
        let mut facet = Self {
            point_m: terrain.near_m(grid, i, j),
            axes: [axes; 2],
            kinds: 1,
        };
        if !terrain.is_uneven() {
            return facet;
        }
        facet.kinds = 2;
        let last = [grid.columns, grid.rows].map(|n| (n - 1) as f64);
        let place = |x: f64, k: usize, last: f64| {
            let away = (k as f64 + 0.5) / SLOPES as f64 - 0.5;
            (x + away * last / LATTICE as f64).clamp(0.0, last)
        };
        for k in 0..SLOPES * SLOPES {
            let (i, j) = (place(i, k % SLOPES, last[0]), place(j, k / SLOPES, last[1]));
            let found = terrain.axes(grid, i, j);
            let [least, greatest] = &mut facet.axes;
            for (axis, found) in found.into_iter().enumerate() {
                if found[2] < least[axis][2] {
                    least[axis] = found;
                }
                if found[2] > greatest[axis][2] {
                    greatest[axis] = found;
                }
            }
        }
        facet
    }

    /// Slopes along the axes of half the two-way path from a pulse's transmitter to the pulse's receiver.
    fn way_slopes(&self, axes: &[[f64; 3]; 2], pulses: &Pulses, pulse: usize) -> [f64; 2] {
        if !pulses.is_bistatic() {
            return self.slopes(axes, pulses.position_m()[pulse]);
        }
        let [there, back] = pulses.antennas_m(pulse).map(|a| self.slopes(axes, a));
        [0, 1].map(|axis| 0.5 * (there[axis] + back[axis]))
    }

    /// Slopes along the axes of the range from `from_m`.
    fn slopes(&self, axes: &[[f64; 3]; 2], from_m: [f64; 3]) -> [f64; 2] {
        let d: [f64; 3] = std::array::from_fn(|a| self.point_m[a] - from_m[a]);
        let inverse = 1.0 / norm(d).max(1e-12);
        axes.map(|axis| dot(d, axis) * inverse)
    }
}
