//! Solvers against dense solutions on small problems, in double precision.

#![allow(clippy::unwrap_used)]

mod common;

use acerra_imaging::{Complex64, Control, ImagingError};
use acerra_invert::{
    CglsOptions, Flight, InvertError, LinearOperator, ParameterChoice, PointOperator,
    Regularization, SparseOptions, SpectralOptions, Stop, TrackData, Weighted, cgls,
    greatest_lambda, solve_sparse, solve_spectral,
};
use common::{Random, Survey, dense, echoes, inner, lattice, norm, relative};
use nalgebra::{DMatrix, DVector};
use std::sync::atomic::AtomicBool;

/// Data of off-grid points along positions a millimetre off, with noise.
fn problem() -> (Survey, Vec<[f64; 3]>, Vec<Complex64>) {
    let survey = Survey::new(23, 19);
    let points = lattice(8, 6, [0.07, 0.2]);
    let scene = [
        ([0.013, 1.27, 0.01], Complex64::new(1.0, 0.3)),
        ([-0.171, 1.66, -0.01], Complex64::new(-0.4, 0.5)),
    ];
    let data = echoes(&survey, &scene, 2e-3);
    (survey, points, data)
}

fn exact(flight: &Flight) -> SpectralOptions {
    let _ = flight;
    SpectralOptions {
        max_iterations: 400,
        tolerance: 1e-12,
        ..SpectralOptions::default()
    }
}

/// Σ f(s)/s ⟨u, d⟩ v by a dense decomposition.
fn filtered(
    matrix: &DMatrix<Complex64>,
    data: &[Complex64],
    filter: impl Fn(f64, f64) -> f64,
) -> Vec<Complex64> {
    let svd = matrix.clone().svd(true, true);
    let (u, v) = (svd.u.unwrap(), svd.v_t.unwrap());
    let greatest = svd.singular_values.max();
    let mut scene = vec![Complex64::ZERO; matrix.ncols()];
    for (k, s) in svd.singular_values.iter().enumerate() {
        let part: Complex64 = (0..data.len()).map(|i| u[(i, k)].conj() * data[i]).sum();
        let factor = filter(*s, greatest);
        for (j, value) in scene.iter_mut().enumerate() {
            *value += v[(k, j)].conj() * part * factor;
        }
    }
    scene
}

#[test]
fn truncated_svd_is_that_of_a_dense_decomposition() {
    let (survey, points, data) = problem();
    let flight = survey.flight();
    let plain = PointOperator::new(&flight, &points);
    let weight: Vec<f32> = points
        .iter()
        .map(|p| 1.0 / flight.column_norm(*p) as f32)
        .collect();
    let even = Weighted::new(&plain, &weight).unwrap();
    for operator in [&plain as &dyn LinearOperator, &even] {
        let matrix = dense(operator);
        for threshold_db in [-6.0, -12.0, -20.0, -30.0] {
            let relative_threshold = 10f64.powf(threshold_db / 20.0);
            let keep = |s: f64, most: f64| {
                if s >= relative_threshold * most {
                    1.0 / s
                } else {
                    0.0
                }
            };
            let expected = filtered(&matrix, &data, keep);
            let options = SpectralOptions {
                regularization: Regularization::Truncation { threshold_db },
                ..exact(&flight)
            };
            let found = solve_spectral(operator, &data, &options, Control::default()).unwrap();
            let error = relative(&found.scene, &expected);
            assert!(error < 1e-6, "{threshold_db} dB: {error:e}");
            let singular = matrix.clone().svd(false, false).singular_values;
            assert!((found.greatest_singular / singular.max() - 1.0).abs() < 1e-9);
            let kept = singular
                .iter()
                .filter(|s| **s >= relative_threshold * singular.max());
            assert!(found.parameters < kept.count() as f64 + 0.5);
            // The residual reported is the residual.
            let mut model = vec![Complex64::ZERO; data.len()];
            operator
                .forward(&found.scene, &mut model, Control::default())
                .unwrap();
            let residual = relative(&model, &data);
            assert!(
                (found.history.residual() - residual).abs() < 1e-9,
                "{residual}"
            );
        }
    }
}

