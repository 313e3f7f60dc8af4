//! The clock and the place of a log whose attitudes other positions take.

use super::finding::{Finding, Verdict};

/// Deviation of an autopilot's stamps (s): its receiver's latency, usually 0.05 to 0.25 s.
const LATENCY_SIGMA_S: f64 = 0.15;

/// Deviation of the distance of two single-point positions (m), each by 10/3 m.
const APART_SIGMA_M: f64 = 5.0;

/// Judges the clock of attitudes by the time at which the log's own positions fit those that take them.
///
/// ```
/// use acerra_chain::evidence::{Verdict, attitude_clock};
/// assert_eq!(attitude_clock(0.12, 0.05).verdict, Verdict::Agrees);
/// // Leap seconds.
/// assert_eq!(attitude_clock(-18.0, 0.1).verdict, Verdict::Contradicts);
/// ```
#[must_use]
pub fn attitude_clock(shift_s: f64, sigma_s: f64) -> Finding {
    Finding::compared(
        "attitude_clock",
        shift_s,
        0.0,
        sigma_s.hypot(LATENCY_SIGMA_S),
        "s",
    )
    .because(format!(
        "by its own positions the log of the attitudes is stamped {shift_s:.2} s later than the positions \
         (σ {sigma_s:.2} s; up to a quarter of a second is a receiver's latency): attitudes of another time turn the \
         lever arm and the antenna wrong ([trajectory] attitude_file; leap seconds, another flight)"
    ))
}

/// Judges whether a log of attitudes belongs to the positions, by the distance between its own and them.
#[must_use]
pub fn attitude_place(apart_m: f64) -> Finding {
    Finding::compared("attitude_place", apart_m, 0.0, APART_SIGMA_M, "m")
        .at_most(Verdict::Doubtful)
        .because(format!(
            "the positions in the log of the attitudes lie {apart_m:.1} m beside those that take them, of which \
             metres are expected: another flight, or a wrong base ([trajectory] attitude_file, [gnss] base_ecef_m, \
             base_deg_m)"
        ))
}
