//! One epoch of the relative filter: prediction, biases, measurement update, ambiguities.

use super::ambiguity::{Attempt, Pair, Resolution, members};
use super::confirm::FixedIntegers;
use super::constellation::{Constellation, SatelliteState, Unusable};
use super::double::{Common, Differencing, DoubleRow};
use super::measurement::Epoch;
use super::noise::{Separation, single_difference_variance_m2, weak_signal_factor};
use super::outliers::{code_misfit, worst};
use super::single::SinglePoint;
use super::slips;
use super::state::FilterState;
use super::zero::{ZeroDifference, zero_differences};
use crate::options::{AmbiguityMode, GlonassAmbiguity, PositioningMode, PpkOptions, RuleSet};
use crate::signal::SPEED_OF_LIGHT_M_S;
use crate::solution::{NotFixedReason, Quality, SatelliteResidual};
use acerra_geo::geodesy::EnuFrame;
use acerra_geo::time::GpsTime;
use nalgebra::DMatrix;

/// Variance of a position taken from a single-point solution (m²).
const POSITION_VARIANCE_M2: f64 = 900.0;
const VELOCITY_VARIANCE: f64 = 100.0;
const ACCELERATION_VARIANCE: f64 = 100.0;
/// A state of exactly zero would count as absent in RTKLIB; accelerations start just off it.
const INITIAL_ACCELERATION: f64 = 1e-6;

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

/// Satellites that may be left out of a fix because their phases contradict the others.
const LARGEST_LEFT_OUT: usize = 3;

