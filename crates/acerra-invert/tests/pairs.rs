//! ⟨Lσ, d⟩ = ⟨σ, L⁺d⟩ of every operator that a solver may work on, and Eq. (3) as L⁺ of weighted data.

#![allow(clippy::unwrap_used)]

mod common;

use acerra_imaging::{
    Complex32, Complex64, Control, IncidenceWeight, PlanOptions, PlaneGrid, PulseArrays, Pulses,
    SurfaceGrid, TiltedGrid, VolumeGrid, image,
};
use acerra_invert::{
    Flight, Ground, LinearOperator, PointOperator, SceneOperator, Weighted, even_weights,
};
use common::{C, Random, Survey, inner, lattice, norm, relative};

/// |⟨Lσ, d⟩ − ⟨σ, L⁺d⟩| relative to what rounding of either side may be.
fn mismatch(operator: &dyn LinearOperator, seed: u64) -> f64 {
    let mut random = Random::new(seed);
    let (scene, data) = (
        random.vector(operator.pixels()),
        random.vector(operator.samples()),
    );
    let mut echo = vec![Complex64::ZERO; data.len()];
    let mut back = vec![Complex64::ZERO; scene.len()];
    operator
        .forward(&scene, &mut echo, Control::default())
        .unwrap();
    operator
        .adjoint(&data, &mut back, Control::default())
        .unwrap();
    let apart = (inner(&echo, &data) - inner(&scene, &back)).norm();
    apart / (norm(&echo) * norm(&data)).min(norm(&scene) * norm(&back))
}

#[test]
fn the_double_precision_operators_are_pairs_to_rounding() {
    let flight = Survey::new(21, 17).flight();
    let points = lattice(7, 6, [0.11, 0.23]);
    let exact = PointOperator::new(&flight, &points);
    assert!(mismatch(&exact, 1) < 1e-12);
    let weight: Vec<f32> = (0..points.len()).map(|k| 0.5 + 0.1 * k as f32).collect();
    assert!(mismatch(&Weighted::new(&exact, &weight).unwrap(), 2) < 1e-12);
    // Uneven frequencies take another path.
    let mut uneven = Survey::new(21, 17);
    uneven.frequency_hz[5] += 3e6;
    let flight = uneven.flight();
    assert!(mismatch(&PointOperator::new(&flight, &points), 3) < 1e-12);
}

#[test]
fn the_fast_operators_are_pairs_within_their_accuracy_on_every_ground() {
    let flight = Survey::new(40, 33).flight();
    let zeros = vec![Complex64::ZERO; flight.samples()];
    let plane = PlaneGrid::new([-0.5, 0.8, 0.0], 0.02, [51, 40]).unwrap();
    let tilted = TiltedGrid::new(
        [-0.5, 0.8, 0.1],
        [0.02, 0.0, 0.002],
        [0.0, 0.02, -0.004],
        51,
        40,
    )
    .unwrap();
    let ground = |x: f64, y: f64| Ok::<_, acerra_imaging::ImagingError>(0.1 * (3.0 * x + y).sin());
    let surface = SurfaceGrid::from_fn(plane, ground).unwrap();
    let volume = VolumeGrid::new(plane, 0.15, 3).unwrap();
    for accuracy in [1e-3, 1e-4] {
        for ground in [
            Ground::Plane(plane.into()),
            Ground::Plane(tilted),
            Ground::Surface(&surface),
            Ground::Volume(volume),
        ] {
            let options = PlanOptions::default().with_accuracy(accuracy);
            let operator =
                SceneOperator::new(&flight, &zeros, ground, options, Control::default()).unwrap();
            let weight = even_weights(&flight, operator.grids());
            let even = Weighted::new(&operator, &weight).unwrap();
            for (found, what) in [
                (mismatch(&operator, 3), "plain"),
                (mismatch(&even, 4), "even"),
            ] {
                assert!(found < accuracy, "{ground:?} {what}: {found:e}");
            }
        }
    }
}

