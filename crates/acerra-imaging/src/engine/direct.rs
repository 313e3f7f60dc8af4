//! The direct engine: every pulse summed at every pixel.

use crate::control::Meter;
use crate::engine::forward::grouped::GroupSpec;
use crate::engine::level_law::LevelLaw;
use crate::engine::polynomials::carrier_polynomials;
use crate::engine::ray_records::RayRecords;
use crate::engine::refracted_table::refracted_table;
use crate::engine::tables::build::RangeTable;
use crate::engine::tables::spec::TableSpec;
use crate::engine::uneven_rays::UnevenRays;
use crate::engine::weights::{WeightedPulses, Weights};
use crate::error::ImagingError;
use crate::grid::image::{ImageGrid, Patch};
use crate::grid::relief::Relief;
use crate::grid::surface::SurfaceGrid;
use crate::grid::terrain::Terrain;
use crate::grid::tilted::TiltedGrid;
use crate::kernel::direct::band::band;
use crate::kernel::direct::corners::UnevenGround;
use crate::kernel::direct::job::{Band, Job, ReferenceContribution, SIDE, Shape, Tally};
use crate::kernel::direct::square::square_band;
use crate::kernel::dispatch::dispatch;
use crate::kernel::level::SimdLevel;
use crate::kernel::profile::DELAYS;
use crate::pulses::{Pulses, Spreading};
use crate::vector::norm;
use acerra_control::Control;
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::ops::Range;
use std::sync::{Arc, Mutex};

/// Columns by which ranges are widened so that the last vector of a row stays inside the table.
const MARGIN_COLUMNS: f64 = 16.0; // a vector, or two of eight

/// Error budget of the direct engine: table, polynomials and range expansion that together keep an
/// accuracy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DirectSpec {
    pub table: TableSpec,
    /// Whether the carrier's polynomials have four coefficients instead of three.
    pub fine_carrier: bool,
    /// Whether the range within a vector is expanded to third order.
    pub cubic: bool,
    /// Phase error allowed to the range expansion, rad.
    pub phase_tolerance_rad: f64,
    /// Ranges below this are summed in double precision, m: see [`TableSpec::folding_range_m`].
    pub reference_below_m: f64,
    /// Whether bins may be read from windows; else they are gathered.
    pub windows: bool,
    /// Whether rays to the pixels cross an uneven surface: tables then hold no weights.
    pub is_below_relief: bool,
    /// Arrangement of pixels; uneven ground is always taken by squares.
    pub shape: Shape,
    /// Groups of pixels that share an expansion of the range in the forward operator.
    pub groups: Option<GroupSpec>,
}

impl DirectSpec {
    /// The arrangement of pixels on a plane, or on uneven ground, which is taken by squares.
    pub fn shape_on(&self, is_uneven: bool) -> Shape {
        match self.shape {
            _ if self.is_below_relief => Shape::WideSquare,
            Shape::Row if is_uneven => Shape::Square,
            shape => shape,
        }
    }
}

/// Antenna positions and table, ready for any number of runs.
#[derive(Debug)]
pub(crate) struct Direct {
    pub spec: DirectSpec,
    pub(super) level: SimdLevel,
    /// Antenna positions by axis, m: one set, or one of transmitters and one of receivers where these are
    /// separate.
    antennas_m: Vec<[Vec<f64>; 3]>,
    table: Arc<RangeTable>,
    /// Rays of antennas apart over level ground; the table's ranges are then halves of optical lengths.
    rays: Option<RayRecords>,
    /// Range of each pulse's entry 0, in bins.
    first_bin: Vec<f64>,
    cosine: [f32; 4],
    sine: [f32; 4],
}

/// Bounds of the ranges from every antenna position that imaging `grid` may look up.
pub(crate) fn table_ranges_m(position_m: &[[f64; 3]], grid: &ImageGrid) -> Vec<[f64; 2]> {
    position_m
        .par_iter()
        .map(|p| grid.ranges_m(*p, MARGIN_COLUMNS))
        .collect()
}

