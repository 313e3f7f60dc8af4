//! Findings on a track's positions.

use std::f64::consts::TAU;

use acerra_geo::lever_arm::HeadingOptions;

use super::median::median;
use crate::align::geometry::ImageGeometry;
use crate::journal::finding::{Finding, Verdict};
use crate::prepare::{Prepared, Track};

/// Share of the log that has positions, and the positions' own σ along the line of sight.
pub(super) fn weigh(
    prepared: &Prepared,
    track: &Track,
    geometry: &ImageGeometry<'_>,
    is_below_ground: bool,
) -> Vec<Finding> {
    let mut findings = Vec::new();
    let before: usize = prepared
        .tracks
        .iter()
        .take_while(|other| other.range.start < track.range.start)
        .map(|other| other.traces_in_log)
        .sum();
    let all = prepared.aligned.all.iter().skip(before);
    let positioned = all
        .take(track.traces_in_log)
        .filter(|place| place.flag.is_covered())
        .count();
    findings.push(trajectory_coverage(positioned, track.traces_in_log));
    let middle_hz = 0.5 * (geometry.band_hz[0] + geometry.band_hz[1]);
    let wavelength_m = geometry.light_speed_m_s / middle_hz;
    let heights_m = prepared.aligned.height_m.get(track.range.clone());
    if track.cleaned.is_some() {
        // Refracted rays hold down to antennas on the ground.
        let least_m = if is_below_ground { 0.0 } else { LEAST_HEIGHT_M };
        let reached_m = heights_m.and_then(height_reached_m);
        findings.extend(reached_m.map(|height_m| flight_height(height_m, least_m)));
    }
    let arm_m = track.horizontal_lever_arm_m();
    if arm_m > 0.0 {
        findings.push(lever_arm_length(arm_m));
    }
    if arm_m > 0.0 && !track.has_attitude() {
        let part = track.range.clone();
        let (time_s, position_m) = (&prepared.aligned.time_s, &prepared.aligned.position_m);
        let halt_s = longest_halt_s(
            time_s.get(part.clone()).unwrap_or(&[]),
            position_m.get(part).unwrap_or(&[]),
        );
        findings.push(lever_arm_heading(arm_m, wavelength_m, halt_s));
    }
    if let Some(seen) = prepared.aligned.radar_height {
        findings.push(radar_height(
            seen.positions_off_m,
            seen.stated_m,
            seen.sigma_m,
        ));
    }
    findings.extend(position_sigma(prepared, track, geometry));
    // Heights by the radar replace those that were written.
    let axes = if prepared.aligned.radar_height.is_some() {
        2
    } else {
        3
    };
    let step_m = track
        .resolution_m
        .map(|m| m[..axes].iter().copied().fold(0.0, f64::max));
    findings.extend(step_m.map(|m| position_resolution(m, wavelength_m)));
    findings
}

/// The loss of focus by the positions' own σ and, where the clock offset is a recorded clock's, by its.
fn position_sigma(
    prepared: &Prepared,
    track: &Track,
    geometry: &ImageGeometry<'_>,
) -> Option<Finding> {
    let middle_hz = 0.5 * (geometry.band_hz[0] + geometry.band_hz[1]);
    let wavelength_m = geometry.light_speed_m_s / middle_hz;
    let positions_m = line_of_sight_sigma_m(prepared, track, geometry)?;
    let clock_m = track
        .recorded_clock
        .as_ref()
        .and_then(|clock| line_of_sight_wander_m_s(prepared, track, geometry).zip(Some(clock)))
        .map(|(wander_m_s, clock)| wander_m_s * clock.sigma_s);
    let mut finding = focusing_loss(positions_m.hypot(clock_m.unwrap_or(0.0)), wavelength_m);
    if let Some(clock_m) = clock_m {
        finding.explanation.push_str(&format!(
            "; {:.1} mm of that by the recorded clock, where the velocity differs from its mean",
            1e3 * clock_m
        ));
    }
    Some(finding)
}

