//! A run of the filter over all rover epochs in one direction.

use super::base_zeros::{BaseStates, BaseZeros};
use super::code_noise::MeasuredNoise;
use super::confirm::{AGREEMENT_S, confirm_alone};
use super::constellation::Constellation;
use super::epoch_input::{BaseView, RoverEpoch};
use super::epoch_result::EpochResult;
use super::filter::Filter;
use super::float_errors::FloatErrors;
use super::glonass::decide;
use super::matching::{matching_base, nearest_base};
use super::measurement::{Epoch, Measurement};
use super::moving_base::{BaseTrack, moved};
use super::plausible::reject_implausible;
use super::precision::scale_covariances;
use super::signal_group::SignalGroup;
use super::single::SingleContext;
use super::zero::{ZeroDifference, zero_differences};
use crate::control::Watch;
use crate::observation::EPOCH_TOLERANCE_S;
use crate::options::{
    AmbiguityMode, FilterDirection, GlonassAmbiguity, PositioningMode, PpkOptions, RuleSet,
};
use crate::ppk_error::PpkError;
use crate::satellite::System;
use crate::solution::GlonassDecision;
use crate::workers::threads;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Everything that both directions share.
pub(crate) struct Prepared<'a> {
    pub constellation: &'a Constellation,
    pub options: &'a PpkOptions,
    /// Those of the trial pass.
    pub trial_options: &'a PpkOptions,
    pub rover: &'a [RoverEpoch],
    pub base: &'a [Epoch],
    pub base_zeros: &'a BaseZeros,
    pub base_states: &'a BaseStates,
    pub base_context: SingleContext<'a>,
    /// Where a moving base was.
    pub base_track: Option<&'a BaseTrack>,
    pub base_position_ecef_m: [f64; 3],
    pub noise: MeasuredNoise,
    /// Groups of signals that a trial pass found to contradict the others.
    pub left_out: Vec<SignalGroup>,
}

/// What a trial pass found.
pub(crate) struct Trial {
    /// As the pass alone can vouch for them.
    pub results: Vec<EpochResult>,
    /// The same before any fix is confirmed, in the order of processing.
    pub unconfirmed: Vec<EpochResult>,
    pub left_out: Vec<SignalGroup>,
}

impl<'a> Prepared<'a> {
    /// A filter at its start.
    pub(crate) fn filter(&'a self) -> Filter<'a> {
        self.filter_with(self.options)
    }

    fn filter_with(&'a self, options: &'a PpkOptions) -> Filter<'a> {
        Filter::new(self.constellation, options, &self.noise)
            .with_short_log(self.is_short_log())
            .without_groups(self.left_out.clone())
    }

    fn is_short_log(&self) -> bool {
        let ends = self.rover.first().zip(self.rover.last());
        ends.is_none_or(|(a, z)| z.epoch.tag.seconds_since(a.epoch.tag) < AGREEMENT_S)
    }

    /// Whether a trial pass has anything to decide: GLONASS ambiguities where that is left to the
    /// data, and the noise where it is measured.
    pub(crate) fn needs_trial(options: &PpkOptions) -> bool {
        options.mode.uses_phases()
            && (options.glonass_ambiguity == GlonassAmbiguity::Auto || options.measure_code_noise)
    }

    /// The results of a trial pass, and the groups of signals that contradict the others.
    pub(crate) fn trial(&self, watch: &Watch<'_>) -> Result<Trial, PpkError> {
        let backward = self.options.direction == FilterDirection::Backward;
        let mut filter = self.filter_with(self.trial_options);
        let unconfirmed =
            self.beside_look_ahead(backward, || self.run(&mut filter, backward, watch))?;
        let mut results = unconfirmed.clone();
        self.confirm_alone(&filter, &mut results);
        Ok(Trial {
            results,
            unconfirmed,
            left_out: filter.suspects.left_out().to_vec(),
        })
    }

