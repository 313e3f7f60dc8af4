//! Ambiguity resolution: selection of pairs, ratio test, and hold.

use super::lambda::LambdaError;
use super::lambda::integer_least_squares;
use crate::float::state::FilterState;
use crate::linear::sparse_row::SparseRow;
use crate::measurements::common::Common;
use crate::measurements::constellation::Constellation;
use crate::measurements::signal_group::{GROUPS, SignalGroup, SuspectGroups};
use crate::measurements::zero::ZeroDifference;
use crate::observations::satellite::System;
use crate::options::{GlonassAmbiguity, PpkOptions};
use nalgebra::{Cholesky, DMatrix, DVector};

/// Difference of costs (−2 ln of the likelihood ratio) from which one set of integers rules out
/// another: odds of 400 to 1.
pub(crate) const RULED_OUT_DIFFERENCE: f64 = 12.0;
/// Least ratio of costs, required in addition.
const RULED_OUT_RATIO: f64 = 2.0;

/// Least number of remaining pairs where every satellite in turn is left out as faulty: with fewer pairs, one
/// of the many searches passes the ratio test by chance.
const LEAST_TO_TRY_ALL: usize = 7;

/// Largest reported ratio.
pub(crate) const LARGEST_RATIO: f64 = 999.9;

/// A pair of satellites whose bias difference is an integer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Pair {
    pub slot: usize,
    pub group: usize,
    pub reference: usize,
    pub other: usize,
}

impl Pair {
    pub(crate) fn signal_group(&self) -> SignalGroup {
        SignalGroup {
            slot: self.slot,
            group: self.group,
        }
    }
}

/// Inputs of ambiguity resolution at one epoch.
pub(crate) struct Resolution<'a> {
    pub constellation: &'a Constellation,
    pub options: &'a PpkOptions,
    pub common: &'a [Common],
    pub rover: &'a [ZeroDifference],
    /// Whether GLONASS and SBAS are included.
    pub with_glonass: bool,
    /// True variances over the model's, for the success rate.
    pub variance_factor: f64,
    /// Groups of signals whose phases may contradict the other groups.
    pub suspects: SuspectGroups,
}

/// Integers found, and the resulting position.
#[derive(Debug, Clone)]
pub(crate) struct Attempt {
    pub pairs: Vec<Pair>,
    pub integers: Vec<f64>,
    /// Second-best over best sum of squares, capped.
    pub ratio: f64,
    pub threshold: f64,
    pub accepted: bool,
    /// (a − z)ᵀQ⁻¹(a − z) of the integers.
    pub cost: f64,
    /// Groups of signals that contradict the rest and were left out.
    pub left_out: Vec<SignalGroup>,
    /// Probability that the integers are right, if the covariance is true.
    pub success_rate: f64,
    /// Leading states after the integers are imposed, and their covariance (row-major).
    pub x: Vec<f64>,
    pub p: Vec<f64>,
}

