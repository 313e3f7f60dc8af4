//! What the methods make of targets between the pixels, along positions that are a little off, in noise.

#![allow(clippy::unwrap_used)]

mod common;

use acerra_imaging::metrics::ImageView;
use acerra_imaging::{Complex32, Complex64, Control, PlanOptions, PlaneGrid};
use acerra_invert::{
    CleanInput, CleanOptions, Flight, Ground, LinearOperator, Regularization, SceneOperator,
    SpectralOptions, Stop, Weighted, clean, even_weights, measure_noise, point_response, restore,
    solve_spectral,
};
use common::{Random, Survey, echoes};

fn narrow(scene: &[Complex64]) -> Vec<Complex32> {
    scene
        .iter()
        .map(|v| Complex32::new(v.re as f32, v.im as f32))
        .collect()
}

struct Bench {
    flight: Flight,
    grid: PlaneGrid,
}

impl Bench {
    fn new() -> (Survey, Self) {
        let survey = Survey::new(61, 69);
        let flight = survey.flight();
        let grid = PlaneGrid::new([-0.5, 0.6, 0.0], 0.02, [51, 71]).unwrap();
        (survey, Self { flight, grid })
    }

    fn operator<'a>(&'a self, data: &'a [Complex64]) -> SceneOperator<'a> {
        let options = PlanOptions::default().with_accuracy(1e-4);
        let ground = Ground::Plane(self.grid.into());
        SceneOperator::new(&self.flight, data, ground, options, Control::default()).unwrap()
    }
}

#[test]
fn clean_finds_reflectivities_and_leaves_the_noise() {
    let (survey, bench) = Bench::new();
    let sigma = 3e-3;
    let scene = [
        ([0.007, 1.254, 0.0], Complex64::new(1.0, 0.4)),
        ([-0.27, 1.71, 0.0], Complex64::new(0.0, 0.5)),
    ];
    let data = echoes(&survey, &scene, sigma);
    let operator = bench.operator(&data);
    let weight = even_weights(&bench.flight, operator.grids());
    let even = Weighted::new(&operator, &weight).unwrap();
    let input = CleanInput {
        flight: &bench.flight,
        operator: &even,
        weight: &weight,
        grid: bench.grid.into(),
        data: &data,
    };
    let options = CleanOptions {
        gain: 0.3,
        threshold: 4.5 * sigma,
        max_cycles: 100,
        max_components: 2000,
    };
    let found = clean(&input, &options, Control::default()).unwrap();
    assert!(
        found.history.residual() < 0.3,
        "{:?}",
        found.history.iterations.last()
    );
    // Components about a target add up to its reflectivity, in modulus.
    let image = restore(&found, &bench.flight, &bench.grid.into());
    let view = narrow(&image);
    for (place, reflectivity) in scene {
        let near = |k: &usize| {
            let p = bench.grid.point_m(*k);
            (p[0] - place[0]).abs() < 0.05 && (p[1] - place[1]).abs() < 0.12
        };
        let most = (0..view.len())
            .filter(near)
            .map(|k| f64::from(view[k].norm()))
            .fold(0.0, f64::max);
        assert!(
            (most / reflectivity.norm() - 1.0).abs() < 0.15,
            "{most} for {reflectivity}"
        );
    }
}

#[test]
fn truncated_svd_narrows_the_point_and_says_what_it_costs() {
    let (_, bench) = Bench::new();
    let point = [0.013, 1.31, 0.0];
    let mut data = vec![Complex64::ZERO; bench.flight.samples()];
    bench.flight.add_echo(point, Complex64::ONE, &mut data);
    let operator = bench.operator(&data);
    let weight = even_weights(&bench.flight, operator.grids());
    let even = Weighted::new(&operator, &weight).unwrap();
    let response = |scene: &[Complex64]| {
        let image = narrow(scene);
        let view = ImageView::new(&image, bench.grid).unwrap();
        point_response(&view, bench.flight.spread(), point).unwrap()
    };
    let mut adjoint = vec![Complex64::ZERO; operator.pixels()];
    even.adjoint(&data, &mut adjoint, Control::default())
        .unwrap();
    even.scene_from(&mut adjoint);
    let before = response(&adjoint);
    // An even point spread has the unit peak.
    assert!((before.peak - 1.0).abs() < 0.03, "{before:?}");
    let options = SpectralOptions {
        regularization: Regularization::Truncation {
            threshold_db: -20.0,
        },
        tolerance: 0.05,
        ..SpectralOptions::default()
    };
    let mut found = solve_spectral(&even, &data, &options, Control::default()).unwrap();
    assert_eq!(found.history.stop, Stop::Converged, "{:?}", found.history);
    even.scene_from(&mut found.scene);
    let after = response(&found.scene);
    // Whitening the spectrum narrows the main lobe both ways.
    for (after, before) in [
        (after.along_3db_m, before.along_3db_m),
        (after.across_3db_m, before.across_3db_m),
    ] {
        assert!(after.unwrap() < before.unwrap(), "{before:?} {after:?}");
    }
    assert!(after.displacement_m < 0.02, "{after:?}");
    assert!(after.main_share > before.main_share, "{before:?} {after:?}");
}

#[test]
fn the_noise_is_measured_in_front_of_the_first_echo() {
    let survey = Survey::new(61, 171);
    let flight = survey.flight();
    for sigma in [1e-3, 0.2] {
        // A strong target, noise of a known deviation.
        let mut spectrum = vec![Complex64::ZERO; flight.samples()];
        let unit = Survey {
            weight: vec![1.0; 61],
            ..Survey::new(61, 171)
        };
        unit.flight().add_echo(
            [0.0, 0.5, 0.0],
            Complex64::new(30.0 * sigma, 0.0),
            &mut spectrum,
        );
        let mut random = Random::new(3);
        spectrum
            .iter_mut()
            .for_each(|e| *e += random.complex() * sigma);
        let quiet = vec![[0.5, 2.5]; 61];
        let found = measure_noise(&flight, &spectrum, &quiet).unwrap().unwrap();
        assert!((found.sigma / sigma - 1.0).abs() < 0.05, "{found:?}");
        let weights: f64 = survey.weight.iter().sum();
        let expected = sigma * (weights * 171.0).sqrt();
        assert!((found.norm(&flight, 1.0) / expected - 1.0).abs() < 0.05);
        assert!(
            measure_noise(&flight, &spectrum, &[[2.0, 1.0]; 61])
                .unwrap()
                .is_none()
        );
        assert!(measure_noise(&flight, &spectrum, &quiet[1..]).is_err());
    }
}
