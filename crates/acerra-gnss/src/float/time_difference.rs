//! Detection of unflagged slips by comparing the changes of phases from one epoch to the next.
//!
//! From one epoch to the next, the phase differences between rover and base change only by the rover's motion
//! and by one clock common to all signals. With four unknowns, most satellites check each other (as
//! time-differenced phases do in receivers' own monitoring; e.g. Soon et al. 2008, "An approach to aid INS
//! using time-differenced GPS carrier phase").

use crate::linear::outliers::median;
use nalgebra::{Matrix4, Vector4};

/// Iterations of the robust fit.
const ITERATIONS: usize = 20;
/// 1.4826 median absolute deviations of normal errors are a standard deviation.
const SIGMA_PER_MAD: f64 = 1.482_6;
/// Fewest changes, in addition to the unknowns, for a test.
const LEAST_FREEDOM: usize = 3;

/// The change of one satellite's phase difference between two epochs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PhaseChange {
    /// Change less the change predicted by geometry and satellite clocks for a rover at rest (m).
    pub change_m: f64,
    pub unit_ecef: [f64; 3],
    /// Standard deviation (m).
    pub sigma_m: f64,
    /// Whether the fit may use it.
    pub trusted: bool,
}

/// A robust fit to the changes.
pub(crate) struct Fit {
    /// Residual of each change (m).
    pub residuals_m: Vec<f64>,
    /// Robust scale of the residuals in units of their standard deviations, at least one.
    pub scale: f64,
}

/// Fits a motion and a clock to the trusted changes; `None` where these are too few.
pub(crate) fn robust_fit(changes: &[PhaseChange]) -> Option<Fit> {
    let trusted = changes.iter().filter(|c| c.trusted).count();
    if trusted < 4 + LEAST_FREEDOM {
        return None;
    }
    let design = |c: &PhaseChange| {
        let u = c.unit_ecef;
        Vector4::new(-u[0], -u[1], -u[2], 1.0)
    };
    let mut weights: Vec<f64> = changes.iter().map(|c| f64::from(c.trusted)).collect();
    let mut fit = Fit {
        residuals_m: Vec::new(),
        scale: 1.0,
    };
    for _ in 0..ITERATIONS {
        let mut normal = Matrix4::zeros();
        let mut right = Vector4::zeros();
        for (c, weight) in changes.iter().zip(&weights) {
            let (h, weight) = (design(c), weight / (c.sigma_m * c.sigma_m));
            normal += h * h.transpose() * weight;
            right += h * (c.change_m * weight);
        }
        let x = normal.cholesky()?.solve(&right);
        fit.residuals_m = changes
            .iter()
            .map(|c| c.change_m - design(c).dot(&x))
            .collect();
        let sizes = || {
            let both = changes.iter().zip(&fit.residuals_m);
            both.map(|(c, r)| r.abs() / c.sigma_m)
        };
        let of_trusted = sizes().zip(changes).filter(|(_, c)| c.trusted);
        fit.scale = (SIGMA_PER_MAD * median(of_trusted.map(|(s, _)| s).collect())).max(1.0);
        // Least absolute values beyond the scale: nearly half the changes may be wrong.
        let next: Vec<f64> = sizes()
            .zip(changes)
            .map(|(size, c)| f64::from(c.trusted) * (fit.scale / size).min(1.0))
            .collect();
        // Equal weights give an equal fit.
        if next == weights {
            break;
        }
        weights = next;
    }
    Some(fit)
}
