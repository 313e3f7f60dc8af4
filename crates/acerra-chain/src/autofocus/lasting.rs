//! Errors of positions that last for a whole track.
//!
//! The error of a float position is the sum of the error of its ambiguities, which lasts for minutes, and the
//! error of its phases, which is as small as a fixed position's. The error of the ambiguities is a shift of
//! the track and a slow change along it; the error of the phases alone changes from trace to trace. Heights
//! by the radar have neither error. A track whose positions are only partly float has no shift in common: its
//! errors are taken as the positions state them, from trace to trace.

use acerra_geo::matrix::Matrix3;
use acerra_geo::trajectory::SolutionStatus;
use acerra_gnss::ErrorCorrelation;

use super::options::AutofocusOptions;
use crate::prepare::{Prepared, Track};

/// Deviations of an error that the positions of a track have in common.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Lasting {
    /// Standard deviation of the constant error east, north, up (m).
    pub shift_sigma_m: [f64; 3],
    /// Standard deviation of the error's rate of change east, north, up (m/s).
    pub rate_sigma_m_s: [f64; 3],
}

impl Prepared {
    /// Slow part of the errors of a track's positions: as stated, else that of float positions.
    pub(super) fn lasting(&self, track: &Track, options: &AutofocusOptions) -> Lasting {
        let of_float_m = self
            .float_sigma_m(track)
            .filter(|_| options.sigma_m.is_none());
        let shift_sigma_m = options.track_shift_sigma_m.or(of_float_m);
        // A Matérn process of order 3/2 changes by √3 of its deviation over its correlation length.
        let usual = ErrorCorrelation::default();
        let slowest = usual.ambiguities.iter().map(|part| part.time_constant_s);
        let rate_1_s = 3_f64.sqrt() / slowest.fold(f64::MIN_POSITIVE, f64::max);
        Lasting {
            shift_sigma_m: shift_sigma_m.unwrap_or_default(),
            rate_sigma_m_s: of_float_m.unwrap_or_default().map(|s| s * rate_1_s),
        }
    }

    /// The fast part of errors with these covariances, one a trace (m²).
    pub(super) fn keep_what_changes(&self, covariance_m2: &mut [Matrix3]) {
        let of_phases_m2 = ErrorCorrelation::default().fixed_variance_m2;
        let axes = self.axes_of_positions();
        for track in &self.tracks {
            if self.is_float(track) {
                for covariance in &mut covariance_m2[track.range.clone()] {
                    *covariance = of_phases(covariance, axes, of_phases_m2);
                }
            }
        }
    }

    /// Rms deviations that a track's float positions state, 0 of heights by the radar; none where they are not
    /// float throughout.
    fn float_sigma_m(&self, track: &Track) -> Option<[f64; 3]> {
        let stated = self.aligned.sigma_m.get(track.range.clone())?;
        let axes = self.axes_of_positions();
        let rms = |axis: usize| {
            let sum: f64 = stated.iter().map(|sigma_m| sigma_m[axis].powi(2)).sum();
            (sum / stated.len() as f64).sqrt()
        };
        let of = |axis| if axis < axes { rms(axis) } else { 0.0 };
        self.is_float(track).then(|| [0, 1, 2].map(of))
    }

    /// Whether all imaged traces of a track are at float positions.
    fn is_float(&self, track: &Track) -> bool {
        let status = self.aligned.status.get(track.range.clone());
        let is_float = |status: &SolutionStatus| *status == SolutionStatus::Float;
        status.is_some_and(|status| !status.is_empty() && status.iter().all(is_float))
    }

    /// Axes, of east, north and up, that are the positions': not the height where the radar measured it.
    fn axes_of_positions(&self) -> usize {
        3 - usize::from(self.aligned.radar_height.is_some())
    }
}

/// The share of a float position's covariance that its phases leave, of the first `axes` axes; other axes
/// keep their covariance.
fn of_phases(covariance_m2: &Matrix3, axes: usize, of_phases_m2: f64) -> Matrix3 {
    let total_m2: f64 = (0..axes).map(|i| covariance_m2[i][i]).sum();
    let share = (of_phases_m2 / total_m2).min(1.0).sqrt();
    let factor = |i: usize| if i < axes { share } else { 1.0 };
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| covariance_m2[i][j] * factor(i) * factor(j)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phases_alone_change_from_trace_to_trace() {
        let wide = [[0.04, 0.01, 0.0], [0.01, 0.04, 0.0], [0.0, 0.0, 0.12]];
        let all = of_phases(&wide, 3, 1e-4);
        for (i, expected) in [2e-5, 2e-5, 6e-5].into_iter().enumerate() {
            assert!((all[i][i] - expected).abs() < 1e-12);
        }
        assert!((all[0][1] - 5e-6).abs() < 1e-12);
        // Heights by the radar keep their covariance.
        let level = of_phases(&wide, 2, 1e-4);
        assert!((level[0][0] - 5e-5).abs() < 1e-12 && level[2][2] == 0.12);
        let good = [[1e-6, 0.0, 0.0], [0.0, 1e-6, 0.0], [0.0, 0.0, 4e-6]];
        assert_eq!(of_phases(&good, 3, 1e-4), good);
        let known = [[0.0; 3]; 3];
        assert_eq!(of_phases(&known, 3, 1e-4), known);
    }
}
