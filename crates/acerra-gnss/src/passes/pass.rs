//! A run of the filter over all rover epochs in one direction.

use super::float_errors::FloatErrors;
use super::precision::scale_covariances;
use crate::confirm::agreement::confirm_alone;
use crate::control::watch::Watch;
use crate::control::workers::threads;
use crate::filter::Filter;
use crate::filter::epoch_result::EpochResult;
use crate::filter::glonass::decide;
use crate::measurements::base_zeros::{BaseStates, BaseZeros};
use crate::measurements::constellation::Constellation;
use crate::measurements::measurement::Epoch;
use crate::measurements::signal_group::SignalGroup;
use crate::noise::code_noise::MeasuredNoise;
use crate::observations::satellite::System;
use crate::options::{AmbiguityMode, FilterDirection, GlonassAmbiguity, PpkOptions};
use crate::single::SingleContext;
use crate::solution::{GlonassDecision, PpkError};
use crate::stations::epoch_input::RoverEpoch;
use crate::stations::moving_base::BaseTrack;
use std::sync::atomic::{AtomicBool, Ordering};

/// Inputs shared by both directions.
pub(crate) struct Prepared<'a> {
    pub constellation: &'a Constellation,
    pub options: &'a PpkOptions,
    /// Options of the trial pass.
    pub trial_options: &'a PpkOptions,
    pub rover: &'a [RoverEpoch],
    pub base: &'a [Epoch],
    pub base_zeros: &'a BaseZeros,
    pub base_states: &'a BaseStates,
    pub base_context: SingleContext<'a>,
    /// Positions of a moving base.
    pub base_track: Option<&'a BaseTrack>,
    pub base_position_ecef_m: [f64; 3],
    pub noise: MeasuredNoise,
    /// Groups of signals that a trial pass found to contradict the others.
    pub left_out: Vec<SignalGroup>,
}

/// Results of a trial pass.
pub(crate) struct Trial {
    /// Results confirmed by the pass alone.
    pub results: Vec<EpochResult>,
    /// The results before any fix is confirmed, in the order of processing.
    pub unconfirmed: Vec<EpochResult>,
    pub left_out: Vec<SignalGroup>,
}

impl<'a> Prepared<'a> {
    /// A filter in its initial state.
    pub(crate) fn filter(&'a self) -> Filter<'a> {
        self.filter_with(self.options)
    }

    fn filter_with(&'a self, options: &'a PpkOptions) -> Filter<'a> {
        Filter::new(self.constellation, options, &self.noise).without_groups(self.left_out.clone())
    }

    /// Whether a trial pass is needed: to decide on GLONASS ambiguities where the decision is left to the
    /// data, or to measure the noise.
    pub(crate) fn needs_trial(options: &PpkOptions) -> bool {
        options.mode.uses_phases()
            && (options.glonass_ambiguity == GlonassAmbiguity::Auto || options.measure_code_noise)
    }

    /// The results of a trial pass, and the groups of signals that contradict the others.
    pub(crate) fn trial(&self, watch: &Watch<'_>) -> Result<Trial, PpkError> {
        let backward = self.options.direction == FilterDirection::Backward;
        let mut filter = self.filter_with(self.trial_options);
        let unconfirmed =
            self.with_look_ahead(backward, watch, || self.run(&mut filter, backward, watch))?;
        let mut results = unconfirmed.clone();
        self.confirm_alone(&filter, &mut results);
        Ok(Trial {
            results,
            unconfirmed,
            left_out: filter.suspects.left_out().to_vec(),
        })
    }

    /// The result of `pass`, the first over the epochs. A second thread, where available, computes in
    /// parallel the data that depend on no filter and serve every pass: zero differences of the base, and
    /// those of the rover at its single-point positions.
    fn with_look_ahead<T>(&self, backward: bool, watch: &Watch<'_>, pass: impl FnOnce() -> T) -> T {
        if threads(self.options) <= 1 || watch.shares_threads() {
            return pass();
        }
        let done = AtomicBool::new(false);
        let look_ahead = || {
            for k in 0..self.rover.len() {
                if done.load(Ordering::Relaxed) {
                    break;
                }
                let index = if backward {
                    self.rover.len() - 1 - k
                } else {
                    k
                };
                let rover = &self.rover[index];
                if let Ok(single) = &rover.single {
                    self.base_view(index, backward);
                    rover.zero_at(self.options, single.position_ecef_m);
                }
            }
        };
        std::thread::scope(|scope| {
            scope.spawn(look_ahead);
            let result = pass();
            done.store(true, Ordering::Relaxed);
            result
        })
    }

    /// Decision of a trial pass on GLONASS ambiguities, where the decision is left to the data.
    pub(crate) fn glonass_decision(&self, trial: &[EpochResult]) -> Option<GlonassDecision> {
        let options = self.options;
        let observed = (0..self.constellation.len())
            .any(|k| self.constellation.id(k).system() == System::Glonass);
        let open = options.glonass_ambiguity == GlonassAmbiguity::Auto
            && options.ambiguity != AmbiguityMode::Off;
        (open && observed).then(|| decide(trial))
    }

    /// Runs `filter` over all epochs; results in the order of processing, one per rover epoch
    /// that has a single-point position.
    pub(crate) fn run(
        &self,
        filter: &mut Filter<'a>,
        backward: bool,
        watch: &Watch<'_>,
    ) -> Result<Vec<EpochResult>, PpkError> {
        let _permit = watch.permit();
        filter.backward = backward;
        let n = self.rover.len();
        let mut results = Vec::with_capacity(n);
        for k in 0..n {
            watch.one_more()?;
            let index = if backward { n - 1 - k } else { k };
            let rover = &self.rover[index];
            match &rover.single {
                Ok(single) => {
                    let base = self.base_view(index, backward);
                    results.push(filter.step(rover, single, base));
                }
                Err(_) => filter.last_time = Some(rover.epoch.tag),
            }
        }
        Ok(results)
    }

    /// Ratio of float errors to the filter's stated errors.
    pub(crate) fn float_errors(&self) -> FloatErrors {
        if self.options.measure_code_noise {
            FloatErrors {
                factors: self.noise.float_factors(),
                // At the middle of the log each pass has processed half of it.
                correlation: self.noise.lasting_share(self.rover.len() / 2),
            }
        } else {
            FloatErrors::AS_STATED
        }
    }

    /// As [`run`](Self::run), with fixes confirmed by the pass alone.
    pub(crate) fn run_alone(
        &self,
        filter: &mut Filter<'a>,
        backward: bool,
        watch: &Watch<'_>,
    ) -> Result<Vec<EpochResult>, PpkError> {
        let mut results = self.run(filter, backward, watch)?;
        self.confirm_alone(filter, &mut results);
        Ok(results)
    }

    /// Confirms the fixes of a pass by the pass alone, and scales their covariances.
    fn confirm_alone(&self, filter: &Filter<'_>, results: &mut [EpochResult]) {
        if let Some(needed) = self.options.min_success_rate {
            confirm_alone(results, needed, &filter.withdrawn);
            scale_covariances(results);
            self.float_errors().scale(results);
        }
    }
}
