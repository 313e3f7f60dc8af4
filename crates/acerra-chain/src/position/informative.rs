//! Selection of a log's positions that are accurate enough for motion and height.

use acerra_geo::trajectory::Trajectory;

/// Ratio of a position's standard deviation to the standard deviation of the log's better positions beyond
/// which the position is not used.
const WORSE: f64 = 10.0;
const LEAST_M: f64 = 0.05;
/// Share of the positions that count as the better ones.
const BETTER_SHARE: f64 = 0.25;

/// The standard deviation (m) beyond which positions of a log show neither motion nor height: ten times the
/// deviation of the log's better quarter. Float positions of a craft on the ground wander and jump by as much
/// as a slow flight moves. Infinite where no position states its deviation.
pub(crate) fn largest_informative_m(trajectory: &Trajectory) -> f64 {
    let fixes = trajectory.fixes().iter();
    let mut sigma_m: Vec<f64> = fixes
        .filter_map(|fix| fix.covariance_m2.map(sigma_of_m))
        .collect();
    if sigma_m.is_empty() {
        return f64::INFINITY;
    }
    sigma_m.sort_by(f64::total_cmp);
    let better_m = sigma_m[(BETTER_SHARE * (sigma_m.len() - 1) as f64) as usize];
    (WORSE * better_m).max(LEAST_M)
}

/// Whether a position with this covariance (m²) shows motion and height; positions without a covariance do.
pub(crate) fn is_informative(covariance_m2: Option<[[f64; 3]; 3]>, largest_m: f64) -> bool {
    covariance_m2.is_none_or(|covariance| sigma_of_m(covariance) <= largest_m)
}

/// Deviation along the worst axis (m).
fn sigma_of_m(covariance_m2: [[f64; 3]; 3]) -> f64 {
    let variances = (0..3).map(|i| covariance_m2[i][i].max(0.0));
    variances.fold(0.0, f64::max).sqrt()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test that cannot go on has failed
mod tests {
    use acerra_geo::trajectory::{Fix, Frame, TimeOrigin};

    use super::*;

    fn stated(sigma_m: impl Fn(u32) -> f64) -> Trajectory {
        let fix = |k| {
            let variance = sigma_m(k).powi(2);
            let mut fix = Fix::new(f64::from(k), [0.0; 3]);
            fix.covariance_m2 = Some(std::array::from_fn(|i| {
                std::array::from_fn(|j| if i == j { variance } else { 0.0 })
            }));
            fix
        };
        Trajectory::new(
            Frame::Local,
            TimeOrigin::Relative,
            (0..100).map(fix).collect(),
        )
        .unwrap()
    }

    #[test]
    fn float_positions_show_nothing_where_there_are_fixed_ones() {
        let log = stated(|k| if k < 60 { 0.5 } else { 0.01 });
        let largest_m = largest_informative_m(&log);
        assert!((largest_m - 0.1).abs() < 1e-12);
        assert!(!is_informative(log.fixes()[0].covariance_m2, largest_m));
        assert!(
            is_informative(log.fixes()[99].covariance_m2, largest_m)
                && is_informative(None, largest_m)
        );
    }

    #[test]
    fn a_log_of_float_positions_is_all_there_is() {
        let log = stated(|k| if k < 60 { 0.5 } else { 0.4 });
        assert!(is_informative(
            log.fixes()[0].covariance_m2,
            largest_informative_m(&log)
        ));
        let silent = Trajectory::new(
            Frame::Local,
            TimeOrigin::Relative,
            vec![Fix::new(0.0, [0.0; 3]), Fix::new(1.0, [0.0; 3])],
        );
        assert!(largest_informative_m(&silent.unwrap()).is_infinite());
    }
}
