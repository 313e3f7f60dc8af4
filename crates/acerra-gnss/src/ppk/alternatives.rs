//! Other settings where fixing is poor, chosen by the agreement of their passes.
//!
//! Weak signals are mostly reflections, so that a carrier-to-noise mask can help. A filter into which
//! integers are fed back bridges gaps that a filter without them does not. The better setting depends on
//! receiver and place, and is decided by the agreement of passes in opposite directions, not by the number of
//! fixes.

use super::attempt::Attempt;
use super::preparation::{Inputs, Preparation};
use crate::confirm::agreement::Witness;
use crate::control::watch::Watch;
use crate::control::workers::{each, threads};
use crate::options::{Cn0Mask, PpkOptions};
use crate::passes::overlay::overlay;
use crate::solution::{PpkError, PpkWarning};
use acerra_control::Control;

/// Masks tried (dB-Hz): 5 and 10 dB below 45, the middle of the range of signals above the elevation mask
/// under open sky (40 to 50).
///
/// The masks exclude reflections, not noise. One reflection that takes 5 or 10 dB off has 0.44 or 0.68 of the
/// direct signal's amplitude, 1 − 10^(−dB/20), and turns the phase by up to its arc sine: 14 or 23 mm on L1,
/// five to eight times the noise that is assumed. Tracking loops hold far weaker signals: noise of 15°, at
/// which they slip, corresponds to 23 dB-Hz in 15 Hz. The best mask, if any, depends on receiver and place,
/// and is chosen by the agreement of the passes.
const MASKS_DB_HZ: [f64; 2] = [35.0, 40.0];

/// The attempt `own`, with the fixes of attempts by alternative options added.
pub(crate) fn better_of(
    attempt: Attempt,
    inputs: &Inputs<'_>,
    preparation: &Preparation,
    control: Control<'_>,
) -> Result<Attempt, PpkError> {
    let options = &preparation.options;
    let others = attempts(inputs, preparation, control);
    control.check()?;
    let before = [attempt.agreeing, attempt.fixed()[0]];
    let witnesses: Vec<Option<[Witness; 2]>> = std::iter::once(&attempt)
        .chain(others.iter().map(|(other, _)| other))
        .map(|a| Some(a.passes.as_ref()?.witnesses.clone()))
        .collect();
    // The passes of the attempt precede the passes of the other attempts.
    let without = |place: usize| -> Vec<&[Witness; 2]> {
        let others = witnesses.iter().enumerate().filter(|(k, _)| *k != place);
        others.filter_map(|(_, w)| w.as_ref()).collect()
    };
    let mut all = vec![(0, attempt, options.clone())];
    all.extend((others.into_iter().enumerate()).map(|(k, (other, own))| (k + 1, other, own)));
    let confirmed = |(place, attempt, own): (usize, Attempt, PpkOptions)| {
        (attempt.confirmed_by(&own, &without(place)), own)
    };
    let mut others = each(threads(options), all, confirmed);
    let (mut attempt, _) = others.remove(0);
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

/// The attempts by alternative options, in parallel as far as there are threads; failed attempts are left
/// out.
fn attempts(
    inputs: &Inputs<'_>,
    preparation: &Preparation,
    control: Control<'_>,
) -> Vec<(Attempt, PpkOptions)> {
    let options = &preparation.options;
    let threads = threads(options);
    let watch = Watch::new(control.silent(), 1).with_permits(threads);
    let one = |own: PpkOptions| {
        let attempt = if own.cn0_mask == options.cn0_mask {
            Attempt::unconfirmed(preparation, &own, &watch)
        } else {
            let masked = {
                let _permit = watch.permit();
                preparation.masked(inputs, &own.clone().with_threads(1), &watch)
            };
            masked.and_then(|masked| Attempt::unconfirmed(&masked, &own, &watch))
        };
        attempt.ok().map(|attempt| (attempt, own))
    };
    let alternatives = alternatives(options);
    // All attempts at once, pass by pass as permits become free: whole attempts share threads unevenly.
    let at_once = if threads == 1 { 1 } else { alternatives.len() };
    each(at_once, alternatives, one)
        .into_iter()
        .flatten()
        .collect()
}

fn alternatives(options: &PpkOptions) -> Vec<PpkOptions> {
    let held = PpkOptions {
        revisable_hold: false,
        ..options.clone()
    };
    let mut alternatives = vec![held.clone()];
    if options.cn0_mask.is_none() {
        for db_hz in MASKS_DB_HZ {
            let mask = Some(Cn0Mask::uniform(db_hz));
            alternatives.push(held.clone().with_cn0_mask(mask));
        }
    }
    alternatives
}
