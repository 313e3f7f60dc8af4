//! Errors of a trajectory's heights: noise from fix to fix, and lasting errors.

use acerra_geo::trajectory::{Fix, SolutionStatus, Trajectory};

/// Intervals between fixes may differ from one another by this share.
const EVEN: f64 = 0.2;
/// Least number of third differences.
const LEAST: usize = 16;
/// Ratio of standard deviation to median modulus of a normal distribution.
const NORMAL: f64 = 1.4826;

/// Standard deviation of the heights' noise from fix to fix (m), by third differences, to which motion of
/// constant acceleration does not contribute; `None` without 19 even fixes in a row.
///
/// Motion that changes from one fix to the next counts as noise: for a lively craft at 1 Hz, the result is an
/// upper bound.
pub(crate) fn height_noise_m(trajectory: &Trajectory) -> Option<f64> {
    let mut moduli_m: Vec<f64> = trajectory.fixes().windows(4).filter_map(third_m).collect();
    if moduli_m.len() < LEAST {
        return None;
    }
    let middle = moduli_m.len() / 2;
    let (_, median_m, _) = moduli_m.select_nth_unstable_by(middle, f64::total_cmp);
    // The variance of a third difference of independent errors is 1 + 9 + 9 + 1 = 20 times theirs.
    Some(NORMAL * *median_m / 20_f64.sqrt())
}

/// Median standard deviation of heights without fixed ambiguities (m), where most heights are such:
/// ambiguities and code multipath drift for as long as a climb lasts.
pub(crate) fn lasting_error_m(trajectory: &Trajectory) -> Option<f64> {
    let drifts = |status| {
        !matches!(
            status,
            SolutionStatus::Fixed | SolutionStatus::External | SolutionStatus::Unknown
        )
    };
    median_sigma_m(trajectory, drifts)
}

/// Median standard deviation of heights with fixed ambiguities (m), where most heights are such: multipath
/// lasts for some ten seconds.
pub(crate) fn stated_error_m(trajectory: &Trajectory) -> Option<f64> {
    median_sigma_m(trajectory, |status| status == SolutionStatus::Fixed)
}

/// Median standard deviation of the heights of some statuses (m), where they are more than half.
fn median_sigma_m(trajectory: &Trajectory, is_of: impl Fn(SolutionStatus) -> bool) -> Option<f64> {
    let fixes = trajectory.fixes();
    let mut sigma_m: Vec<f64> = fixes
        .iter()
        .filter(|fix| is_of(fix.status))
        .filter_map(|fix| Some(fix.covariance_m2?[2][2].max(0.0).sqrt()))
        .collect();
    if sigma_m.is_empty() || 2 * sigma_m.len() <= fixes.len() {
        return None;
    }
    let middle = sigma_m.len() / 2;
    Some(*sigma_m.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Modulus of the third difference of four even fixes (m).
fn third_m(four: &[Fix]) -> Option<f64> {
    let [a, b, c, d] = four else { return None };
    let steps_s = [
        b.time_s - a.time_s,
        c.time_s - b.time_s,
        d.time_s - c.time_s,
    ];
    let is_even = steps_s
        .iter()
        .all(|s| (s - steps_s[0]).abs() <= EVEN * steps_s[0]);
    let up = |fix: &Fix| fix.position_m[2];
    is_even.then(|| (up(d) - 3.0 * up(c) + 3.0 * up(b) - up(a)).abs())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test that cannot go on has failed
mod tests {
    use acerra_geo::trajectory::{Frame, TimeOrigin};

    use super::*;

    fn heights(count: u32, height_m: impl Fn(f64) -> f64) -> Trajectory {
        let fix = |k| {
            let t = 0.2 * f64::from(k);
            Fix::new(t, [1.5 * t, 0.0, height_m(t)])
        };
        Trajectory::new(
            Frame::Local,
            TimeOrigin::Relative,
            (0..count).map(fix).collect(),
        )
        .unwrap()
    }

    #[test]
    fn noise_is_told_from_a_swaying_climb() {
        let sway = |t: f64| 4.0 + 0.3 * t + 0.06 * (0.7 * t).sin();
        let quiet_m = height_noise_m(&heights(300, sway)).unwrap();
        assert!(quiet_m < 2e-4, "{quiet_m}");
        // Even numbers of a congruential sequence: a deviation of 1/√12.
        let noise = |t: f64| ((t * 5.0).round() * 0.754_877_666).fract() - 0.5;
        let mixed = |t: f64| {
            let scrambled = (1e4 * (noise(t) + 1.0).sin()).fract() - 0.5;
            sway(t) + 0.02 * scrambled
        };
        let noisy_m = height_noise_m(&heights(300, mixed)).unwrap();
        assert!(
            (noisy_m / (0.02 / 12_f64.sqrt()) - 1.0).abs() < 0.25,
            "{noisy_m}"
        );
    }

    #[test]
    fn a_few_fixes_tell_nothing() {
        assert_eq!(height_noise_m(&heights(18, |t| t)), None);
        assert!(height_noise_m(&heights(19, |t| t)).is_some());
    }

    #[test]
    fn heights_drift_where_most_ambiguities_are_not_fixed() {
        let with = |floats: u32| {
            let fix = |k: u32| Fix {
                status: if k < floats {
                    SolutionStatus::Float
                } else {
                    SolutionStatus::Fixed
                },
                covariance_m2: Some([[0.01, 0.0, 0.0], [0.0, 0.01, 0.0], [0.0, 0.0, 0.16]]),
                ..Fix::new(f64::from(k), [0.0; 3])
            };
            Trajectory::new(
                Frame::Local,
                TimeOrigin::Relative,
                (0..20).map(fix).collect(),
            )
            .unwrap()
        };
        assert!((lasting_error_m(&with(11)).unwrap() - 0.4).abs() < 1e-12);
        assert_eq!(lasting_error_m(&with(10)), None);
        assert_eq!(stated_error_m(&with(10)), None);
        assert!((stated_error_m(&with(9)).unwrap() - 0.4).abs() < 1e-12);
    }
}
