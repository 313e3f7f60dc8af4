//! The direct coupling from antenna to antenna, and the delays that are possible by it and by the radio's time zero.

use acerra_radar::Radargram;

use crate::align::delay::{DelayCue, coupling_delay};

/// Range zero lies after the radio's own time zero, but for how its marks are set (s).
const ZERO_S: f64 = -1e-9;
/// Delays that cables and electronics may have (s): a later constant echo than the coupling's is another one, in a window
/// that opens after the coupling.
const POSSIBLE_S: [f64; 2] = [ZERO_S, 20e-9];
/// Deviations from the delay by the coupling at which range zero is still possible: the distance of the antennas, the
/// ringing and the crest's place within the pulse are not known better than the deviation states.
const REACH_SIGMAS: f64 = 3.0;
/// Ringing of the coupling after range zero (s): the timing jitter of the radio leaves more of the ringing than a
/// reflector echoes. The ringing covers the first 0.6 m of range, in which no reflector stands.
const RINGING_S: f64 = 4e-9;

/// Delay by the direct coupling, where the record shows the coupling.
pub(super) fn seen(raw: &Radargram) -> Option<DelayCue> {
    coupling_delay(raw).filter(|cue| (POSSIBLE_S[0]..=POSSIBLE_S[1]).contains(&cue.delay_s))
}

/// First and last delay at which range zero is possible (s). Range zero comes before the direct coupling, by the travel
/// time between the antennas, where the record shows the coupling; else it comes after the radio's time zero.
pub(super) fn possible_delays_s(coupling: Option<DelayCue>) -> [f64; 2] {
    coupling.map_or(POSSIBLE_S, |cue| {
        [-1.0, 1.0].map(|sign| cue.delay_s + sign * REACH_SIGMAS * cue.sigma_s)
    })
}

/// Fast time from which echoes are free of the coupling and its ringing (s).
pub(super) fn free_from_s(coupling: Option<DelayCue>) -> f64 {
    coupling.map_or(f64::NEG_INFINITY, |cue| cue.delay_s + RINGING_S)
}
