//! Error budget: the cheapest range tables and expansions that keep an accuracy.

use super::arrangement::{Arrangements, Target};
use super::band::effective_band_hz;
use super::bins::{choose_table, fine_bin_m};
use super::sample::Sample;
use crate::engine::direct::DirectSpec;
use crate::engine::factorized::bandwidth::Bandwidths;
use crate::engine::factorized::cell::Cell;
use crate::engine::factorized::relief_error::relief_error;
use crate::engine::factorized::spec::{Demand, FactorizedSpec};
use crate::engine::factorized::two_stages::with_second_stage;
use crate::engine::level_law::LevelLaw;
use crate::engine::tables::fit_error::FitErrors;
use crate::engine::tables::spec::TableSpec;
use crate::error::ImagingError;
use crate::grid::image::ImageGrid;
use crate::grid::roughness::Roughness;
use crate::grid::tilted::TiltedGrid;
use crate::kernel::direct::job::Shape;
use crate::kernel::level::SimdLevel;
use crate::kernel::merge::{MOST_SAMPLES, MOST_TAPS, TAPS};
use crate::pulses::Pulses;
use crate::vector::dot;
use acerra_control::Control;

/// Share of the accuracy for interpolation over uneven ground, equal to the share of both axes of a plane
/// together.
const ALLOWED_TO_RELIEF: f64 = 0.6;
/// Initial factor by which coarse grids over uneven ground are finer than the bandwidth requires: the
/// bandwidth is that of the steepest slopes.
const COARSEST: f64 = 0.8;
/// Greatest such factor over uneven ground: kinks have unbounded bandwidth.
const FINEST: f64 = 3.0;

/// Share of the accuracy for the error of one bistatic spreading factor shared by all pixels of a group.
const SPREADING_SHARE: f64 = 0.2;

/// Whether the spreading factor of separate antennas differs too much between the pixels of a group to be
/// shared.
pub(super) fn has_own_spreadings(
    pulses: &Pulses,
    grid: &TiltedGrid,
    group: [usize; 2],
    sample: &Sample,
    accuracy: f64,
) -> bool {
    // Mean square distance of the pixels from the middle.
    let away = |pixels: usize, step: [f64; 3]| (pixels.pow(2) - 1) as f64 / 12.0 * dot(step, step);
    let away_m = (away(group[0], grid.u_m) + away(group[1], grid.v_m)).sqrt();
    sample.spreading_error(pulses.half_apart_m(), away_m) > SPREADING_SHARE * accuracy
}

/// The fineness to try after one whose error exceeds the allowed error by the factor `excess`. With a
/// fineness of 1 the errors within the bandwidth are as allowed; errors at kinks remain, and fall about with
/// the square of the spacing.
fn finer(fineness: f64, excess: f64) -> f64 {
    if fineness < 1.0 {
        return if excess > 6.0 {
            1.0
        } else {
            (fineness + 0.1).min(1.0)
        };
    }
    fineness * excess.sqrt().max(1.15)
}

/// Chooses parameters of the engines for given data, pixels and instruction set.
pub(crate) struct Budget<'a> {
    pulses: &'a Pulses<'a>,
    grid: &'a ImageGrid<'a>,
    level: SimdLevel,
    /// Power at each frequency, by which errors are weighted.
    power: Vec<f64>,
}

/// A partition of the aperture, the tables of its sub-apertures, and the cost of the direct engine.
pub(crate) struct FactorizedBudget {
    pub spec: FactorizedSpec,
    pub inner: DirectSpec,
    pub direct_cost: f64,
}

impl<'a> Budget<'a> {
    /// The budget of data whose power at each frequency is `power` `[N]`.
    pub fn new(
        pulses: &'a Pulses<'a>,
        grid: &'a ImageGrid<'a>,
        level: SimdLevel,
        power: Vec<f64>,
    ) -> Self {
        Self {
            pulses,
            grid,
            level,
            power,
        }
    }

    /// The cheapest table and expansion that keep `accuracy`, and their cost in vector operations a
    /// pixel.
    pub fn direct(&self, accuracy: f64) -> (DirectSpec, f64) {
        self.cheapest(
            &self.target(self.grid.plane()),
            &self.tables(accuracy),
            accuracy,
        )
    }

