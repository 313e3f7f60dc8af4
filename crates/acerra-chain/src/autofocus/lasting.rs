//! Errors of positions that last for a whole track.
//!
//! The error of a float position is that of its ambiguities, which lasts for minutes, and that of its phases, which
//! is as small as a fixed position's. The first is a shift of the track and its change along it; the second alone
//! changes from trace to trace.

use acerra_geo::matrix::Matrix3;
use acerra_geo::trajectory::SolutionStatus;

use super::options::AutofocusOptions;
use crate::prepare::{Prepared, Track};

/// Time for which errors of float ambiguities last (s).
const AMBIGUITIES_LAST_S: f64 = 300.0;
/// Sum of the variances east, north and up that phases alone give a position (m²).
const OF_PHASES_M2: f64 = 1e-4;

/// Deviations of an error that the positions of a track have in common.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Lasting {
    /// East, north, up (m).
    pub shift_sigma_m: [f64; 3],
    /// Of its change (m/s).
    pub rate_sigma_m_s: [f64; 3],
}

impl Prepared {
    /// What lasts of the errors of a track's positions: as stated, else that of float positions.
    pub(super) fn lasting(&self, track: &Track, options: &AutofocusOptions) -> Lasting {
        let of_float_m = self
            .float_sigma_m(track)
            .filter(|_| options.sigma_m.is_none());
        let shift_sigma_m = options.track_shift_sigma_m.or(of_float_m);
        // A Matérn process of order 3/2 of this length changes by √3 of its deviation in it.
        let rate_1_s = 3_f64.sqrt() / AMBIGUITIES_LAST_S;
        Lasting {
            shift_sigma_m: shift_sigma_m.unwrap_or_default(),
            rate_sigma_m_s: of_float_m.unwrap_or_default().map(|s| s * rate_1_s),
        }
    }

    /// Rms deviations that a track's float positions state; none where most of them are no such.
    fn float_sigma_m(&self, track: &Track) -> Option<[f64; 3]> {
        let stated = self.aligned.sigma_m.get(track.range.clone())?;
        let status = self.aligned.status.get(track.range.clone())?;
        let (mut sum_m2, mut count) = ([0.0; 3], 0_usize);
        for (sigma_m, status) in stated.iter().zip(status) {
            if *status == SolutionStatus::Float {
                (0..3).for_each(|i| sum_m2[i] += sigma_m[i] * sigma_m[i]);
                count += 1;
            }
        }
        (2 * count > status.len()).then(|| sum_m2.map(|s| (s / count as f64).sqrt()))
    }
}

/// What of a covariance changes from trace to trace: of a float position what its phases leave, of others all.
pub(super) fn changing(covariance_m2: Matrix3, status: SolutionStatus) -> Matrix3 {
    let total = covariance_m2[0][0] + covariance_m2[1][1] + covariance_m2[2][2];
    if status != SolutionStatus::Float || total <= OF_PHASES_M2 {
        return covariance_m2;
    }
    covariance_m2.map(|row| row.map(|v| v * OF_PHASES_M2 / total))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phases_alone_change_from_trace_to_trace() {
        let wide = [[0.04, 0.01, 0.0], [0.01, 0.04, 0.0], [0.0, 0.0, 0.12]];
        assert_eq!(changing(wide, SolutionStatus::Fixed), wide);
        assert_eq!(changing(wide, SolutionStatus::Single), wide);
        let float = changing(wide, SolutionStatus::Float);
        for (i, expected) in [2e-5, 2e-5, 6e-5].into_iter().enumerate() {
            assert!((float[i][i] - expected).abs() < 1e-12);
        }
        assert!((float[0][1] - 5e-6).abs() < 1e-12);
        let good = [[1e-6, 0.0, 0.0], [0.0, 1e-6, 0.0], [0.0, 0.0, 4e-6]];
        assert_eq!(changing(good, SolutionStatus::Float), good);
    }
}
