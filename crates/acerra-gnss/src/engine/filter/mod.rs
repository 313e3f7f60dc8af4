//! One epoch of the relative filter: prediction, biases, measurement update, ambiguities.

mod observe;
mod predict;
mod resolve;
mod update;

use crate::engine::ambiguity::Resolution;
use crate::engine::confirm::FixedIntegers;
use crate::engine::constellation::{Constellation, SatelliteState, Unusable};
use crate::engine::double::{Common, DoubleRow};
use crate::engine::measurement::Epoch;
use crate::engine::outliers::{code_misfit, worst};
use crate::engine::single::SinglePoint;
use crate::engine::slips;
use crate::engine::state::FilterState;
use crate::engine::zero::ZeroDifference;
use crate::options::{AmbiguityMode, PositioningMode, PpkOptions, RuleSet};
use crate::solution::{NotFixedReason, Quality, SatelliteResidual};
use acerra_geo::time::GpsTime;

/// The rover's epoch with everything that does not depend on the filter.
pub(crate) struct RoverEpoch {
    pub epoch: Epoch,
    pub states: Vec<Result<SatelliteState, Unusable>>,
    pub single: Result<SinglePoint, (NotFixedReason, [f64; 3])>,
}

/// The base's data that go with a rover epoch.
pub(crate) struct BaseView<'a> {
    pub epoch: &'a Epoch,
    pub zero: Vec<ZeroDifference>,
    /// Rover tag minus base tag (s).
    pub age_s: f64,
    /// Time that enters the clock noise (s).
    pub noise_age_s: f64,
}

/// What the filter says about an epoch.
#[derive(Debug, Clone)]
pub(crate) struct EpochResult {
    pub tag: GpsTime,
    pub time: GpsTime,
    pub position_ecef_m: [f64; 3],
    pub covariance_ecef_m2: [[f64; 3]; 3],
    pub velocity: Option<([f64; 3], [[f64; 3]; 3])>,
    /// `None`: no relative solution (the position is the single-point one).
    pub quality: Option<Quality>,
    pub satellites: usize,
    pub age_s: f64,
    pub ratio: f64,
    pub reason: Option<NotFixedReason>,
    pub residuals: Vec<SatelliteResidual>,
    /// The integers of a fix.
    pub integers: Option<FixedIntegers>,
}

/// An epoch as ambiguity resolution sees it.
struct EpochView<'e> {
    rover: &'e RoverEpoch,
    base: &'e BaseView<'e>,
    common: &'e [Common],
    wavelengths_m: &'e [[f64; 3]],
}

/// Share of the codes' past misfit that counts at the next epoch.
const MISFIT_KEPT: f64 = 0.98;

/// The filter of one pass.
#[derive(Clone)]
pub(crate) struct Filter<'a> {
    pub(super) constellation: &'a Constellation,
    pub(super) options: &'a PpkOptions,
    base_position_ecef_m: [f64; 3],
    pub(crate) state: FilterState,
    pub(crate) last_time: Option<GpsTime>,
    consecutive_fixes: u32,
    /// Some fix of the present run of fixes was certain.
    certain: bool,
    /// Squared code residuals in units of their variance, and their degrees of freedom, both
    /// fading.
    misfit: [f64; 2],
    /// First ratio of the previous epoch, before any retry, and the last one.
    pub(super) previous_first_ratio: f64,
    pub(super) previous_ratio: f64,
    pub(super) previously_fixed: bool,
    pub(super) previous_pairs: usize,
    /// Satellite that partial resolution takes out next.
    pub(super) next_to_drop: usize,
    pub(super) held: bool,
}

impl<'a> Filter<'a> {
    pub(crate) fn new(
        constellation: &'a Constellation,
        options: &'a PpkOptions,
        base_position_ecef_m: [f64; 3],
    ) -> Self {
        Self {
            constellation,
            options,
            base_position_ecef_m,
            state: FilterState::new(constellation, options),
            last_time: None,
            consecutive_fixes: 0,
            certain: false,
            misfit: [0.0; 2],
            previous_first_ratio: 0.0,
            previous_ratio: 0.0,
            previously_fixed: false,
            previous_pairs: 0,
            next_to_drop: 0,
            held: false,
        }
    }

