//! One epoch of the relative filter: prediction, biases, measurement update, ambiguities.

mod adjust;
mod baseline_length;
mod continuity;
mod demo5;
pub(crate) mod epoch_result;
pub(crate) mod glonass;
mod held;
mod last_phases;
mod new_ambiguities;
mod observe;
mod predict;
mod report;
mod residuals;
mod resolve;
mod update;

use crate::ambiguity::attempt::{Attempt, Pair};
use crate::ambiguity::fixed_integers::{FixedIntegers, FloatSolution};
use crate::float::slips;
use crate::float::state::FilterState;
use crate::measurements::common::Common;
use crate::measurements::constellation::Constellation;
use crate::measurements::signal_group::{SignalGroup, SuspectGroups};
use crate::measurements::zero::ZeroDifference;
use crate::noise::calibration::FloatMisfit;
use crate::noise::code_noise::MeasuredNoise;
use crate::noise::robust_codes::Inflation;
use crate::observations::observation::LossOfLock;
use crate::options::{AmbiguityMode, PositioningMode, PpkOptions};
use crate::single::SinglePoint;
use crate::solution::{NotFixedReason, Quality};
use crate::stations::epoch_input::{BaseView, RoverEpoch, UnflaggedSlips};
use crate::stations::moving_base::LARGEST_SEPARATION_S;
use acerra_geo::geodesy::EnuFrame;
use acerra_geo::time::GpsTime;
use epoch_result::EpochResult;
use glonass::GlonassPlan;
use last_phases::LastPhases;
use nalgebra::{Matrix3, Vector3};
use residuals::Update;
use std::sync::Arc;

/// Common observations of rover and base at an epoch.
struct EpochView<'e> {
    rover: &'e RoverEpoch,
    base: &'e BaseView<'e>,
    common: Vec<Common>,
    /// Wavelength (m) of each common satellite and slot; 0 where the carriers differ.
    wavelengths_m: Vec<[f64; 3]>,
    /// Noise factor of each common satellite's codes.
    inflation: Inflation,
    unflagged_slips: UnflaggedSlips,
}

impl<'e> EpochView<'e> {
    fn new(
        filter: &Filter<'_>,
        rover: &'e RoverEpoch,
        single: &SinglePoint,
        base: &'e BaseView<'e>,
    ) -> Self {
        let common = filter.common(rover, base);
        let wavelengths_m = filter.wavelengths(rover, base, &common);
        let mut view = Self {
            rover,
            base,
            common,
            wavelengths_m,
            inflation: Inflation::new(),
            unflagged_slips: UnflaggedSlips::default(),
        };
        if filter.options.measure_code_noise {
            view.inflation = filter.code_inflation(&view, single);
        }
        view
    }
}

/// The filter of one pass.
#[derive(Clone)]
pub(crate) struct Filter<'a> {
    pub(crate) constellation: &'a Constellation,
    pub(crate) options: &'a PpkOptions,
    pub(crate) noise: &'a MeasuredNoise,
    pub(crate) state: FilterState,
    pub(crate) last_time: Option<GpsTime>,
    consecutive_fixes: u32,
    /// Whether some fix of the present run of fixes was settled.
    settled: bool,
    /// Whether some fix of the present run of fixes, or with the held integers, was certain.
    certain: bool,
    /// Squared code residuals in units of their variance, and their degrees of freedom, both
    /// fading.
    misfit: [f64; 2],
    /// First ratio of the previous epoch, before any retry, and the last one.
    pub(crate) previous_first_ratio: f64,
    pub(crate) previous_ratio: f64,
    pub(crate) previously_fixed: bool,
    pub(crate) previous_pairs: usize,
    /// Satellite that partial resolution takes out next.
    pub(crate) next_to_drop: usize,
    pub(crate) held: bool,
    /// The state conditioned on the held integers.
    held_state: Option<FilterState>,
    /// Memory for the state before an update.
    room: Option<FilterState>,
    /// Memory for a copy of the state that is conditioned on integers.
    spare: Option<FilterState>,
    /// Number of consecutive epochs at which the float state contradicts the held integers.
    doubts: u32,
    /// Whether GLONASS ambiguities stay float.
    glonass_float: bool,
    /// Whether the present fix uses integers held before.
    rests_on_held: bool,
    /// The pairs of this epoch whose ambiguities may be resolved, before any pair is left out.
    all_pairs: Vec<Pair>,
    /// Groups of signals whose phases contradict the other groups.
    pub(crate) suspects: SuspectGroups,
    /// Phase differences of the last epoch.
    last_phases: LastPhases,
    /// Whether epochs come in descending order of time.
    pub(crate) backward: bool,
    /// Number of the present set of held integers.
    generation: u32,
    /// Numbers of the withdrawn sets of held integers.
    pub(crate) withdrawn: Vec<u32>,
}