/// A position takes three pairs; only a further one checks it.
const LEAST_CHECKED_PAIRS: usize = 4;
/// Fixes in a row after which integers need no proof by leaving satellites out: wrong ones do not
/// pass the ratio test that long while geometry and multipath change.
const LASTING_FIXES: u32 = 50;
/// Share of the codes' past misfit that counts at the next epoch.
const MISFIT_KEPT: f64 = 0.98;
/// Degrees of freedom that the model's own word weighs.
const MISFIT_PRIOR: f64 = 30.0;
const LEAST_VARIANCE_FACTOR: f64 = 0.1;

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

    /// True variances over those of the model, from the residuals of the codes so far; never above
    /// one, for what is slow to average out does not show in them.
    fn variance_factor(&self) -> f64 {
        let [squares, freedom] = self.misfit;
        ((squares + MISFIT_PRIOR) / (freedom + MISFIT_PRIOR)).clamp(LEAST_VARIANCE_FACTOR, 1.0)
    }

    /// Whether the integers of a fix are right beyond reasonable doubt: likely enough by their
    /// covariance, more than a position needs, and in a run of fixes found once whichever
    /// satellites are left out (or the run is long).
    fn is_certain(&self, common: &[Common], zero: &[ZeroDifference], attempt: &Attempt) -> bool {
        let Some(least) = self.options.least_success_rate else {
            return true;
        };
        let resolution = Resolution {
            constellation: self.constellation,
            options: self.options,
            common,
            rover: zero,
            with_glonass: true,
            variance_factor: self.variance_factor(),
        };
        attempt.success_rate >= least
            && attempt.pairs.len() >= LEAST_CHECKED_PAIRS
            && (self.certain
                || self.consecutive_fixes >= LASTING_FIXES
                || resolution.hinges_on_no_satellite(&self.state, attempt))
    }

    fn uses_phase(&self) -> bool {
        matches!(
            self.options.mode,
            PositioningMode::Kinematic | PositioningMode::Static
        )
    }

    fn common(&self, rover: &RoverEpoch, base: &BaseView<'_>) -> Vec<Common> {
        let mut common = Vec::with_capacity(rover.epoch.measurements.len());
        for (index, m) in rover.epoch.measurements.iter().enumerate() {
            if let Some(b) = base.epoch.find(m.satellite)
                && rover.states[index].is_ok()
                && base.zero[b].elevation_rad > 0.0
            {
                common.push(Common {
                    satellite: m.satellite,
                    rover: index,
                    base: b,
                });
            }
        }
        common
    }

    /// Wavelengths of signals that both receivers track on the same carrier.
    fn wavelengths(
        &self,
        rover: &RoverEpoch,
        base: &BaseView<'_>,
        common: &[Common],
    ) -> Vec<[f64; 3]> {
        common
            .iter()
            .map(|c| {
                let u = &rover.epoch.measurements[c.rover].frequency_hz;
                let b = &base.epoch.measurements[c.base].frequency_hz;
                std::array::from_fn(|slot| {
                    if u[slot] != 0.0 && u[slot] == b[slot] {
                        SPEED_OF_LIGHT_M_S / u[slot]
                    } else {
                        0.0
                    }
                })
            })
            .collect()
    }

    fn rover_zero(&self, rover: &RoverEpoch) -> Vec<ZeroDifference> {
        zero_differences(
            self.options,
            &rover.epoch,
            &rover.states,
            self.state.position(),
            false,
        )
    }

    fn differences(
        &self,
        common: &[Common],
        wavelengths_m: &[[f64; 3]],
        rover: &[ZeroDifference],
        base: &BaseView<'_>,
        state: &FilterState,
        excluded: &[(usize, usize)],
    ) -> super::double::Differences {
        let baseline_m = (0..3)
            .map(|k| (state.x[k] - self.base_position_ecef_m[k]).powi(2))
            .sum::<f64>()
            .sqrt();
        Differencing {
            constellation: self.constellation,
            options: self.options,
            common,
            wavelengths_m,
            rover,
            base: &base.zero,
            separation: Separation {
                baseline_m,
                age_s: base.noise_age_s,
            },
            excluded,
        }
        .rows(state)
    }

    fn predict_position(&mut self, single: &SinglePoint, elapsed_s: f64) {
        let first = !self.state.exists[0];
        match (self.options.mode, self.options.dynamics) {
            (PositioningMode::Static, _) => {
                if first {
                    self.initialise_position(single);
                }
            }
            (_, None) => self.initialise_position(single),
            (_, Some(dynamics)) => {
                let variance = (0..3).map(|k| self.state.covariance(k, k)).sum::<f64>() / 3.0;
                if first || variance > POSITION_VARIANCE_M2 {
                    self.initialise_position(single);
                    self.initialise_motion(single);
                } else {
                    self.propagate(elapsed_s, variance);
                    let frame = EnuFrame::from_ecef(self.state.position());
                    let (h, v) = (
                        dynamics.horizontal_noise.powi(2) * elapsed_s.abs(),
                        dynamics.vertical_noise.powi(2) * elapsed_s.abs(),
                    );
                    let noise = frame.ecef_covariance_from_enu(&[
                        [h, 0.0, 0.0],
                        [0.0, h, 0.0],
                        [0.0, 0.0, v],
                    ]);
                    for (i, row) in noise.iter().enumerate() {
                        for (j, value) in row.iter().enumerate() {
                            *self.state.covariance_mut(6 + i, 6 + j) += value;
                        }
                    }
                }
            }
        }
    }

    fn initialise_position(&mut self, single: &SinglePoint) {
        for k in 0..3 {
            self.state
                .initialise(k, single.position_ecef_m[k], POSITION_VARIANCE_M2);
        }
        // In static mode a motion model would have nothing to do.
        for k in 3..self.state.position_states {
            if !self.state.exists[k] {
                self.state.initialise(k, 0.0, 0.0);
                self.state.exists[k] = false;
            }
        }
    }

    fn initialise_motion(&mut self, single: &SinglePoint) {
        let velocity = single.velocity.map_or([0.0; 3], |(v, _)| v);
        for (k, v) in velocity.into_iter().enumerate() {
            self.state.initialise(3 + k, v, VELOCITY_VARIANCE);
            self.state
                .initialise(6 + k, INITIAL_ACCELERATION, ACCELERATION_VARIANCE);
        }
    }

    /// p += v·t + a·t²/2, v += a·t, P ← FPFᵀ, for all states at once.
    fn propagate(&mut self, t: f64, position_variance: f64) {
        let use_acceleration = self.options.rules == RuleSet::Rtklib
            || position_variance < self.options.position_variance_gate_m2;
        let half = if use_acceleration { t * t / 2.0 } else { 0.0 };
        let n = self.state.len();
        for k in 0..3 {
            let (v, a) = (self.state.x[3 + k], self.state.x[6 + k]);
            self.state.x[k] += v * t + a * half;
            self.state.x[3 + k] += a * t;
        }
        // F differs from the identity in the position and velocity rows only.
        for column in 0..n {
            for k in 0..3 {
                let (v, a) = (
                    self.state.covariance(3 + k, column),
                    self.state.covariance(6 + k, column),
                );
                *self.state.covariance_mut(k, column) += v * t + a * half;
                *self.state.covariance_mut(3 + k, column) += a * t;
            }
        }
        for row in 0..n {
            for k in 0..3 {
                let (v, a) = (
                    self.state.covariance(row, 3 + k),
                    self.state.covariance(row, 6 + k),
                );
                *self.state.covariance_mut(row, k) += v * t + a * half;
                *self.state.covariance_mut(row, 3 + k) += a * t;
            }
        }
    }

    fn predict_biases(
        &mut self,
        rover: &RoverEpoch,
        base: &BaseView<'_>,
        common: &[Common],
        elapsed_s: f64,
    ) {
        let options = self.options;
        let instantaneous = options.ambiguity == AmbiguityMode::Instantaneous;
        for slot in 0..options.frequencies {
            self.age_tracks(slot, instantaneous);
            let growth = options.bias_noise_cycles.powi(2) * elapsed_s.abs();
            for c in common {
                let index = self.state.bias_index(c.satellite, slot);
                *self.state.covariance_mut(index, index) += growth;
                let least_rejections = options.rules == RuleSet::Demo5
                    && self.state.track(c.satellite, slot).rejections >= 2;
                let track = self.state.track_mut(c.satellite, slot);
                if !instantaneous && (track.slipped() || least_rejections) {
                    track.lock = -options.least_lock;
                    track.rejections = 0;
                    self.state.remove(index);
                }
            }
            let code_phase: Vec<Option<f64>> = common
                .iter()
                .map(|c| {
                    let u = &rover.epoch.measurements[c.rover];
                    let b = &base.epoch.measurements[c.base];
                    let frequency = u.frequency_hz[slot];
                    let (lu, lb) = (u.phase_cycles[slot], b.phase_cycles[slot]);
                    let (pu, pb) = (u.code_m[slot], b.code_m[slot]);
                    let complete = lu != 0.0
                        && lb != 0.0
                        && pu != 0.0
                        && pb != 0.0
                        && frequency != 0.0
                        && b.frequency_hz[slot] == frequency;
                    complete.then(|| (lu - lb) - (pu - pb) * frequency / SPEED_OF_LIGHT_M_S)
                })
                .collect();
            // One offset for all keeps biases near code minus phase: receiver clocks drift.
            let offsets: Vec<f64> = common
                .iter()
                .zip(&code_phase)
                .filter_map(|(c, beta)| Some((*beta)? - self.state.bias(c.satellite, slot)?))
                .collect();
            if !offsets.is_empty() {
                let mean = offsets.iter().sum::<f64>() / offsets.len() as f64;
                for satellite in 0..self.constellation.len() {
                    let index = self.state.bias_index(satellite, slot);
                    if self.state.exists[index] {
                        self.state.x[index] += mean;
                    }
                }
            }
            for (c, beta) in common.iter().zip(&code_phase) {
                let index = self.state.bias_index(c.satellite, slot);
                if let (Some(beta), false) = (beta, self.state.exists[index]) {
                    self.state
                        .initialise(index, *beta, options.initial_bias_cycles.powi(2));
                    if options.rules == RuleSet::Demo5 {
                        self.state.track_mut(c.satellite, slot).lock = -options.least_lock;
                    }
                }
            }
        }
    }

    /// Counts outages and forgets the biases of satellites gone for too long.
    fn age_tracks(&mut self, slot: usize, instantaneous: bool) {
        for satellite in 0..self.constellation.len() {
            let index = self.state.bias_index(satellite, slot);
            let exists = self.state.exists[index];
            let track = self.state.track_mut(satellite, slot);
            track.outage = track.outage.saturating_add(1);
            let gone = track.outage > self.options.largest_outage;
            if gone && !instantaneous {
                track.lock = -self.options.least_lock;
            }
            if exists && (gone || instantaneous) {
                if !instantaneous {
                    track.outage = 0;
                }
                self.state.remove(index);
            }
        }
    }

    fn measurement_update(&mut self, rows: &[DoubleRow], common: &[Common]) -> bool {
        let m = rows.len();
        let mut noise = DMatrix::<f64>::zeros(m, m);
        for (a, ra) in rows.iter().enumerate() {
            for (b, rb) in rows.iter().enumerate() {
                if ra.block == rb.block {
                    noise[(a, b)] =
                        ra.variance_reference_m2 + if a == b { ra.variance_other_m2 } else { 0.0 };
                }
            }
        }
        let sparse: Vec<_> = rows
            .iter()
            .map(|r| {
                let satellites = [common[r.reference].satellite, common[r.other].satellite];
                self.state.sparse(r, satellites)
            })
            .collect();
        self.state.update(&sparse, noise)
    }

    /// Marks the satellites whose phase was used, and counts rejections.
    fn mark_valid(&mut self, rows: &[DoubleRow], common: &[Common], rejected: &[(usize, usize)]) {
        for track in &mut self.state.tracks {
            track.valid = false;
            track.in_fix = false;
        }
        for row in rows.iter().filter(|r| !r.is_code) {
            for k in [row.reference, row.other] {
                self.state.track_mut(common[k].satellite, row.slot).valid = true;
            }
        }
        for &(k, slot) in rejected {
            let track = self.state.track_mut(common[k].satellite, slot);
            track.rejections += 1;
            if self.options.rules == RuleSet::Demo5 {
                track.valid = false;
            }
        }
        for track in self.state.tracks.iter_mut().filter(|t| t.valid) {
            track.outage = 0;
            match self.options.rules {
                RuleSet::Rtklib => track.lock += 1,
                RuleSet::Demo5 => {
                    if track.lock < 0 {
                        track.lock += 1;
                    }
                }
            }
        }
    }

    /// Satellites used on the first frequency (by phase; by code in differential mode).
    fn count_valid(&self, rows: &[DoubleRow], common: &[Common]) -> usize {
        let by_code = !self.uses_phase();
        let mut used = vec![false; common.len()];
        for row in rows.iter().filter(|r| r.slot == 0 && r.is_code == by_code) {
            used[row.reference] = true;
            used[row.other] = true;
        }
        used.iter().filter(|&&u| u).count()
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

    /// The satellites of `pairs` that partial resolution may leave out, the noisiest first; at
    /// most a third of them.
    fn noisiest_first(
        &self,
        common: &[Common],
        zero: &[ZeroDifference],
        pairs: &[Pair],
    ) -> Vec<(usize, usize)> {
        let mut members = members(pairs);
        let noise = |&(satellite, slot): &(usize, usize)| {
            common
                .iter()
                .find(|c| c.satellite == satellite)
                .map_or(0.0, |c| {
                    let z = &zero[c.rover];
                    let system = self.constellation.id(satellite).system();
                    let near = Separation {
                        baseline_m: 0.0,
                        age_s: 0.0,
                    };
                    let cn0 = [z.cn0_db_hz[slot], 0.0];
                    let elevation = z.elevation_rad;
                    let model = single_difference_variance_m2(
                        self.options,
                        system,
                        slot,
                        false,
                        elevation,
                        cn0,
                        near,
                    );
                    model * weak_signal_factor(self.options, z.cn0_drop_db[slot])
                })
        };
        members.sort_by(|a, b| noise(b).total_cmp(&noise(a)));
        members.truncate(members.len() / 3);
        members
    }

    /// Forgets every phase bias.
    fn forget_biases(&mut self) {
        for index in self.state.position_states..self.state.len() {
            if self.state.exists[index] {
                self.state.remove(index);
            }
        }
        for track in &mut self.state.tracks {
            track.lock = -self.options.least_lock;
            track.valid = false;
        }
    }

    /// Ambiguity resolution, and a check of the phases against the integers found: satellites
    /// that contradict the others are left out and the search repeated.
    fn resolve_checked(
        &mut self,
        epoch: &EpochView<'_>,
        zero: &[ZeroDifference],
        excluded: &mut Vec<(usize, usize)>,
        result: &mut EpochResult,
    ) -> Result<Attempt, NotFixedReason> {
        let mut left_out = 0;
        loop {
            let attempt = self.resolve(epoch.common, zero, result)?;
            let Some(limit) = self.options.largest_phase_residual_sigma else {
                return Ok(attempt);
            };
            let mut fixed = self.state.clone();
            fixed.x[..attempt.x.len()].copy_from_slice(&attempt.x);
            for (pair, integer) in attempt.pairs.iter().zip(&attempt.integers) {
                let reference = self.state.bias(pair.reference, pair.slot).unwrap_or(0.0);
                let index = fixed.bias_index(pair.other, pair.slot);
                fixed.x[index] = reference - integer;
            }
            let rover = zero_differences(
                self.options,
                &epoch.rover.epoch,
                &epoch.rover.states,
                fixed.position(),
                false,
            );
            let differences = self.differences(
                epoch.common,
                epoch.wavelengths_m,
                &rover,
                epoch.base,
                &fixed,
                excluded,
            );
            let in_fix =
                |k: usize, slot: usize| self.state.track(epoch.common[k].satellite, slot).in_fix;
            let worst = worst(&differences.rows, false, in_fix);
            let Some(worst) = worst.filter(|w| w.normalised > limit) else {
                return Ok(attempt);
            };
            for track in &mut self.state.tracks {
                track.in_fix = false;
            }
            if left_out == LARGEST_LEFT_OUT {
                return Err(NotFixedReason::PhasesInconsistent {
                    normalised: worst.normalised,
                });
            }
            left_out += 1;
            excluded.push((worst.common, worst.slot));
            self.state
                .track_mut(epoch.common[worst.common].satellite, worst.slot)
                .valid = false;
        }
    }

    /// One search of the integers, with partial resolution if that is chosen.
    fn attempt_by_rtklib(
        &self,
        common: &[Common],
        zero: &[ZeroDifference],
        with_glonass: bool,
        [slipped, half_cycle]: [usize; 2],
    ) -> Result<Attempt, NotFixedReason> {
        let resolution = Resolution {
            constellation: self.constellation,
            options: self.options,
            common,
            rover: zero,
            with_glonass,
            variance_factor: self.variance_factor(),
        };
        let pairs = resolution.pairs(&self.state);
        if pairs.len() < 2 {
            let pairs = pairs.len();
            return Err(NotFixedReason::TooFewAmbiguities {
                pairs,
                slipped,
                half_cycle,
            });
        }
        match self.options.partial_ambiguity {
            None => resolution.attempt(&self.state, pairs),
            Some(partial) => {
                let dispensable = self.noisiest_first(common, zero, &pairs);
                let least = partial.least_satellites_to_fix.saturating_sub(1);
                resolution.partial_attempt(&self.state, pairs, &dispensable, least)
            }
        }
        .map_err(|_| NotFixedReason::SearchFailed)
    }

    /// Ambiguity resolution of this epoch: the accepted attempt, or why there is none.
    fn resolve(
        &mut self,
        common: &[Common],
        zero: &[ZeroDifference],
        result: &mut EpochResult,
    ) -> Result<Attempt, NotFixedReason> {
        let options = self.options;
        if options.ambiguity == AmbiguityMode::Off || options.ratio_threshold < 1.0 {
            return Err(NotFixedReason::AmbiguityResolutionOff);
        }
        let slipped = common
            .iter()
            .filter(|c| self.state.track(c.satellite, 0).slipped())
            .count();
        let half_cycle = common
            .iter()
            .filter(|c| {
                let track = self.state.track(c.satellite, 0);
                track.half_cycle_flag() || !track.half_cycle_known
            })
            .count();
        let attempt = match options.rules {
            RuleSet::Rtklib => {
                let learning = options.glonass_ambiguity == GlonassAmbiguity::FixAndHold;
                let mut outcome = None;
                // GLONASS joins once its biases are learnt; a fix that fails with it is tried
                // without.
                let tries: &[bool] = match (learning, self.held) {
                    (false, _) => &[true],
                    (true, false) => &[false],
                    (true, true) => &[true, false],
                };
                for &with_glonass in tries {
                    let attempt =
                        self.attempt_by_rtklib(common, zero, with_glonass, [slipped, half_cycle]);
                    let accepted = attempt.as_ref().is_ok_and(|a| a.accepted);
                    if accepted || outcome.is_none() {
                        outcome = Some(attempt);
                    }
                    if accepted {
                        break;
                    }
                }
                outcome.unwrap_or(Err(NotFixedReason::SearchFailed))?
            }
            RuleSet::Demo5 => self.resolve_demo5(common, zero, slipped, half_cycle)?,
        };
        result.ratio = attempt.ratio;
        if !attempt.accepted {
            return Err(NotFixedReason::RatioTooLow {
                ratio: attempt.ratio,
                needed: attempt.threshold,
                slipped,
            });
        }
        for p in &attempt.pairs {
            self.state.track_mut(p.reference, p.slot).in_fix = true;
            self.state.track_mut(p.other, p.slot).in_fix = true;
        }
        Ok(attempt)
    }
}