    /// The result of `pass`, the first over the epochs. Where there is a second thread, it computes
    /// beside it what hangs on no filter and serves every pass: zero differences of the base, and
    /// those of the rover at its single-point positions.
    fn beside_look_ahead<T>(&self, backward: bool, pass: impl FnOnce() -> T) -> T {
        if threads(self.options) <= 1 {
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

    /// What a trial pass says of GLONASS ambiguities, where that is left to the data.
    pub(crate) fn glonass_decision(&self, trial: &[EpochResult]) -> Option<GlonassDecision> {
        let options = self.options;
        let observed = (0..self.constellation.len())
            .any(|k| self.constellation.id(k).system() == System::Glonass);
        let open = options.glonass_ambiguity == GlonassAmbiguity::Auto
            && options.ambiguity != AmbiguityMode::Off;
        (open && observed).then(|| decide(trial))
    }

    /// Zero differences of a base epoch for a rover epoch.
    fn base_zero(&self, index: usize, rover: usize) -> Arc<[ZeroDifference]> {
        self.base_zeros
            .get(rover, index, || self.new_base_zero(index, rover))
    }

    fn new_base_zero(&self, index: usize, rover: usize) -> Vec<ZeroDifference> {
        let epoch = &self.base[index];
        // Ephemerides are chosen by the rover's tag, so that both ends use the same ones.
        let mut states = self
            .base_states
            .get(rover, index, || {
                let tag = self.rover[rover].epoch.tag;
                self.base_context.states(epoch, tag, false)
            })
            .to_vec();
        let place_ecef_m = self.base_place_ecef_m(index);
        if !self.options.reproduce_defects {
            reject_implausible(self.constellation, epoch, &mut states, place_ecef_m);
        }
        zero_differences(
            self.base_context.options,
            epoch,
            &states,
            place_ecef_m,
            true,
        )
    }

    /// Where the base's antenna is taken to be at one of its epochs.
    fn base_place_ecef_m(&self, index: usize) -> [f64; 3] {
        let own = self.base_track.and_then(|track| track.at(index));
        own.map_or(self.base_position_ecef_m, |point| point.position_ecef_m)
    }

    /// A moving base at the epoch nearest to the rover's, carried to the rover's time.
    fn moving_base(&self, track: &BaseTrack, rover_index: usize) -> Option<BaseView<'_>> {
        let rover = &self.rover[rover_index];
        let time = rover.single.as_ref().ok()?.time;
        let index = nearest_base(self.base, &rover.epoch)?;
        let point = track.at(index)?;
        let age_s = time.seconds_since(point.time);
        Some(BaseView {
            epoch: &self.base[index],
            zero: self.base_zero(index, rover_index),
            place_ecef_m: point.position_ecef_m,
            moved: Some(moved(point, time)),
            age_s,
            noise_age_s: age_s,
        })
    }

    fn base_view(&self, rover_index: usize, backward: bool) -> Option<BaseView<'_>> {
        let rover = &self.rover[rover_index].epoch;
        if self.options.mode == PositioningMode::Single {
            return None;
        }
        if let Some(track) = self.base_track {
            return self.moving_base(track, rover_index);
        }
        if self.options.interpolate_base
            && let Some(view) = self.interpolated(rover_index, backward)
        {
            return Some(view);
        }
        let index = matching_base(self.base, rover, backward)?;
        let epoch = &self.base[index];
        let age_s = rover.tag.seconds_since(epoch.tag);
        Some(BaseView {
            epoch,
            zero: self.base_zero(index, rover_index),
            place_ecef_m: self.base_position_ecef_m,
            moved: None,
            age_s,
            noise_age_s: age_s,
        })
    }