    /// Processes one rover epoch that has a single-point position.
    pub(crate) fn step(
        &mut self,
        rover: &RoverEpoch,
        single: &SinglePoint,
        base: Option<BaseView<'_>>,
    ) -> EpochResult {
        let elapsed_s = self
            .last_time
            .map_or(0.0, |last| single.time.seconds_since(last));
        self.last_time = Some(single.time);
        let mut result = EpochResult {
            tag: rover.epoch.tag,
            time: single.time,
            position_ecef_m: single.position_ecef_m,
            covariance_ecef_m2: single.covariance_ecef_m2,
            velocity: single.velocity,
            quality: None,
            satellites: single.satellites,
            age_s: base.as_ref().map_or(0.0, |b| b.age_s),
            ratio: 0.0,
            reason: None,
            residuals: Vec::new(),
            integers: None,
        };
        if self.options.mode == PositioningMode::Single {
            return result;
        }
        let Some(base) = base else {
            result.reason = Some(NotFixedReason::BaseTooOld { age_s: None });
            return result;
        };
        if base.age_s.abs() > self.options.largest_age_s {
            result.reason = Some(NotFixedReason::BaseTooOld {
                age_s: Some(base.age_s),
            });
            return result;
        }
        let common = self.common(rover, &base);
        let too_few = |common: usize| Some(NotFixedReason::TooFewCommonSatellites { common });
        if common.is_empty() {
            result.reason = too_few(0);
            return result;
        }
        let wavelengths = self.wavelengths(rover, &base, &common);
        self.predict_position(single, elapsed_s);
        let phase = self.uses_phase();
        if phase {
            slips::detect(
                &mut self.state,
                self.options,
                &common,
                &wavelengths,
                &rover.epoch,
                base.epoch,
                elapsed_s < 0.0,
            );
            self.predict_biases(rover, &base, &common, elapsed_s);
        }
        let checks_residuals = self.options.largest_phase_residual_sigma.is_some()
            || self.options.largest_code_residual_sigma.is_some();
        let mut prior = checks_residuals.then(|| self.state.clone());
        let mut excluded: Vec<(usize, usize)> = Vec::new();
        let (zero, differences) = loop {
            for _ in 0..self.options.iterations.max(1) {
                let zero = self.rover_zero(rover);
                let rows = self
                    .differences(&common, &wavelengths, &zero, &base, &self.state, &excluded)
                    .rows;
                let least = if self.options.rules == RuleSet::Demo5 {
                    4
                } else {
                    1
                };
                if rows.len() < least || !self.measurement_update(&rows, &common) {
                    self.consecutive_fixes = 0;
                    result.reason = too_few(self.count_valid(&rows, &common));
                    return result;
                }
            }
            let zero = self.rover_zero(rover);
            let differences =
                self.differences(&common, &wavelengths, &zero, &base, &self.state, &excluded);
            if let Some(prior) = &mut prior {
                let beyond = |limit: Option<f64>, of_codes: bool| {
                    let limit = limit?;
                    worst(&differences.rows, of_codes, |_, _| true).filter(|w| w.normalised > limit)
                };
                let code = beyond(self.options.largest_code_residual_sigma, true);
                let phase = beyond(self.options.largest_phase_residual_sigma, false);
                if let Some(worst) = code.or(phase) {
                    if 3 * (excluded.len() + 1) <= common.len() {
                        excluded.push((worst.common, worst.slot));
                        // A bias that begins with a code like this would begin far off.
                        let satellite = common[worst.common].satellite;
                        if code.is_some() && prior.has_initial_variance(satellite, worst.slot) {
                            prior.remove(prior.bias_index(satellite, worst.slot));
                        }
                        self.state.clone_from(prior);
                        continue;
                    }
                    // More contradictions than agreement: the integers held must be wrong.
                    self.forget_biases();
                    self.consecutive_fixes = 0;
                    self.report_float(&mut result, &common, &zero, &differences.rows);
                    result.satellites = self.count_valid(&differences.rows, &common);
                    result.quality = Some(Quality::Float);
                    result.reason = Some(NotFixedReason::PhasesInconsistent {
                        normalised: worst.normalised,
                    });
                    return result;
                }
            }
            break (zero, differences);
        };
        let rows = differences.rows;
        let (squares, freedom) = code_misfit(&rows);
        self.misfit = [
            MISFIT_KEPT * self.misfit[0] + squares,
            MISFIT_KEPT * self.misfit[1] + freedom as f64,
        ];
        self.mark_valid(&rows, &common, &differences.rejected);
        let satellites = self.count_valid(&rows, &common);
        result.satellites = satellites;
        self.remember(rover, &base);
        let np = self.state.position_states;
        self.report_float(&mut result, &common, &zero, &rows);
        if !phase {
            result.quality = (satellites >= 4).then_some(Quality::Dgps);
            result.reason = Some(NotFixedReason::AmbiguityResolutionOff);
            return result;
        }
        if satellites < 4 {
            self.consecutive_fixes = 0;
            result.reason = too_few(satellites);
            // With code rows of satellites without phase there may still be a position.
            if self.options.rules == RuleSet::Demo5 && rows.len() >= 4 {
                result.quality = Some(Quality::Dgps);
            }
            return result;
        }
        result.quality = Some(Quality::Float);
        let epoch = EpochView {
            rover,
            base: &base,
            common: &common,
            wavelengths_m: &wavelengths,
        };
        match self.resolve_checked(&epoch, &zero, &mut excluded, &mut result) {
            Ok(attempt) => {
                if self.consecutive_fixes == 0 {
                    self.certain = false;
                }
                let certain = self.is_certain(&common, &zero, &attempt);
                self.certain |= certain;
                if self.options.least_success_rate.is_some() {
                    result.integers = Some(FixedIntegers::new(&attempt, certain, &result));
                }
                result.quality = Some(Quality::Fixed);
                result.position_ecef_m = [attempt.x[0], attempt.x[1], attempt.x[2]];
                result.covariance_ecef_m2 =
                    std::array::from_fn(|i| std::array::from_fn(|j| attempt.p[i * np + j]));
                if np == 9 {
                    result.velocity = Some((
                        [attempt.x[3], attempt.x[4], attempt.x[5]],
                        std::array::from_fn(|i| {
                            std::array::from_fn(|j| attempt.p[(3 + i) * np + 3 + j])
                        }),
                    ));
                }
                for r in &mut result.residuals {
                    r.fixed = self
                        .constellation
                        .index(r.satellite)
                        .is_some_and(|s| self.state.track(s, r.slot).in_fix);
                }
                self.consecutive_fixes += 1;
                if self.options.ambiguity == AmbiguityMode::FixAndHold
                    && self.consecutive_fixes >= self.options.least_fixes_to_hold
                    && self.certain
                {
                    let resolution = Resolution {
                        constellation: self.constellation,
                        options: self.options,
                        common: &common,
                        rover: &zero,
                        with_glonass: true,
                        variance_factor: self.variance_factor(),
                    };
                    if resolution.hold(&mut self.state, &attempt) {
                        self.learn_channel_biases(&common);
                        self.held = true;
                    }
                }
            }
            Err(reason) => {
                result.reason = Some(reason);
                self.consecutive_fixes = 0;
            }
        }
        self.previously_fixed = result.quality == Some(Quality::Fixed);
        result
    }