/// Bounds, m, of half the optical length of every pulse's ways to a grid below level ground, for antennas apart; `None` of
/// any other grid or pulses.
pub(crate) fn half_ways_m(pulses: &Pulses, grid: &ImageGrid) -> Option<Vec<[f64; 2]>> {
    let law = LevelLaw::new(pulses, grid).filter(LevelLaw::is_apart)?;
    let distances_m: Vec<_> = (pulses.antenna_places_m())
        .map(|places_m| table_ranges_m(places_m, grid))
        .collect();
    Some(law.half_ways_m(&distances_m))
}

/// Bounds, m, of the ranges from every antenna position to `grid` over uneven ground: the heights span the
/// surface's `[low, high]` and the terrain below the grid.
pub(crate) fn uneven_ranges_m(
    position_m: &[[f64; 3]],
    (grid, [low, high]): (&TiltedGrid, [f64; 2]),
    terrain: Terrain,
) -> Vec<[f64; 2]> {
    let z_m = grid.origin_m[2];
    let [lowest, highest] = terrain.heights_on(grid).map_or([0.0; 2], |h| h.span_m());
    let span_m = [low.min(z_m + lowest), high.max(z_m + highest)];
    let ranges_m = |p: &[f64; 3]| SurfaceGrid::ranges_over(grid, span_m, *p, MARGIN_COLUMNS);
    position_m.par_iter().map(ranges_m).collect()
}

/// The x, the y and the z of all positions.
fn axes_m(position_m: &[[f64; 3]]) -> [Vec<f64>; 3] {
    std::array::from_fn(|axis| position_m.iter().map(|p| p[axis]).collect())
}

impl Direct {
    /// Builds the range tables.
    ///
    /// # Errors
    /// Cancellation.
    pub fn new(
        echoes: &WeightedPulses,
        ranges_m: &[[f64; 2]],
        spec: DirectSpec,
        level: SimdLevel,
        control: Control,
    ) -> Result<Self, ImagingError> {
        let pulses = &echoes.pulses;
        let mut rays = None;
        let table = match &echoes.weights.law {
            Some(law) if law.is_apart() => {
                rays = Some(RayRecords::new(echoes, law, ranges_m, spec.table.bin_m));
                RangeTable::build(pulses, spec.table, ranges_m, &Weights::unit(), control)?
            }
            None if spec.is_below_relief => {
                RangeTable::build(pulses, spec.table, ranges_m, &Weights::unit(), control)?
            }
            Some(law) => refracted_table(echoes, law, (spec.table, ranges_m), level, control)?,
            None => RangeTable::build(pulses, spec.table, ranges_m, &echoes.weights, control)?,
        };
        let (cosine, sine) = carrier_polynomials(table.carrier_rad, spec.fine_carrier);
        Ok(Self {
            spec,
            level,
            antennas_m: pulses.antenna_places_m().map(axes_m).collect(),
            first_bin: table.first_bins_beyond(0.0),
            table: Arc::new(table),
            rays,
            cosine,
            sine,
        })
    }

    /// These tables for monostatic antennas at `position_m`, with echoes delayed by a range of `beyond_m`
    /// relative to the pixels.
    ///
    /// The tables must cover the ranges from the new positions to the pixels plus `beyond_m`, with the margin
    /// of [`table_ranges_m`].
    pub fn moved(&self, position_m: &[[f64; 3]], beyond_m: f64) -> Self {
        Self {
            antennas_m: vec![axes_m(position_m)],
            first_bin: self.table.first_bins_beyond(beyond_m),
            table: Arc::clone(&self.table),
            rays: None,
            ..*self
        }
    }

