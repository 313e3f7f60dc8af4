//! Uncertainty of a target's place, by the stated errors of positions and clocks.

use std::ops::Range;

use acerra_chain::position::aligned::Aligned;
use acerra_chain::{Prepared, Track};
use acerra_imaging::metrics::Target;

/// Standard deviations of a target's place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PlaceSigma {
    /// Along the track (m).
    pub along_m: f64,
    /// Across it (m).
    pub across_m: f64,
}

/// The deviation of a target's place, by the geometry at the point of the track that is nearest to it; none
/// where the positions state no errors.
///
/// Errors of the positions shift the image as a whole. A height error σ displaces a target at horizontal
/// distance y from a track of height h from y to √(y² + 2hσ) (Eq. (14) of Catapano et al. 2020): by hσ/y to
/// the side of the track, by √(2hσ) under it. An estimated or recorded clock offset moves targets along the
/// track by its deviation times the speed. An estimated delay contributes its deviation as range. Without
/// recorded attitudes the platform tilts about the course: the lever arm then moves the radar sideways by its
/// vertical part and in height by its horizontal part. Errors of range that drift while the target is in view
/// displace the target along the track by the range times the drift per metre of track.
pub(crate) fn place_sigma(prepared: &Prepared, target: &Target) -> Option<PlaceSigma> {
    let aligned = &prepared.aligned;
    let away_m = |p: &[f64; 3]| (p[0] - target.x_m).hypot(p[1] - target.y_m);
    let nearest = (0..aligned.position_m.len()).min_by(|a, b| {
        let distance = |k: usize| away_m(&aligned.position_m[k]);
        distance(*a).total_cmp(&distance(*b))
    })?;
    let sigma_m = aligned.sigma_m.get(nearest)?;
    let place = &aligned.position_m[nearest];
    let ground_m = prepared.ground.map_or(0.0, |found| found.sigma_m);
    let mut tracks = prepared.tracks.iter();
    let track = tracks.find(|track| track.range.contains(&nearest));
    let [arm_level_m, arm_height_m] = track.map_or([0.0; 2], lever_arm_sigma_m);
    let level_m = sigma_m[0].hypot(sigma_m[1]) * std::f64::consts::FRAC_1_SQRT_2;
    let horizontal_m = level_m.hypot(arm_level_m);
    let y_m = away_m(place);
    let height_m = place[2] - target.z_m;
    let height_sigma_m = sigma_m[2].hypot(ground_m).hypot(arm_height_m);
    let range_m = y_m.hypot(height_m);
    let range_sigma_m = 0.5 * prepared.scene.light_speed_m_s * track.map_or(0.0, delay_sigma_s);
    let by_height_m = displacement_m(y_m, height_m, height_sigma_m).hypot(displacement_m(
        y_m,
        range_m,
        range_sigma_m,
    ));
    let speed_m_s = track.map_or(0.0, |track| {
        speed_m_s(aligned, &track.range, nearest, range_m)
    });
    let by_clock_m = track.map_or(0.0, clock_sigma_s) * speed_m_s;
    let by_drift_m = if speed_m_s > 0.0 {
        let in_view_s = aperture_m(prepared, target, range_m) / speed_m_s;
        let of_positions_m = (level_m * y_m).hypot(sigma_m[2] * height_m) / range_m.max(1e-9);
        let of_swing_m = track.map_or(0.0, swing_sigma_m);
        let drift_m_s = drift_m_s(of_positions_m, MULTIPATH_S, in_view_s)
            .hypot(drift_m_s(of_swing_m, SWING_S, in_view_s));
        drift_m_s * range_m / speed_m_s
    } else {
        0.0
    };
    Some(PlaceSigma {
        along_m: horizontal_m.hypot(by_clock_m).hypot(by_drift_m),
        across_m: horizontal_m.hypot(by_height_m),
    })
}

