//! Length of sub-apertures and spacing of coarse grids.

use super::aperture::{centre_m, partition_aperture};
use super::cell::Cell;
use super::coarse::Coarse;
use super::interpolation::{TOO_FAST, widest_band, worst_error};
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

/// Partition of the aperture and spacing of the coarse grids.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FactorizedSpec {
    /// Pulses in a sub-aperture.
    pub pulses: usize,
    pub coarse: Coarse,
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
        let ways: Vec<Way> = demand
            .taps
            .iter()
            .map(|taps| Way::new(*taps, demand))
            .collect();
        let pixels = |g: &TiltedGrid| (g.columns * g.rows) as f64;
        let mut last = Vec::new();
        // From the longest on: merging alone makes most of the short ones too dear.
        for count in COUNTS.into_iter().rev() {
            control.check()?;
            if count > 2 * pulses.len() {
                continue;
            }
            let parts = partition_aperture(pulses, count);
            let merges = parts.len() as f64 / pulses.len() as f64;
            let least = ways
                .iter()
                .map(|way| way.merge)
                .fold(f64::INFINITY, f64::min)
                * merges;
            if best.is_some_and(|b| least > b.cost) || parts == last {
                continue;
            }
            let bandwidth = bandwidth_per_m(pulses, grid, demand.band_hz, &parts);
            last = parts;
            let mut possible = false;
            for way in &ways {
                let Some(cells) = way.longest(grid, bandwidth) else {
                    continue;
                };
                possible = true;
                let coarse = Coarse {
                    cells,
                    taps: way.taps,
                };
                let coarse_pixels = coarse.grid(grid);
                let share = pixels(&coarse_pixels) / pixels(grid);
                let cost = (demand.direct_cost)(&coarse_pixels) * share + way.merge * merges;
                if best.is_none_or(|b| cost <= b.cost) {
                    best = Some(Self {
                        pulses: count,
                        coarse,
                        bandwidth_per_m: bandwidth,
                        interpolation_error: 0.0,
                        cost,
                    });
                }
            }
            if !possible {
                // Sub-apertures of this length contain directions that not even the fine grid samples, and
                // longer ones contain more, though fewer of their pulses are looked at.
                best = None;
            }
        }
        if let Some(best) = &mut best {
            best.interpolation_error = best.error_on(grid);
        }
        Ok(best)
    }
}

impl FactorizedSpec {
    /// Relative RMS error of interpolation along rows and across them together.
    fn error_on(&self, grid: &TiltedGrid) -> f64 {
        let steps = [norm(grid.u_m), norm(grid.v_m)];
        let squares = [0, 1].map(|axis| {
            let cell = self.coarse.cells[axis];
            let nu = self.bandwidth_per_m[axis] * steps[axis] * cell.interval();
            worst_error(self.coarse.taps, nu, cell.pixels).powi(2)
        });
        f64::sqrt(squares[0] + squares[1])
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
    /// Cells of coarse grids that are open, the shortest intervals first.
    pub cells: &'a [Cell],
    /// Numbers of taps that are open.
    pub taps: &'a [usize],
}

/// A number of taps, and what it takes and allows.
struct Way<'d> {
    taps: usize,
    /// Vector operations to merge a pixel, as measured beside those of the direct engine.
    merge: f64,
    /// Widest band that they interpolate, cycles a sample.
    nu: f64,
    cells: &'d [Cell],
}

impl<'d> Way<'d> {
    fn new(taps: usize, demand: &Demand<'d>) -> Self {
        // The second part is of loads that cross cache lines.
        let loads = 2 * taps;
        Self {
            taps,
            merge: (2 * loads + 27) as f64 / demand.lanes as f64 + 0.19 * loads as f64,
            nu: widest_band(taps, 0.5 * demand.accuracy),
            cells: demand.cells,
        }
    }

    /// The cells of the longest intervals along and across rows that interpolate signals of the given bandwidth;
    /// `None` where not even single pixels do.
    fn longest(&self, grid: &TiltedGrid, bandwidth: [f64; 2]) -> Option<[Cell; 2]> {
        let steps = [norm(grid.u_m), norm(grid.v_m)];
        let longest = |axis: usize| {
            let nu_of_pixels = bandwidth[axis] * steps[axis];
            let is_met = |cell: &Cell| {
                let nu = nu_of_pixels * cell.interval();
                // On the pixels themselves nothing is interpolated.
                nu <= self.nu || (cell.interval() <= 1.0 && nu < TOO_FAST)
            };
            let met = self.cells.partition_point(is_met);
            met.checked_sub(1).map(|last| self.cells[last])
        };
        Some([longest(0)?, longest(1)?])
    }
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
