//! The direct coupling from antenna to antenna after calibration: an independent check of the delay.

use super::result::Calibrated;
use super::rounds::Survey;
use crate::align::delay::coupling_delay;
use crate::journal::warnings::Warnings;

/// Deviations between the delay found and that of the coupling from which they contradict.
const CONTRADICTS: f64 = 4.0;
/// Delays of cables and electronics that a coupling may have (s): a later echo is another constant echo, in a
/// window that opens after the coupling.
const POSSIBLE_S: [f64; 2] = [-1e-9, 20e-9];

/// Warns where the direct coupling of a track speaks for another delay than the one found.
pub(super) fn compare(survey: &Survey<'_>, calibrated: &Calibrated, warnings: &mut Warnings) {
    for track in survey.tracks {
        let Some(cue) = coupling_delay(&track.raw) else {
            continue;
        };
        let found_s = calibrated.values.delay_s + track.known_delay_s;
        let is_possible = (POSSIBLE_S[0]..=POSSIBLE_S[1]).contains(&cue.delay_s);
        if is_possible && (found_s - cue.delay_s).abs() > CONTRADICTS * cue.sigma_s {
            warnings.add(format!(
                "track {}: the delay found, {:.2} ns, contradicts the direct coupling, which speaks for {:.2} ± \
                 {:.2} ns: the echo followed may be another one than the reflector's (the places of the \
                 reflectors, [trajectory] time_offset_s)",
                track.name,
                found_s * 1e9,
                cue.delay_s * 1e9,
                cue.sigma_s * 1e9
            ));
        }
    }
}
