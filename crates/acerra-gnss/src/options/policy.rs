//! Rules of other programs that the engine can follow exactly: RTKLIB 2.4.3 b34 with its defects, and the
//! demo5 branch (RTKLIB-EX).
//!
//! Every difference from the engine's rules is one method here, so that the engine names the rule and not the
//! program. Sources: observed behaviour of RTKLIB 2.4.3 b34 and RTKLIB-EX 2.5.1.

use super::all::PpkOptions;
use super::choices::{AmbiguityMode, PartialAmbiguity, PositioningMode, RuleSet};

/// Rules of a run that differ from the engine's rules.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Policy {
    demo5: bool,
    defects: bool,
}

impl PpkOptions {
    /// The rules that these options follow.
    pub(crate) const fn policy(&self) -> Policy {
        Policy {
            demo5: matches!(self.rules, RuleSet::Demo5),
            defects: self.reproduce_defects,
        }
    }

    /// Whether integers are kept outside the filter, where they can be withdrawn, instead of being fed back
    /// into the filter.
    pub(crate) fn holds_outside_filter(&self) -> bool {
        self.revisable_hold && !self.policy().demo5 && self.ambiguity == AmbiguityMode::FixAndHold
    }

    /// Whether two fixes of a receiver at rest may differ by more than their standard deviations.
    pub(crate) fn tolerates_static_difference(&self) -> bool {
        self.mode == PositioningMode::Static && !self.policy().defects
    }

    /// Fewest pairs that are held.
    pub(crate) fn least_pairs_to_hold(&self) -> usize {
        let partial = self.partial_ambiguity.filter(|_| self.policy().demo5);
        partial
            .map_or(1, |p: PartialAmbiguity| p.min_pairs_to_hold)
            .max(1)
    }

    /// Whether slips are detected in Doppler shifts.
    pub(crate) fn detects_slips_by_doppler(&self) -> bool {
        self.policy().demo5 && self.doppler_slip_threshold_cycles_s > 0.0
    }

    /// Factor on the standard deviation of the codes of single-point positions; `own` is the engine's factor.
    pub(crate) fn single_point_code_factor(&self, own: f64) -> f64 {
        if self.policy().demo5 {
            self.code_phase_ratio[0]
        } else {
            own
        }
    }

    /// Factor on the standard deviation of the phases of a frequency slot.
    pub(crate) fn phase_factor(&self, slot: usize) -> f64 {
        if self.policy().demo5 {
            self.code_phase_ratio[slot] / self.code_phase_ratio[0]
        } else {
            1.0
        }
    }
}

impl Policy {
    /// Whether ambiguities are resolved by demo5's procedure.
    pub(crate) const fn resolves_by_demo5(self) -> bool {
        self.demo5
    }

    /// Whether a satellite has been tracked for long enough to be resolved; `lock` counts epochs.
    pub(crate) const fn is_locked(self, lock: i32) -> bool {
        if self.demo5 { lock >= 0 } else { lock > 0 }
    }

    /// Lock count after one more epoch with a valid phase.
    pub(crate) const fn next_lock(self, lock: i32) -> i32 {
        if self.demo5 && lock >= 0 {
            lock
        } else {
            lock + 1
        }
    }

    /// Whether a new ambiguity waits as long as an ambiguity after a slip.
    pub(crate) const fn new_ambiguities_wait(self) -> bool {
        self.demo5
    }

    /// Whether phases with an unknown half cycle are resolved as well.
    pub(crate) const fn resolves_half_cycles(self) -> bool {
        self.defects
    }

    /// Variance (m²) added to a phase whose half cycle is unknown.
    pub(crate) const fn half_cycle_variance_m2(self) -> f64 {
        if self.demo5 { 0.01 } else { 0.0 }
    }

    /// Whether SBAS ambiguities are resolved where GLONASS ones are not.
    pub(crate) const fn resolves_sbas_without_glonass(self) -> bool {
        !self.demo5
    }

    /// Whether codes without a phase of the same signal count.
    pub(crate) const fn takes_codes_without_phase(self) -> bool {
        self.demo5
    }

    /// Whether satellites with a slip and SBAS satellites are avoided as reference.
    pub(crate) const fn prefers_calm_reference(self) -> bool {
        self.demo5
    }

    /// Whether an innovation beyond its limit counts against the reference satellite as well.
    pub(crate) const fn rejects_reference(self) -> bool {
        !self.demo5
    }

    /// Factor on the limit of innovations of a new ambiguity.
    pub(crate) const fn fresh_innovation_factor(self) -> f64 {
        if self.demo5 { 10.0 } else { 1.0 }
    }

    /// Whether a phase with an innovation beyond its limit is excluded from a fix.
    pub(crate) const fn rejected_phases_are_invalid(self) -> bool {
        self.demo5
    }

    /// Whether this number of rejections in a row counts as a slip.
    pub(crate) const fn is_slip(self, rejections: u32) -> bool {
        self.demo5 && rejections >= 2
    }

    /// Fewest double differences of an update.
    pub(crate) const fn least_rows(self) -> usize {
        if self.demo5 { 4 } else { 1 }
    }

    /// Whether this number of double differences gives a position by codes where phases are too few.
    pub(crate) const fn gives_position_by_codes(self, rows: usize) -> bool {
        self.demo5 && rows >= 4
    }

    /// Whether acceleration moves the position however uncertain the acceleration is.
    pub(crate) const fn always_accelerates(self) -> bool {
        !self.demo5
    }

    /// Whether a Galileo ephemeris of any message, and of the future, is taken.
    pub(crate) const fn takes_any_galileo(self) -> bool {
        self.demo5
    }

    /// Whether single-point residuals must pass a χ² test.
    pub(crate) const fn tests_single_point(self) -> bool {
        !self.demo5
    }

    /// Factor on a delay's variance on another carrier, from the squared ratio of frequencies.
    pub(crate) fn ionosphere_scale(self, squared_ratio: f64) -> f64 {
        if self.demo5 {
            squared_ratio * squared_ratio
        } else {
            squared_ratio
        }
    }

    /// Age (s) that determines the clock noise of an interpolation between two base epochs.
    pub(crate) const fn interpolation_age_s(self, from_previous_s: f64, to_next_s: f64) -> f64 {
        if self.demo5 {
            from_previous_s.min(to_next_s)
        } else {
            from_previous_s.max(to_next_s)
        }
    }

    /// Whether pseudoranges that disagree with the receiver's position are refused.
    pub(crate) const fn refuses_implausible(self) -> bool {
        !self.defects
    }

    /// Rank of an epoch without a position among the numbers of qualities; the lower number wins.
    pub(crate) const fn rank_of_none(self) -> u8 {
        if self.defects { 0 } else { u8::MAX }
    }

    /// Whether only the flags of the epochs processed, and of those with a phase, count as slips.
    pub(crate) const fn sees_flags_of_processed_only(self) -> bool {
        self.defects
    }

    /// Whether a repeated update keeps the present position with the covariance from before the update.
    pub(crate) const fn repeats_from_present(self) -> bool {
        self.defects
    }
}
