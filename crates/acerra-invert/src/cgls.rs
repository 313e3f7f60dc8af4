//! Conjugate gradients for least squares, with Tikhonov's term (Hestenes & Stiefel 1952; Björck 1996,
//! CGLS). Two scenes and two data vectors are all it keeps.

use crate::error::{InvertError, check_length, check_range};
use crate::history::{History, Iteration, Stop};
use crate::operator::LinearOperator;
use crate::vector::{add_scaled, norm, power, scale_and_add};
use acerra_imaging::{Complex64, Control, Progress};

/// Requirements on a least-squares solution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CglsOptions {
    /// μ of min ‖Lσ − d‖² + μ²‖σ‖²; 0 for none, when stopping early regularises.
    pub mu: f64,
    /// Most iterations.
    pub max_iterations: usize,
    /// ‖L⁺r − μ²σ‖ relative to ‖L⁺d‖ below which the solution has converged.
    pub tolerance: f64,
    /// ‖d − Lσ‖ at which it stops, the norm of the noise; 0 to go on.
    pub noise_norm: f64,
}

impl Default for CglsOptions {
    fn default() -> Self {
        Self {
            mu: 0.0,
            max_iterations: 100,
            tolerance: 1e-6,
            noise_norm: 0.0,
        }
    }
}

/// A scene and the iterations of its computation.
#[derive(Debug, Clone)]
pub struct CglsSolution {
    /// The scene.
    pub scene: Vec<Complex64>,
    /// The iterations.
    pub history: History,
}

/// Solves min ‖Lσ − d‖² + μ²‖σ‖² from σ = 0.
///
/// # Errors
/// Invalid parameters, data that are zero, errors of the operator, cancellation.
pub fn cgls<L: LinearOperator + ?Sized>(
    operator: &L,
    data: &[Complex64],
    options: &CglsOptions,
    control: Control,
) -> Result<CglsSolution, InvertError> {
    check_length("data", operator.samples(), data.len())?;
    check_range("mu", "at least 0", options.mu, options.mu >= 0.0)?;
    let silent = control.silent();
    let mu2 = options.mu * options.mu;
    let data_norm = norm(data);
    let mut residual = data.to_vec();
    let mut scene = vec![Complex64::ZERO; operator.pixels()];
    let mut gradient = vec![Complex64::ZERO; operator.pixels()];
    operator.adjoint(&residual, &mut gradient, silent)?;
    let mut direction = gradient.clone();
    let mut modelled = vec![Complex64::ZERO; operator.samples()];
    let first = power(&gradient);
    if !(first > 0.0 && first.is_finite()) {
        return Err(InvertError::NoSignal { what: "the image" });
    }
    let mut gamma = first;
    let mut iterations = Vec::new();
    let mut stop = Stop::Iterations;
    for number in 1..=options.max_iterations {
        operator.forward(&direction, &mut modelled, silent)?;
        let curvature = power(&modelled) + mu2 * power(&direction);
        if curvature <= 0.0 {
            stop = Stop::Exhausted;
            break;
        }
        let step = Complex64::new(gamma / curvature, 0.0);
        add_scaled(&mut scene, step, &direction);
        add_scaled(&mut residual, -step, &modelled);
        operator.adjoint(&residual, &mut gradient, silent)?;
        add_scaled(&mut gradient, Complex64::new(-mu2, 0.0), &scene);
        let next = power(&gradient);
        let residual_norm = norm(&residual);
        iterations.push(Iteration {
            number,
            residual: residual_norm / data_norm,
            change: (next / first).sqrt(),
        });
        control.report(Progress {
            done: number as u64,
            total: options.max_iterations as u64,
        });
        if residual_norm <= options.noise_norm {
            stop = Stop::Noise;
            break;
        }
        if next <= options.tolerance.powi(2) * first {
            stop = Stop::Converged;
            break;
        }
        scale_and_add(&mut direction, next / gamma, &gradient);
        gamma = next;
    }
    Ok(CglsSolution {
        scene,
        history: History { iterations, stop },
    })
}
