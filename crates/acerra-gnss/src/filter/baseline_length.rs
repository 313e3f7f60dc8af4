//! The known distance between two antennas on one vehicle.
//!
//! The length is the same observation at every epoch: given to the filter at every epoch, as in RTKLIB, its
//! error would seem to average out. Where integers are held outside the filter, the length is therefore
//! applied to the state of each epoch once, and removed before the next.

use super::Filter;
use crate::ambiguity::attempt::Attempt;
use crate::linear::sparse_row::SparseRow;
use crate::solution::NotFixedReason;
use crate::stations::epoch_input::BaseView;

/// Largest standard deviation of the position over the length at which the length is used: beyond it the
/// sphere cannot be linearised (as in RTKLIB).
const LARGEST_SHARE: f64 = 0.1;
/// Largest error of the length of a fix, in standard deviations.
const LARGEST_DEPARTURE_SIGMA: f64 = 4.0;
/// Standard deviation (m) of an antenna's phase centre over directions, which phase residuals do not contain.
const PHASE_CENTRE_SIGMA_M: f64 = 0.005;

/// State vector and covariance before the length was imposed.
pub(super) struct Unconstrained {
    x: Vec<f64>,
    p: Vec<f64>,
}

fn vector(x: &[f64], base: &BaseView<'_>) -> ([f64; 3], f64) {
    let from = base.moved.map_or(base.place_ecef_m, |m| m.position_ecef_m);
    let vector: [f64; 3] = std::array::from_fn(|k| x[k] - from[k]);
    (vector, vector.iter().map(|v| v * v).sum::<f64>().sqrt())
}

impl Filter<'_> {
    /// Updates the state with the length of the baseline, where the length is known and the position good
    /// enough; returns the state before the update, if the update is to be removed.
    pub(super) fn constrain_length(&mut self, base: &BaseView<'_>) -> Option<Unconstrained> {
        let known = self.options.baseline_length?;
        let (vector, length_m) = vector(&self.state.x, base);
        let variance_m2 = (0..3).map(|k| self.state.covariance(k, k)).sum::<f64>() / 3.0;
        if variance_m2 > (LARGEST_SHARE * length_m).powi(2) {
            return None;
        }
        // Integers fed back into the state must not be removed with the length.
        let before = self.options.holds_outside_filter().then(|| Unconstrained {
            x: self.state.x.clone(),
            p: self.state.p.clone(),
        });
        let direction: [_; 3] = std::array::from_fn(|k| (k, vector[k] / length_m));
        let row = SparseRow::new(&direction, known.length_m - length_m);
        let noise = self.state.white_noise(1, known.sigma_m * known.sigma_m);
        self.state.update(&[row], noise);
        before
    }

    /// Removes the effect of the length; states removed since remain removed.
    pub(super) fn release_length(&mut self, before: Option<Unconstrained>) {
        let Some(Unconstrained { x, p }) = before else {
            return;
        };
        (self.state.x, self.state.p) = (x, p);
        for index in 0..self.state.len() {
            if !self.state.exists[index] {
                self.state.remove(index);
            }
        }
    }

    /// The reason for rejecting a fix whose length is not the known length.
    pub(super) fn contradicted_length(
        &self,
        base: &BaseView<'_>,
        attempt: &Attempt,
    ) -> Option<NotFixedReason> {
        let known = self.options.baseline_length?;
        self.options.min_success_rate?;
        let (vector, length_m) = vector(&attempt.x, base);
        let np = self.state.leading_states;
        let mut variance_m2 = known.sigma_m.powi(2) + PHASE_CENTRE_SIGMA_M.powi(2);
        for i in 0..3 {
            for j in 0..3 {
                let motion_m2 = base.moved.map_or(0.0, |m| m.motion_ecef_m2[i][j]);
                let own = attempt.p[i * np + j] + motion_m2;
                variance_m2 += vector[i] * own * vector[j] / (length_m * length_m);
            }
        }
        let limit_m = LARGEST_DEPARTURE_SIGMA * variance_m2.max(0.0).sqrt();
        ((length_m - known.length_m).abs() > limit_m).then_some(NotFixedReason::BaselineLength {
            found_m: length_m,
            expected_m: known.length_m,
        })
    }
}
