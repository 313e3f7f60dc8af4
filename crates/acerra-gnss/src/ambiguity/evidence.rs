//! Test whether the phases of an epoch support one set of integers against all others.
//!
//! The filter models errors of phases as white noise and ambiguities as constants. Multipath lasts for
//! minutes: ten epochs in a row hold nearly the same error, and integers that fit a reflection by chance
//! would soon look far likelier than they are. Here the whole error of a phase counts as correlated: the
//! ambiguities' covariance is never smaller than the covariance of the mean of the correlated phases.
//!
//! Where all satellites fail the ratio test, a search without one satellite may pass it: because that
//! satellite was faulty, or because one of many searches passes by chance. Leaving a satellite out removes
//! its evidence and therefore adds a cost: a faulty phase is rare (1 %), and its fraction of a cycle is
//! uniform, while noise is a quarter to a tenth of a cycle wide. −2 ln of the product of both probabilities
//! is 12 to 14 for each satellite.

use super::attempt::{Attempt, Pair, RULED_OUT_DIFFERENCE, differences, members};
use super::lambda::integer_least_squares;
use crate::float::state::FilterState;
use crate::measurements::signal_group::SignalGroup;
use crate::noise::calibration::PHASE_CORRELATION_S;
use nalgebra::DMatrix;

/// Number of independent phases in a mean over a time (s): the variance of a mean of a first-order
/// Gauss–Markov process falls with the time over twice its correlation time.
pub(crate) fn independent_phases(lasted_s: f64) -> f64 {
    1.0 + lasted_s / (2.0 * PHASE_CORRELATION_S)
}

/// The float ambiguities, and the largest error of their phases that lasts for minutes.
pub(crate) struct Evidence<'a> {
    pub state: &'a FilterState,
    /// Variance (cycle²) of the phase of a satellite, by its index, and slot.
    pub phase_variance_cycles2: &'a dyn Fn(usize, usize) -> f64,
    /// The pairs of the epoch, before any pair is left out.
    pub all: &'a [Pair],
    /// Least probability of the integers.
    pub least_probability: f64,
}

impl Evidence<'_> {
    /// Whether the integers of `attempt` are as likely as required against the second-best set, and against
    /// the set that best fits the satellites left out by `attempt`.
    pub(crate) fn supports(&self, attempt: &Attempt) -> bool {
        let (float, covariance) = self.differences(&attempt.pairs);
        let Ok(found) = integer_least_squares(&float, covariance.as_slice(), 2) else {
            return false;
        };
        let mut both = found.integers[0].iter().zip(&attempt.integers);
        let least_odds = self.least_probability / (1.0 - self.least_probability);
        both.all(|(a, b)| (a - b).abs() < 0.5)
            && found.costs[1] - found.costs[0] >= 2.0 * least_odds.ln()
            && self.outweighs_left_out(attempt, found.costs[0])
    }

    /// Cost of the best integers of `pairs`, with the lasting errors of phases; `None` without pairs.
    pub(crate) fn cost(&self, pairs: &[Pair]) -> Option<f64> {
        let (float, covariance) = self.differences(pairs);
        let found = integer_least_squares(&float, covariance.as_slice(), 1).ok()?;
        found.costs.first().copied()
    }

    /// Whether the integers, of this cost, fit all pairs best, or fit so much better that this outweighs the
    /// satellites left out.
    fn outweighs_left_out(&self, attempt: &Attempt, cost: f64) -> bool {
        let faults = faults(attempt, self.all);
        if faults == 0 {
            return true;
        }
        let (float, covariance) = self.differences(self.all);
        let Ok(found) = integer_least_squares(&float, covariance.as_slice(), 1) else {
            return false;
        };
        let of_all = |satellite: usize, slot: usize| {
            let mut own = self.all.iter().zip(&found.integers[0]);
            own.find(|(p, _)| (p.other, p.slot) == (satellite, slot))
                .map_or(0.0, |(_, integer)| *integer)
        };
        let same = |(p, integer): (&Pair, &f64)| {
            let theirs = of_all(p.other, p.slot) - of_all(p.reference, p.slot);
            (theirs - integer).abs() < 0.5
        };
        attempt.pairs.iter().zip(&attempt.integers).all(same)
            || found.costs[0] > cost + RULED_OUT_DIFFERENCE * faults as f64
    }

    /// The float differences (cycles) and their covariance (cycle²) with the lasting errors of phases.
    fn differences(&self, pairs: &[Pair]) -> (Vec<f64>, DMatrix<f64>) {
        let (float, mut covariance) = differences(self.state, pairs);
        let variance = |satellite, slot| (self.phase_variance_cycles2)(satellite, slot);
        let variances: Vec<[f64; 2]> = (pairs.iter())
            .map(|p| [variance(p.reference, p.slot), variance(p.other, p.slot)])
            .collect();
        for (a, p) in pairs.iter().enumerate() {
            let [of_reference, of_other] = variances[a];
            for (b, q) in pairs.iter().enumerate() {
                if p.slot != q.slot {
                    continue;
                }
                let mut shared = 0.0;
                for (of_p, own) in [(p.reference, of_reference), (p.other, -of_other)] {
                    for (of_q, sign_q) in [(q.reference, 1.0), (q.other, -1.0)] {
                        if of_p == of_q {
                            shared += sign_q * own;
                        }
                    }
                }
                covariance[(a, b)] += shared;
            }
        }
        (float, covariance)
    }
}

/// Number of faults that explain the satellites left out: one for each satellite, and one for each group of
/// signals that is left out as a whole.
fn faults(attempt: &Attempt, all: &[Pair]) -> usize {
    let used = members(&attempt.pairs);
    let groups: Vec<SignalGroup> = attempt.pairs.iter().map(Pair::signal_group).collect();
    all.chunk_by(|a, b| a.signal_group() == b.signal_group())
        .map(|group| {
            if groups.contains(&group[0].signal_group()) {
                let of_group = members(group);
                of_group.iter().filter(|m| !used.contains(m)).count()
            } else {
                1
            }
        })
        .sum()
}
