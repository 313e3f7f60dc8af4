//! Length of sub-apertures and spacing of coarse grids.

use super::aperture::{centre_m, partition_aperture};
use super::coarse::coarse_grid;
use super::interpolation::worst_error;
use crate::control::Control;
use crate::error::ImagingError;
use crate::grid::tilted::TiltedGrid;
use crate::kernel::merge::TAPS;
use crate::pulses::Pulses;
use crate::vector::{dot, norm};
use rayon::prelude::*;
use std::ops::Range;

/// Pulses of sub-apertures that are considered.
const COUNTS: [usize; 16] = [
    6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512, 768, 1024,
];

/// Greatest number of fine pixels in a coarse interval.
const COARSEST: usize = 64;

/// Partition of the aperture and spacing of the coarse grids.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FactorizedSpec {
    /// Pulses in a sub-aperture.
    pub pulses: usize,
    /// Fine pixels per coarse interval, along the row and across.
    pub coarse: [usize; 2],
    /// Bound of the spatial frequencies along the row and across, cycles/m.
    pub bandwidth_per_m: [f64; 2],
    /// Interpolation error expected for a spectrum that fills the bound.
    pub interpolation_error: f64,
    /// Estimated cost in vector operations a pixel and pulse.
    pub cost: f64,
}

impl FactorizedSpec {
    /// The cheapest partition that meets `demand`; `None` where coarse grids do not pay.
    ///
    /// # Errors
    /// Cancellation.
    pub fn choose(
        pulses: &Pulses,
        grid: &TiltedGrid,
        demand: &Demand,
        control: Control,
    ) -> Result<Option<Self>, ImagingError> {
        let mut best: Option<Self> = None;
        if grid.columns < 4 * TAPS || grid.rows < 4 * TAPS {
            return Ok(None);
        }
        // Vector operations as measured beside those of the direct engine; the second part is of loads that
        // cross cache lines.
        let merge = 75.0 / demand.lanes as f64 + 4.6;
        let pixels = |g: &TiltedGrid| (g.columns * g.rows) as f64;
        let mut last = Vec::new();
        // From the longest on: merging alone makes most of the short ones too dear.
        for count in COUNTS.into_iter().rev() {
            control.check()?;
            if count > 2 * pulses.len() {
                continue;
            }
            let parts = partition_aperture(pulses, count);
            let merging = merge * parts.len() as f64 / pulses.len() as f64;
            if best.is_some_and(|b| merging > b.cost) || parts == last {
                continue;
            }
            let bandwidth = bandwidth_per_m(pulses, grid, demand.band_hz, &parts);
            last = parts;
            let Some((coarse, error)) = coarsest_intervals(grid, bandwidth, demand.accuracy) else {
                // Sub-apertures of this length contain directions that not even the fine grid samples, and
                // longer ones contain more, though fewer of their pulses are looked at.
                best = None;
                continue;
            };
            let coarse_pixels = coarse_grid(grid, coarse);
            let share = pixels(&coarse_pixels) / pixels(grid);
            let cost = (demand.direct_cost)(&coarse_pixels) * share + merging;
            if best.is_none_or(|b| cost <= b.cost) {
                best = Some(Self {
                    pulses: count,
                    coarse,
                    bandwidth_per_m: bandwidth,
                    interpolation_error: error,
                    cost,
                });
            }
        }
        Ok(best)
    }
}

/// Requirements on a partition.
#[derive(Clone, Copy)]
pub(crate) struct Demand<'a> {
    /// Lowest, carrier and highest frequency, Hz.
    pub band_hz: [f64; 3],
    /// Relative error allowed.
    pub accuracy: f64,
    /// Vector operations of the direct engine per value and pulse on a coarse grid.
    pub direct_cost: &'a dyn Fn(&TiltedGrid) -> f64,
    /// Numbers in a vector.
    pub lanes: usize,
}

/// The longest intervals along and across rows, in fine pixels, that interpolate signals of the given
/// bandwidth, and their relative RMS error together; `None` where not even single pixels do.
fn coarsest_intervals(
    grid: &TiltedGrid,
    bandwidth: [f64; 2],
    accuracy: f64,
) -> Option<([usize; 2], f64)> {
    let steps = [norm(grid.u_m), norm(grid.v_m)];
    let mut coarse = [1; 2];
    let mut error = 0.0;
    for axis in 0..2 {
        let error_of = |d: usize| worst_error(bandwidth[axis] * steps[axis] * d as f64, d);
        // Longer intervals err more.
        let (mut longest, mut too_long) = (0, COARSEST + 1);
        while too_long - longest > 1 {
            let d = usize::midpoint(longest, too_long);
            if error_of(d) < 0.5 * accuracy {
                longest = d;
            } else {
                too_long = d;
            }
        }
        if longest == 0 {
            return None;
        }
        coarse[axis] = longest;
        error += error_of(longest).powi(2);
    }
    Some((coarse, f64::sqrt(error)))
}

/// Bound of the spatial frequencies of all sub-apertures along the grid's axes, from a lattice of
/// pixels that includes edges and those nearest to the sub-aperture; `band_hz` is lowest, carrier
/// and highest frequency.
fn bandwidth_per_m(
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
