//! The iteration to a single-point position, and the validation of the result.

use super::context::{SingleContext, SinglePoint};
use super::equations::{Equations, Row, STATES};
use crate::linear::chi_square::chi_square_999;
use crate::measurements::constellation::{SatelliteState, Unusable};
use crate::measurements::measurement::Epoch;
use crate::observations::signal::SPEED_OF_LIGHT_M_S;
use crate::solution::NotFixedReason;
use nalgebra::{SMatrix, SVector};

const LARGEST_ITERATIONS: usize = 10;
/// Least number of satellites that remain when outliers are left out of a position that fails its validation.
const LEAST_FOR_BEST_EFFORT: usize = 6;
/// Largest root mean square of the residuals of such a position (m).
const LARGEST_RMS_M: f64 = 30.0;
/// Distance (m) over which no satellite's elevation changes by more than 0.2°.
const LARGEST_STEP_M: f64 = 50e3;
/// Margin for the non-linearity of the equations, and for a last step of up to 0.1 mm: residuals of metres
/// are known to a millimetre.
const PASSING_MARGIN: f64 = 1.01;
/// Share of the redundant satellites from which on a wrong set of satellites may agree by chance: the residuals of all
/// satellites then scale the covariance.
const LARGEST_EXCLUSION: f64 = 1.0 / 3.0;
/// Largest error of a reflected signal (m): gross errors of codes left out do not increase deviations further.
const LARGEST_REFLECTION_M: f64 = 100.0;
/// Least redundancy of a satellite, as a share of its variance.
const LEAST_REDUNDANCY: f64 = 1e-6;
/// Start of an iteration.
#[derive(Clone, Copy)]
struct Start {
    position_ecef_m: [f64; 3],
    /// Whether the receiver is near this position, except for the effect of one or two faulty satellites:
    /// directions, and delays in the atmosphere, are then known. Otherwise (at worst at the Earth's centre)
    /// they are unknown before the first step.
    is_near: bool,
}

impl Start {
    /// The start for an iteration that continues from the end of this one.
    fn moved_to(self, position_ecef_m: [f64; 3]) -> Self {
        let squares = (0..3).map(|k| (position_ecef_m[k] - self.position_ecef_m[k]).powi(2));
        Self {
            position_ecef_m,
            is_near: squares.sum::<f64>().sqrt() < LARGEST_STEP_M,
        }
    }
}

struct Converged {
    x: SVector<f64, STATES>,
    covariance: SMatrix<f64, STATES, STATES>,
    equations: Equations,
}

impl Converged {
    fn position(&self) -> [f64; 3] {
        [self.x[0], self.x[1], self.x[2]]
    }

    /// Squared residuals in units of their variances.
    fn chi_square(&self) -> f64 {
        let rows = self.equations.rows.iter();
        rows.map(|r| r.residual_m * r.residual_m / r.variance_m2)
            .sum()
    }

    /// Equations beyond those that determine the states.
    fn redundancy(&self) -> usize {
        self.equations.rows.len().saturating_sub(STATES)
    }

    /// Whether the residuals exceed their variances by more than chance allows.
    fn is_contradicting(&self) -> bool {
        let redundancy = self.redundancy();
        redundancy > 0 && self.chi_square() > chi_square_999(redundancy)
    }

    /// True variances over those assumed, from the residuals; 1 without redundancy.
    fn variance_factor(&self) -> f64 {
        match self.redundancy() {
            0 => 1.0,
            redundancy => self.chi_square() / redundancy as f64,
        }
    }

    /// χ² without the equation of one satellite: reduced by v²/(σ² − hᵀQh), with the satellite's residual v
    /// at the position from all satellites and the covariance Q of that position (Cook 1977). `None` where
    /// the other satellites determine no position.
    fn chi_square_without(&self, row: usize) -> Option<f64> {
        let row = &self.equations.rows[row];
        let design = SVector::from(row.design);
        let redundancy = row.variance_m2 - design.dot(&(self.covariance * design));
        (redundancy > LEAST_REDUNDANCY * row.variance_m2)
            .then(|| self.chi_square() - row.residual_m.powi(2) / redundancy)
    }
}

