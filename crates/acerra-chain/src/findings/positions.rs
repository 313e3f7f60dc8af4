//! Findings on the positions as their source gives them: base, autopilot, attitudes of another log.

use acerra_geo::trajectory::StatusCounts;

use crate::journal::finding::{Finding, Verdict};
use crate::position::SourceSeen;

/// Judges the quality that the source of the positions states.
pub(crate) fn weigh_source(seen: &SourceSeen) -> Vec<Finding> {
    let autopilot = seen.autopilot.as_ref();
    let mut findings: Vec<Finding> = autopilot
        .map(|(source, statuses)| autopilot_fixed(source, statuses))
        .into_iter()
        .chain(seen.base_from_single_m.map(base_position))
        .collect();
    if let Some(attitudes) = &seen.attitudes {
        let clock = attitudes.clock;
        findings.extend(clock.map(|[shift_s, sigma_s]| attitude_clock(shift_s, sigma_s)));
        findings.push(attitude_place(attitudes.apart_m));
    }
    findings
}

/// Judges the positions of an autopilot's log by the number of carrier-phase solutions with fixed
/// ambiguities: other solutions are good to decimetres or metres.
fn autopilot_fixed(source: &str, statuses: &StatusCounts) -> Finding {
    let share = statuses.fixed() as f64 / statuses.total().max(1) as f64;
    let verdict = if share >= 0.8 {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    Finding::judged("autopilot_fixed", share, "share of the positions", verdict)
        .expecting(1.0)
        .because(format!(
            "{} of {} positions of {source} in the autopilot's log are fixed by carrier phase ({statuses}); \
             others are good to metres, where focusing needs millimetres to centimetres ([trajectory] file, \
             source; [gnss] with the receiver's raw log; [autofocus])",
            statuses.fixed(),
            statuses.total()
        ))
}

/// Deviation of the median of single-frequency single-point positions (m): the errors by ionosphere,
/// troposphere and broadcast orbits.
const SINGLE_POINT_SIGMA_M: f64 = 10.0 / 3.0;

/// Judges the base's position by its distance from the base's own single-point position.
///
/// A base that is off moves the whole image by as much; relative positions hardly suffer, so that
/// it is never more than doubtful.
fn base_position(from_single_m: f64) -> Finding {
    Finding::compared(
        "base_position",
        from_single_m,
        0.0,
        SINGLE_POINT_SIGMA_M,
        "m",
    )
    .at_most(Verdict::Doubtful)
    .because(format!(
        "the base's position lies {from_single_m:.1} m from its own single-point position, where metres are \
             expected: the whole image is off by as much ([gnss] base_ecef_m or base_deg_m)"
    ))
}

/// Deviation of an autopilot's stamps (s): its receiver's latency, usually 0.05 to 0.25 s.
const LATENCY_SIGMA_S: f64 = 0.15;

/// Deviation of the distance of two single-point positions (m), each by 10/3 m.
const APART_SIGMA_M: f64 = 5.0;

/// Judges the clock of attitudes by the time at which the log's own positions fit those that take them.
fn attitude_clock(shift_s: f64, sigma_s: f64) -> Finding {
    Finding::compared(
        "attitude_clock",
        shift_s,
        0.0,
        sigma_s.hypot(LATENCY_SIGMA_S),
        "s",
    )
    .because(format!(
        "by its own positions the log of the attitudes is stamped {shift_s:.2} s later than the positions \
         (σ {sigma_s:.2} s; up to a quarter of a second is a receiver's latency): attitudes of another time \
         turn the lever arm and the antenna to wrong directions ([trajectory] attitude_file; leap seconds, \
         another flight)"
    ))
}

/// Judges whether a log of attitudes belongs to the positions, by the distance between the log's own
/// positions and them.
fn attitude_place(apart_m: f64) -> Finding {
    Finding::compared("attitude_place", apart_m, 0.0, APART_SIGMA_M, "m")
        .at_most(Verdict::Doubtful)
        .because(format!(
            "the positions in the log of the attitudes lie {apart_m:.1} m from the positions that use the \
             attitudes, where metres are expected: another flight, or a wrong base ([trajectory] \
             attitude_file, [gnss] base_ecef_m, base_deg_m)"
        ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn latency_of_an_autopilot_agrees_and_leap_seconds_contradict() {
        assert_eq!(attitude_clock(0.12, 0.05).verdict, Verdict::Agrees);
        assert_eq!(attitude_clock(-18.0, 0.1).verdict, Verdict::Contradicts);
    }

    #[test]
    fn a_base_fourteen_metres_off_is_doubtful_and_one_of_three_cannot_be_told() {
        assert_eq!(base_position(3.0).verdict, Verdict::Agrees);
        assert_eq!(base_position(14.0).verdict, Verdict::Doubtful);
        assert_eq!(base_position(1e4).verdict, Verdict::Doubtful);
    }

    #[test]
    fn an_autopilots_positions_are_doubted_unless_most_are_fixed() {
        use acerra_geo::trajectory::SolutionStatus::{Fixed, Single};
        let counts = |fixed, single| -> StatusCounts {
            let fixed = std::iter::repeat_n(Fixed, fixed);
            fixed.chain(std::iter::repeat_n(Single, single)).collect()
        };
        let good = autopilot_fixed("GPS[0]", &counts(9, 1));
        assert_eq!((good.verdict, good.value), (Verdict::Agrees, Some(0.9)));
        let poor = autopilot_fixed("GPS[0]", &counts(1, 9));
        assert_eq!(poor.verdict, Verdict::Doubtful);
        assert!(poor.explanation.contains("1 fixed, 9 single"), "{poor:?}");
    }
}
