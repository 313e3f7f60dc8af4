//! Truncated SVD and Tikhonov, by filtering the singular values that a bidiagonalisation finds.
//!
//! The filter is applied to B_k started at the data: f(L L⁺) d converges long before every singular value
//! does, as only the part excited by the data counts. Once the Krylov space is exhausted the result is that
//! of the dense decomposition.

use crate::bidiagonal::{Bidiagonalization, bidiagonalization_bytes};
use crate::error::{InvertError, check_range};
use crate::history::{History, Iteration, Stop};
use crate::operator::LinearOperator;
use crate::parameter::{ParameterChoice, by_discrepancy, by_l_curve};
use crate::projected::{Filter, Projected, SmallSolution};
use acerra_imaging::{Complex64, Control, Progress};

/// Singular values that enter the solution.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Regularization {
    /// Those above a threshold, unchanged: truncated SVD.
    Truncation {
        /// The threshold, dB (20 log₁₀) below the greatest singular value; negative.
        threshold_db: f64,
    },
    /// All, damped by this μ, relative to the greatest singular value.
    Tikhonov {
        /// μ over the greatest singular value.
        relative_mu: f64,
    },
    /// Damped so that the residual equals the noise; by the L-curve where the noise is unknown or no
    /// solution reaches it.
    Automatic {
        /// ‖noise‖ in the data.
        noise_norm: Option<f64>,
    },
}

/// Requirements on a spectral solution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpectralOptions {
    /// Singular values that enter.
    pub regularization: Regularization,
    /// Most steps.
    pub max_iterations: usize,
    /// Relative change of the solution between evaluations below which it has converged.
    pub tolerance: f64,
    /// Most bytes that basis and scenes may take.
    pub memory_limit_bytes: u128,
}

impl Default for SpectralOptions {
    fn default() -> Self {
        Self {
            regularization: Regularization::Automatic { noise_norm: None },
            max_iterations: 200,
            tolerance: 1e-2,
            memory_limit_bytes: 8 << 30,
        }
    }
}

/// A scene and how it was found.
#[derive(Debug, Clone)]
pub struct SpectralSolution {
    /// The scene.
    pub scene: Vec<Complex64>,
    /// The greatest singular value found.
    pub greatest_singular: f64,
    /// The threshold of a truncation, or μ, over the greatest singular value.
    pub relative_parameter: f64,
    /// Method of the choice.
    pub choice: ParameterChoice,
    /// Effective number of parameters: Σ f(s) over the singular values found.
    pub parameters: f64,
    /// The iterations.
    pub history: History,
    /// Bytes taken, excluding the data.
    pub memory_bytes: u128,
}

/// Evaluations of the solution are at least this many steps apart, and a twelfth of the steps so far.
const LOOK_EVERY: usize = 4;
/// Looks in a row that must agree.
const AGREEING_LOOKS: usize = 2;

/// Solves min ‖Lσ − d‖ with filtered singular values.
///
/// # Errors
/// Parameters without a meaning, more memory than allowed, errors of the operator, cancellation.
///
/// ```
/// use acerra_imaging::{Complex64, Control, PulseArrays, Pulses};
/// use acerra_invert::{Flight, PointOperator, Regularization, SpectralOptions, solve_spectral};
/// let position_m: Vec<[f64; 3]> = (0..21).map(|m| [0.1 * f64::from(m) - 1.0, 0.0, 3.0]).collect();
/// let frequency_hz: Vec<f64> = (0..18).map(|n| 3.1e9 + 1e8 * f64::from(n)).collect();
/// let pulses = Pulses::new(PulseArrays {
///     position_m: &position_m,
///     frequency_hz: &frequency_hz,
///     spectrum: &[Complex64::ZERO; 21 * 18],
///     weight: &[1.0; 21],
///     light_speed_m_s: 3e8,
/// })?;
/// let flight = Flight::of(&pulses)?;
/// let mut data = vec![Complex64::ZERO; flight.samples()];
/// flight.add_echo([0.02, 1.0, 0.0], Complex64::ONE, &mut data);
/// let points: Vec<[f64; 3]> = (0..9).map(|k| [0.0, 0.6 + 0.1 * f64::from(k), 0.0]).collect();
/// let options = SpectralOptions {
///     regularization: Regularization::Truncation { threshold_db: -20.0 },
///     ..SpectralOptions::default()
/// };
/// let operator = PointOperator::new(&flight, &points);
/// let found = solve_spectral(&operator, &data, &options, Control::default())?;
/// assert!(found.scene[4].norm() > 2.0 * found.scene[0].norm());
/// # Ok::<(), acerra_invert::InvertError>(())
/// ```
pub fn solve_spectral<L: LinearOperator + ?Sized>(
    operator: &L,
    data: &[Complex64],
    options: &SpectralOptions,
    control: Control,
) -> Result<SpectralSolution, InvertError> {
    check(options)?;
    let steps = options.max_iterations.min(operator.samples());
    let memory_bytes = bidiagonalization_bytes(operator, steps);
    if memory_bytes > options.memory_limit_bytes {
        return Err(InvertError::TooLarge {
            what: "the basis of an inversion and its scenes",
            bytes: memory_bytes,
            limit_bytes: options.memory_limit_bytes,
        });
    }
    let silent = control.silent();
    let mut process = Bidiagonalization::start(operator, data, silent)?;
    let mut looks = Looks::default();
    let (last, stop) = loop {
        let goes_on = process.step(silent)?;
        let step = process.order();
        control.report(Progress {
            done: step as u64,
            total: steps as u64 + 1,
        });
        let is_last = !goes_on || step >= steps;
        if !is_last && step < looks.next {
            continue;
        }
        let chosen = choose(&process, options.regularization)?;
        let stop = looks.look(
            step,
            &chosen.solution,
            process.data_norm(),
            options.tolerance,
        );
        if !goes_on {
            break (chosen, Stop::Exhausted);
        }
        if stop {
            break (chosen, Stop::Converged);
        }
        if is_last {
            break (chosen, Stop::Iterations);
        }
    };
    let scene = process.scene_of(&last.solution.left, silent)?;
    Ok(SpectralSolution {
        scene,
        greatest_singular: last.greatest,
        relative_parameter: last.relative,
        choice: last.choice,
        parameters: last.solution.parameters,
        history: History {
            iterations: looks.iterations,
            stop,
        },
        memory_bytes,
    })
}

