//! The integers of an ambiguity fix, and whether two fixes agree on them.

use super::ambiguity::{Attempt, Pair};
use super::double::GROUPS;
use super::state::FilterState;
use crate::satellite::System;

/// Fewest ambiguities that must be the same for one fix to confirm another: a position takes three,
/// so that three would agree with some place whatever they are; the fourth is the first to check.
const LEAST_SHARED: usize = 4;
/// The same where both rest on one set of held integers: the float state, which knows nothing of
/// them, has checked the set at every epoch, and only that it is still this set is in question.
const LEAST_SHARED_OF_HELD: usize = 3;
/// The same between passes, which have nothing else in common.
const LEAST_SHARED_BETWEEN_PASSES: usize = 4;

/// The float solution of an epoch, before integers are imposed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FloatSolution {
    pub position_ecef_m: [f64; 3],
    pub covariance_ecef_m2: [[f64; 3]; 3],
    /// Velocity (ECEF, m/s) and its covariance, where it is estimated.
    pub velocity: Option<([f64; 3], [[f64; 3]; 3])>,
}

/// The integers of a fix, with the float solution to fall back to.
#[derive(Debug, Clone)]
pub(crate) struct FixedIntegers {
    pairs: Vec<Pair>,
    integers: Vec<f64>,
    /// Numbers of the biases of each pair's reference and other satellite.
    arcs: Vec<[u32; 2]>,
    /// Probability that they are right, from the float ambiguities' covariance.
    pub success_rate: f64,
    pub certain: bool,
    /// Number of the set of held integers in force.
    pub generation: u32,
    /// The same, of a fix that rests on them.
    pub held: Option<u32>,
    pub float: FloatSolution,
}

impl FixedIntegers {
    /// The integers of `attempt`; `float` is the epoch's solution before they are imposed.
    ///
    /// GLONASS is left aside: its differences between carriers drift with the receivers' clocks.
    pub(crate) fn new(
        attempt: &Attempt,
        state: &FilterState,
        certain: bool,
        generation: u32,
        float: FloatSolution,
    ) -> Self {
        let arc = |satellite, slot| state.track(satellite, slot).arc;
        let of_attempt = attempt.pairs.iter().zip(&attempt.integers);
        let kept = || {
            of_attempt
                .clone()
                .filter(|(p, _)| GROUPS[p.group] != [System::Glonass])
        };
        Self {
            pairs: kept().map(|(p, _)| *p).collect(),
            integers: kept().map(|(_, integer)| *integer).collect(),
            arcs: kept()
                .map(|(p, _)| [arc(p.reference, p.slot), arc(p.other, p.slot)])
                .collect(),
            success_rate: attempt.success_rate,
            certain,
            generation,
            held: None,
            float,
        }
    }

    /// Integer of a satellite relative to its group's reference, and the number of its bias.
    fn of(&self, satellite: usize, slot: usize, group: usize) -> Option<(f64, u32)> {
        let own = self
            .pairs
            .iter()
            .position(|p| p.other == satellite && p.slot == slot);
        let reference = || {
            self.pairs
                .iter()
                .position(|p| p.reference == satellite && (p.slot, p.group) == (slot, group))
        };
        own.map(|k| (self.integers[k], self.arcs[k][1]))
            .or_else(|| reference().map(|k| (0.0, self.arcs[k][0])))
    }

    /// Whether both fixes of one pass put the same integers to the satellites that they share and
    /// that did not slip in between.
    pub(crate) fn same_as(&self, other: &Self) -> bool {
        let least = match (self.held, other.held) {
            (Some(a), Some(b)) if a == b => LEAST_SHARED_OF_HELD,
            _ => LEAST_SHARED,
        };
        self.shared_with(other, true).is_some_and(|n| n >= least)
    }

    /// Whether every integer of this fix is the other's too.
    pub(crate) fn is_part_of(&self, other: &Self) -> bool {
        self.shared_with(other, true) == Some(self.pairs.len())
    }

    /// As [`same_as`](Self::same_as), of fixes of different passes: a slip in between makes them
    /// differ.
    pub(crate) fn same_as_in_another_pass(&self, other: &Self) -> bool {
        let shared = self.shared_with(other, false);
        shared.is_some_and(|n| n >= LEAST_SHARED_BETWEEN_PASSES)
    }

    /// How many integers both have in common; `None` where one differs. `of_same_arcs` leaves out
    /// satellites that slipped in between.
    fn shared_with(&self, other: &Self, of_same_arcs: bool) -> Option<usize> {
        let mut shared = 0;
        for ((pair, integer), arcs) in self.pairs.iter().zip(&self.integers).zip(&self.arcs) {
            let theirs = |satellite| other.of(satellite, pair.slot, pair.group);
            if let (Some(a), Some(b)) = (theirs(pair.reference), theirs(pair.other)) {
                if of_same_arcs && [a.1, b.1] != *arcs {
                    continue;
                }
                if (b.0 - a.0 - integer).abs() > 0.5 {
                    return None;
                }
                shared += 1;
            }
        }
        Some(shared)
    }
}