    /// Images `patch` from the pulses `which` into `out` `[rows, columns]`. After cancellation `out`
    /// is incomplete.
    pub fn run(
        &self,
        echoes: &WeightedPulses,
        which: Range<usize>,
        patch: &Patch,
        out: &mut [Complex32],
        meter: &Meter,
    ) -> Tally {
        let (grid, pulses) = (&patch.grid, which.len() as u64);
        let wave_m = 2.0 * TAU * self.table.spec.bin_m / self.table.carrier_rad;
        let ground = UnevenRays::new(echoes, self.spec.phase_tolerance_rad, wave_m)
            .filter(|_| self.spec.is_below_relief);
        let job = Job {
            ground: ground.as_ref().map(|ground| ground as &dyn UnevenGround),
            ..self.job(echoes, which, norm(grid.u_m).max(1e-12), meter)
        };
        let tally = Mutex::new(Tally::default());
        let share = |(i, j): (usize, usize), columns: usize, out: &mut [Complex32]| {
            if meter.is_cancelled() {
                return;
            }
            let one = Band {
                origin_m: grid.point_m(i as f64, j as f64),
                u_m: grid.u_m,
                v_m: grid.v_m,
                columns,
                rows: out.len() / columns,
            };
            let relief = patch.relief.map(|r| r.seen_from(i, j));
            let counted = self.band(&job, &one, relief, out);
            if let Ok(mut sum) = tally.lock() {
                sum.add(counted);
            }
            meter.add(out.len() as u64 * pulses);
        };
        let shape = self.shape_on(patch.relief.is_some());
        let lanes = self.level.lanes();
        let height = shape.tile_rows(lanes);
        if grid.rows >= 2 * height {
            out.par_chunks_mut(height * grid.columns)
                .enumerate()
                .for_each(|(k, out)| {
                    share((0, k * height), grid.columns, out);
                });
        } else if shape != Shape::Row {
            // Few rows: strips of squares.
            out.par_chunks_mut(SIDE * grid.columns)
                .enumerate()
                .for_each(|(k, out)| share((0, k * SIDE), grid.columns, out));
        } else {
            // Few rows: pieces of rows are distributed over the threads.
            let piece = 2 * shape.block_width(lanes);
            out.par_chunks_mut(grid.columns)
                .enumerate()
                .for_each(|(j, row)| {
                    row.par_chunks_mut(piece).enumerate().for_each(|(k, out)| {
                        share((k * piece, j), out.len(), out);
                    });
                });
        }
        tally.into_inner().unwrap_or_default()
    }

    /// Whether pixels are seen along rays into the ground, and tables hold no weights.
    fn has_rays(&self) -> bool {
        self.rays.is_some() || self.spec.is_below_relief
    }

    /// The arrangement of pixels: rays below level ground are expanded over squares.
    fn shape_on(&self, is_uneven: bool) -> Shape {
        match self.rays {
            Some(_) => Shape::WideSquare,
            None => self.spec.shape_on(is_uneven),
        }
    }