/// Deviation of a track's clock offset, where it was estimated or recorded (s); 0 for a stated offset.
fn clock_sigma_s(track: &Track) -> f64 {
    let searched_s = track.search.as_ref().map(|s| s.estimate.sigma_s);
    let recorded_s = track.recorded_clock.as_ref().map(|clock| clock.sigma_s);
    searched_s.or(recorded_s).unwrap_or(0.0)
}

/// Deviation of a track's delay, where it was searched (s).
fn delay_sigma_s(track: &Track) -> f64 {
    track.delay.as_ref().map_or(0.0, |found| found.sigma_s)
}

/// Tilt of a multirotor without recorded attitudes, and angle between its nose and the course (rad): 5° in a
/// wind, and 3°.
const TILT_SIGMA_RAD: f64 = 0.087;
const HEADING_SIGMA_RAD: f64 = 0.052;

/// Error of a recorded heading (rad): 2° of a compass on a multirotor.
const COMPASS_SIGMA_RAD: f64 = 0.035;
/// Swing of the tilt about its mean (rad): 2°.
const SWING_SIGMA_RAD: f64 = 0.035;
/// Times for which a swing and an error of the positions last (s): swings of a period of 3 s, and multipath.
const SWING_S: f64 = 0.5;
const MULTIPATH_S: f64 = 10.0;

/// Displacement by a track's lever arm under unrecorded tilts and headings, or under the error of recorded
/// headings: horizontally and in height (m).
fn lever_arm_sigma_m(track: &Track) -> [f64; 2] {
    let horizontal_m = track.horizontal_lever_arm_m();
    if track.has_attitude() {
        return [COMPASS_SIGMA_RAD * horizontal_m, 0.0];
    }
    of_arm_m(horizontal_m, track.lever_arm_m[2])
}

/// Motion of the radar at the end of the lever arm by unrecorded swings of the tilt (m).
fn swing_sigma_m(track: &Track) -> f64 {
    if track.has_attitude() {
        return 0.0;
    }
    SWING_SIGMA_RAD * track.horizontal_lever_arm_m().hypot(track.lever_arm_m[2])
}

/// Standard deviation of the least-squares slope (m/s), over `in_view_s`, of an error of the deviation `sigma_m` that
/// lasts for `lasting_s`: σ/τ over a shorter time, √(24τ/T³) σ over a longer one.
fn drift_m_s(sigma_m: f64, lasting_s: f64, in_view_s: f64) -> f64 {
    sigma_m
        * lasting_s
            .recip()
            .min((24.0 * lasting_s / in_view_s.powi(3)).sqrt())
}

/// Length of the aperture in which a target is seen (m), by the width of its image: 0.886 λR / 2L at −3 dB. The
/// range, where the width is not known.
fn aperture_m(prepared: &Prepared, target: &Target, range_m: f64) -> f64 {
    let frequency_hz = &prepared.spectrum.frequency_hz;
    let ends = frequency_hz.first().zip(frequency_hz.last());
    let of_width = target
        .along
        .width_3db_m
        .zip(ends)
        .map(|(width_m, (low, high))| {
            let wavelength_m = 2.0 * prepared.scene.light_speed_m_s / (low + high);
            0.443 * wavelength_m * range_m / width_m
        });
    of_width.filter(|m| m.is_finite()).unwrap_or(range_m)
}

fn of_arm_m(horizontal_m: f64, up_m: f64) -> [f64; 2] {
    [
        (TILT_SIGMA_RAD * up_m).hypot(HEADING_SIGMA_RAD * horizontal_m),
        TILT_SIGMA_RAD * horizontal_m,
    ]
}

