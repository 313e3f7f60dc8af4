//! One solver on one set of data.

use acerra_imaging::{Complex64, Control as ImagingControl, Progress};
use acerra_invert::{
    CleanInput, CleanOptions, History, InvertError, LinearOperator, Regularization, SceneOperator,
    SparseOptions, SpectralOptions, TrackData, Weighted, clean, greatest_lambda, restore,
    solve_sparse, solve_spectral, sparse_bytes,
};

use super::options::{InversionOptions, Method};
use super::record::{Chosen, ParameterRecord};

/// Inputs of a solver in addition to the data.
pub(super) struct Setting<'a> {
    pub operator: &'a SceneOperator<'a>,
    /// Weights that normalise the columns.
    pub weight: &'a [f32],
    pub options: InversionOptions,
    /// ‖noise‖ in the data.
    pub noise_norm: Option<f64>,
    /// Correlation with noise that no pixel of the image exceeds.
    pub noise_peak: Option<f64>,
    pub memory_limit_bytes: u128,
}

/// The reflectivities of a scene, and the record of the solver.
pub(super) struct Solved {
    pub scene: Vec<Complex64>,
    pub parameter: ParameterRecord,
    /// Absolute value of λ or of the threshold of CLEAN, for use on other data.
    pub absolute: Option<f64>,
    pub parameters: f64,
    pub history: History,
    pub memory_bytes: u128,
}

/// Relative change of the solution that ends the iterations. Singular values near a sharp threshold enter and
/// leave until they have converged, so that a truncation settles to a few per cent only.
const TRUNCATED_TOLERANCE: f64 = 5e-2;
const DAMPED_TOLERANCE: f64 = 1e-2;
/// Duality gap of a sparse scene.
const SPARSE_TOLERANCE: f64 = 1e-3;
/// Least λ and least threshold of CLEAN relative to the strongest value: errors of positions and model exceed
/// −30 dB.
const LEAST_SHARE: f64 = 0.03;
const MAX_COMPONENTS: usize = 20_000;

/// Solves for the scene of `data`; `absolute` is the absolute value of λ or of the threshold of CLEAN.
pub(super) fn solve(
    setting: &Setting<'_>,
    data: &[Complex64],
    absolute: Option<f64>,
    control: ImagingControl<'_>,
) -> Result<Solved, InvertError> {
    let even = Weighted::new(setting.operator, setting.weight)?;
    match setting.options.method {
        Method::Adjoint | Method::Tsvd | Method::Cgls => spectral(setting, &even, data, control),
        Method::Sparse => {
            let track = [TrackData {
                operator: &even,
                data,
            }];
            let (mut solved, mut scenes) = sparse(setting, &track, absolute, control)?;
            solved.scene = scenes.pop().unwrap_or_default();
            even.scene_from(&mut solved.scene);
            Ok(solved)
        }
        Method::Clean => clean_points(setting, &even, data, absolute, control),
    }
}

fn spectral(
    setting: &Setting<'_>,
    even: &Weighted<'_, SceneOperator<'_>>,
    data: &[Complex64],
    control: ImagingControl<'_>,
) -> Result<Solved, InvertError> {
    let parameters = &setting.options.parameters;
    let is_truncated = setting.options.method == Method::Tsvd;
    let regularization = match (is_truncated, parameters.damping) {
        (true, _) => Regularization::Truncation {
            threshold_db: parameters.threshold_db,
        },
        (false, Some(relative_mu)) => Regularization::Tikhonov { relative_mu },
        (false, None) => Regularization::Automatic {
            noise_norm: setting.noise_norm,
        },
    };
    let options = SpectralOptions {
        regularization,
        max_iterations: setting.options.max_iterations(),
        tolerance: if is_truncated {
            TRUNCATED_TOLERANCE
        } else {
            DAMPED_TOLERANCE
        },
        memory_limit_bytes: setting.memory_limit_bytes,
    };
    let mut found = solve_spectral(even, data, &options, control)?;
    even.scene_from(&mut found.scene);
    let parameter = if is_truncated {
        ParameterRecord {
            name: "threshold of singular values below the greatest, dB",
            value: parameters.threshold_db,
            choice: Chosen::Given,
        }
    } else {
        ParameterRecord {
            name: "damping over the greatest singular value",
            value: found.relative_parameter,
            choice: found.choice.into(),
        }
    };
    Ok(Solved {
        scene: found.scene,
        parameter,
        absolute: (!is_truncated).then_some(found.relative_parameter),
        parameters: found.parameters,
        history: found.history,
        memory_bytes: found.memory_bytes,
    })
}

