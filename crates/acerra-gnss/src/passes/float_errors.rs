//! Errors of float positions beyond the covariance that the filter states.
//!
//! The filter models the codes' errors of different satellites as independent except for one common delay.
//! Their effect on the position is measured where integers are known, horizontally and vertically separately:
//! low satellites are weak and equally reflected, and determine the height. Errors that last longer than the
//! log are equal in a forward and a backward pass: the mean of the two passes is less accurate than the mean
//! of independent estimates would be.

use crate::filter::epoch_result::EpochResult;
use crate::solution::Quality;
use acerra_geo::geodesy::EnuFrame;

/// Ratio of float errors to the filter's stated errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FloatErrors {
    /// Factors on variances, horizontally and vertically.
    pub factors: [f64; 2],
    /// Correlation of the errors of passes in opposite directions.
    pub correlation: f64,
}

impl FloatErrors {
    /// The filters' stated errors, independent in both passes.
    pub(crate) const AS_STATED: Self = Self {
        factors: [1.0; 2],
        correlation: 0.0,
    };

    /// Scales the covariances of the float positions of a pass.
    pub(crate) fn scale(&self, results: &mut [EpochResult]) {
        let [horizontal, vertical] = self.factors.map(f64::sqrt);
        let factors = [horizontal, horizontal, vertical];
        for result in results {
            if result.quality == Some(Quality::Float) {
                let frame = EnuFrame::from_ecef(result.position_ecef_m);
                let mut enu = frame.enu_covariance_from_ecef(&result.covariance_ecef_m2);
                for (i, row) in enu.iter_mut().enumerate() {
                    for (j, value) in row.iter_mut().enumerate() {
                        *value *= factors[i] * factors[j];
                    }
                }
                result.covariance_ecef_m2 = frame.ecef_covariance_from_enu(&enu);
            }
        }
    }

    /// Factor on the covariance of the weighted mean of two passes, for their common errors, from the
    /// variances of the passes (m²).
    pub(crate) fn of_mean(&self, [a, b]: [f64; 2]) -> f64 {
        // Weights of inverse variances: the cross term over the variance of the mean.
        1.0 + 2.0 * self.correlation * (a * b).sqrt() / (a + b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_passes_share_does_not_average_out() {
        let with = |correlation| FloatErrors {
            correlation,
            ..FloatErrors::AS_STATED
        };
        // The mean of two equal estimates has half the variance of one (independent), or the same variance
        // (fully correlated).
        assert!((with(0.0).of_mean([2.0, 2.0]) - 1.0).abs() < 1e-12);
        assert!((with(1.0).of_mean([2.0, 2.0]) - 2.0).abs() < 1e-12);
        // A far worse estimate adds no information.
        assert!(with(1.0).of_mean([2.0, 2e6]) < 1.01);
    }
}
