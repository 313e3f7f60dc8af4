//! What the positions say of themselves.

use std::f64::consts::TAU;

use acerra_geo::trajectory::StatusCounts;

use super::finding::{Finding, Verdict};

/// Judges the loss of focus that the positions' own σ predict, after Eq. (5): a phase error of
/// 4πσ/λ along the line of sight.
///
/// Errors that all traces share move the image without blurring it, so that the loss is a bound;
/// beyond half a wavelength (float and single-point positions) what is left of the focus is chance.
#[must_use]
pub fn focusing_loss(sigma_m: f64, wavelength_m: f64) -> Finding {
    let phase_rad = 2.0 * TAU * sigma_m / wavelength_m;
    let loss_db = 10.0 * std::f64::consts::LOG10_E * phase_rad * phase_rad;
    let verdict = if sigma_m <= 0.5 * wavelength_m {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    let cost = if loss_db <= WHOLE_FOCUS_DB {
        format!("cost up to {loss_db:.1} dB of focus")
    } else {
        let turns = phase_rad / TAU;
        format!("are {turns:.1} turns of phase there and back: they may cost the whole focus")
    };
    Finding::judged("position_sigma", 1e3 * sigma_m, "mm", verdict)
        .expecting(0.0)
        .because(format!(
            "positions of σ = {:.0} mm along the line of sight {cost}, as much of them as changes from trace to \
             trace",
            1e3 * sigma_m
        ))
}

/// Loss of focus, dB, above which what is left of a target is no more than traces add up to by chance.
const WHOLE_FOCUS_DB: f64 = 20.0;

/// Judges the share of the log's traces that have a position.
#[must_use]
pub fn trajectory_coverage(positioned: usize, traces: usize) -> Finding {
    let share = positioned as f64 / traces.max(1) as f64;
    let verdict = match share {
        s if s >= 0.8 => Verdict::Agrees,
        0.0 => Verdict::Contradicts,
        _ => Verdict::Doubtful,
    };
    Finding::judged("trajectory_coverage", share, "share of the traces", verdict)
        .expecting(1.0)
        .because(format!(
            "{positioned} of {traces} traces have a position ([trajectory] time_offset_s; do the \
             logs belong together?)"
        ))
}

/// Judges the positions of an autopilot's log by how many of them are carrier-phase solutions with fixed
/// ambiguities: the others are good to decimetres or metres.
#[must_use]
pub fn autopilot_fixed(source: &str, statuses: &StatusCounts) -> Finding {
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

/// Deviation of the median of single-frequency single-point positions (m): what ionosphere,
/// troposphere and broadcast orbits leave.
const SINGLE_POINT_SIGMA_M: f64 = 10.0 / 3.0;

/// Judges the base's position by its distance from the base's own single-point position.
///
/// A base that is off moves the whole image by as much; relative positions hardly suffer, so that
/// it is never more than doubtful.
#[must_use]
pub fn base_position(from_single_m: f64) -> Finding {
    Finding::compared(
        "base_position",
        from_single_m,
        0.0,
        SINGLE_POINT_SIGMA_M,
        "m",
    )
    .at_most(Verdict::Doubtful)
    .because(format!(
        "the base's position lies {from_single_m:.1} m from its own single-point position, of \
             which metres are expected: the whole image is off by as much ([gnss] base_ecef_m or \
             base_deg_m)"
    ))
}

/// Height above the ground below which a flight is doubtful (m): the antenna's far field begins
/// there.
const LEAST_HEIGHT_M: f64 = 0.3;

/// Judges the height that the flight reaches above the ground or the image's plane.
#[must_use]
pub fn flight_height(height_m: f64) -> Finding {
    let verdict = match height_m {
        h if h >= LEAST_HEIGHT_M => Verdict::Agrees,
        h if h > 0.0 => Verdict::Doubtful,
        _ => Verdict::Contradicts,
    };
    Finding::judged("flight_height", height_m, "m", verdict).because(format!(
        "the flight reaches {height_m:.2} m above the ground (heights of the positions, \
         [trajectory] origin_deg_m, lever_arm_m, [image] z_m, terrain)"
    ))
}

/// Longest lever arm to the side or ahead that a small drone has room for (m).
const LONGEST_ARM_M: f64 = 1.5;

/// Judges the length of the horizontal part of a lever arm by the size of a small drone.
#[must_use]
pub fn lever_arm_length(horizontal_arm_m: f64) -> Finding {
    let verdict = if horizontal_arm_m <= LONGEST_ARM_M {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    Finding::judged("lever_arm_length", horizontal_arm_m, "m", verdict).because(format!(
        "the radar is said to stand {horizontal_arm_m:.2} m to the side or ahead of the positioned \
         point; a small drone has room for {LONGEST_ARM_M} m ([trajectory] lever_arm_m)"
    ))
}

/// How far a small drone's nose stands from its course (rad): 3° of crab and yaw.
const HEADING_SIGMA_RAD: f64 = 0.05;

/// Judges a horizontal lever arm that is turned by the course, for want of an attitude: what the
/// nose's departure from the course makes of it must stay below λ/4 of range, or the phases are lost.
#[must_use]
pub fn lever_arm_heading(horizontal_arm_m: f64, wavelength_m: f64) -> Finding {
    let sigma_m = horizontal_arm_m * HEADING_SIGMA_RAD;
    let verdict = if sigma_m <= 0.25 * wavelength_m {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    Finding::judged("lever_arm_heading", 1e3 * sigma_m, "mm", verdict)
        .expecting(0.0)
        .because(format!(
            "no attitude is recorded: a lever arm of {horizontal_arm_m:.2} m to the side or ahead, \
             turned by the course, leaves {:.0} mm of unknown motion; λ/4 is {:.0} mm ([trajectory] \
             lever_arm_m)",
            1e3 * sigma_m,
            250.0 * wavelength_m
        ))
}

/// Judges heights by the radar beside those of the positions that they replace: `off_m` is the standard
/// deviation of the positions' about the radar's, `stated_m` what the positions state of themselves.
#[must_use]
pub fn radar_height(off_m: f64, stated_m: Option<f64>, sigma_m: f64) -> Finding {
    let verdict = match stated_m {
        // Good heights were given away for worse ones.
        Some(stated_m) if stated_m < sigma_m => Verdict::Doubtful,
        Some(stated_m) if off_m > 3.0 * stated_m.hypot(sigma_m) => Verdict::Doubtful,
        _ => Verdict::Agrees,
    };
    Finding {
        sigma: stated_m.map(|stated_m| stated_m.hypot(sigma_m)),
        ..Finding::judged("radar_height", off_m, "m", verdict)
    }
    .expecting(0.0)
    .because(format!(
        "heights are those by the surface echo over level ground, ± {sigma_m:.2} m each; the \
         positions' wander about them by {off_m:.2} m and state {}; keep those that are better \
         ([trajectory] height; [image] z_m: the level of the ground is taken for the image's)",
        stated_m.map_or("no deviation".to_owned(), |m| format!("± {m:.2} m"))
    ))
}

/// The height of the flight by the surface echo, where no echo follows the heights of the positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AltimeterSeen {
    /// Median of the heights by the echo less those of the positions (m).
    pub level_m: f64,
    /// Standard deviation of the positions' heights about the echo's, their level aside (m).
    pub wander_m: f64,
    /// Standard deviation of a height by the echo (m).
    pub sigma_m: f64,
    /// How far the echo stands out (dB), and the share of the traces in which it is followed.
    pub contrast_db: f64,
    /// Share of the traces in which it is followed.
    pub picked: f64,
}

/// An echo that stands out so far (dB), in such a share of the traces, is taken for the ground's.
const ALTIMETER_CONTRAST_DB: f64 = 10.0;
const ALTIMETER_PICKED: f64 = 0.8;
/// How far an echo may be from straight below and still come from what stands on the ground (m).
const HEIGHT_OFF_M: f64 = 1.0;
/// Heights that wander by so much (m), beside the echo's own deviation, blur every target.
const HEIGHT_WANDER_M: f64 = 0.1;

/// Judges heights that no echo follows, by the echo that stands out most near them; none where none
/// does. What stands out may be a wall or a roof: it is never more than doubtful.
#[must_use]
pub fn surface_height(seen: &AltimeterSeen) -> Option<Finding> {
    let is_ground = seen.contrast_db >= ALTIMETER_CONTRAST_DB && seen.picked >= ALTIMETER_PICKED;
    let is_off = seen.level_m.abs() > HEIGHT_OFF_M
        || seen.wander_m > HEIGHT_WANDER_M.hypot(3.0 * seen.sigma_m);
    let verdict = if is_off {
        Verdict::Doubtful
    } else {
        Verdict::Agrees
    };
    is_ground.then(|| {
        Finding {
            sigma: Some(seen.sigma_m),
            ..Finding::judged("surface_height", seen.level_m, "m", verdict)
        }
        .expecting(0.0)
        .because(format!(
            "no echo follows the heights of the positions; the clearest one near them, seen in {:.0} % \
             of the traces, is {:+.2} m from straight below, and their heights wander about it by \
             {:.2} m (heights of the positions, [trajectory] origin_deg_m, height = \"radar\"; [image] \
             z_m; [radar] delay_ns)",
            100.0 * seen.picked,
            seen.level_m,
            seen.wander_m
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

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

    #[test]
    fn a_long_lever_arm_without_attitude_is_doubtful() {
        assert_eq!(lever_arm_heading(0.05, 0.0759).verdict, Verdict::Agrees);
        assert_eq!(lever_arm_heading(0.5, 0.0759).verdict, Verdict::Doubtful);
    }

    #[test]
    fn a_plane_above_the_flight_contradicts_and_an_arm_longer_than_the_drone_is_doubtful() {
        assert_eq!(flight_height(4.0).verdict, Verdict::Agrees);
        assert_eq!(flight_height(-1.4).verdict, Verdict::Contradicts);
        assert_eq!(lever_arm_length(0.3).verdict, Verdict::Agrees);
        assert_eq!(lever_arm_length(8.0).verdict, Verdict::Doubtful);
    }

    #[test]
    fn float_positions_are_doubtful_and_the_loss_is_that_of_the_phase_error() {
        // 6 mm at 7.6 cm: 0.99 rad, 4.3 dB.
        let fixed = focusing_loss(0.006, 0.0759);
        assert_eq!(fixed.verdict, Verdict::Agrees);
        assert!(fixed.explanation.contains("4.3 dB"), "{fixed:?}");
        assert_eq!(focusing_loss(0.4, 0.0759).verdict, Verdict::Doubtful);
    }

    #[test]
    fn heights_a_metre_off_or_wandering_are_doubted_where_an_echo_tells_the_ground() {
        let seen = AltimeterSeen {
            level_m: 0.05,
            wander_m: 0.05,
            sigma_m: 0.05,
            contrast_db: 15.0,
            picked: 0.95,
        };
        let verdict = |seen| surface_height(&seen).map(|finding| finding.verdict);
        assert_eq!(verdict(seen), Some(Verdict::Agrees));
        let high = AltimeterSeen {
            level_m: -1.4,
            ..seen
        };
        assert_eq!(verdict(high), Some(Verdict::Doubtful));
        let wandering = AltimeterSeen {
            wander_m: 0.3,
            ..seen
        };
        assert_eq!(verdict(wandering), Some(Verdict::Doubtful));
        let faint = AltimeterSeen {
            contrast_db: 7.0,
            ..high
        };
        assert_eq!(verdict(faint), None);
    }

    #[test]
    fn radar_heights_in_place_of_better_ones_are_doubted() {
        let verdict = |off_m, stated_m| radar_height(off_m, stated_m, 0.05).verdict;
        assert_eq!(verdict(0.04, Some(0.01)), Verdict::Doubtful);
        assert_eq!(verdict(1.5, Some(2.0)), Verdict::Agrees);
        assert_eq!(verdict(9.0, Some(2.0)), Verdict::Doubtful);
        assert_eq!(verdict(1.5, None), Verdict::Agrees);
    }
}
