//! Length of sub-apertures and spacing of coarse grids.

use super::aperture::partition_aperture;
use super::bandwidth::{Bandwidths, bandwidth_per_m};
use super::cell::Cell;
use super::coarse::Coarse;
use super::interpolation::{TOO_FAST, widest_band, worst_error};
use crate::error::ImagingError;
use crate::grid::image::ImageGrid;
use crate::grid::terrain::Terrain;
use crate::grid::tilted::TiltedGrid;
use crate::kernel::merge::TAPS;
use crate::pulses::Pulses;
use crate::vector::norm;
use acerra_control::Control;
use std::ops::Range;

/// Candidate numbers of pulses in a sub-aperture.
pub(super) const COUNTS: [usize; 16] = [
    6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512, 768, 1024,
];

/// Sub-apertures of one length, and their coarse grids.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stage {
    /// Pulses in a sub-aperture.
    pub pulses: usize,
    pub coarse: Coarse,
    /// Bound of the spatial frequencies along the row and across, cycles/m.
    pub bandwidth_per_m: [f64; 2],
}

/// Partition of the aperture and spacing of the coarse grids.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FactorizedSpec {
    /// The sub-apertures whose images are merged on the image's grid.
    pub outer: Stage,
    /// Shorter sub-apertures whose images are merged on the coarse grids of `outer`; `None` where the range
    /// tables are summed on these grids directly.
    pub shorter: Option<Stage>,
    /// Interpolation error expected for a spectrum that fills the bounds.
    pub interpolation_error: f64,
    /// Estimated cost in vector operations a pixel and pulse.
    pub cost: f64,
}