    /// The part of a run that all its bands share.
    fn job<'a>(
        &'a self,
        echoes: &'a WeightedPulses,
        which: Range<usize>,
        pixel_m: f64,
        meter: &'a Meter,
    ) -> Job<'a> {
        let tolerance_bins = self.spec.phase_tolerance_rad / self.table.carrier_rad;
        let half_block_m = 0.5 * pixel_m * Shape::Row.block_width(self.level.lanes()) as f64;
        Job {
            pulses: which,
            near_centre: half_block_m / self.table.spec.bin_m * f64::from(f32::EPSILON)
                < 0.2 * tolerance_bins,
            antennas_m: &self.antennas_m,
            table: self.table.view(&self.first_bin),
            cosine: self.cosine,
            sine: self.sine,
            pixel_m,
            tolerance_bins,
            windows: self.spec.windows && !self.spec.table.interleaved,
            reference_below_m: match echoes.weights.spreading {
                Spreading::InverseSquare => self.spec.reference_below_m,
                Spreading::None => 0.0,
            },
            weight: match self.has_rays() {
                true => None,
                false => echoes.pixel_weight(),
            },
            ground: None,
            rays: (self.rays.as_ref()).map(|rays| rays.view(self.spec.phase_tolerance_rad)),
            reference: echoes,
            control: meter.control(),
        }
    }

    fn band(&self, job: &Job, one: &Band, relief: Option<Relief>, out: &mut [Complex32]) -> Tally {
        let quality = (
            self.spec.table.degree,
            self.spec.fine_carrier,
            self.spec.cubic,
        );
        if self.has_rays() {
            return dispatch!(self.level, s => match quality {
                (1, false, _) => square_band::<_, 1, 3, true, true, false, true>(s, job, one, None, out),
                (1, true, _) => square_band::<_, 1, 4, true, true, false, true>(s, job, one, None, out),
                (2, _, _) => square_band::<_, 2, 4, true, true, false, true>(s, job, one, None, out),
                _ => square_band::<_, 3, 4, true, true, false, true>(s, job, one, None, out),
            });
        }
        let shape = self.shape_on(relief.is_some());
        if job.weight.is_some() && shape == Shape::Row {
            return dispatch!(self.level, s => match quality {
                (1, false, false) => band::<_, 1, 3, false, true>(s, job, one, out),
                (1, false, true) => band::<_, 1, 3, true, true>(s, job, one, out),
                (1, _, _) => band::<_, 1, 4, true, true>(s, job, one, out),
                (2, _, _) => band::<_, 2, 4, true, true>(s, job, one, out),
                _ => band::<_, 3, 4, true, true>(s, job, one, out),
            });
        }
        if relief.is_some() {
            let wide = shape == Shape::WideSquare;
            return dispatch!(self.level, s => match (quality, wide) {
                ((1, false, _), false) => square_band::<_, 1, 3, true, false, true, false>(s, job, one, relief, out),
                ((1, true, _), false) => square_band::<_, 1, 4, true, false, true, false>(s, job, one, relief, out),
                ((2, _, _), false) => square_band::<_, 2, 4, true, false, true, false>(s, job, one, relief, out),
                (_, false) => square_band::<_, 3, 4, true, false, true, false>(s, job, one, relief, out),
                ((1, false, _), true) => square_band::<_, 1, 3, true, true, true, false>(s, job, one, relief, out),
                ((1, true, _), true) => square_band::<_, 1, 4, true, true, true, false>(s, job, one, relief, out),
                ((2, _, _), true) => square_band::<_, 2, 4, true, true, true, false>(s, job, one, relief, out),
                (_, true) => square_band::<_, 3, 4, true, true, true, false>(s, job, one, relief, out),
            });
        }
        if shape == Shape::Square {
            return dispatch!(self.level, s => match quality {
                (1, false, false) => square_band::<_, 1, 3, false, false, false, false>(s, job, one, None, out),
                (1, false, true) => square_band::<_, 1, 3, true, false, false, false>(s, job, one, None, out),
                (1, _, _) => square_band::<_, 1, 4, true, false, false, false>(s, job, one, None, out),
                (2, _, _) => square_band::<_, 2, 4, true, false, false, false>(s, job, one, None, out),
                _ => square_band::<_, 3, 4, true, false, false, false>(s, job, one, None, out),
            });
        }
        if shape == Shape::WideSquare {
            return dispatch!(self.level, s => match quality {
                (1, false, false) => square_band::<_, 1, 3, false, true, false, false>(s, job, one, None, out),
                (1, false, true) => square_band::<_, 1, 3, true, true, false, false>(s, job, one, None, out),
                (1, _, _) => square_band::<_, 1, 4, true, true, false, false>(s, job, one, None, out),
                (2, _, _) => square_band::<_, 2, 4, true, true, false, false>(s, job, one, None, out),
                _ => square_band::<_, 3, 4, true, true, false, false>(s, job, one, None, out),
            });
        }
        dispatch!(self.level, s => match quality {
            (1, false, false) => band::<_, 1, 3, false, false>(s, job, one, out),
            (1, false, true) => band::<_, 1, 3, true, false>(s, job, one, out),
            (1, _, _) => band::<_, 1, 4, true, false>(s, job, one, out),
            (2, _, _) => band::<_, 2, 4, true, false>(s, job, one, out),
            _ => band::<_, 3, 4, true, false>(s, job, one, out),
        })
    }
}

impl ReferenceContribution for WeightedPulses<'_> {
    fn contributions(&self, pulse: usize, points_m: &[[f64; 3]]) -> [Complex64; DELAYS] {
        WeightedPulses::contributions(self, pulse, points_m)
    }
}