/// The sparse scenes of one or more tracks, in normalised columns.
pub(super) fn sparse(
    setting: &Setting<'_>,
    tracks: &[TrackData<'_>],
    absolute: Option<f64>,
    control: ImagingControl<'_>,
) -> Result<(Solved, Vec<Vec<Complex64>>), InvertError> {
    let memory_bytes = sparse_bytes(tracks);
    if memory_bytes > setting.memory_limit_bytes {
        return Err(InvertError::TooLarge {
            what: "the scenes of a sparse inversion",
            bytes: memory_bytes,
            limit_bytes: setting.memory_limit_bytes,
        });
    }
    let greatest = greatest_lambda(tracks, control.silent())?;
    let (lambda, choice) = match (absolute, setting.options.parameters.sparsity) {
        (Some(lambda), _) => (lambda, Chosen::Given),
        (None, Some(share)) => (share * greatest, Chosen::Given),
        (None, None) => above_noise(setting.noise_peak, greatest),
    };
    let options = SparseOptions {
        lambda,
        max_iterations: setting.options.max_iterations(),
        tolerance: SPARSE_TOLERANCE,
    };
    let found = solve_sparse(tracks, &options, control)?;
    let solved = Solved {
        scene: Vec::new(),
        parameter: ParameterRecord {
            name: "sparsity over the smallest whose scene is empty",
            value: lambda / greatest,
            choice,
        },
        absolute: Some(lambda),
        parameters: found.support as f64,
        history: found.history,
        memory_bytes,
    };
    Ok((solved, found.scenes))
}

fn clean_points(
    setting: &Setting<'_>,
    even: &Weighted<'_, SceneOperator<'_>>,
    data: &[Complex64],
    absolute: Option<f64>,
    control: ImagingControl<'_>,
) -> Result<Solved, InvertError> {
    let operator = setting.operator;
    let Some(grid) = operator.grids().first() else {
        return Err(InvertError::NoSignal { what: "no pixels" });
    };
    let track = [TrackData {
        operator: even,
        data,
    }];
    let greatest = greatest_lambda(&track, control.silent())?;
    let (threshold, choice) = match (absolute, setting.options.parameters.clean_threshold_db) {
        (Some(threshold), _) => (threshold, Chosen::Given),
        (None, Some(db)) => (greatest * 10f64.powf(db / 20.0), Chosen::Given),
        (None, None) => above_noise(setting.noise_peak, greatest),
    };
    let input = CleanInput {
        flight: operator.flight(),
        operator: even,
        weight: setting.weight,
        grid: *grid,
        data,
    };
    let options = CleanOptions {
        gain: setting.options.parameters.clean_gain,
        threshold,
        max_cycles: setting.options.max_iterations(),
        max_components: MAX_COMPONENTS,
    };
    let found = clean(&input, &options, control)?;
    Ok(Solved {
        scene: restore(&found, operator.flight(), grid),
        parameter: ParameterRecord {
            name: "threshold of points below the strongest, dB",
            value: 20.0 * (threshold / greatest).log10(),
            choice,
        },
        absolute: Some(threshold),
        parameters: found.components.len() as f64,
        history: found.history,
        memory_bytes: 3 * 16 * operator.pixels() as u128 + operator.working_bytes(),
    })
}

/// The level that noise does not exceed at any pixel, but at least [`LEAST_SHARE`] of the strongest.
fn above_noise(noise_peak: Option<f64>, greatest: f64) -> (f64, Chosen) {
    let floor = LEAST_SHARE * greatest;
    match noise_peak {
        Some(peak) if peak > floor => (peak.min(0.9 * greatest), Chosen::Noise),
        _ => (floor, Chosen::Floor),
    }
}

/// Progress of a solver as progress of a step.
pub(super) fn steps<'a>(control: &'a crate::control::Control<'_>) -> impl Fn(Progress) + Sync + 'a {
    |progress| control.at(progress.done)
}
