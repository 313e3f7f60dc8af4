//! Retrospective confirmation of ambiguity fixes: integers that passed the ratio test while their
//! success rate was low count once the same integers are found with certainty, before or after.

use super::ambiguity::{Attempt, Pair};
use super::constellation::Constellation;
use super::filter::EpochResult;
use crate::satellite::System;
use crate::solution::{NotFixedReason, Quality};

/// Fewest ambiguities that must be the same for one fix to confirm another.
const LEAST_SHARED: usize = 4;

/// The integers of a fix, with the float solution to fall back to.
#[derive(Debug, Clone)]
pub(crate) struct FixedIntegers {
    pairs: Vec<Pair>,
    integers: Vec<f64>,
    /// Probability that they are right, from the float ambiguities' covariance.
    success_rate: f64,
    certain: bool,
    /// Number of the set of held integers in force.
    generation: u32,
    float_position_ecef_m: [f64; 3],
    float_covariance_ecef_m2: [[f64; 3]; 3],
    float_velocity: Option<([f64; 3], [[f64; 3]; 3])>,
}

impl FixedIntegers {
    /// The integers of `attempt`; `float` is the epoch's result before they are imposed.
    pub(crate) fn new(
        attempt: &Attempt,
        certain: bool,
        generation: u32,
        float: &EpochResult,
    ) -> Self {
        Self {
            pairs: attempt.pairs.clone(),
            integers: attempt.integers.clone(),
            success_rate: attempt.success_rate,
            certain,
            generation,
            float_position_ecef_m: float.position_ecef_m,
            float_covariance_ecef_m2: float.covariance_ecef_m2,
            float_velocity: float.velocity,
        }
    }

    /// Integer of a satellite relative to its group's reference.
    fn of(&self, satellite: usize, slot: usize, group: usize) -> Option<f64> {
        let own = self
            .pairs
            .iter()
            .position(|p| p.other == satellite && p.slot == slot);
        let reference = || {
            self.pairs
                .iter()
                .any(|p| p.reference == satellite && (p.slot, p.group) == (slot, group))
        };
        own.map(|k| self.integers[k])
            .or_else(|| reference().then_some(0.0))
    }

    /// Whether both fixes put the same integers to the satellites that they share.
    ///
    /// GLONASS is left aside: its differences between carriers drift with the receivers' clocks.
    fn same_as(&self, other: &Self, constellation: &Constellation) -> bool {
        let mut shared = 0;
        for (pair, integer) in self.pairs.iter().zip(&self.integers) {
            if constellation.id(pair.other).system() == System::Glonass {
                continue;
            }
            let theirs = |satellite| other.of(satellite, pair.slot, pair.group);
            if let (Some(a), Some(b)) = (theirs(pair.reference), theirs(pair.other)) {
                if (b - a - integer).abs() > 0.5 {
                    return false;
                }
                shared += 1;
            }
        }
        shared >= LEAST_SHARED
    }
}

/// Calls fixes float that neither are certain themselves nor have the integers of the nearest
/// certain fix before or after them. `results` are those of one pass, in its order.
///
/// Fixes under integers that were `withdrawn` later confirm nothing, themselves included.
pub(crate) fn confirm(
    results: &mut [EpochResult],
    needed: f64,
    withdrawn: &[u32],
    constellation: &Constellation,
) {
    for result in results.iter_mut() {
        if let Some(own) = &mut result.integers {
            own.certain &= !withdrawn.contains(&own.generation);
        }
    }
    let mut confirmed = vec![false; results.len()];
    let mut confirm_along = |order: &mut dyn Iterator<Item = usize>| {
        let mut nearest: Option<&FixedIntegers> = None;
        for k in order {
            let Some(own) = &results[k].integers else {
                continue;
            };
            if own.certain || nearest.is_some_and(|certain| own.same_as(certain, constellation)) {
                confirmed[k] = true;
                nearest = Some(own);
            }
        }
    };
    confirm_along(&mut (0..results.len()).rev());
    confirm_along(&mut (0..results.len()));
    for (result, confirmed) in results.iter_mut().zip(confirmed) {
        let Some(own) = result.integers.take() else {
            continue;
        };
        if !confirmed {
            result.quality = Some(Quality::Float);
            result.reason = Some(NotFixedReason::IntegersUncertain {
                success_rate: own.success_rate,
                needed,
            });
            result.position_ecef_m = own.float_position_ecef_m;
            result.covariance_ecef_m2 = own.float_covariance_ecef_m2;
            result.velocity = own.float_velocity;
            for residual in &mut result.residuals {
                residual.fixed = false;
            }
        }
    }
}