impl SingleContext<'_> {
    /// The single-point position of `epoch`, starting from `start`.
    ///
    /// On failure returns the reason and the position at which the iteration ended.
    pub(crate) fn solve(
        &self,
        epoch: &Epoch,
        states: &[Result<SatelliteState, Unusable>],
        start_ecef_m: [f64; 3],
    ) -> Result<SinglePoint, (NotFixedReason, [f64; 3])> {
        let all = vec![true; epoch.measurements.len()];
        let far = Start {
            position_ecef_m: start_ecef_m,
            is_near: false,
        };
        let found = self.converge(epoch, states, far, &all);
        let (start, checked) = match &found {
            Ok(solved) => (far.moved_to(solved.position()), self.check(solved)),
            Err(failure) => (far, Err(*failure)),
        };
        let solved = match (found, checked) {
            (Ok(solved), Ok(())) => solved,
            (found, Err(failure)) if self.options.raim => {
                let mut repaired = self
                    .leave_one_out(epoch, states, start, found.as_ref().ok())
                    .or_else(|| self.best_effort(epoch, states, start))
                    .ok_or(failure)?;
                repaired.covariance *= covariance_factor(&repaired, found.as_ref().ok());
                repaired
            }
            (_, Err(failure)) | (Err(failure), _) => return Err(failure),
        };
        let position_ecef_m = solved.position();
        Ok(SinglePoint {
            position_ecef_m,
            covariance_ecef_m2: std::array::from_fn(|i| {
                std::array::from_fn(|j| solved.covariance[(i, j)])
            }),
            satellites: solved.equations.satellites,
            velocity: self.velocity(epoch, states, position_ecef_m, &solved.equations.used),
            time: epoch.tag - solved.x[3] / SPEED_OF_LIGHT_M_S,
        })
    }

    fn converge(
        &self,
        epoch: &Epoch,
        states: &[Result<SatelliteState, Unusable>],
        start: Start,
        keep: &[bool],
    ) -> Result<Converged, (NotFixedReason, [f64; 3])> {
        let mut x = SVector::<f64, STATES>::zeros();
        for k in 0..3 {
            x[k] = start.position_ecef_m[k];
        }
        let position = |x: &SVector<f64, STATES>| [x[0], x[1], x[2]];
        for iteration in 0..LARGEST_ITERATIONS {
            let equations = self.equations(epoch, states, &x, iteration > 0 || start.is_near, keep);
            if equations.rows.len() < STATES {
                let used = equations.satellites;
                let reason = NotFixedReason::TooFewSatellitesForSingle { used };
                return Err((reason, position(&x)));
            }
            let mut normal = SMatrix::<f64, STATES, STATES>::zeros();
            let mut right = SVector::<f64, STATES>::zeros();
            for row in &equations.rows {
                let h = SVector::from(row.design);
                let weight = 1.0 / row.variance_m2;
                normal.ger(weight, &h, &h, 1.0);
                right += h * (row.residual_m * weight);
            }
            let Some(covariance) = normal.try_inverse() else {
                return Err((NotFixedReason::SinglePointFailed, position(&x)));
            };
            let step = covariance * right;
            x += step;
            if !x.iter().all(|v| v.is_finite() && v.abs() < 1e12) {
                return Err((NotFixedReason::SinglePointFailed, start.position_ecef_m));
            }
            if step.norm() < 1e-4 {
                return Ok(Converged {
                    x,
                    covariance,
                    equations,
                });
            }
        }
        Err((NotFixedReason::SinglePointFailed, position(&x)))
    }

    /// Validates a position by its residuals and geometry; fails with the reason and the position.
    fn check(&self, solved: &Converged) -> Result<(), (NotFixedReason, [f64; 3])> {
        let end = solved.position();
        let rows = solved.equations.rows.len();
        if self.checks_residuals(rows) && solved.is_contradicting() {
            return Err((NotFixedReason::SinglePointFailed, end));
        }
        let gdop = gdop(&solved.equations.directions);
        if gdop.is_nan() || gdop <= 0.0 || gdop > self.options.max_gdop {
            return Err((NotFixedReason::PoorGeometry { gdop }, end));
        }
        Ok(())
    }

    /// Whether the residuals of `rows` equations must be within their variances.
    fn checks_residuals(&self, rows: usize) -> bool {
        rows > STATES && self.options.policy().tests_single_point()
    }

    /// Whether the residuals without satellite `k` would surely exceed their variances, judged by those of
    /// all satellites: the decrease of χ² by leaving one satellite out needs no new position.
    fn cannot_pass_without(&self, of_all: &Converged, k: usize) -> bool {
        let equations = &of_all.equations;
        let Some(row) = equations.used.iter().position(|&used| used == k) else {
            // The satellite has no effect on the position.
            return true;
        };
        let left = equations.rows.len() - 1;
        let limit = || PASSING_MARGIN * chi_square_999(left - STATES);
        self.checks_residuals(left)
            && of_all
                .chi_square_without(row)
                .is_some_and(|sum| sum > limit())
    }

    /// The solution with the least residuals among the solutions without one satellite.
    fn leave_one_out(
        &self,
        epoch: &Epoch,
        states: &[Result<SatelliteState, Unusable>],
        start: Start,
        of_all: Option<&Converged>,
    ) -> Option<Converged> {
        let mut keep = vec![true; epoch.measurements.len()];
        if states.iter().filter(|s| s.is_ok()).count() < 6 {
            return None;
        }
        let mut best: Option<(f64, Converged)> = None;
        for left_out in 0..keep.len() {
            if states[left_out].is_err()
                || of_all.is_some_and(|all| self.cannot_pass_without(all, left_out))
            {
                continue;
            }
            keep[left_out] = false;
            let converged = self.converge(epoch, states, start, &keep).ok();
            if let Some(solved) = converged.filter(|solved| self.check(solved).is_ok()) {
                let n = solved.equations.satellites;
                if n >= 5 {
                    let sum: f64 = solved.equations.rows[..n]
                        .iter()
                        .map(|r| r.residual_m * r.residual_m)
                        .sum();
                    let rms = (sum / n as f64).sqrt();
                    if rms < best.as_ref().map_or(100.0, |(least, _)| *least) {
                        best = Some((rms, solved));
                    }
                }
            }
            keep[left_out] = true;
        }
        best.map(|(_, solved)| solved)
    }

    /// The solution without the satellites with the largest residuals, until the remaining satellites agree or are
    /// too few.
    fn best_effort(
        &self,
        epoch: &Epoch,
        states: &[Result<SatelliteState, Unusable>],
        start: Start,
    ) -> Option<Converged> {
        let mut keep = vec![true; epoch.measurements.len()];
        loop {
            let solved = self.converge(epoch, states, start, &keep).ok()?;
            let n = solved.equations.satellites;
            let rows = &solved.equations.rows[..n];
            if n > LEAST_FOR_BEST_EFFORT && solved.is_contradicting() {
                let square = |r: &Row| r.residual_m * r.residual_m / r.variance_m2;
                let worst =
                    (0..n).max_by(|a, b| square(&rows[*a]).total_cmp(&square(&rows[*b])))?;
                keep[solved.equations.used[worst]] = false;
                continue;
            }
            let rms_m = (rows.iter().map(|r| r.residual_m.powi(2)).sum::<f64>() / n as f64).sqrt();
            let gdop = gdop(&solved.equations.directions);
            if rms_m > LARGEST_RMS_M || gdop.is_nan() || gdop > self.options.max_gdop {
                return None;
            }
            return Some(solved);
        }
    }
}

