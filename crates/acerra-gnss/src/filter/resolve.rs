//! Resolution of ambiguities at one epoch, and the checks before integers are accepted.

use super::epoch_result::EpochResult;
use super::{EpochView, Filter};
use crate::ambiguity::attempt::{Attempt, Pair, Resolution, members};
use crate::ambiguity::evidence::{Evidence, independent_phases};
use crate::float::state::FilterState;
use crate::linear::double_row::DoubleRow;
use crate::linear::outliers::{standardised, worst};
use crate::measurements::common::Common;
use crate::measurements::noise::{
    Separation, SignalView, single_difference_variance_m2, weak_signal_factor,
};
use crate::measurements::zero::ZeroDifference;
use crate::noise::phase_walk::{NormalisedResidual, of_satellites};
use crate::options::{AmbiguityMode, GlonassAmbiguity};
use crate::solution::NotFixedReason;

/// Satellites that may be left out of a fix because their phases contradict the others.
const LARGEST_LEFT_OUT: usize = 3;

impl<'a> Filter<'a> {
    /// Ambiguity resolution at this epoch.
    pub(super) fn resolution<'r>(
        &self,
        common: &'r [Common],
        zero: &'r [ZeroDifference],
        with_glonass: bool,
    ) -> Resolution<'r>
    where
        'a: 'r,
    {
        Resolution {
            constellation: self.constellation,
            options: self.options,
            common,
            rover: zero,
            with_glonass,
            variance_factor: self.variance_factor(),
            suspects: self.suspects.clone(),
        }
    }

    /// Whether the integers of a fix are likely enough by their covariance to be held until measurements
    /// contradict them.
    pub(super) fn is_settled(&self, attempt: &Attempt) -> bool {
        let least = self.options.min_success_rate;
        least.is_none_or(|least| self.rests_on_held || attempt.success_rate >= least)
    }

    /// Whether settled integers are right beyond reasonable doubt: at this epoch, or at an earlier epoch of a
    /// run of fixes or of the hold, the phases supported the integers against all others.
    pub(super) fn is_certain(
        &self,
        epoch: &EpochView<'_>,
        zero: &[ZeroDifference],
        attempt: &Attempt,
    ) -> bool {
        let Some(least) = self.options.min_success_rate else {
            return true;
        };
        if self.certain && !self.resolves_alone() {
            return true;
        }
        let variance = |satellite: usize, slot: usize| {
            self.phase_variance_cycles2(epoch, zero, satellite, slot)
        };
        let evidence = Evidence {
            state: &self.state,
            phase_variance_cycles2: &variance,
            all: &self.all_pairs,
            least_probability: least,
        };
        evidence.supports(attempt)
    }

    /// Epochs that are resolved one by one do not confirm each other's integers.
    fn resolves_alone(&self) -> bool {
        self.options.ambiguity == AmbiguityMode::Instantaneous
    }

    /// Variance by the model of the mean phase difference of a satellite between the receivers, since the
    /// satellite's ambiguity began (cycle²).
    pub(super) fn phase_variance_cycles2(
        &self,
        epoch: &EpochView<'_>,
        zero: &[ZeroDifference],
        satellite: usize,
        slot: usize,
    ) -> f64 {
        let found = epoch.common.iter().position(|c| c.satellite == satellite);
        found.map_or(0.0, |k| {
            let z = &zero[epoch.common[k].rover];
            let lasted_s = (self.last_time.zip(self.state.track(satellite, slot).began))
                .map_or(0.0, |(now, began)| now.seconds_since(began).abs());
            self.phase_variance_m2(satellite, slot, z)
                / epoch.wavelengths_m[k][slot].powi(2)
                / independent_phases(lasted_s)
        })
    }

    /// Variance of one phase difference between the receivers by the model (m²).
    fn phase_variance_m2(&self, satellite: usize, slot: usize, zero: &ZeroDifference) -> f64 {
        let signal = SignalView {
            system: self.constellation.id(satellite).system(),
            slot,
            is_code: false,
            sin_elevation: zero.sin_elevation,
            cn0_db_hz: [zero.cn0_db_hz[slot], 0.0],
            noise_power: [zero.noise_power[slot], 0.0],
        };
        let model = single_difference_variance_m2(self.options, &signal, Separation::NONE);
        model * weak_signal_factor(self.options, zero.cn0_drop_db[slot])
    }

    /// The satellites of `pairs` that partial resolution may leave out, the noisiest first; at
    /// most a third of them.
    pub(super) fn noisiest_first(
        &self,
        common: &[Common],
        zero: &[ZeroDifference],
        pairs: &[Pair],
    ) -> Vec<(usize, usize)> {
        let noise = |satellite: usize, slot: usize| {
            let found = common.iter().find(|c| c.satellite == satellite);
            found.map_or(0.0, |c| {
                self.phase_variance_m2(satellite, slot, &zero[c.rover])
            })
        };
        let mut members: Vec<_> = members(pairs)
            .into_iter()
            .map(|(satellite, slot)| (noise(satellite, slot), (satellite, slot)))
            .collect();
        members.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        members.truncate(members.len() / 3);
        members.into_iter().map(|(_, member)| member).collect()
    }

    /// Ambiguity resolution, and a check of the phases against the integers found: satellites
    /// that contradict the others are left out and the search repeated.
    pub(super) fn resolve_checked(
        &mut self,
        epoch: &EpochView<'_>,
        zero: &[ZeroDifference],
        excluded: &mut Vec<(usize, usize)>,
        result: &mut EpochResult,
    ) -> Result<Attempt, NotFixedReason> {
        let mut left_out = 0;
        self.all_pairs.clear();
        if self.options.min_success_rate.is_some() {
            let resolution = self.resolution(&epoch.common, zero, !self.glonass_float);
            self.all_pairs = resolution.pairs(&self.state);
        }
        loop {
            let conditioned = self.conditioned(&epoch.common);
            let attempt = self.resolve(epoch, zero, conditioned.as_ref(), result);
            self.held_state.clone_from(&conditioned);
            let attempt = attempt?;
            let Some(limit) = self.options.max_phase_residual_sigma else {
                return Ok(attempt);
            };
            let mut fixed =
                conditioned.unwrap_or_else(|| self.state.copied_into(self.spare.take()));
            fixed.x[..attempt.x.len()].copy_from_slice(&attempt.x);
            for (pair, integer) in attempt.pairs.iter().zip(&attempt.integers) {
                let reference = fixed.bias(pair.reference, pair.slot).unwrap_or(0.0);
                let index = fixed.bias_index(pair.other, pair.slot);
                fixed.x[index] = reference - integer;
            }
            let rover = self.zero_at(epoch.rover, fixed.position());
            let differences = self.differences(epoch, &rover, &fixed, excluded);
            let in_fix =
                |k: usize, slot: usize| self.state.track(epoch.common[k].satellite, slot).in_fix;
            let worst = worst(&differences.rows, false, in_fix);
            let Some(worst) = worst.filter(|w| w.normalised > limit) else {
                let (residuals, rows) = standardised(&differences.rows, false, in_fix);
                let squares = residuals.iter().map(|r| r.normalised.powi(2)).sum();
                // The position uses three degrees of freedom.
                result.phase_misfit = [squares, rows.saturating_sub(3) as f64];
                result.phase_residuals = of_satellites(residuals, &epoch.common);
                if self.options.measure_code_noise {
                    result.code_residuals = self.code_residuals(epoch, &differences.rows, &fixed);
                }
                self.spare = Some(fixed);
                return Ok(attempt);
            };
            self.spare = Some(fixed);
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

    /// The codes' residuals about the position of a fix, over the model's deviation of a single sample.
    fn code_residuals(
        &self,
        epoch: &EpochView<'_>,
        rows: &[DoubleRow],
        fixed: &FilterState,
    ) -> Vec<NormalisedResidual> {
        let factor = |k: usize, slot: usize| {
            let satellite = epoch.common[k].satellite;
            let system = self.constellation.id(satellite).system();
            let count = fixed.track(satellite, slot).codes_used;
            let inflation = epoch.inflation.get(k).map_or(1.0, |of| of[slot]);
            self.noise.of(system, slot).factor(count) * inflation
        };
        let by_model: Vec<DoubleRow> = rows
            .iter()
            .filter(|row| row.is_code)
            .map(|row| DoubleRow {
                variance_reference_m2: row.variance_reference_m2 / factor(row.reference, row.slot),
                variance_other_m2: row.variance_other_m2 / factor(row.other, row.slot),
                ..*row
            })
            .collect();
        let (residuals, _) = standardised(&by_model, true, |_, _| true);
        of_satellites(residuals, &epoch.common)
    }

    /// One search of the integers, with partial resolution where the options require it.
    pub(super) fn attempt_by_rtklib(
        &self,
        resolution: &Resolution<'_>,
        state: &FilterState,
        pairs: Vec<Pair>,
        [slipped, half_cycle]: [usize; 2],
    ) -> Result<Attempt, NotFixedReason> {
        if pairs.len() < 2 {
            let pairs = pairs.len();
            return Err(NotFixedReason::TooFewAmbiguities {
                pairs,
                slipped,
                half_cycle,
            });
        }
        match self.options.partial_ambiguity {
            None => resolution.attempt(state, pairs),
            Some(partial) => {
                let least = partial.min_satellites_to_fix.saturating_sub(1);
                let dispensable =
                    |of: &[Pair]| self.noisiest_first(resolution.common, resolution.rover, of);
                resolution.partial_attempt(state, pairs, dispensable, least)
            }
        }
        .map_err(|_| NotFixedReason::SearchFailed)
    }

    /// Ambiguity resolution of this epoch: the accepted attempt, or the reason for a failure.
    pub(super) fn resolve(
        &mut self,
        epoch: &EpochView<'_>,
        zero: &[ZeroDifference],
        conditioned: Option<&FilterState>,
        result: &mut EpochResult,
    ) -> Result<Attempt, NotFixedReason> {
        let (options, common) = (self.options, &epoch.common[..]);
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
        let attempt = if options.policy().resolves_by_demo5() {
            self.resolve_demo5(common, zero, slipped, half_cycle)?
        } else {
            self.resolve_own(epoch, zero, conditioned, [slipped, half_cycle])?
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

    /// The attempt of this epoch with GLONASS, and without GLONASS where the first attempt fails.
    fn resolve_own(
        &self,
        epoch: &EpochView<'_>,
        zero: &[ZeroDifference],
        conditioned: Option<&FilterState>,
        counts: [usize; 2],
    ) -> Result<Attempt, NotFixedReason> {
        let (options, common) = (self.options, &epoch.common[..]);
        let learning = options.glonass_ambiguity == GlonassAmbiguity::FixAndHold;
        let optional = options.glonass_ambiguity == GlonassAmbiguity::Auto;
        let mut outcome = None;
        let mut tried: Option<Vec<Pair>> = None;
        // GLONASS is included once its biases are estimated; a fix that fails with GLONASS is tried without.
        let tries: &[bool] = match (learning, self.held) {
            _ if self.glonass_float => &[false],
            (false, _) if !optional => &[true],
            (false, _) => &[true, false],
            (true, false) => &[false],
            (true, true) => &[true, false],
        };
        for &with_glonass in tries {
            let resolution = self.resolution(common, zero, with_glonass);
            let state = conditioned.unwrap_or(&self.state);
            let pairs = resolution.pairs(state);
            // Without GLONASS satellites the second try would repeat the first.
            if tried.as_ref() == Some(&pairs) {
                continue;
            }
            tried = Some(pairs.clone());
            let attempt = self.attempt_by_rtklib(&resolution, state, pairs, counts);
            let accepted = attempt.as_ref().is_ok_and(|a| a.accepted);
            if accepted || outcome.is_none() {
                outcome = Some(attempt);
            }
            if accepted {
                break;
            }
        }
        let outcome = outcome.unwrap_or(Err(NotFixedReason::SearchFailed));
        if let Some(normalised) =
            conditioned.and_then(|state| self.new_ambiguities_contradict(epoch, zero, state))
        {
            return Err(NotFixedReason::PhasesInconsistent { normalised });
        }
        outcome
    }
}