impl<'a> Filter<'a> {
    pub(crate) fn new(
        constellation: &'a Constellation,
        options: &'a PpkOptions,
        noise: &'a MeasuredNoise,
    ) -> Self {
        Self {
            constellation,
            options,
            noise,
            state: FilterState::new(constellation, options),
            last_time: None,
            consecutive_fixes: 0,
            settled: false,
            certain: false,
            misfit: [0.0; 2],
            previous_first_ratio: 0.0,
            previous_ratio: 0.0,
            previously_fixed: false,
            previous_pairs: 0,
            next_to_drop: 0,
            held: false,
            generation: 0,
            last_phases: LastPhases::default(),
            backward: false,
            held_state: None,
            room: None,
            spare: None,
            doubts: 0,
            glonass_float: false,
            rests_on_held: false,
            all_pairs: Vec::new(),
            suspects: SuspectGroups::default(),
            withdrawn: Vec::new(),
        }
    }

    /// This filter without the groups of signals that contradict the others.
    pub(crate) fn without_groups(self, left_out: Vec<SignalGroup>) -> Self {
        Self {
            suspects: SuspectGroups::known(left_out),
            ..self
        }
    }

    /// This filter with the GLONASS decision of an earlier pass.
    pub(crate) fn with_glonass(mut self, plan: GlonassPlan) -> Self {
        match plan {
            GlonassPlan::Estimate => {}
            GlonassPlan::Float => self.glonass_float = true,
            GlonassPlan::Slope([slope, sigma]) => {
                if let Some(index) = self.state.channel_slope_index() {
                    self.state.initialise(index, slope, sigma * sigma);
                }
            }
        }
        self
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
        let mut result = EpochResult::from_single(rover, single, base.as_ref());
        if self.options.mode == PositioningMode::Single {
            return result;
        }
        let base = match self.young_enough(base) {
            Ok(base) => base,
            Err(reason) => return result.not_fixed(reason),
        };
        let mut epoch = EpochView::new(self, rover, single, &base);
        if epoch.common.is_empty() {
            return result.not_fixed(NotFixedReason::TooFewCommonSatellites { common: 0 });
        }
        if self.uses_phase() && self.options.max_phase_residual_sigma.is_some() {
            epoch.unflagged_slips = self.unflagged_slips(&epoch, single);
        }
        self.predict(single, &epoch, elapsed_s);
        let mut excluded = Vec::new();
        match self.checked_update(&epoch, &mut excluded) {
            Ok(update) => {
                self.advance_held(single, &epoch, elapsed_s, &excluded);
                let unconstrained = self.constrain_length(&base);
                self.take_up(&epoch, &update, &mut excluded, &mut result);
                self.release_length(unconstrained);
            }
            Err(failure) => {
                self.held_state = None;
                self.consecutive_fixes = 0;
                if let Some(update) = &failure.contradicting {
                    self.report_float(&mut result, &epoch, update);
                    result.quality = Some(Quality::Float);
                }
                result.reason = Some(failure.reason);
            }
        }
        if result.quality.is_none() && self.options.output_single {
            self.fall_back_to_codes(&epoch, single, &mut result);
        }
        result
    }

    /// The position from differential codes, where phases give none.
    fn fall_back_to_codes(
        &self,
        epoch: &EpochView<'_>,
        single: &SinglePoint,
        result: &mut EpochResult,
    ) {
        if let Some(state) = self.position_by_codes(epoch, single) {
            result.quality = Some(Quality::Dgps);
            result.position_ecef_m = state.position();
            result.covariance_ecef_m2 =
                std::array::from_fn(|i| std::array::from_fn(|j| state.covariance(i, j)));
        } else {
            result.position_ecef_m = single.position_ecef_m;
            result.covariance_ecef_m2 = single.covariance_ecef_m2;
        }
    }

