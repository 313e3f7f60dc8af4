//! The parameter μ of Tikhonov, chosen from the data.

use crate::projected::{Filter, Projected};
use serde::Serialize;

/// Method by which a regularisation parameter was chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum ParameterChoice {
    /// Stated by the caller.
    Given,
    /// The residual equals the noise (Morozov's discrepancy principle).
    Discrepancy,
    /// The corner of the L-curve, of the logarithms of residual and solution (Hansen 1992).
    LCurve,
}

/// Points of an L-curve.
const POINTS: usize = 160;

/// The μ at which ‖d − Lσ‖ = `noise_norm`; `None` where no μ reaches it: the residual of every solution is
/// larger, or even a zero solution's is smaller.
#[must_use]
pub fn by_discrepancy(projected: &Projected, noise_norm: f64) -> Option<f64> {
    let wanted = noise_norm * noise_norm;
    let residual = |mu: f64| projected.residual_power(Filter::Tikhonov { mu });
    let greatest = projected.greatest();
    let (mut low, mut high) = ((1e-7 * greatest).ln(), (1e4 * greatest).ln());
    if residual(low.exp()) > wanted || residual(high.exp()) < wanted {
        return None;
    }
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if residual(middle.exp()) > wanted {
            high = middle;
        } else {
            low = middle;
        }
    }
    Some((0.5 * (low + high)).exp())
}

/// The μ of greatest curvature of (ln ‖d − Lσ‖, ln ‖σ‖), between the least and the greatest singular
/// value found so far.
#[must_use]
pub fn by_l_curve(projected: &Projected) -> f64 {
    let greatest = projected.greatest();
    let least = projected.least().max(1e-7 * greatest);
    let step = (greatest / least).ln() / (POINTS - 1) as f64;
    let mu = |k: usize| least * (step * k as f64).exp();
    let curve: Vec<[f64; 2]> = (0..POINTS).map(|k| on_l_curve(projected, mu(k))).collect();
    let mut best = (greatest, f64::NEG_INFINITY);
    for (k, around) in curve.windows(3).enumerate() {
        if let Some(curvature) = curvature(around, step)
            && curvature > best.1
        {
            best = (mu(k + 1), curvature);
        }
    }
    best.0
}

/// (ln ‖d − Lσ‖, ln ‖σ‖) at μ.
fn on_l_curve(projected: &Projected, mu: f64) -> [f64; 2] {
    let solution = projected.solve(Filter::Tikhonov { mu });
    [solution.residual_power, solution.power].map(|p| 0.5 * p.max(f64::MIN_POSITIVE).ln())
}

/// Curvature at the middle of three points `step` apart in ln μ, positive at a corner; `None` where the curve
/// is stationary.
fn curvature(around: &[[f64; 2]], step: f64) -> Option<f64> {
    let [before, here, after] = around else {
        return None;
    };
    let first = [0, 1].map(|i| (after[i] - before[i]) / (2.0 * step));
    let second = [0, 1].map(|i| (after[i] - 2.0 * here[i] + before[i]) / (step * step));
    let speed = first[0].hypot(first[1]);
    (speed > 1e-3).then(|| (first[0] * second[1] - second[0] * first[1]) / speed.powi(3))
}