impl Resolution<'_> {
    /// The pairs whose ambiguities may be resolved at this epoch.
    pub(crate) fn pairs(&self, state: &FilterState) -> Vec<Pair> {
        let options = self.options;
        let policy = options.policy();
        let mut pairs = Vec::new();
        for (group_index, group) in GROUPS.iter().enumerate() {
            for slot in 0..options.frequencies {
                let own = SignalGroup {
                    slot,
                    group: group_index,
                };
                if self.suspects.left_out().contains(&own) {
                    continue;
                }
                let eligible = |c: &Common| {
                    let system = self.constellation.id(c.satellite).system();
                    if !group.contains(&system) || !self.system_allowed(system) {
                        return false;
                    }
                    let track = state.track(c.satellite, slot);
                    state.bias(c.satellite, slot).is_some()
                        && track.valid
                        && policy.is_locked(track.lock)
                        && !track.half_cycle_flag()
                        && self.rover[c.rover].elevation_rad >= options.ambiguity_elevation_mask_rad
                };
                let known = |c: &Common| state.track(c.satellite, slot).half_cycle_known;
                let Some(reference) = self.common.iter().find(|c| eligible(c) && known(c)) else {
                    continue;
                };
                for c in self.common {
                    if c.satellite != reference.satellite
                        && eligible(c)
                        && (policy.resolves_half_cycles() || known(c))
                    {
                        pairs.push(Pair {
                            slot,
                            group: group_index,
                            reference: reference.satellite,
                            other: c.satellite,
                        });
                    }
                }
            }
        }
        pairs
    }

    fn system_allowed(&self, system: System) -> bool {
        match system {
            System::Glonass => {
                self.options.glonass_ambiguity != GlonassAmbiguity::Off && self.with_glonass
            }
            System::Sbas => {
                self.with_glonass || self.options.policy().resolves_sbas_without_glonass()
            }
            System::Beidou => self.options.beidou_ambiguity,
            _ => true,
        }
    }

    /// As [`attempt`](Self::attempt); while the ratio test fails, the first satellite
    /// among those `dispensable` is left out and the search repeated, down to `least` pairs.
    pub(crate) fn partial_attempt(
        &self,
        state: &FilterState,
        pairs: Vec<Pair>,
        dispensable: impl FnOnce(&[Pair]) -> Vec<(usize, usize)>,
        least: usize,
    ) -> Result<Attempt, LambdaError> {
        let full = self.attempt(state, pairs)?;
        if full.accepted {
            return Ok(full);
        }
        if let Some(attempt) = self.attempt_without_groups(state, &full) {
            return Ok(attempt);
        }
        let mut remaining = full.pairs.clone();
        for (satellite, slot) in dispensable(&full.pairs) {
            remaining = without(&remaining, satellite, slot);
            if remaining.len() < least.max(2) {
                break;
            }
            match self.attempt(state, remaining.clone()) {
                Ok(attempt) if attempt.accepted => return Ok(attempt),
                _ => {}
            }
        }
        // A single faulty satellite, even the strongest, is found by leaving out each in turn.
        let mut best: Option<Attempt> = None;
        for (satellite, slot) in members(&full.pairs) {
            let rest = without(&full.pairs, satellite, slot);
            if rest.len() < LEAST_TO_TRY_ALL {
                break;
            }
            if let Ok(attempt) = self.attempt(state, rest)
                && attempt.accepted
                && best.as_ref().is_none_or(|b| attempt.ratio > b.ratio)
            {
                best = Some(attempt);
            }
        }
        Ok(best.unwrap_or(full))
    }

    /// The ratio required for a number of pairs.
    fn threshold(&self, pairs: usize) -> f64 {
        let [least, most] = self.options.ratio_threshold_range;
        if least >= most {
            return self.options.ratio_threshold;
        }
        // With fewer pairs wrong candidates pass more often by chance, so that a higher ratio is required.
        let base = self.options.ratio_threshold;
        (1.0 + (base - 1.0) * (8.0 / pairs.max(1) as f64)).clamp(least, most)
    }

    /// Searches the integers of `pairs` and, if accepted, imposes them on the position.
    pub(crate) fn attempt(
        &self,
        state: &FilterState,
        pairs: Vec<Pair>,
    ) -> Result<Attempt, LambdaError> {
        let n = pairs.len();
        let index = indices(state, &pairs);
        let (float, q) = differences(state, &pairs);
        let found = integer_least_squares(&float, q.as_slice(), 2)?;
        let (best, second) = (found.costs[0], found.costs[1]);
        let ratio = if best > 0.0 {
            (second / best).min(LARGEST_RATIO)
        } else {
            0.0
        };
        let threshold = self.threshold(n);
        let accepted = best <= 0.0 || second / best >= threshold;
        let np = state.leading_states;
        let mut result = Attempt {
            pairs,
            integers: found.integers[0].clone(),
            ratio,
            threshold,
            accepted,
            cost: best,
            left_out: Vec::new(),
            success_rate: found.success_rate(self.variance_factor),
            x: state.x[..np].to_vec(),
            p: (0..np * np)
                .map(|k| state.covariance(k / np, k % np))
                .collect(),
        };
        if accepted {
            let cholesky = Cholesky::new(q).ok_or(LambdaError::NotPositiveDefinite { index: 0 })?;
            let qab = DMatrix::from_fn(n, np, |a, k| {
                state.covariance(index[a].0, k) - state.covariance(index[a].1, k)
            });
            let step =
                DVector::from_iterator(n, float.iter().zip(&found.integers[0]).map(|(f, z)| f - z));
            let dx = qab.tr_mul(&cholesky.solve(&step));
            let dp = qab.tr_mul(&cholesky.solve(&qab));
            for k in 0..np {
                result.x[k] -= dx[k];
                for l in 0..np {
                    result.p[k * np + l] -= dp[(k, l)];
                }
            }
        }
        Ok(result)
    }

    /// Feeds fixed integers back into the filter as pseudo-measurements.
    ///
    /// Returns whether anything was held.
    pub(crate) fn hold(&self, state: &mut FilterState, attempt: &Attempt) -> bool {
        let options = self.options;
        let elevation = |satellite: usize| {
            self.common
                .iter()
                .find(|c| c.satellite == satellite)
                .map_or(0.0, |c| self.rover[c.rover].elevation_rad)
        };
        let mut rows = Vec::new();
        // Integer of each member of a group relative to the group's reference; the first member
        // above the mask becomes the reference of the hold.
        let mut start = 0;
        while start < attempt.pairs.len() {
            let first = attempt.pairs[start];
            let end = start
                + attempt.pairs[start..]
                    .iter()
                    .take_while(|p| (p.group, p.slot) == (first.group, first.slot))
                    .count();
            let mut members: Vec<(usize, f64)> = vec![(first.reference, 0.0)];
            members.extend((start..end).map(|k| (attempt.pairs[k].other, attempt.integers[k])));
            members.sort_by_key(|m| m.0);
            members.retain(|&(s, _)| elevation(s) >= options.hold_elevation_mask_rad);
            if let Some((&(reference, integer_of_reference), others)) = members.split_first() {
                for &(other, integer) in others {
                    let (i, j) = (
                        state.bias_index(reference, first.slot),
                        state.bias_index(other, first.slot),
                    );
                    rows.push(SparseRow::new(
                        &[(i, 1.0), (j, -1.0)],
                        (integer - integer_of_reference) - (state.x[i] - state.x[j]),
                    ));
                }
            }
            start = end;
        }
        let n = rows.len();
        if n < options.least_pairs_to_hold() {
            return false;
        }
        let noise = state.white_noise(n, options.hold_variance_cycles2);
        state.update(&rows, noise)
    }
}