/// Horizontal speed (m/s) at which a track passes a target: that of the path along its lines within `reach_m` of the trace
/// nearest to the target. A halt adds no path, and leaves the place to the traces before and after the halt.
fn speed_m_s(aligned: &Aligned, track: &Range<usize>, nearest: usize, reach_m: f64) -> f64 {
    let level_m = |a: usize, b: usize| {
        let [a, b] = [a, b].map(|k| aligned.position_m[k]);
        (b[0] - a[0]).hypot(b[1] - a[1])
    };
    let steps = (aligned.lines(track.clone()).into_iter())
        .flat_map(|line| line.start..line.end.saturating_sub(1))
        .map(|k| k + track.start)
        .filter(|k| level_m(*k, nearest) <= reach_m)
        .map(|k| (level_m(k, k + 1), aligned.time_s[k + 1] - aligned.time_s[k]))
        .filter(|(_, duration_s)| *duration_s > 0.0);
    let (path_m, weighted) = steps.fold((0.0, 0.0), |(path_m, weighted), (step_m, duration_s)| {
        (path_m + step_m, weighted + step_m * step_m / duration_s)
    });
    if path_m > 0.0 { weighted / path_m } else { 0.0 }
}

fn displacement_m(y_m: f64, height_m: f64, sigma_m: f64) -> f64 {
    (y_m * y_m + 2.0 * height_m.abs() * sigma_m).sqrt() - y_m
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_speed_is_that_of_the_own_track() {
        let place = |k: u32| match k {
            0..10 => [0.1 * f64::from(k), 0.0, 5.0],
            _ => [50.0, 0.3 * f64::from(k), 5.0],
        };
        let aligned = Aligned {
            position_m: (0..20).map(place).collect(),
            time_s: (0..20).map(|k| 0.1 * f64::from(k % 10)).collect(),
            ..Aligned::default()
        };
        assert!((speed_m_s(&aligned, &(0..10), 9, 5.0) - 1.0).abs() < 1e-12);
        assert!((speed_m_s(&aligned, &(10..20), 10, 5.0) - 3.0).abs() < 1e-12);
        assert!(speed_m_s(&aligned, &(4..5), 4, 5.0).abs() < f64::EPSILON);
    }

    #[test]
    fn a_halt_beside_a_target_leaves_the_speed_before_and_after_it() {
        // 1.5 m/s, ten seconds at the origin, 1.5 m/s.
        let place = |k: u32| {
            let t = 0.1 * f64::from(k);
            let moving_s = (t - 4.0).min(0.0) + (t - 14.0).max(0.0);
            [1.5 * moving_s, 0.0, 5.0]
        };
        let aligned = Aligned {
            position_m: (0..180).map(place).collect(),
            time_s: (0..180).map(|k| 0.1 * f64::from(k)).collect(),
            ..Aligned::default()
        };
        let speed = speed_m_s(&aligned, &(0..180), 90, 5.0);
        assert!((speed - 1.5).abs() < 1e-9, "{speed}");
    }

    #[test]
    fn an_arm_without_attitude_errs_by_its_length_times_the_tilt() {
        let [level_m, height_m] = of_arm_m(0.3, -0.4);
        assert!((level_m - 0.0381).abs() < 1e-3 && (height_m - 0.0261).abs() < 1e-4);
        assert!(of_arm_m(0.0, 0.0) == [0.0; 2]);
    }

    #[test]
    fn errors_drift_less_over_a_longer_aperture() {
        // A centimetre that lasts for 10 s: 1 mm/s over 5 s, and the slope of many independent errors over 100 s.
        assert!((drift_m_s(0.01, 10.0, 5.0) - 1e-3).abs() < 1e-12);
        let long = drift_m_s(0.01, 10.0, 100.0);
        assert!((long - 0.01 * 240_f64.sqrt() / 1e3).abs() < 1e-12);
        assert!(drift_m_s(0.0, 10.0, 5.0).abs() < f64::EPSILON);
    }

    #[test]
    fn heights_displace_targets_as_equation_14_has_it() {
        // Under the track √(2hσ), to its side hσ/y.
        assert!((displacement_m(0.0, 4.0, 0.01) - 0.08_f64.sqrt()).abs() < 1e-12);
        assert!((displacement_m(5.0, 10.0, 0.001) - 0.002).abs() < 1e-6);
    }
}
