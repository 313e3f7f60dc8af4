//! The integers of an ambiguity fix, and their comparison between two fixes.

use super::attempt::{Attempt, Pair};
use crate::float::state::FilterState;
use crate::measurements::signal_group::GROUPS;
use crate::observations::satellite::System;

/// Fewest equal ambiguities by which one fix confirms another: a position is determined by three, so that any
/// three integers agree with some position; the fourth is the first redundant integer.
const LEAST_SHARED: usize = 4;
/// Fewest equal ambiguities where both fixes use one set of held integers: the float state, which is
/// independent of the held integers, has tested the set at every epoch, so that only the identity of the set
/// needs a test.
const LEAST_SHARED_OF_HELD: usize = 3;
/// Fewest equal ambiguities between passes, which have no held integers in common.
const LEAST_SHARED_BETWEEN_PASSES: usize = 4;

/// Number of differences of satellites that determine a position.
const POSITION_DIRECTIONS: usize = 3;

/// Comparison of the integer differences that two fixes share, for phases without a slip in between.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Continuity {
    /// Number of equal differences.
    pub kept: usize,
    /// Number of satellites whose integers changed relative to the others.
    pub changed: usize,
}

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
    /// Bias numbers (arcs) of each pair's reference and other satellite.
    arcs: Vec<[u32; 2]>,
    /// Number of slips of these phases that the pass has found so far.
    slips: Vec<[u32; 2]>,
    /// Number of differences of satellites used by the fix, GLONASS included, each counted once for all
    /// frequencies.
    pub directions: usize,
    /// Probability that the integers are right, from the float ambiguities' covariance.
    pub success_rate: f64,
    pub certain: bool,
    /// Number of the set of held integers in force.
    pub generation: u32,
    /// The integers of a fix that uses held integers.
    pub held: Option<u32>,
    pub float: FloatSolution,
}

impl FixedIntegers {
    /// The integers of `attempt`; `float` is the epoch's solution before they are imposed.
    ///
    /// GLONASS is omitted: differences between its carriers drift with the receivers' clocks.
    pub(crate) fn new(
        attempt: &Attempt,
        state: &FilterState,
        certain: bool,
        generation: u32,
        float: FloatSolution,
    ) -> Self {
        let arc = |satellite, slot| state.track(satellite, slot).arc;
        let slips = |satellite, slot| state.track(satellite, slot).slips;
        let mut directions: Vec<_> = attempt.pairs.iter().map(|p| p.other).collect();
        directions.sort_unstable();
        directions.dedup();
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
            slips: kept()
                .map(|(p, _)| [slips(p.reference, p.slot), slips(p.other, p.slot)])
                .collect(),
            directions: directions.len(),
            success_rate: attempt.success_rate,
            certain,
            generation,
            held: None,
            float,
        }
    }

    /// Whether phases of more satellites than determine a position check the fix. A second frequency of the
    /// same satellites does not: any integers of four satellites agree with some position.
    pub(crate) fn is_checked(&self) -> bool {
        self.directions > POSITION_DIRECTIONS
    }

    /// Whether two or more satellites check the fix beyond those that determine a position. A single
    /// redundant satellite is a single check: where codes leave a volume of a few metres for the position,
    /// dozens of sets of integers have a position within it, and about every fifth wrong set fits one more
    /// phase to within its noise.
    pub(crate) fn is_checked_twice(&self) -> bool {
        self.directions > POSITION_DIRECTIONS + 1
    }

    /// Integer of a satellite relative to the group's reference, and the number of the satellite's bias.
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

    /// Whether both fixes of one pass have equal integers for their common satellites without a slip in
    /// between.
    pub(crate) fn same_as(&self, other: &Self) -> bool {
        let least = match (self.held, other.held) {
            (Some(a), Some(b)) if a == b => LEAST_SHARED_OF_HELD,
            _ => LEAST_SHARED,
        };
        self.shared_with(other, true).is_some_and(|n| n >= least)
    }

    /// Whether the other fix has every integer of this fix.
    pub(crate) fn is_part_of(&self, other: &Self) -> bool {
        self.shared_with(other, true) == Some(self.pairs.len())
    }

    /// As [`same_as`](Self::same_as), for fixes of different passes: a slip in between makes the fixes
    /// differ.
    pub(crate) fn same_as_in_another_pass(&self, other: &Self) -> bool {
        let shared = self.shared_with(other, false);
        shared.is_some_and(|n| n >= LEAST_SHARED_BETWEEN_PASSES)
    }

    /// Comparison of the integers of phases without a slip between two fixes: fixes of one pass, or of passes
    /// `at_one_epoch`.
    pub(crate) fn continuity(&self, other: &Self, at_one_epoch: bool) -> Continuity {
        let mut found = Continuity::default();
        let of_signals = |a: &Pair, b: &Pair| (a.slot, a.group) == (b.slot, b.group);
        let mut start = 0;
        for block in self.pairs.chunk_by(of_signals) {
            let first = (block[0].reference, 0.0, self.slips[start][0]);
            let others = block.iter().enumerate().map(|(k, pair)| {
                let own = start + k;
                (pair.other, self.integers[own], self.slips[own][1])
            });
            // Changes of the integers of these signals' satellites, the reference first.
            let changes = std::iter::once(first).chain(others);
            let mut changes: Vec<i64> = changes
                .filter_map(|(satellite, integer, slips)| {
                    let (of_other, theirs) = other.in_block(satellite, &block[0])?;
                    let unbroken = at_one_epoch || theirs == slips;
                    unbroken.then(|| (integer - of_other).round() as i64)
                })
                .collect();
            changes.sort_unstable();
            let alike = changes.chunk_by(|a, b| a == b).map(<[i64]>::len).max();
            let alike = alike.unwrap_or(0);
            found.kept += alike.saturating_sub(1);
            found.changed += changes.len() - alike;
            start += block.len();
        }
        found
    }

    /// Integer of a satellite relative to the reference of its block, which has the slot and group of
    /// `like`, and the slips of its phase.
    fn in_block(&self, satellite: usize, like: &Pair) -> Option<(f64, u32)> {
        let mut block = (0..self.pairs.len())
            .filter(|&k| (self.pairs[k].slot, self.pairs[k].group) == (like.slot, like.group))
            .peekable();
        let first = *block.peek()?;
        if self.pairs[first].reference == satellite {
            return Some((0.0, self.slips[first][0]));
        }
        let own = block.find(|&k| self.pairs[k].other == satellite)?;
        Some((self.integers[own], self.slips[own][1]))
    }

    /// Number of integers in common; `None` where one differs. `of_same_arcs` leaves out satellites that
    /// slipped in between.
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

    /// Integers of one system's satellites against a common reference that never slips.
    #[cfg(test)]
    pub(crate) fn of_one_block(integers: &[f64], slips: &[u32], certain: bool) -> Self {
        let pair = |k: usize| Pair {
            slot: 0,
            group: 0,
            reference: 0,
            other: k + 1,
        };
        Self {
            pairs: (0..integers.len()).map(pair).collect(),
            integers: integers.to_vec(),
            arcs: vec![[0; 2]; integers.len()],
            slips: slips.iter().map(|slips| [0, *slips]).collect(),
            directions: integers.len(),
            success_rate: 1.0,
            certain,
            generation: 0,
            held: None,
            float: FloatSolution {
                position_ecef_m: [0.0; 3],
                covariance_ecef_m2: [[0.0; 3]; 3],
                velocity: None,
            },
        }
    }
}
