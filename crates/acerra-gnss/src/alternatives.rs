//! Other settings where fixing is poor, chosen by what their passes agree on.
//!
//! Weak signals are mostly reflected ones, and a filter that is told integers bridges what one
//! that doubts them does not: which helps depends on receiver and place. Passes in opposite
//! directions that come to the same places tell which did; a longer list of fixes would not.

use crate::attempt::{Attempt, Inputs};
use crate::control::Control;
use crate::engine::{EpochResult, Witness};
use crate::observation::EPOCH_TOLERANCE_S;
use crate::options::{Cn0Mask, PpkOptions};
use crate::ppk_error::PpkError;
use crate::solution::{NotFixedReason, PpkWarning, Quality};

/// Masks tried (dB-Hz). Under open sky signals above the elevation mask have 40 to 50 dB-Hz;
/// codes of 35 are two to three times, of 30 five times as noisy (SIGMA-ε), and mostly reflected.
const MASKS_DB_HZ: [f64; 2] = [35.0, 40.0];
/// Fixes further apart than this (m) are of different integers.
const DIFFERENT_PLACE_M: f64 = 0.1;

/// The attempt itself, with whatever alternatives to its options fixed besides.
pub(crate) fn better_of(
    attempt: Attempt,
    inputs: &Inputs<'_>,
    options: &PpkOptions,
    control: Control<'_>,
) -> Result<Attempt, PpkError> {
    let mut others = Vec::new();
    for alternative in alternatives(options) {
        match Attempt::new(inputs, &alternative, control.silent()) {
            Ok(other) => others.push((other, alternative)),
            Err(_) => control.check()?,
        }
    }
    let before = [attempt.agreeing, attempt.fixed()[0]];
    let witnesses: Vec<[Witness; 2]> = std::iter::once(&attempt)
        .chain(others.iter().map(|(other, _)| other))
        .filter_map(|a| Some(a.passes.as_ref()?.witnesses.clone()))
        .collect();
    let all: Vec<&[Witness; 2]> = witnesses.iter().collect();
    let mut attempt = attempt.confirmed_by(options, &all);
    let mut others: Vec<(Attempt, PpkOptions)> = others
        .into_iter()
        .map(|(other, own)| (other.confirmed_by(&own, &all), own))
        .collect();
    others.sort_by_key(|(other, _)| std::cmp::Reverse(other.agreeing));
    let Some((best, chosen)) = others.first() else {
        return Ok(attempt);
    };
    let (agreeing, cn0_mask_db_hz) = (best.agreeing, chosen.cn0_mask.map(|m| m.min_db_hz[0][0]));
    attempt.glonass = attempt.glonass.or(best.glonass);
    for (other, _) in others {
        overlay(&mut attempt.results, other.results);
    }
    let fixed = attempt.fixed()[0];
    if fixed > before[1] {
        attempt.warnings.push(PpkWarning::AlternativeTaken {
            cn0_mask_db_hz: cn0_mask_db_hz.filter(|_| options.cn0_mask.is_none()),
            agreeing: [before[0], agreeing],
            fixed: [before[1], fixed],
        });
    }
    Ok(attempt)
}

fn alternatives(options: &PpkOptions) -> Vec<PpkOptions> {
    let held = PpkOptions {
        revisable_hold: false,
        ..options.clone()
    };
    let by_model = PpkOptions {
        measure_code_noise: false,
        initial_bias_cycles: 30.0,
        ..held.clone()
    };
    let mut alternatives = vec![held.clone(), by_model];
    if options.cn0_mask.is_none() {
        for db_hz in MASKS_DB_HZ {
            let mask = Some(Cn0Mask::uniform(db_hz));
            alternatives.push(held.clone().with_cn0_mask(mask));
        }
    }
    alternatives
}

/// Puts the fixes of `other` where `results` have none; of two at different places that one is
/// believed which a pass in the other direction found too, else neither.
fn overlay(results: &mut [EpochResult], other: Vec<EpochResult>) {
    let mut other = other.into_iter().peekable();
    for result in results {
        while other
            .next_if(|o| o.tag.seconds_since(result.tag) < -EPOCH_TOLERANCE_S)
            .is_some()
        {}
        let near = |o: &EpochResult| o.tag.seconds_since(result.tag) <= EPOCH_TOLERANCE_S;
        let Some(better) = other.next_if(near) else {
            continue;
        };
        let fixed = |r: &EpochResult| r.quality == Some(Quality::Fixed);
        if !fixed(&better) {
            continue;
        }
        if !fixed(result) {
            *result = better;
            continue;
        }
        let distance_m = result.distance_m(&better);
        if distance_m > DIFFERENT_PLACE_M {
            match (result.anchored, better.anchored) {
                (true, false) => {}
                (false, true) => *result = better,
                _ => {
                    result.quality = Some(Quality::Float);
                    result.reason = Some(NotFixedReason::PassesDisagree { distance_m });
                    result.widen_to(&better);
                }
            }
        }
    }
}