/// The biases of reference and other of each pair in the state vector.
fn indices(state: &FilterState, pairs: &[Pair]) -> Vec<(usize, usize)> {
    pairs
        .iter()
        .map(|p| {
            (
                state.bias_index(p.reference, p.slot),
                state.bias_index(p.other, p.slot),
            )
        })
        .collect()
}

/// The float bias differences (cycles) and their covariance (cycle²).
pub(crate) fn differences(state: &FilterState, pairs: &[Pair]) -> (Vec<f64>, DMatrix<f64>) {
    let index = indices(state, pairs);
    let float: Vec<f64> = index
        .iter()
        .map(|&(i, j)| state.x[i] - state.x[j])
        .collect();
    let mut q = DMatrix::<f64>::zeros(pairs.len(), pairs.len());
    for (a, &(ia, ja)) in index.iter().enumerate() {
        for (b, &(ib, jb)) in index.iter().enumerate().take(a + 1) {
            let value =
                state.covariance(ia, ib) - state.covariance(ia, jb) - state.covariance(ja, ib)
                    + state.covariance(ja, jb);
            q[(a, b)] = value;
            q[(b, a)] = value;
        }
    }
    (float, q)
}

/// Whether another set of integers fits the float ambiguities so much better that `integers` are rejected: by
/// odds, and by the ratio of costs, which does not depend on the accuracy of the covariance.
pub(crate) fn is_ruled_out(state: &FilterState, pairs: &[Pair], integers: &[f64]) -> bool {
    if pairs.len() < 2 {
        return false;
    }
    let (float, covariance) = differences(state, pairs);
    let Some(cost) = cost(&float, covariance.clone(), integers) else {
        return false;
    };
    // No competing cost is below zero: up to here no search is needed.
    if cost <= RULED_OUT_DIFFERENCE {
        return false;
    }
    integer_least_squares(&float, covariance.as_slice(), 1).is_ok_and(|found| {
        let best = found.costs[0];
        cost - best > RULED_OUT_DIFFERENCE && cost > RULED_OUT_RATIO * best
    })
}

/// (a − z)ᵀQ⁻¹(a − z); `None` where Q is not positive definite.
fn cost(float: &[f64], covariance: DMatrix<f64>, integers: &[f64]) -> Option<f64> {
    let cholesky = Cholesky::new(covariance)?;
    let n = integers.len();
    let departure = DVector::from_iterator(n, float.iter().zip(integers).map(|(a, z)| a - z));
    Some(departure.dot(&cholesky.solve(&departure)))
}

/// The satellites and slots of `pairs`, each once.
pub(crate) fn members(pairs: &[Pair]) -> Vec<(usize, usize)> {
    let mut members: Vec<(usize, usize)> = pairs
        .iter()
        .flat_map(|p| [(p.reference, p.slot), (p.other, p.slot)])
        .collect();
    members.sort_unstable();
    members.dedup();
    members
}

/// `pairs` without a satellite; where the satellite is a reference, the first of its partners becomes the
/// reference.
pub(crate) fn without(pairs: &[Pair], satellite: usize, slot: usize) -> Vec<Pair> {
    let mut remaining: Vec<Pair> = pairs
        .iter()
        .copied()
        .filter(|p| p.slot != slot || p.other != satellite)
        .collect();
    let orphaned = |p: &&mut Pair| p.slot == slot && p.reference == satellite;
    let heir = remaining.iter_mut().find(|p| orphaned(p)).map(|p| p.other);
    if let Some(heir) = heir {
        remaining
            .iter_mut()
            .filter(orphaned)
            .for_each(|p| p.reference = heir);
        remaining.retain(|p| p.reference != p.other);
    }
    remaining
}
