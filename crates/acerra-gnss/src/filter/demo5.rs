//! Ambiguity resolution by the rules of the demo5 branch: a gate on the float solution, retries
//! without newly risen satellites, leaving satellites out one at a time, and GLONASS joining once
//! its inter-channel biases are learnt.

use super::Filter;
use crate::ambiguity::attempt::{Attempt, Resolution, members};
use crate::measurements::common::Common;
use crate::measurements::signal_group::SuspectGroups;
use crate::measurements::zero::ZeroDifference;
use crate::observations::satellite::System;
use crate::options::GlonassAmbiguity;
use crate::solution::NotFixedReason;

impl Filter<'_> {
    pub(crate) fn resolve_demo5(
        &mut self,
        common: &[Common],
        zero: &[ZeroDifference],
        slipped: usize,
        half_cycle: usize,
    ) -> Result<Attempt, NotFixedReason> {
        let options = self.options;
        let variance_m2 = (0..3).map(|k| self.state.covariance(k, k)).sum::<f64>() / 3.0;
        if variance_m2 > options.position_variance_gate_m2 {
            self.previous_ratio = 0.0;
            self.previous_first_ratio = 0.0;
            self.previous_pairs = 0;
            return Err(NotFixedReason::FloatTooUncertain { variance_m2 });
        }
        let dropped = self.drop_one(common);
        let mut outcome = self.attempt_with_or_without_glonass(common, zero, slipped, half_cycle);
        let first_ratio = ratio(&outcome);
        if options
            .partial_ambiguity
            .is_some_and(|p| p.filter_new_satellites)
        {
            let failed = !accepted(&outcome);
            let collapsed = first_ratio < 1.1 * options.ratio_threshold
                && first_ratio < self.previous_first_ratio / 2.0;
            if (self.previously_fixed && failed) || collapsed {
                let mut delay = 2;
                let mut put_back = false;
                for slot in 0..options.frequencies {
                    for c in common {
                        let track = self.state.track_mut(c.satellite, slot);
                        if track.valid && track.lock == 0 {
                            track.lock = -options.min_lock_epochs - delay;
                            delay += 2;
                            put_back = true;
                        }
                    }
                }
                if put_back {
                    outcome =
                        self.attempt_with_or_without_glonass(common, zero, slipped, half_cycle);
                }
            }
        }
        if let Some((satellite, locks)) = dropped {
            let improved = ratio(&outcome) >= 1.5 * self.previous_ratio;
            if !accepted(&outcome) && !improved {
                for (slot, lock) in locks.into_iter().enumerate() {
                    self.state.track_mut(satellite, slot).lock = lock;
                }
            }
        }
        self.previous_first_ratio = first_ratio;
        self.previous_ratio = ratio(&outcome);
        self.previous_pairs = outcome.as_ref().map_or(0, |a| a.pairs.len());
        if let Ok(attempt) = &outcome
            && attempt.accepted
        {
            for (satellite, slot) in members(&attempt.pairs) {
                self.state.track_mut(satellite, slot).lock += 1;
            }
        }
        outcome
    }

    /// After a failure with many pairs, takes the next satellite out of ambiguity resolution.
    fn drop_one(&mut self, common: &[Common]) -> Option<(usize, Vec<i32>)> {
        let options = self.options;
        let partial = options.partial_ambiguity?;
        if self.previous_ratio >= options.ratio_threshold
            || self.previous_pairs < partial.min_pairs_to_drop.max(1)
        {
            self.next_to_drop = 0;
            return None;
        }
        let candidates: Vec<usize> = common
            .iter()
            .map(|c| c.satellite)
            .filter(|&s| {
                let track = self.state.track(s, 0);
                track.valid && track.lock >= 0 && track.half_cycle_known
            })
            .collect();
        let satellite = *candidates.get(self.next_to_drop % candidates.len().max(1))?;
        self.next_to_drop = (self.next_to_drop + 1) % candidates.len();
        let pairs = i32::try_from(self.previous_pairs).unwrap_or(i32::MAX);
        let locks = (0..options.frequencies)
            .map(|slot| {
                let track = self.state.track_mut(satellite, slot);
                std::mem::replace(&mut track.lock, -pairs)
            })
            .collect();
        Some((satellite, locks))
    }

    fn attempt_with_or_without_glonass(
        &self,
        common: &[Common],
        zero: &[ZeroDifference],
        slipped: usize,
        half_cycle: usize,
    ) -> Result<Attempt, NotFixedReason> {
        let learnt = self.options.glonass_ambiguity != GlonassAmbiguity::FixAndHold || self.held;
        let with = self.plain_attempt(common, zero, slipped, half_cycle, learnt);
        if learnt
            && self.options.glonass_ambiguity == GlonassAmbiguity::FixAndHold
            && !accepted(&with)
        {
            let without = self.plain_attempt(common, zero, slipped, half_cycle, false);
            if accepted(&without) {
                return without;
            }
        }
        with
    }

    fn plain_attempt(
        &self,
        common: &[Common],
        zero: &[ZeroDifference],
        slipped: usize,
        half_cycle: usize,
        with_glonass: bool,
    ) -> Result<Attempt, NotFixedReason> {
        let resolution = Resolution {
            constellation: self.constellation,
            options: self.options,
            common,
            rover: zero,
            with_glonass,
            variance_factor: 1.0,
            suspects: SuspectGroups::default(),
        };
        let pairs = resolution.pairs(&self.state);
        let least = self
            .options
            .partial_ambiguity
            .map_or(2, |p| p.min_satellites_to_fix.saturating_sub(1).max(2));
        if pairs.len() < least {
            let pairs = pairs.len();
            return Err(NotFixedReason::TooFewAmbiguities {
                pairs,
                slipped,
                half_cycle,
            });
        }
        resolution
            .attempt(&self.state, pairs)
            .map_err(|_| NotFixedReason::SearchFailed)
    }

    /// Moves a share of the fraction left in each GLONASS and SBAS bias difference into that
    /// satellite's inter-channel bias.
    pub(crate) fn learn_channel_biases(&mut self, common: &[Common]) {
        let options = self.options;
        if options.glonass_ambiguity != GlonassAmbiguity::FixAndHold {
            return;
        }
        for system in [System::Glonass, System::Sbas] {
            for slot in 0..options.frequencies {
                let mut reference = None;
                for c in common {
                    if self.constellation.id(c.satellite).system() != system
                        || !self.state.track(c.satellite, slot).valid
                    {
                        continue;
                    }
                    let index = self.state.bias_index(c.satellite, slot);
                    if !self.state.exists[index] {
                        continue;
                    }
                    let Some(reference) = reference else {
                        reference = Some(index);
                        continue;
                    };
                    let difference = self.state.x[index] - self.state.x[reference];
                    let share = options.hold_gain * (difference - difference.round());
                    self.state.x[index] -= share;
                    self.state.track_mut(c.satellite, slot).channel_bias_cycles += share;
                }
            }
        }
    }
}

fn accepted(outcome: &Result<Attempt, NotFixedReason>) -> bool {
    outcome.as_ref().is_ok_and(|a| a.accepted)
}

fn ratio(outcome: &Result<Attempt, NotFixedReason>) -> f64 {
    outcome.as_ref().map_or(0.0, |a| a.ratio)
}