/// Factor on the covariance of a position without some satellites: the variance factor of all satellites, of which those
/// left out count with the limit of their residuals, or with the residuals themselves where too many were left out.
fn covariance_factor(repaired: &Converged, of_all: Option<&Converged>) -> f64 {
    let Some(of_all) = of_all else {
        return 1.0;
    };
    let satellites = [of_all, repaired].map(|c| c.equations.satellites);
    let left_out = satellites[0].saturating_sub(satellites[1]) as f64;
    let redundancy = of_all.redundancy() as f64;
    let limited = repaired.chi_square() + left_out * chi_square_999(1);
    let mut factor = repaired
        .variance_factor()
        .max(limited / redundancy.max(1.0));
    if left_out >= LARGEST_EXCLUSION * redundancy {
        let rows = &repaired.equations.rows[..repaired.equations.satellites];
        let sum_m2: f64 = rows.iter().map(|row| row.variance_m2).sum();
        let most = LARGEST_REFLECTION_M.powi(2) * rows.len() as f64 / sum_m2;
        factor = factor.max(of_all.variance_factor().min(most));
    }
    factor.max(1.0)
}

/// Geometric dilution of precision with one clock; infinite when singular.
fn gdop(directions: &[(f64, f64)]) -> f64 {
    let mut normal = SMatrix::<f64, 4, 4>::zeros();
    for &(azimuth, elevation) in directions {
        let (sin_az, cos_az) = azimuth.sin_cos();
        let (sin_el, cos_el) = elevation.sin_cos();
        let h = SVector::from([cos_el * sin_az, cos_el * cos_az, sin_el, 1.0]);
        normal += h * h.transpose();
    }
    if directions.len() < 4 {
        return f64::INFINITY;
    }
    normal
        .try_inverse()
        .map_or(f64::INFINITY, |q| q.trace().sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The least-squares solution of linear equations.
    fn solved(rows: Vec<Row>) -> Converged {
        let mut normal = SMatrix::<f64, STATES, STATES>::zeros();
        let mut right = SVector::<f64, STATES>::zeros();
        for row in &rows {
            let h = SVector::from(row.design);
            normal += h * h.transpose() / row.variance_m2;
            right += h * (row.residual_m / row.variance_m2);
        }
        let covariance = normal.try_inverse().unwrap();
        let x = covariance * right;
        let left = rows.into_iter().map(|row| Row {
            residual_m: row.residual_m - SVector::from(row.design).dot(&x),
            ..row
        });
        Converged {
            x,
            covariance,
            equations: Equations {
                rows: left.collect(),
                satellites: 0,
                directions: Vec::new(),
                used: Vec::new(),
            },
        }
    }

    /// Twelve equations, of which the last alone sees the last clock.
    fn rows() -> Vec<Row> {
        let of = |k: usize| Row {
            residual_m: ((7 * k) % 5) as f64 - 1.7,
            variance_m2: 1.0 + (k % 3) as f64,
            design: std::array::from_fn(|a| match a {
                7 => f64::from(u8::from(k == 11)),
                _ => (((3 * k + 5 * a * a + k * a) % 13) as f64 - 6.0) / 6.0,
            }),
        };
        (0..12).map(of).collect()
    }

    #[test]
    fn chi_square_without_a_satellite_is_that_of_the_position_by_the_others() {
        let all = solved(rows());
        for k in 0..11 {
            let mut rest = rows();
            rest.remove(k);
            let expected = solved(rest).chi_square();
            let found = all.chi_square_without(k).unwrap();
            assert!((found - expected).abs() < 1e-9, "{k}: {found} {expected}");
            assert!(found < all.chi_square());
        }
        assert_eq!(all.chi_square_without(11), None);
    }
}