fn check(options: &SpectralOptions) -> Result<(), InvertError> {
    match options.regularization {
        Regularization::Truncation { threshold_db } => {
            check_range("threshold_db", "below 0", threshold_db, threshold_db < 0.0)?;
        }
        Regularization::Tikhonov { relative_mu } => {
            check_range("relative_mu", "above 0", relative_mu, relative_mu > 0.0)?;
        }
        Regularization::Automatic {
            noise_norm: Some(noise_norm),
        } => check_range("noise_norm", "above 0", noise_norm, noise_norm > 0.0)?,
        Regularization::Automatic { noise_norm: None } => {}
    }
    check_range(
        "tolerance",
        "above 0",
        options.tolerance,
        options.tolerance > 0.0,
    )?;
    let steps = options.max_iterations as f64;
    check_range("max_iterations", "at least 1", steps, steps >= 1.0)
}

/// A solution of the small problem with its parameter.
struct Chosen {
    solution: SmallSolution,
    greatest: f64,
    relative: f64,
    choice: ParameterChoice,
}

fn choose<L: LinearOperator + ?Sized>(
    process: &Bidiagonalization<'_, L>,
    regularization: Regularization,
) -> Result<Chosen, InvertError> {
    let projected = Projected::new(process.alpha(), process.beta(), process.data_norm())?;
    let greatest = projected.greatest();
    let (filter, relative, choice) = match regularization {
        Regularization::Truncation { threshold_db } => {
            let relative = 10f64.powf(threshold_db / 20.0);
            let least = relative * greatest;
            (
                Filter::Truncated { least },
                relative,
                ParameterChoice::Given,
            )
        }
        Regularization::Tikhonov { relative_mu } => {
            let mu = relative_mu * greatest;
            (Filter::Tikhonov { mu }, relative_mu, ParameterChoice::Given)
        }
        Regularization::Automatic { noise_norm } => {
            let by_noise = noise_norm.and_then(|norm| by_discrepancy(&projected, norm));
            let (mu, choice) = match by_noise {
                Some(mu) => (mu, ParameterChoice::Discrepancy),
                None => (by_l_curve(&projected), ParameterChoice::LCurve),
            };
            (Filter::Tikhonov { mu }, mu / greatest, choice)
        }
    };
    Ok(Chosen {
        solution: projected.solve(filter),
        greatest,
        relative,
        choice,
    })
}

/// The solutions evaluated on the way.
#[derive(Default)]
struct Looks {
    iterations: Vec<Iteration>,
    before: Vec<f64>,
    agreeing: usize,
    next: usize,
}

impl Looks {
    /// Records a solution; whether it agrees with those before.
    fn look(
        &mut self,
        step: usize,
        solution: &SmallSolution,
        data_norm: f64,
        tolerance: f64,
    ) -> bool {
        // Right vectors are orthonormal: norms of coefficients are norms of scenes.
        let difference: f64 = solution
            .right
            .iter()
            .enumerate()
            .map(|(k, c)| (c - self.before.get(k).unwrap_or(&0.0)).powi(2))
            .sum();
        let change = (difference / solution.power.max(f64::MIN_POSITIVE)).sqrt();
        self.iterations.push(Iteration {
            number: step,
            residual: solution.residual_power.sqrt() / data_norm,
            change,
        });
        self.before.clone_from(&solution.right);
        self.agreeing = if change <= tolerance {
            self.agreeing + 1
        } else {
            0
        };
        self.next = step + LOOK_EVERY.max(step / 12);
        self.agreeing >= AGREEING_LOOKS
    }
}