#[test]
fn the_fast_operators_are_the_double_precision_ones() {
    let flight = Survey::new(30, 33).flight();
    let zeros = vec![Complex64::ZERO; flight.samples()];
    let plane = PlaneGrid::new([-0.3, 0.8, 0.0], 0.03, [21, 18]).unwrap();
    let relief = |x: f64, y: f64| Ok::<_, acerra_imaging::ImagingError>(0.2 * (2.0 * x - y).cos());
    let surface = SurfaceGrid::from_fn(plane, relief).unwrap();
    let mut random = Random::new(7);
    let volume = VolumeGrid::new(plane, 0.2, 4).unwrap();
    for ground in [
        Ground::Plane(plane.into()),
        Ground::Surface(&surface),
        Ground::Volume(volume),
    ] {
        let options = PlanOptions::default().with_accuracy(1e-4);
        let fast =
            SceneOperator::new(&flight, &zeros, ground, options, Control::default()).unwrap();
        let points: Vec<[f64; 3]> = (0..fast.pixels()).map(|k| fast.point_m(k)).collect();
        let exact = PointOperator::new(&flight, &points);
        let (scene, data) = (random.vector(fast.pixels()), random.vector(fast.samples()));
        let mut echoes = [
            vec![Complex64::ZERO; data.len()],
            vec![Complex64::ZERO; data.len()],
        ];
        let mut images = [
            vec![Complex64::ZERO; scene.len()],
            vec![Complex64::ZERO; scene.len()],
        ];
        fast.forward(&scene, &mut echoes[0], Control::default())
            .unwrap();
        exact
            .forward(&scene, &mut echoes[1], Control::default())
            .unwrap();
        fast.adjoint(&data, &mut images[0], Control::default())
            .unwrap();
        exact
            .adjoint(&data, &mut images[1], Control::default())
            .unwrap();
        let (echo, image) = (
            relative(&echoes[0], &echoes[1]),
            relative(&images[0], &images[1]),
        );
        assert!(
            echo < 1e-4 && image < 1e-4,
            "{ground:?}: {echo:e} {image:e}"
        );
    }
}

#[test]
fn the_adjoint_of_weighted_data_is_the_image_of_equation_3() {
    let survey = Survey::new(30, 33);
    let spectrum = Random::new(9).vector(30 * 33);
    let pulses = Pulses::new(PulseArrays {
        position_m: &survey.position_m,
        frequency_hz: &survey.frequency_hz,
        spectrum: &spectrum,
        weight: &survey.weight,
        light_speed_m_s: C,
    })
    .unwrap();
    let plane = PlaneGrid::new([-0.3, 0.8, 0.0], 0.03, [21, 18]).unwrap();
    let incidence = IncidenceWeight {
        cosine_power: 2.0,
        ..IncidenceWeight::default()
    };
    // Rolled by up to 20°, pitched by up to 11°.
    let looks: Vec<[f64; 3]> = (0..30)
        .map(|m| {
            let (x, y) = (0.34 * f64::from(m).sin(), 0.2 * (0.7 * f64::from(m)).cos());
            [x, y, -(1.0 - x * x - y * y).sqrt()]
        })
        .collect();
    let tilted = pulses.with_boresight(&looks).unwrap();
    for (pulses, incidence) in [
        (pulses, None),
        (pulses, Some(incidence)),
        (tilted, Some(incidence)),
    ] {
        let options = PlanOptions::default().with_accuracy(1e-4);
        let weighted_options = options.with_incidence(incidence);
        let expected: Vec<Complex32> =
            image(pulses, plane, &weighted_options, Control::default()).unwrap();
        let expected: Vec<Complex64> = expected
            .iter()
            .map(|v| Complex64::new(f64::from(v.re), f64::from(v.im)))
            .collect();
        let flight = Flight::of(&pulses).unwrap().with_incidence(incidence, 0.0);
        let data = flight.weighted(&spectrum).unwrap();
        let ground = Ground::Plane(plane.into());
        let operator =
            SceneOperator::new(&flight, &data, ground, options, Control::default()).unwrap();
        let mut found = vec![Complex64::ZERO; operator.pixels()];
        operator
            .adjoint(&data, &mut found, Control::default())
            .unwrap();
        assert!(relative(&found, &expected) < 2e-4);
        let at = operator.point_m(100);
        assert!(
            (flight.correlate(at, &data) - expected[100]).norm() < 1e-3 * norm(&expected) / 19.0
        );
    }
}
