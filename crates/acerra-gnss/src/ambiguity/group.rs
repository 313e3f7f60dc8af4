//! Groups of signals whose phases contradict the rest: one frequency of one system.
//!
//! Receivers can disagree on a whole signal: by a quarter of a cycle between tracking modes, or where two
//! signals on one carrier count as one. The biases of the signal are then constant, but not integers;
//! together with the other signals they make every set of integers unlikely. Such a group is identified by
//! the gain in likelihood of the other signals when the group is left out.

use super::attempt::{Attempt, Pair, Resolution};
use crate::float::state::FilterState;
use crate::measurements::signal_group::SignalGroup;
use crate::observations::satellite::System;

/// Cost (−2 ln of the likelihood) per ambiguity from which integers contradict the float ones:
/// right integers have one on average, twice that by chance once in 10⁴ for 12 of them.
const CONTRADICTING_COST: f64 = 2.0;
/// Largest share of the cost per ambiguity that may remain: above it, other groups are the cause of the
/// contradiction.
const LARGEST_REST: f64 = 0.1;
/// Largest number of groups left out at a time.
const LARGEST_LEFT_OUT: usize = 2;
/// Least number of remaining pairs.
const LEAST_PAIRS: usize = 7;

impl Resolution<'_> {
    /// A fix without one or two groups, where integers with all groups contradict the float ambiguities: each
    /// step leaves out the group without which the rest is likeliest.
    pub(crate) fn attempt_without_groups(
        &self,
        state: &FilterState,
        full: &Attempt,
    ) -> Option<Attempt> {
        let mut pairs = full.pairs.clone();
        let mut cost = full.cost;
        let mut left_out = Vec::new();
        while left_out.len() < LARGEST_LEFT_OUT && cost > CONTRADICTING_COST * pairs.len() as f64 {
            let mut groups: Vec<SignalGroup> = pairs.iter().map(Pair::signal_group).collect();
            groups.dedup();
            // For GLONASS other rules apply.
            groups.retain(|g| g.system() != System::Glonass && self.suspects.may_contradict(*g));
            let without = |group: SignalGroup| {
                let rest = pairs.iter().filter(|p| p.signal_group() != group);
                let rest: Vec<Pair> = rest.copied().collect();
                if rest.len() < LEAST_PAIRS {
                    return None;
                }
                Some((group, self.attempt(state, rest).ok()?))
            };
            let per_pair = |attempt: &Attempt| attempt.cost / attempt.pairs.len() as f64;
            let (group, mut best) = groups
                .into_iter()
                .filter_map(without)
                .min_by(|(_, a), (_, b)| per_pair(a).total_cmp(&per_pair(b)))?;
            left_out.push(group);
            if best.accepted && per_pair(&best) <= LARGEST_REST * per_pair(full) {
                best.left_out = left_out;
                return Some(best);
            }
            (pairs, cost) = (best.pairs, best.cost);
        }
        None
    }
}