#[test]
fn tikhonov_and_cgls_are_the_dense_damped_least_squares() {
    let (survey, points, data) = problem();
    let flight = survey.flight();
    let operator = PointOperator::new(&flight, &points);
    let matrix = dense(&operator);
    let greatest = matrix.clone().svd(false, false).singular_values.max();
    for relative_mu in [0.3, 0.05, 0.01] {
        let mu = relative_mu * greatest;
        let normal = matrix.adjoint() * &matrix
            + DMatrix::identity(points.len(), points.len()) * Complex64::new(mu * mu, 0.0);
        let right = matrix.adjoint() * DVector::from_vec(data.clone());
        let expected = normal.lu().solve(&right).unwrap();
        let options = SpectralOptions {
            regularization: Regularization::Tikhonov { relative_mu },
            ..exact(&flight)
        };
        let found = solve_spectral(&operator, &data, &options, Control::default()).unwrap();
        let error = relative(&found.scene, expected.as_slice());
        assert!(error < 1e-6, "{relative_mu} {error:e} {:?}", found.history);
        let options = CglsOptions {
            mu,
            max_iterations: 400,
            tolerance: 1e-10,
            noise_norm: 0.0,
        };
        let found = cgls(&operator, &data, &options, Control::default()).unwrap();
        assert_eq!(found.history.stop, Stop::Converged);
        let error = relative(&found.scene, expected.as_slice());
        assert!(error < 1e-6, "{relative_mu} {error:e} {:?}", found.history);
    }
}

#[test]
fn the_discrepancy_principle_leaves_the_noise_and_nothing_else() {
    let (survey, points, data) = problem();
    let flight = survey.flight();
    let operator = PointOperator::new(&flight, &points);
    let options = |noise_norm| SpectralOptions {
        regularization: Regularization::Automatic { noise_norm },
        ..exact(&flight)
    };
    let least = {
        let options = SpectralOptions {
            regularization: Regularization::Tikhonov { relative_mu: 1e-6 },
            ..exact(&flight)
        };
        let found = solve_spectral(&operator, &data, &options, Control::default()).unwrap();
        found.history.residual() * norm(&data)
    };
    let wanted = (least * norm(&data)).sqrt();
    let found =
        solve_spectral(&operator, &data, &options(Some(wanted)), Control::default()).unwrap();
    assert_eq!(found.choice, ParameterChoice::Discrepancy);
    let mut model = vec![Complex64::ZERO; data.len()];
    operator
        .forward(&found.scene, &mut model, Control::default())
        .unwrap();
    let residual = relative(&model, &data) * norm(&data);
    assert!((residual / wanted - 1.0).abs() < 1e-3, "{residual}");
    // A level that no solution reaches, and none at all, leave the choice to the L-curve.
    for noise in [Some(0.5 * least), None] {
        let found = solve_spectral(&operator, &data, &options(noise), Control::default()).unwrap();
        assert_eq!(found.choice, ParameterChoice::LCurve);
    }
}