    fn arrangements(&self) -> Arrangements<'a> {
        Arrangements {
            pulses: self.pulses,
            level: self.level,
        }
    }

    fn target<'g>(&self, grid: &'g TiltedGrid) -> Target<'g> {
        Target {
            grid,
            sample: Sample::draw(self.pulses, grid, self.grid.terrain()),
            is_uneven: self.grid.is_uneven(),
        }
    }

    /// Tables that keep `accuracy`: narrower bins may need fewer terms of the carrier, and higher degrees
    /// permit wider bins.
    pub fn tables(&self, accuracy: f64) -> Vec<TableSpec> {
        let Some(errors) = FitErrors::new(self.pulses, &self.power) else {
            return Vec::new();
        };
        (1..=3)
            .flat_map(|degree| [0.7, 0.5, 0.35].map(|share| (degree, share)))
            .filter_map(|(degree, share)| {
                choose_table(self.pulses, &errors, degree, (share * accuracy, 0.0))
            })
            .collect()
    }

    /// The cheapest combination of one of `tables` and an arrangement, and the cost of this combination.
    fn cheapest(&self, on: &Target, tables: &[TableSpec], accuracy: f64) -> (DirectSpec, f64) {
        let arrange = self.arrangements();
        // A square has one weight for all of its pixels, and separate heights.
        let has_weights = self.pulses.boresight().is_some()
            || has_own_spreadings(self.pulses, on.grid, [4, 4], &on.sample, accuracy);
        let is_below_relief = self.pulses.ground().is_some_and(|ground| {
            let [_, highest_m] = ground.surface().span_m();
            ground.level_m().is_none() && self.grid.plane().origin_m[2] < highest_m
        });
        let is_refracted = is_below_relief
            || LevelLaw::new(self.pulses, self.grid).is_some_and(|law| law.is_apart());
        let shapes: &[Shape] = match (self.grid.is_uneven(), has_weights) {
            _ if is_refracted => &[Shape::WideSquare],
            (true, _) => &[Shape::Square, Shape::WideSquare],
            (false, true) => &[Shape::Row],
            (false, false) => &[Shape::Row, Shape::Square, Shape::WideSquare],
        };
        let mut best: Option<(DirectSpec, f64)> = None;
        for table in tables {
            for &shape in shapes {
                let least = arrange.least_cost(*table, accuracy, shape);
                if best.is_some_and(|(_, cost)| least >= cost) {
                    continue;
                }
                let found = arrange.by(on, *table, accuracy, shape);
                if best.is_none_or(|(_, cost)| found.1 < cost) {
                    best = Some(found);
                }
            }
        }
        best.unwrap_or_else(|| self.fallback(accuracy))
    }

    /// A very fine cubic table, for accuracies that no other table keeps; plans accept no such accuracy.
    fn fallback(&self, accuracy: f64) -> (DirectSpec, f64) {
        let table = TableSpec {
            bin_m: fine_bin_m(self.pulses),
            degree: 3,
            period: None,
            carrier: self.pulses.frequency_hz().len() / 2,
            interleaved: false,
            reach: 1.0,
        };
        (self.arrangements().spec(table, accuracy, Shape::Row), 100.0)
    }

    /// The cheapest partition that keeps `accuracy`; `None` where coarse grids do not pay. With `windows` the
    /// direct engine may image coarse grids through windows of bins, with `two_stages` sub-apertures may be
    /// merged from shorter ones. `roughness` describes uneven ground.
    ///
    /// # Errors
    /// Cancellation.
    pub fn factorized(
        &self,
        accuracy: f64,
        [windows, two_stages]: [bool; 2],
        roughness: Option<&Roughness>,
        control: Control,
    ) -> Result<Option<FactorizedBudget>, ImagingError> {
        let (_, direct_cost) = self.direct(accuracy);
        let inner_accuracy = 0.8 * accuracy;
        let tables = self.tables(inner_accuracy);
        let inner_on = |coarse: &TiltedGrid| {
            let on = windows.then(|| self.target(coarse));
            self.inner(on, &tables, inner_accuracy)
        };
        // All tables have the same carrier.
        let (grid, terrain) = (self.grid.plane(), self.grid.terrain());
        let (first, _) = inner_on(grid);
        let band_hz = effective_band_hz(self.pulses, &self.power, accuracy, &first.table);
        let bandwidths = Bandwidths::default();
        let mut fineness = roughness.map_or(1.0, |_| COARSEST);
        loop {
            let demand = Demand {
                terrain,
                band_hz,
                fineness,
                bandwidths: &bandwidths,
                accuracy: 0.85 * accuracy,
                direct_cost: &|coarse| inner_on(coarse).1,
                lanes: self.level.lanes(),
                cells: &Cell::all(MOST_SAMPLES),
                taps: &[TAPS, MOST_TAPS],
            };
            let one_stage = FactorizedSpec::choose(self.pulses, grid, &demand, control)?;
            let Some(mut spec) = one_stage else {
                return Ok(None);
            };
            if two_stages {
                spec = with_second_stage(self.pulses, grid, &demand, spec, control)?;
            }
            if let Some(roughness) = roughness {
                let on = (grid, terrain, roughness);
                spec.interpolation_error = relief_error(self.pulses, on, band_hz, &spec);
                let excess = spec.interpolation_error / (ALLOWED_TO_RELIEF * accuracy);
                if excess > 1.0 {
                    fineness = finer(fineness, excess);
                    if fineness > FINEST {
                        return Ok(None);
                    }
                    continue;
                }
            }
            return Ok(Some(FactorizedBudget {
                inner: inner_on(&spec.table_grid(grid)).0,
                spec,
                direct_cost,
            }));
        }
    }

    /// The direct spec for coarse grids, and its cost a value: windows where they are allowed and fit,
    /// otherwise gathers of interleaved coefficients.
    fn inner(
        &self,
        windows_on: Option<Target>,
        tables: &[TableSpec],
        accuracy: f64,
    ) -> (DirectSpec, f64) {
        let windowed = windows_on.map(|on| self.cheapest(&on, tables, accuracy));
        // Measured operations a value for exact ranges and coefficients read lane by lane.
        let lanes = self.level.lanes() as f64;
        let gathered = |table: &TableSpec| {
            let fours = (table.degree as f64 + 1.0) / 2.0;
            let spec = self.arrangements().spec(
                TableSpec {
                    interleaved: true,
                    ..*table
                },
                accuracy,
                Shape::Row,
            );
            (spec, (60.0 + 25.0 * fours) / lanes + 4.4 * fours)
        };
        tables
            .iter()
            .map(gathered)
            .chain(windowed)
            .reduce(|best, found| if found.1 < best.1 { found } else { best })
            .unwrap_or_else(|| self.fallback(accuracy))
    }
}