    fn remember(&mut self, rover: &RoverEpoch, base: &BaseView<'_>) {
        slips::remember(&mut self.state, self.options, 0, &rover.epoch);
        slips::remember(&mut self.state, self.options, 1, base.epoch);
    }

    fn report_float(
        &self,
        result: &mut EpochResult,
        common: &[Common],
        zero: &[ZeroDifference],
        rows: &[DoubleRow],
    ) {
        result.position_ecef_m = self.state.position();
        result.covariance_ecef_m2 =
            std::array::from_fn(|i| std::array::from_fn(|j| self.state.covariance(i, j)));
        if self.state.position_states == 9 && self.state.exists[3] {
            result.velocity = Some((
                [self.state.x[3], self.state.x[4], self.state.x[5]],
                std::array::from_fn(|i| {
                    std::array::from_fn(|j| self.state.covariance(3 + i, 3 + j))
                }),
            ));
        }
        for slot in 0..self.options.frequencies {
            for (k, c) in common.iter().enumerate() {
                let of = |is_code: bool| {
                    let mut own = rows
                        .iter()
                        .filter(|r| r.slot == slot && r.is_code == is_code);
                    own.clone()
                        .find(|r| r.other == k)
                        .map(|r| r.residual_m)
                        .or_else(|| own.any(|r| r.reference == k).then_some(0.0))
                };
                let (phase_m, code_m) = (of(false), of(true));
                if phase_m.is_none() && code_m.is_none() {
                    continue;
                }
                let z = &zero[c.rover];
                result.residuals.push(SatelliteResidual {
                    satellite: self.constellation.id(c.satellite),
                    slot,
                    azimuth_rad: z.azimuth_rad,
                    elevation_rad: z.elevation_rad,
                    phase_m,
                    code_m,
                    slipped: self.state.track(c.satellite, slot).slipped(),
                    fixed: false,
                });
            }
        }
    }
}