    /// Base residuals interpolated linearly between its epochs around the rover's tag; satellites
    /// that slip in between are left out. `None` where there is nothing to interpolate.
    fn interpolated(&self, rover_index: usize, backward: bool) -> Option<BaseView<'_>> {
        let rover = &self.rover[rover_index].epoch;
        let after = self
            .base
            .partition_point(|b| b.tag.seconds_since(rover.tag) < -EPOCH_TOLERANCE_S);
        let (before, after) = (after.checked_sub(1)?, after);
        let next = self.base.get(after)?;
        let (from_previous_s, from_next_s) = (
            rover.tag.seconds_since(self.base[before].tag),
            rover.tag.seconds_since(next.tag),
        );
        let largest = self.options.max_age_s;
        if from_next_s.abs() < EPOCH_TOLERANCE_S
            || from_previous_s > largest
            || -from_next_s > largest
        {
            return None;
        }
        let (early, late) = (
            self.base_zero(before, rover_index),
            self.base_zero(after, rover_index),
        );
        let span_s = from_previous_s - from_next_s;
        // The epoch that flags and phases are taken from is the one the filter meets first.
        let (kept, other) = if backward {
            (after, before)
        } else {
            (before, after)
        };
        let (kept_zero, other_zero) = if backward {
            (&late, &early)
        } else {
            (&early, &late)
        };
        let (kept_weight, other_weight) = if backward {
            (from_previous_s / span_s, -from_next_s / span_s)
        } else {
            (-from_next_s / span_s, from_previous_s / span_s)
        };
        let slipped = |a: &Measurement, b: &Measurement, slot: usize| {
            a.slip_count[slot] != b.slip_count[slot]
                || (a.loss_of_lock[slot] ^ b.loss_of_lock[slot]) & 2 != 0
        };
        let mut zero = kept_zero.to_vec();
        for (k, z) in zero.iter_mut().enumerate() {
            let m = &self.base[kept].measurements[k];
            let partner = self.base[other].find(m.satellite);
            for slot in 0..self.options.frequencies {
                let (phase, code) = partner.map_or((0.0, 0.0), |p| {
                    let partner = &self.base[other].measurements[p];
                    let broken = slipped(m, partner, slot);
                    let phase = if broken {
                        0.0
                    } else {
                        other_zero[p].phase_m[slot]
                    };
                    (phase, other_zero[p].code_m[slot])
                });
                let blend = |mine: f64, theirs: f64| {
                    if mine == 0.0 || theirs == 0.0 {
                        0.0
                    } else {
                        mine * kept_weight + theirs * other_weight
                    }
                };
                z.phase_m[slot] = blend(z.phase_m[slot], phase);
                z.code_m[slot] = blend(z.code_m[slot], code);
            }
        }
        let noise_age_s = match self.options.rules {
            // What an interpolation leaves of a wandering clock: nothing at either end.
            _ if self.options.measure_code_noise => from_previous_s * -from_next_s / span_s,
            RuleSet::Rtklib => from_previous_s.max(-from_next_s),
            RuleSet::Demo5 => from_previous_s.min(-from_next_s),
        };
        Some(BaseView {
            epoch: &self.base[kept],
            zero: zero.into(),
            place_ecef_m: self.base_position_ecef_m,
            moved: None,
            age_s: if backward {
                from_next_s
            } else {
                from_previous_s
            },
            noise_age_s,
        })
    }

    /// Runs `filter` over all epochs; results in the order of processing, one per rover epoch
    /// that has a single-point position.
    pub(crate) fn run(
        &self,
        filter: &mut Filter<'a>,
        backward: bool,
        watch: &Watch<'_>,
    ) -> Result<Vec<EpochResult>, PpkError> {
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

    /// How float errors differ from what a filter states.
    pub(crate) fn float_errors(&self) -> FloatErrors {
        if self.options.measure_code_noise {
            FloatErrors {
                factors: self.noise.float_factors(),
                // Each pass has had half of the log in the middle of it.
                correlation: self.noise.lasting_share(self.rover.len() / 2),
            }
        } else {
            FloatErrors::AS_STATED
        }
    }

    /// As [`run`](Self::run), with fixes confirmed by nothing but the pass itself.
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

    /// Confirms the fixes of a pass by the pass itself, and states their covariances.
    fn confirm_alone(&self, filter: &Filter<'_>, results: &mut [EpochResult]) {
        if let Some(needed) = self.options.min_success_rate {
            confirm_alone(results, needed, &filter.withdrawn);
            scale_covariances(results);
            self.float_errors().scale(results);
        }
    }
}
