//! Bandwidth of the images of sub-apertures.

use super::aperture::centre_m;
use crate::grid::tilted::TiltedGrid;
use crate::pulses::Pulses;
use crate::vector::{dot, norm};
use rayon::prelude::*;
use std::ops::Range;

/// Bound of the spatial frequencies of all sub-apertures along the grid's axes, from a lattice of
/// pixels that includes edges and those nearest to the sub-aperture; `band_hz` is lowest, carrier
/// and highest frequency.
pub(crate) fn bandwidth_per_m(
    pulses: &Pulses,
    grid: &TiltedGrid,
    [low, carrier, high]: [f64; 3],
    parts: &[Range<usize>],
) -> [f64; 2] {
    const LATTICE: usize = 12;
    let axes = [grid.u_m, grid.v_m].map(|v| v.map(|x| x / norm(v).max(1e-300)));
    let scale = 2.0 / pulses.light_speed_m_s();
    let found: Vec<[f64; 2]> = parts
        .par_iter()
        .map(|part| {
            let centre = centre_m(pulses, part.clone());
            let mut points = Vec::with_capacity((LATTICE + 1).pow(2) + 25);
            let (i1, j1) = ((grid.columns - 1) as f64, (grid.rows - 1) as f64);
            for j in 0..=LATTICE {
                for i in 0..=LATTICE {
                    let at = |k: usize, last: f64| last * k as f64 / LATTICE as f64;
                    points.push(grid.point_m(at(i, i1), at(j, j1)));
                }
            }
            // Directions change fastest under the antenna.
            let (i, j) = grid.nearest(centre, [0.0, i1], [0.0, j1]);
            for dj in -2..=2 {
                for di in -2..=2 {
                    let at = |x: f64, d: i32, last: f64| {
                        (x + f64::from(d) * 0.5 * last / LATTICE as f64).clamp(0.0, last)
                    };
                    points.push(grid.point_m(at(i, di, i1), at(j, dj, j1)));
                }
            }
            let stride = (part.len() / 6).max(1);
            let members: Vec<usize> = part.clone().step_by(stride).chain([part.end - 1]).collect();
            // Sines of the direction's angles from the normal planes of the axes.
            let sines = |from: [f64; 3], to: [f64; 3]| {
                let d: [f64; 3] = std::array::from_fn(|a| to[a] - from[a]);
                let inverse = 1.0 / norm(d).max(1e-12);
                axes.map(|axis| dot(d, axis) * inverse)
            };
            let mut most = [0f64; 2];
            for point in points {
                let of_centre = sines(centre, point).map(|sine| carrier * sine);
                for &m in &members {
                    let sines = sines(pulses.position_m()[m], point);
                    for axis in 0..2 {
                        let [low, high] = [low, high].map(|f| f * sines[axis] - of_centre[axis]);
                        most[axis] = most[axis].max(low.abs()).max(high.abs());
                    }
                }
            }
            most
        })
        .collect();
    [0, 1].map(|axis| 1.04 * scale * found.iter().map(|f| f[axis]).fold(0.0, f64::max))
}
