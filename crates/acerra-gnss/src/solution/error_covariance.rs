//! Covariance between the errors of a trajectory's positions.
//!
//! A standard deviation states the error of one position. Users of a stretch of trajectory, such as
//! autofocus, also need the correlation of the errors: an error that all positions share moves an image, an
//! error that changes within an aperture blurs it.

use super::epoch::Solution;
use super::error_correlation::ErrorCorrelation;
use super::quality::Quality;
use nalgebra::{Matrix3, SymmetricEigen};

impl ErrorCorrelation {
    /// Covariance (ECEF, m²) of the errors of two positions: of the error of `a` along each axis (rows) with
    /// the error of `b` (columns). With `b` = `a` the result is the stated covariance; a matrix of such
    /// blocks over any epochs is positive semi-definite.
    ///
    /// Each position's error is its covariance's symmetric root times unit processes: one of the phases, and
    /// one of ambiguities (or of codes, for positions from codes alone), which share the position's variance.
    ///
    /// ```
    /// use acerra_gnss::{ErrorCorrelation, Lasting, Quality, Solution};
    /// use acerra_geo::time::GpsTime;
    /// let at = |seconds: f64, quality, sigma_m: f64| Solution {
    ///     time: GpsTime::from_week_tow(2_300, seconds),
    ///     position_ecef_m: [4_641_950.0, 1_393_058.0, 4_133_281.0],
    ///     covariance_ecef_m2: std::array::from_fn(|i| {
    ///         std::array::from_fn(|j| if i == j { sigma_m * sigma_m } else { 0.0 })
    ///     }),
    ///     baseline: None,
    ///     velocity_ecef_m_s: None,
    ///     quality,
    ///     satellites: 9,
    ///     age_s: 0.0,
    ///     ratio: 0.0,
    ///     not_fixed: None,
    ///     residuals: Vec::new(),
    /// };
    /// let errors = ErrorCorrelation {
    ///     phases: vec![Lasting { share: 0.6, time_constant_s: 50.0 }],
    ///     ambiguities: vec![Lasting { share: 1.0, time_constant_s: 300.0 }],
    ///     fixed_variance_m2: 3.0 * 0.01 * 0.01,
    /// };
    /// let (a, b) = (at(0.0, Quality::Fixed, 0.01), at(5.0, Quality::Fixed, 0.01));
    /// assert!((errors.covariance_ecef_m2(&a, &a)[0][0] - 1e-4).abs() < 1e-12);
    /// let expected = 1e-4 * 0.6 * (-5.0f64 / 50.0).exp();
    /// assert!((errors.covariance_ecef_m2(&a, &b)[0][0] - expected).abs() < 1e-12);
    /// // A float position's error hardly changes within seconds.
    /// let (a, b) = (at(0.0, Quality::Float, 0.2), at(5.0, Quality::Float, 0.2));
    /// assert!(errors.covariance_ecef_m2(&a, &b)[0][0] > 0.97 * 0.04);
    /// ```
    #[must_use]
    pub fn covariance_ecef_m2(&self, a: &Solution, b: &Solution) -> [[f64; 3]; 3] {
        let apart_s = a.time.seconds_since(b.time).abs();
        let of_phases = [a, b].map(|s| self.phase_share(s));
        let phases = (of_phases[0] * of_phases[1]).sqrt() * self.of_phases(apart_s);
        let rest = ((1.0 - of_phases[0]) * (1.0 - of_phases[1])).sqrt();
        let correlation = phases + rest * self.of_ambiguities(apart_s);
        let product = root(a) * root(b) * correlation;
        std::array::from_fn(|i| std::array::from_fn(|j| product[(i, j)]))
    }

    /// Share of a position's error variance due to phases.
    fn phase_share(&self, solution: &Solution) -> f64 {
        let variance_m2: f64 = (0..3).map(|k| solution.covariance_ecef_m2[k][k]).sum();
        match solution.quality {
            Quality::Fixed => 1.0,
            Quality::Float if variance_m2 > 0.0 => (self.fixed_variance_m2 / variance_m2).min(1.0),
            _ => 0.0,
        }
    }
}

/// Symmetric root of a position's covariance (m).
fn root(solution: &Solution) -> Matrix3<f64> {
    let covariance = Matrix3::from_fn(|i, j| solution.covariance_ecef_m2[i][j]);
    let mut eigen = SymmetricEigen::new(covariance);
    eigen.eigenvalues.apply(|v| *v = v.max(0.0).sqrt());
    eigen.recompose()
}