#[test]
fn the_l_curve_is_near_the_best_parameter() {
    // Singular values and data of Hansen's kind: smooth decay, white noise.
    let survey = Survey::new(23, 19);
    let points = lattice(10, 12, [0.03, 0.08]);
    let flight = survey.flight();
    let operator = PointOperator::new(&flight, &points);
    let mut random = Random::new(4);
    let truth: Vec<Complex64> = (0..points.len())
        .map(|k| Complex64::new((-((k % 10) as f64 - 4.5).powi(2) / 6.0).exp(), 0.0))
        .collect();
    let mut data = vec![Complex64::ZERO; flight.samples()];
    operator
        .forward(&truth, &mut data, Control::default())
        .unwrap();
    let sigma = 0.03 * norm(&data) / (data.len() as f64).sqrt();
    data.iter_mut().for_each(|d| *d += random.complex() * sigma);
    let error = |regularization| {
        let options = SpectralOptions {
            regularization,
            ..exact(&flight)
        };
        let found = solve_spectral(&operator, &data, &options, Control::default()).unwrap();
        relative(&found.scene, &truth)
    };
    let best = (0..60)
        .map(|k| {
            error(Regularization::Tikhonov {
                relative_mu: 10f64.powf(-f64::from(k) / 15.0),
            })
        })
        .fold(f64::INFINITY, f64::min);
    let by_curve = error(Regularization::Automatic { noise_norm: None });
    let by_noise = error(Regularization::Automatic {
        noise_norm: Some(sigma * (data.len() as f64).sqrt()),
    });
    assert!(by_curve < 3.0 * best, "L-curve {by_curve}, best {best}");
    assert!(by_noise < 1.5 * best, "discrepancy {by_noise}, best {best}");
}

/// min ½‖Ay − d‖² + λ‖y‖₁ by cyclic coordinate descent on the dense matrix.
fn coordinate_descent(
    matrix: &DMatrix<Complex64>,
    data: &[Complex64],
    lambda: f64,
) -> Vec<Complex64> {
    let columns: Vec<&[Complex64]> = (0..matrix.ncols())
        .map(|j| &matrix.as_slice()[j * matrix.nrows()..(j + 1) * matrix.nrows()])
        .collect();
    let mut y = vec![Complex64::ZERO; columns.len()];
    let mut residual = data.to_vec();
    for _ in 0..20_000 {
        let mut moved = 0.0_f64;
        for (j, column) in columns.iter().enumerate() {
            let power = norm(column).powi(2);
            let at = inner(column, &residual) + y[j] * power;
            let kept = (1.0 - lambda / at.norm().max(1e-300)).max(0.0);
            let new = at * kept / power;
            let by = new - y[j];
            residual
                .iter_mut()
                .zip(*column)
                .for_each(|(r, c)| *r -= c * by);
            y[j] = new;
            moved = moved.max(by.norm());
        }
        if moved < 1e-13 {
            break;
        }
    }
    y
}

#[test]
fn fista_is_the_sparse_solution_of_coordinate_descent() {
    let (survey, points, data) = problem();
    let flight = survey.flight();
    let operator = PointOperator::new(&flight, &points);
    let matrix = dense(&operator);
    let tracks = [TrackData {
        operator: &operator,
        data: &data,
    }];
    let most = greatest_lambda(&tracks, Control::default()).unwrap();
    for share in [0.5, 0.1, 0.02] {
        let lambda = share * most;
        let options = SparseOptions {
            lambda,
            max_iterations: 20_000,
            tolerance: 1e-13,
        };
        let found = solve_sparse(&tracks, &options, Control::default()).unwrap();
        let expected = coordinate_descent(&matrix, &data, lambda);
        let error = relative(&found.scenes[0], &expected);
        assert!(
            error < 1e-5,
            "λ {share}: {error:e}, {:?}",
            found.history.stop
        );
        assert_eq!(found.history.stop, Stop::Converged);
        assert!(found.support < points.len());
    }
    let options = SparseOptions {
        lambda: 1.001 * most,
        max_iterations: 100,
        tolerance: 1e-9,
    };
    let nothing = solve_sparse(&tracks, &options, Control::default()).unwrap();
    assert_eq!(nothing.support, 0);
}