/// The height that a tenth of the traces exceed: a drone may be on the ground for long (m).
fn height_reached_m(height_m: &[f64]) -> Option<f64> {
    let mut sorted: Vec<f64> = height_m.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() * 9 / 10).copied()
}

/// Root mean square of the velocity's deviation from its mean, along the line of sight to the middle of the
/// image (m/s): an error of the clock moves traces against one another by this velocity, and the image as a
/// whole by the mean.
fn line_of_sight_wander_m_s(
    prepared: &Prepared,
    track: &Track,
    geometry: &ImageGeometry<'_>,
) -> Option<f64> {
    let middle = geometry.pixel_m.get(geometry.pixel_m.len() / 2)?;
    let times_s = prepared.aligned.time_s.get(track.range.clone())?;
    let pairs = geometry.position_m.windows(2).zip(times_s.windows(2));
    let velocities: Vec<([f64; 3], [f64; 3])> = pairs
        .filter(|(_, t)| t[1] > t[0])
        .map(|(p, t)| {
            let velocity = std::array::from_fn(|i| (p[1][i] - p[0][i]) / (t[1] - t[0]));
            (p[0], velocity)
        })
        .collect();
    let count = velocities.len() as f64;
    let mean: [f64; 3] =
        std::array::from_fn(|i| velocities.iter().map(|(_, v)| v[i]).sum::<f64>() / count);
    let square = |(position, velocity): &([f64; 3], [f64; 3])| {
        let away: [f64; 3] = std::array::from_fn(|i| middle[i] - position[i]);
        let range_m = away.iter().map(|v| v * v).sum::<f64>().sqrt();
        let along: f64 = (0..3)
            .map(|i| (velocity[i] - mean[i]) * away[i] / range_m)
            .sum();
        along * along
    };
    let wander_m_s = (velocities.iter().map(square).sum::<f64>() / count).sqrt();
    wander_m_s.is_finite().then_some(wander_m_s)
}

/// Median over the traces of the positions' σ towards the middle of the image (m).
fn line_of_sight_sigma_m(
    prepared: &Prepared,
    track: &Track,
    geometry: &ImageGeometry<'_>,
) -> Option<f64> {
    let sigma_m = prepared.aligned.sigma_m.get(track.range.clone())?;
    let middle = geometry.pixel_m.get(geometry.pixel_m.len() / 2)?;
    let along = |(position, sigma): (&[f64; 3], &[f64; 3])| {
        let away: [f64; 3] = std::array::from_fn(|i| middle[i] - position[i]);
        let range_m = away.iter().map(|v| v * v).sum::<f64>().sqrt();
        let weighed = (0..3).map(|i| (away[i] / range_m * sigma[i]).powi(2));
        weighed.sum::<f64>().sqrt()
    };
    median(geometry.position_m.iter().zip(sigma_m).map(along))
}

/// Judges the loss of focus that the positions' own σ predict, after Eq. (5): a phase error of
/// 4πσ/λ along the line of sight.
///
/// Errors that all traces share move the image without blurring it, so that the loss is an upper bound;
/// beyond half a wavelength (float and single-point positions) the remaining focus is chance.
fn focusing_loss(sigma_m: f64, wavelength_m: f64) -> Finding {
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
            "positions of σ = {:.0} mm along the line of sight {cost}, for the part that changes from trace \
             to trace",
            1e3 * sigma_m
        ))
}

/// Judges the step of the last digit in which positions are written: rounding errs evenly, by step/√12, and from trace to
/// trace. λ/8 there and back is a quarter of a turn, at which half of the focus is gone.
fn position_resolution(step_m: f64, wavelength_m: f64) -> Finding {
    let sigma_m = step_m / 12f64.sqrt();
    let verdict = if sigma_m <= 0.125 * wavelength_m {
        Verdict::Agrees
    } else {
        Verdict::Contradicts
    };
    Finding::judged("position_resolution", 1e3 * sigma_m, "mm", verdict)
        .expecting(0.0)
        .because(format!(
            "the positions are written in steps of {:.1} mm: rounding leaves σ = {:.1} mm, where λ/8 is \
             {:.1} mm (more decimals in the output of the receiver or the logger; [autofocus] estimates the \
             remaining errors)",
            1e3 * step_m,
            1e3 * sigma_m,
            125.0 * wavelength_m
        ))
}

