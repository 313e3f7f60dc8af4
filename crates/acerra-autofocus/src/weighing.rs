//! Weights of observations by the residuals of a solution.

use nalgebra::DVector;

use crate::observe::{Kind, Rows};
use crate::smoother::Smoothed;

/// Degrees of freedom of the residuals' Student distribution.
const STUDENT_FREEDOM: f64 = 5.0;
/// Median of the square of a standard normal variable.
const MEDIAN_SQUARE: f64 = 0.4549;
/// Lags over which neighbouring residuals may be correlated, as a share of the flight.
const CORRELATED_SHARE: f64 = 0.1;

impl Rows {
    /// Weights rows by their residuals: a scale for each point, and Student weights relative to that scale.
    pub fn weigh(&mut self, found: &Smoothed) {
        let squares: Vec<f64> = self
            .rows
            .iter()
            .enumerate()
            .map(|(index, row)| self.residual_m(index, found).powi(2) / row.variance_m2)
            .collect();
        let mut of_point = vec![[Vec::new(), Vec::new()]; self.points];
        for (row, square) in self.rows.iter().zip(&squares) {
            of_point[row.point][usize::from(row.kind == Kind::Delay)].push(*square);
        }
        for (scale, groups) in self.scale.iter_mut().zip(&mut of_point) {
            for (scale, group) in scale.iter_mut().zip(groups) {
                group.sort_by(f64::total_cmp);
                let median = group.get(group.len() / 2).copied().unwrap_or(0.0);
                *scale = (median / MEDIAN_SQUARE).max(1.0);
            }
        }
        let scale = &self.scale;
        for (row, square) in self.rows.iter_mut().zip(&squares) {
            let q = square / scale[row.point][usize::from(row.kind == Kind::Delay)];
            row.weight = ((STUDENT_FREEDOM + 1.0) / (STUDENT_FREEDOM + q)).min(1.0);
        }
    }

    /// Increases each point's variances by the correlation of its residuals from pulse to pulse: correlated
    /// errors average out more slowly.
    pub fn widen_by_correlation(&mut self, found: &Smoothed) {
        let lags = ((CORRELATED_SHARE * self.pulses as f64) as usize).max(1);
        for kind in [Kind::Phase, Kind::Delay] {
            for point in 0..self.points {
                let mut residual = vec![0.0; self.pulses];
                for (index, row) in self.rows.iter().enumerate() {
                    if row.point == point && row.kind == kind {
                        let scaled = self.residual_m(index, found) / row.variance_m2.sqrt();
                        residual[row.pulse] = scaled * row.weight.sqrt();
                    }
                }
                let factor = correlation_factor(&residual, lags);
                self.scale[point][usize::from(kind == Kind::Delay)] *= factor;
            }
        }
    }
}

/// 1 + 2 Σ ρ(lag) as long as ρ stays positive, at least 1.
fn correlation_factor(residual: &[f64], lags: usize) -> f64 {
    let vector = DVector::from_column_slice(residual);
    let power = vector.norm_squared();
    if power == 0.0 {
        return 1.0;
    }
    let mut factor = 1.0;
    for lag in 1..=lags.min(residual.len() - 1) {
        let pairs = residual.iter().zip(&residual[lag..]);
        let rho = pairs.map(|(a, b)| a * b).sum::<f64>() / power;
        if rho < 2.0 / (residual.len() as f64).sqrt() {
            break;
        }
        factor += 2.0 * rho;
    }
    factor
}