#[test]
fn a_group_of_tracks_shares_its_support_and_not_its_phases() {
    let (survey, points, data) = problem();
    let mut beside = Survey::new(23, 19);
    beside.position_m.iter_mut().for_each(|p| p[1] -= 0.8);
    let flights = [survey.flight(), beside.flight()];
    let turned: Vec<Complex64> = echoes(
        &beside,
        &[([0.013, 1.27, 0.01], Complex64::new(-0.7, 0.2))],
        2e-3,
    );
    let operators = flights.each_ref().map(|f| PointOperator::new(f, &points));
    let tracks = [
        TrackData {
            operator: &operators[0],
            data: &data,
        },
        TrackData {
            operator: &operators[1],
            data: &turned,
        },
    ];
    let lambda = 0.2 * greatest_lambda(&tracks, Control::default()).unwrap();
    let options = SparseOptions {
        lambda,
        max_iterations: 5000,
        tolerance: 1e-11,
    };
    let found = solve_sparse(&tracks, &options, Control::default()).unwrap();
    // The conditions of optimality, pixel by pixel.
    let residuals: Vec<Vec<Complex64>> = tracks
        .iter()
        .zip(&found.scenes)
        .map(|(track, scene)| {
            let mut model = vec![Complex64::ZERO; track.data.len()];
            track
                .operator
                .forward(scene, &mut model, Control::default())
                .unwrap();
            let mut back = vec![Complex64::ZERO; scene.len()];
            let residual: Vec<_> = track.data.iter().zip(&model).map(|(d, m)| d - m).collect();
            track
                .operator
                .adjoint(&residual, &mut back, Control::default())
                .unwrap();
            back
        })
        .collect();
    let mut bright = 0;
    for i in 0..points.len() {
        let gradient = residuals[0][i].norm().hypot(residuals[1][i].norm());
        let value = found.scenes[0][i].norm().hypot(found.scenes[1][i].norm());
        assert!(gradient <= lambda * (1.0 + 1e-4), "{i}: {gradient}");
        if value > 1e-4 {
            bright += 1;
            assert!((gradient / lambda - 1.0).abs() < 1e-4);
            assert!(found.scenes.iter().all(|s| s[i] != Complex64::ZERO));
        }
    }
    assert!(bright > 0 && bright < 12, "{bright}");
}

#[test]
fn bad_input_is_refused_by_name() {
    let (survey, points, data) = problem();
    let flight = survey.flight();
    let operator = PointOperator::new(&flight, &points);
    let options = SpectralOptions::default();
    let zeros = vec![Complex64::ZERO; data.len()];
    let solve = |data: &[Complex64], options: &SpectralOptions, control| {
        solve_spectral(&operator, data, options, control).unwrap_err()
    };
    let quiet = Control::default();
    assert!(matches!(
        solve(&zeros, &options, quiet),
        InvertError::NoSignal { .. }
    ));
    let mut infinite = data.clone();
    infinite[3].re = f64::NAN;
    assert!(matches!(
        solve(&infinite, &options, quiet),
        InvertError::NoSignal { .. }
    ));
    assert!(matches!(
        solve(&data[1..], &options, quiet),
        InvertError::Length { what: "data", .. }
    ));
    let little = SpectralOptions {
        memory_limit_bytes: 1000,
        ..options
    };
    assert!(matches!(
        solve(&data, &little, quiet),
        InvertError::TooLarge { bytes, limit_bytes: 1000, .. } if bytes > 1000
    ));
    let upside_down = SpectralOptions {
        regularization: Regularization::Truncation { threshold_db: 20.0 },
        ..options
    };
    assert!(matches!(
        solve(&data, &upside_down, quiet),
        InvertError::OutOfRange { .. }
    ));
    let flag = AtomicBool::new(true);
    let cancelled = solve(&data, &options, Control::default().cancelled_by(&flag));
    assert_eq!(cancelled, InvertError::Imaging(ImagingError::Cancelled));
    let tracks = [TrackData {
        operator: &operator,
        data: &data,
    }];
    let sparse = SparseOptions {
        lambda: f64::NAN,
        max_iterations: 1,
        tolerance: 1.0,
    };
    assert!(solve_sparse(&tracks, &sparse, quiet).is_err());
    assert!(solve_sparse(&[], &sparse, quiet).is_err());
    assert!(cgls(&operator, &zeros, &CglsOptions::default(), quiet).is_err());
}