    fn young_enough<'b>(&self, base: Option<BaseView<'b>>) -> Result<BaseView<'b>, NotFixedReason> {
        let age_s = base.as_ref().map(|b| b.age_s);
        let largest_s = match self.options.mode {
            PositioningMode::MovingBase => self.options.max_age_s.min(LARGEST_SEPARATION_S),
            _ => self.options.max_age_s,
        };
        base.filter(|b| b.age_s.abs() <= largest_s)
            .ok_or(NotFixedReason::BaseTooOld { age_s })
    }

    /// Predicts position and biases at this epoch.
    fn predict(&mut self, single: &SinglePoint, epoch: &EpochView<'_>, elapsed_s: f64) {
        self.predict_position(single, elapsed_s);
        if self.uses_phase() {
            let view = slips::SlipView {
                options: self.options,
                common: &epoch.common,
                wavelengths_m: &epoch.wavelengths_m,
                rover: &epoch.rover.epoch,
                base: epoch.base.epoch,
                backward: elapsed_s < 0.0,
            };
            slips::detect(&mut self.state, &view);
            for &(k, slot) in epoch.unflagged_slips.iter() {
                let track = self.state.track_mut(epoch.common[k].satellite, slot);
                track.flags |= LossOfLock::SLIP;
            }
            self.predict_biases(epoch, elapsed_s);
        }
    }

    /// Reports the result of a successful update, and resolves ambiguities where there are any.
    fn take_up(
        &mut self,
        epoch: &EpochView<'_>,
        update: &Update,
        excluded: &mut Vec<(usize, usize)>,
        result: &mut EpochResult,
    ) {
        let rows = &update.differences.rows;
        self.note_misfit(rows);
        self.mark_valid(rows, epoch, &update.differences.rejected);
        self.remember(epoch.rover, epoch.base);
        self.report_float(result, epoch, update);
        let satellites = result.satellites;
        if !self.uses_phase() {
            result.quality = (satellites >= 4).then_some(Quality::Dgps);
            result.reason = Some(NotFixedReason::AmbiguityResolutionOff);
            return;
        }
        if satellites < 4 {
            self.consecutive_fixes = 0;
            result.reason = Some(NotFixedReason::TooFewCommonSatellites { common: satellites });
            // With code rows of satellites without phase there may still be a position.
            if self.options.policy().gives_position_by_codes(rows.len()) {
                result.quality = Some(Quality::Dgps);
            }
            return;
        }
        result.quality = Some(Quality::Float);
        match self.resolve_checked(epoch, &update.zero, excluded, result) {
            Ok(attempt) => match self.contradicted_length(epoch.base, &attempt) {
                None => self.take_up_fix(epoch, &update.zero, &attempt, result),
                Some(reason) => {
                    result.reason = Some(reason);
                    self.consecutive_fixes = 0;
                }
            },
            Err(reason) => {
                result.reason = Some(reason);
                self.consecutive_fixes = 0;
            }
        }
        self.previously_fixed = result.quality == Some(Quality::Fixed);
    }

    /// Reports a fix, and feeds its integers back once enough fixes agree.
    fn take_up_fix(
        &mut self,
        epoch: &EpochView<'_>,
        zero: &[ZeroDifference],
        attempt: &Attempt,
        result: &mut EpochResult,
    ) {
        if self.consecutive_fixes == 0 {
            self.settled = false;
            self.certain &= self.rests_on_held;
        }
        let settled = self.is_settled(attempt);
        self.settled |= settled;
        let certain = settled && self.is_certain(epoch, zero, attempt);
        self.certain |= certain;
        if self.options.min_success_rate.is_some() {
            let float = FloatSolution {
                position_ecef_m: result.position_ecef_m,
                covariance_ecef_m2: result.covariance_ecef_m2,
                velocity: result.velocity,
            };
            if self.rests_on_held {
                result.float_misfit = self.float_misfit(attempt);
            }
            let mut integers =
                FixedIntegers::new(attempt, &self.state, certain, self.generation, float);
            integers.held = self.rests_on_held.then_some(self.generation);
            result.integers = Some(Arc::new(integers));
        }
        self.report_fix(result, attempt);
        let mut used: Vec<SignalGroup> = attempt.pairs.iter().map(Pair::signal_group).collect();
        used.dedup();
        self.suspects.note(&used, &attempt.left_out);
        self.consecutive_fixes += 1;
        if self.options.ambiguity == AmbiguityMode::FixAndHold
            && self.consecutive_fixes >= self.options.min_fixes_to_hold
            && self.may_hold()
        {
            if self.options.holds_outside_filter() {
                self.hold_outside_filter(attempt);
                return;
            }
            let resolution = self.resolution(&epoch.common, zero, true);
            if resolution.hold(&mut self.state, attempt) {
                self.learn_channel_biases(&epoch.common);
                self.held = true;
            }
        }
    }

    /// Distance of the float position from the position of `attempt`.
    fn float_misfit(&self, attempt: &Attempt) -> Option<FloatMisfit> {
        let np = self.state.leading_states;
        let frame = EnuFrame::from_ecef(self.state.position());
        let distance_ecef = std::array::from_fn(|k| attempt.x[k] - self.state.x[k]);
        let covariance_ecef = std::array::from_fn(|i| {
            std::array::from_fn(|j| self.state.covariance(i, j) - attempt.p[i * np + j])
        });
        let distance = Vector3::from(frame.enu_vector_from_ecef(distance_ecef));
        let of = frame.enu_covariance_from_ecef(&covariance_ecef);
        let covariance = Matrix3::from_fn(|i, j| of[i][j]);
        let whole = distance.dot(&covariance.cholesky()?.solve(&distance)) / 3.0;
        let level = distance.fixed_rows::<2>(0).into_owned();
        let of_level = covariance.fixed_view::<2, 2>(0, 0).into_owned();
        let horizontal = level.dot(&of_level.cholesky()?.solve(&level)) / 2.0;
        Some(FloatMisfit {
            whole,
            horizontal,
            vertical: distance.z.powi(2) / covariance[(2, 2)],
        })
    }

    fn remember(&mut self, rover: &RoverEpoch, base: &BaseView<'_>) {
        slips::remember(&mut self.state, self.options, 0, &rover.epoch);
        slips::remember(&mut self.state, self.options, 1, base.epoch);
    }
}