impl FactorizedSpec {
    /// The cheapest partition of one stage that meets `demand`; `None` where coarse grids cost more than they
    /// save.
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
        let ways = Way::all(demand, 1);
        let mut last = Vec::new();
        // Longest sub-apertures first: merging alone makes most of the short ones too dear.
        for count in COUNTS.into_iter().rev() {
            control.check()?;
            if count > 2 * pulses.len() {
                continue;
            }
            let parts = partition_aperture(pulses, count);
            let merges = parts.len() as f64 / pulses.len() as f64;
            let least = ways
                .iter()
                .map(Way::least_merge)
                .fold(f64::INFINITY, f64::min)
                * merges;
            if best.is_some_and(|b| least > b.cost) || parts == last {
                continue;
            }
            let bandwidth = demand.bandwidth_per_m(pulses, grid, (count, &parts));
            last = parts;
            let mut possible = false;
            for way in &ways {
                let Some(outer) = way.stage(count, grid, bandwidth) else {
                    continue;
                };
                possible = true;
                let coarse = outer.coarse.grid(grid);
                let cost = (demand.direct_cost)(&coarse) * share(&coarse, grid)
                    + way.merge(&outer) * merges;
                if best.is_none_or(|b| cost <= b.cost) {
                    best = Some(Self {
                        outer,
                        shorter: None,
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

    /// Relative RMS error of all interpolations together.
    pub(super) fn error_on(&self, grid: &TiltedGrid) -> f64 {
        let outer = self.outer.squared_error_on(grid);
        let coarse = self.outer.coarse.grid(grid);
        let shorter = (self.shorter).map_or(0.0, |stage| stage.squared_error_on(&coarse));
        (outer + shorter).sqrt()
    }

    /// The grid on which the range tables are summed for an image on `grid`.
    pub fn table_grid(&self, grid: &TiltedGrid) -> TiltedGrid {
        let coarse = self.outer.coarse.grid(grid);
        (self.shorter).map_or(coarse, |stage| stage.coarse.grid(&coarse))
    }

    /// Bytes of the images of the sub-apertures `parts`: unfinished rows with the heights of uneven ground,
    /// and all images kept.
    pub fn coarse_bytes(&self, image: &ImageGrid, parts: &[Range<usize>]) -> [u128; 2] {
        let grid = image.plane();
        let ground = |stage: &Stage, on: &TiltedGrid| match image.is_uneven() {
            true => stage.coarse.ground_bytes(on),
            false => 0,
        };
        let of = |stage: &Stage, on: &TiltedGrid, images| {
            stage.coarse.bytes(on, images) + ground(stage, on)
        };
        let one = of(&self.outer, grid, 0);
        let shorter = self.shorter.map_or(0, |stage| {
            let most = |part: &Range<usize>| part.len().div_ceil(stage.pulses);
            let images = parts.iter().map(most).max().unwrap_or(0);
            of(&stage, &self.outer.coarse.grid(grid), images)
        });
        [one + shorter, of(&self.outer, grid, 1) - one]
    }

    /// Pixels after which all grids repeat together, along the row and across.
    pub fn period_pixels(&self) -> [usize; 2] {
        [0, 1].map(|axis| {
            let shorter = (self.shorter).map_or(1, |stage| stage.coarse.cells[axis].pixels);
            self.outer.coarse.cells[axis].pixels * shorter
        })
    }
}

impl Stage {
    /// Square of the relative RMS error of interpolation along rows of `grid` and across them together.
    fn squared_error_on(&self, grid: &TiltedGrid) -> f64 {
        let steps = [norm(grid.u_m), norm(grid.v_m)];
        let squares = [0, 1].map(|axis| {
            let cell = self.coarse.cells[axis];
            let nu = self.bandwidth_per_m[axis] * steps[axis] * cell.interval();
            match cell.pixels == cell.samples {
                true => 0.0,
                false => worst_error(self.coarse.taps, nu, cell.pixels).powi(2),
            }
        });
        squares[0] + squares[1]
    }
}

/// Number of pixels of the grid `of` for each pixel of `grid`.
pub(super) fn share(of: &TiltedGrid, grid: &TiltedGrid) -> f64 {
    let pixels = |g: &TiltedGrid| (g.columns * g.rows) as f64;
    pixels(of) / pixels(grid)
}

/// Requirements on a partition.
#[derive(Clone, Copy)]
pub(crate) struct Demand<'a> {
    /// The ground of all grids.
    pub terrain: Terrain<'a>,
    /// Lowest, carrier and highest frequency, Hz.
    pub band_hz: [f64; 3],
    /// Factor applied to the bandwidth, which makes coarse grids finer by the same factor.
    pub fineness: f64,
    /// Bandwidths computed already.
    pub bandwidths: &'a Bandwidths,
    /// Relative error allowed.
    pub accuracy: f64,
    /// Vector operations of the direct engine per value and pulse on a coarse grid.
    pub direct_cost: &'a dyn Fn(&TiltedGrid) -> f64,
    /// Numbers in a vector.
    pub lanes: usize,
    /// Candidate cells of coarse grids, the shortest intervals first.
    pub cells: &'a [Cell],
    /// Candidate numbers of taps.
    pub taps: &'a [usize],
}

impl Demand<'_> {
    /// Bandwidth of sub-apertures of `count` pulses on the image's grid, along the row and across, cycles/m:
    /// the design value of their coarse grids.
    pub fn bandwidth_per_m(
        &self,
        pulses: &Pulses,
        grid: &TiltedGrid,
        (count, parts): (usize, &[Range<usize>]),
    ) -> [f64; 2] {
        let found = (self.bandwidths).of(count, || {
            bandwidth_per_m(pulses, (grid, self.terrain), self.band_hz, parts)
        });
        found.map(|b| b * self.fineness)
    }

    /// The bandwidth of sub-apertures of `count` pulses on another grid.
    pub fn bandwidth_on(
        &self,
        pulses: &Pulses,
        grid: &TiltedGrid,
        parts: &[Range<usize>],
    ) -> [f64; 2] {
        bandwidth_per_m(pulses, (grid, self.terrain), self.band_hz, parts)
            .map(|b| b * self.fineness)
    }
}

/// A number of taps, its cost, and the bandwidth that it permits.
pub(super) struct Way<'d> {
    taps: usize,
    /// Vector operations to merge a pixel: along the row, and across rows, the latter multiplied by the
    /// pixels of a coarse interval.
    merge: [f64; 2],
    /// Widest band that the taps interpolate, cycles a sample.
    nu: f64,
    cells: &'d [Cell],
}

impl<'d> Way<'d> {
    /// One entry for every number of taps, where `stages` stages share the allowed error.
    pub fn all(demand: &Demand<'d>, stages: usize) -> Vec<Self> {
        let error = 0.5 * demand.accuracy / (stages as f64).sqrt();
        (demand.taps.iter())
            .map(|taps| {
                // Fitted to run times of eight pairs of lengths at two accuracies, with AVX-512 and AVX2: all within 19 %.
                let (samples, lanes) = (*taps as f64, demand.lanes as f64);
                // Ranges to pixels with separate heights need a few operations more.
                let heights = if demand.terrain.is_uneven() { 7.0 } else { 0.0 };
                Self {
                    taps: *taps,
                    merge: [
                        (5.0 * samples + heights) / lanes,
                        140.0 * samples / lanes.powi(2),
                    ],
                    nu: widest_band(*taps, error),
                    cells: demand.cells,
                }
            })
            .collect()
    }

    /// Vector operations to merge one pixel of the fine grid from the coarse grid of `stage`.
    pub fn merge(&self, stage: &Stage) -> f64 {
        self.merge[0] + self.merge[1] / stage.coarse.cells[0].interval()
    }

    /// Lower bound of [`Self::merge`] over all stages.
    fn least_merge(&self) -> f64 {
        self.merge[0]
    }

    /// Sub-apertures of `pulses` on the coarsest grids that interpolate signals of the given bandwidth on
    /// `grid`; `None` where even the pixels of `grid` are too coarse.
    pub fn stage(&self, pulses: usize, grid: &TiltedGrid, bandwidth: [f64; 2]) -> Option<Stage> {
        let steps = [norm(grid.u_m), norm(grid.v_m)];
        let longest = |axis: usize| {
            let nu_of_pixels = bandwidth[axis] * steps[axis];
            let is_met = |cell: &Cell| {
                let nu = nu_of_pixels * cell.interval();
                // With a sample on every pixel nothing is interpolated.
                nu <= self.nu || (cell.interval() <= 1.0 && nu < TOO_FAST)
            };
            let met = self.cells.partition_point(is_met);
            met.checked_sub(1).map(|last| self.cells[last])
        };
        Some(Stage {
            pulses,
            coarse: Coarse {
                cells: [longest(0)?, longest(1)?],
                taps: self.taps,
            },
            bandwidth_per_m: bandwidth,
        })
    }
}