/// Loss of focus, dB, above which the remaining level of a target is no more than the chance sum of the
/// traces.
const WHOLE_FOCUS_DB: f64 = 20.0;

/// Judges the share of the log's traces that have a position.
fn trajectory_coverage(positioned: usize, traces: usize) -> Finding {
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

/// Height above the ground below which a flight is doubtful (m): the antenna's far field begins
/// there.
const LEAST_HEIGHT_M: f64 = 0.3;

/// Judges the height that the flight reaches above the ground or the image's plane, which is doubtful below `least_m`.
fn flight_height(height_m: f64, least_m: f64) -> Finding {
    let verdict = match height_m {
        h if h <= 0.0 => Verdict::Contradicts,
        h if h < least_m => Verdict::Doubtful,
        _ => Verdict::Agrees,
    };
    Finding::judged("flight_height", height_m, "m", verdict).because(format!(
        "the flight reaches {height_m:.2} m above the ground (heights of the positions, \
         [trajectory] origin_deg_m, lever_arm_m, [image] z_m, terrain)"
    ))
}

/// Longest lever arm to the side or ahead that a small drone has room for (m).
const LONGEST_ARM_M: f64 = 1.5;

/// Judges the length of the horizontal part of a lever arm by the size of a small drone.
fn lever_arm_length(horizontal_arm_m: f64) -> Finding {
    let verdict = if horizontal_arm_m <= LONGEST_ARM_M {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    Finding::judged("lever_arm_length", horizontal_arm_m, "m", verdict).because(format!(
        "the lever arm places the radar {horizontal_arm_m:.2} m to the side or ahead of the positioned \
         point; a small drone has room for {LONGEST_ARM_M} m ([trajectory] lever_arm_m)"
    ))
}

/// Angle between a small drone's nose and its course (rad): 3° of crab and yaw.
const HEADING_SIGMA_RAD: f64 = 0.05;

/// A halt within which a platform may turn on the spot (s).
const TURN_S: f64 = 2.0;
/// Half of the time over which the speed of a platform is averaged (s): gusts move a hovering platform to and fro.
const HALF_WINDOW_S: f64 = 1.0;

/// Longest time for which a platform halts between two moving parts of its traces (s).
fn longest_halt_s(time_s: &[f64], position_m: &[[f64; 3]]) -> f64 {
    let places = time_s.len().min(position_m.len());
    let is_moving = |k: usize| {
        let from = time_s.partition_point(|t| *t < time_s[k] - HALF_WINDOW_S);
        let to = time_s.partition_point(|t| *t <= time_s[k] + HALF_WINDOW_S) - 1;
        let [from, to] = [from, to.min(places - 1)];
        let way_m = (position_m[to][0] - position_m[from][0])
            .hypot(position_m[to][1] - position_m[from][1]);
        way_m >= HeadingOptions::default().min_speed_m_s * (time_s[to] - time_s[from])
    };
    let moving: Vec<usize> = (0..places).filter(|k| is_moving(*k)).collect();
    let halts = moving.windows(2).filter(|pair| pair[1] > pair[0] + 1);
    halts
        .map(|pair| time_s[pair[1]] - time_s[pair[0]])
        .fold(0.0, f64::max)
}

/// Judges a horizontal lever arm that is turned by the course, without a recorded attitude: the error of
/// range by the angle between nose and course must stay below λ/4, or the phases are lost. A platform that halts
/// for `halt_s` may turn on the spot, so that the arm points anywhere afterwards.
fn lever_arm_heading(horizontal_arm_m: f64, wavelength_m: f64, halt_s: f64) -> Finding {
    let may_turn = halt_s >= TURN_S;
    let sigma_m = horizontal_arm_m * if may_turn { 1.0 } else { HEADING_SIGMA_RAD };
    let verdict = if sigma_m <= 0.25 * wavelength_m {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    let cause = if may_turn {
        format!(
            "turned by the course, points elsewhere if the platform turned on the spot while it halted for \
             {halt_s:.0} s, which is up to"
        )
    } else {
        "turned by the course, leaves".to_owned()
    };
    Finding::judged("lever_arm_heading", 1e3 * sigma_m, "mm", verdict)
        .expecting(0.0)
        .because(format!(
            "no attitude is recorded: a lever arm of {horizontal_arm_m:.2} m to the side or ahead, {cause} \
             {:.0} mm of unknown motion; λ/4 is {:.0} mm ([trajectory] lever_arm_m, attitude_file)",
            1e3 * sigma_m,
            250.0 * wavelength_m
        ))
}

/// Compares heights by the radar with those of the positions that they replace: `off_m` is the standard
/// deviation of the positions' about the radar's, `stated_m` the deviation that the positions state.
fn radar_height(off_m: f64, stated_m: Option<f64>, sigma_m: f64) -> Finding {
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
        "heights are by the surface echo over level ground, ± {sigma_m:.2} m each; the positions' heights \
         wander about the radar's by {off_m:.2} m and state {}; keep the better heights ([trajectory] \
         height; [image] z_m: the level of the ground counts as the image's)",
        stated_m.map_or("no deviation".to_owned(), |m| format!("± {m:.2} m"))
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_lever_arm_without_attitude_is_doubtful() {
        let verdict = |arm_m, halt_s| lever_arm_heading(arm_m, 0.0759, halt_s).verdict;
        assert_eq!(verdict(0.05, 0.0), Verdict::Agrees);
        assert_eq!(verdict(0.5, 0.0), Verdict::Doubtful);
        assert_eq!(verdict(0.05, 3.0), Verdict::Doubtful);
        assert_eq!(verdict(0.01, 3.0), Verdict::Agrees);
    }

    #[test]
    fn a_halt_lies_between_two_moving_parts() {
        // Ten traces a second at 1 m/s, with a gap in the motion.
        let flight = |parts: &[(usize, f64)]| {
            let steps = parts
                .iter()
                .flat_map(|(traces, speed_m_s)| vec![*speed_m_s; *traces]);
            let mut x_m = 0.0;
            let position_m: Vec<[f64; 3]> = steps
                .map(|speed_m_s| {
                    x_m += 0.1 * speed_m_s;
                    [x_m, 0.0, 5.0]
                })
                .collect();
            let time_s: Vec<f64> = (0..position_m.len()).map(|k| 0.1 * k as f64).collect();
            longest_halt_s(&time_s, &position_m)
        };
        assert_eq!(flight(&[]), 0.0);
        assert_eq!(flight(&[(50, 0.0), (100, 1.0), (50, 0.0)]), 0.0);
        let halt_s = flight(&[(100, 1.0), (60, 0.0), (100, 1.0)]);
        // The mean over two seconds shortens a halt of 6 s by up to a second at each end.
        assert!((4.0..6.0).contains(&halt_s), "{halt_s}");
    }

    #[test]
    fn a_plane_above_the_flight_contradicts_and_an_arm_longer_than_the_drone_is_doubtful() {
        assert_eq!(flight_height(4.0, 0.3).verdict, Verdict::Agrees);
        assert_eq!(flight_height(0.1, 0.3).verdict, Verdict::Doubtful);
        assert_eq!(flight_height(0.01, 0.0).verdict, Verdict::Agrees);
        assert_eq!(flight_height(-1.4, 0.0).verdict, Verdict::Contradicts);
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
    fn digits_coarser_than_the_phase_contradict() {
        // Four and five decimals of a minute, and heights of one decimal; λ = 75.9 mm.
        assert_eq!(
            position_resolution(0.1855, 0.0759).verdict,
            Verdict::Contradicts
        );
        assert_eq!(
            position_resolution(0.01855, 0.0759).verdict,
            Verdict::Agrees
        );
        let heights = position_resolution(0.1, 0.0759);
        assert_eq!(heights.verdict, Verdict::Contradicts);
        assert!((heights.value.unwrap() - 28.87).abs() < 0.01);
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
