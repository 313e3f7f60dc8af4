//! The forward operator models echoes to the accuracy asked for and is the adjoint of imaging.

#![allow(clippy::unwrap_used)]

#[macro_use]
mod common;
use common::{C, Campaign, Random, band};

use acerra_imaging::plan::Decision;
use acerra_imaging::{
    Complex32, Complex64, Control, Engine, Forward, ImagingError, ImagingPlan, PlanOptions,
    PlaneGrid, SimdLevel, Spreading, TiltedGrid, reference,
};

at_every_level!(
    echoes_match_the_double_precision_sum,
    hard_geometry,
    every_pixel_size,
    coarse_grids_of_fractions_of_pixels,
    forward_and_adjoint_are_adjoint,
);

/// A reproducible image; most of it dark, as scenes are.
fn random_image(pixels: usize, seed: u64) -> Vec<Complex32> {
    let mut random = Random(seed);
    (0..pixels)
        .map(|_| {
            let v = random.complex();
            let v = v * (0.1 + v.norm_sqr());
            Complex32::new(v.re as f32, v.im as f32)
        })
        .collect()
}

/// Eq. (1) summed plainly, times the weights of the pulses.
fn plain(
    campaign: &Campaign,
    grid: &TiltedGrid,
    image: &[Complex32],
    s: Spreading,
) -> Vec<Complex64> {
    let scene: Vec<_> = image
        .iter()
        .enumerate()
        .map(|(k, v)| reference::Scatterer {
            position_m: grid.point_m((k % grid.columns) as f64, (k / grid.columns) as f64),
            reflectivity: Complex64::new(f64::from(v.re), f64::from(v.im)),
        })
        .collect();
    let n = campaign.frequency_hz.len();
    let mut echo =
        reference::forward(&campaign.position_m, &campaign.frequency_hz, &scene, C, s).unwrap();
    for (row, w) in echo.chunks_mut(n).zip(&campaign.weight) {
        row.iter_mut().for_each(|e| *e *= w);
    }
    echo
}

fn check(campaign: &Campaign, grid: impl Into<TiltedGrid>, options: &PlanOptions) {
    let grid = grid.into();
    let image = random_image(grid.columns * grid.rows, 5);
    let forward = Forward::new(campaign.pulses(), grid, options).unwrap();
    if options.accuracy > 5e-4 && options.engine != Engine::Auto {
        assert_eq!(forward.engine(), options.engine, "{forward}");
    }
    let mut echo = vec![Complex64::ZERO; campaign.spectrum.len()];
    forward.run(&image, &mut echo, Control::default()).unwrap();
    let expected = plain(campaign, &grid, &image, options.spreading);
    let error = reference::relative_l2(&echo, &expected).unwrap();
    assert!(
        error <= options.accuracy,
        "{error:e} for {:e}\n{forward}",
        options.accuracy
    );
}

/// A wavering track of 30 pulses beside or over the patch.
fn track(distance_m: f64, height_m: f64) -> Campaign {
    let position: Vec<_> = (0..30)
        .map(|m| {
            let s = f64::from(m) * 0.05;
            [
                0.1 * (3.0 * s).sin() - distance_m,
                s - 0.7,
                height_m + 0.05 * (5.0 * s).cos(),
            ]
        })
        .collect();
    Campaign::new(position, band(40), &[[0.2, 0.1, 0.0], [9.0, 3.0, 0.0]], 17)
}

fn echoes_match_the_double_precision_sum(level: SimdLevel) {
    for (distance_m, height_m) in [(3.0, 4.0), (0.0, 3.0), (2500.0, 1500.0)] {
        let campaign = track(distance_m, height_m);
        let plane = PlaneGrid::new([-0.4, -0.4, 0.0], 0.01, [90, 75]).unwrap();
        let u_m = [0.008, 0.003, 0.002];
        let tilted = TiltedGrid::new([0.0, -0.5, 0.1], u_m, [-0.004, 0.012, 0.0], 83, 60).unwrap();
        for grid in [plane.into(), tilted] {
            for engine in [Engine::Direct, Engine::Factorized] {
                for (accuracy, spreading) in [
                    (1e-2, Spreading::None),
                    (1e-3, Spreading::InverseSquare),
                    (3e-5, Spreading::InverseSquare),
                ] {
                    let options = PlanOptions::default()
                        .with_accuracy(accuracy)
                        .with_spreading(spreading)
                        .with_level(level)
                        .with_engine(engine);
                    check(&campaign, grid, &options);
                }
            }
        }
    }
}

fn hard_geometry(level: SimdLevel) {
    let options = PlanOptions::default().with_level(level);
    // An antenna 2 cm over a pixel, others within the plane, uneven frequencies, repeated places.
    let mut frequency_hz = band(40);
    for (k, f) in frequency_hz.iter_mut().enumerate() {
        *f += 2e6 * (k as f64).sin();
    }
    let position = vec![
        [0.2, 0.1, 0.02],
        [0.201, 0.1, 4.0],
        [1.5, 0.003, 0.0],
        [1.5, 0.003, 0.0],
        [-4.0, 1.0, 0.0],
    ];
    let campaign = Campaign::new(position, frequency_hz, &[[0.1, 0.0, 0.0]], 3);
    let plane = PlaneGrid::new([-0.3, -0.2, 0.0], 0.01, [70, 40]).unwrap();
    check(&campaign, plane, &options);
    // Single pixels, rows and columns; one pulse; large pixels.
    let campaign = Campaign::random(5.0, 1, band(30), 8);
    for (nx, ny, pixel_m) in [(1, 1, 0.01), (1, 50, 0.01), (50, 1, 0.01), (20, 20, 0.7)] {
        let grid = PlaneGrid::new([-0.2, -0.2, 0.0], pixel_m, [nx, ny]).unwrap();
        check(&campaign, grid, &options);
    }
}

/// The pixels that a plan of the direct engine takes together.
fn group(forward: &Forward) -> Option<[usize; 2]> {
    let decisions = &forward.report().decisions;
    decisions.iter().rev().find_map(|d| match d {
        Decision::Direct(choice) => Some(choice.group),
        _ => None,
    })
}

/// Small pixels are summed in groups, coarse ones go to bins of their own; blocks under low antennas go by
/// rows or in double precision.
/// Pixels so coarse that no whole number of them makes an interval of a coarse grid.
fn coarse_grids_of_fractions_of_pixels(level: SimdLevel) {
    let position = (0..48)
        .map(|m| [0.1, 0.024 * f64::from(m) - 0.6, 5.0 + 0.001 * f64::from(m)])
        .collect();
    let campaign = Campaign::new(position, band(40), &[[0.1, 0.1, 0.0]], 4);
    let mut fractions = 0;
    for pixel_m in [0.031, 0.04] {
        let grid = PlaneGrid::new([-1.9, -2.1, 0.0], pixel_m, [101, 117]).unwrap();
        for accuracy in [5e-3, 1e-3] {
            let options = PlanOptions::default()
                .with_accuracy(accuracy)
                .with_level(level)
                .with_engine(Engine::Factorized);
            check(&campaign, grid, &options);
            let forward = Forward::new(campaign.pulses(), grid, &options).unwrap();
            fractions += (forward.report().decisions.iter())
                .filter(|d| match d {
                    Decision::Factorized(c) => c.coarse.iter().any(|d| d.fract() > 0.0),
                    _ => false,
                })
                .count();
        }
    }
    assert!(fractions >= 2, "{fractions}");
}

fn every_pixel_size(level: SimdLevel) {
    for height_m in [0.25, 5.0] {
        let position = (0..6)
            .map(|m| {
                [
                    0.1,
                    0.2 * f64::from(m) - 0.3,
                    height_m + 0.01 * f64::from(m),
                ]
            })
            .collect();
        let campaign = Campaign::new(position, band(40), &[[0.1, 0.1, 0.0]], 4);
        for (pixel_m, expected) in [
            (0.005, Some([4, 4])),
            (0.01, Some([4, 4])),
            (0.02, Some([4, 4])),
            (0.04, Some([4, 4])),
            (0.1, None),
        ] {
            let u_m = [pixel_m, 0.1 * pixel_m, 0.05 * pixel_m];
            let v_m = [-0.2 * pixel_m, pixel_m, 0.0];
            // Neither whole groups nor whole blocks.
            let grid = TiltedGrid::new([-0.2, -0.3, 0.0], u_m, v_m, 115, 43).unwrap();
            for (accuracy, spreading) in [
                (2e-3, Spreading::None),
                (2e-3, Spreading::InverseSquare),
                (3e-4, Spreading::InverseSquare),
            ] {
                let options = PlanOptions::default()
                    .with_accuracy(accuracy)
                    .with_spreading(spreading)
                    .with_level(level)
                    .with_engine(Engine::Direct);
                check(&campaign, grid, &options);
                if let Some(expected) = expected
                    && accuracy > 1e-3
                    && height_m > 1.0
                {
                    let forward = Forward::new(campaign.pulses(), grid, &options).unwrap();
                    assert_eq!(group(&forward), Some(expected), "{forward}");
                }
            }
        }
    }
}

fn forward_and_adjoint_are_adjoint(level: SimdLevel) {
    let campaign = track(3.0, 4.0);
    let grid = PlaneGrid::new([-0.6, -0.6, 0.0], 0.01, [121, 110]).unwrap();
    let sigma = random_image(grid.len(), 6);
    for engine in [Engine::Direct, Engine::Factorized] {
        for accuracy in [1e-2, 1e-3, 1e-4] {
            let options = PlanOptions::default()
                .with_accuracy(accuracy)
                .with_level(level)
                .with_engine(engine);
            let forward = Forward::new(campaign.pulses(), grid, &options).unwrap();
            let plan = ImagingPlan::new(campaign.pulses(), grid, &options).unwrap();
            let mut echo = vec![Complex64::ZERO; campaign.spectrum.len()];
            forward.run(&sigma, &mut echo, Control::default()).unwrap();
            let mut image = vec![Complex32::ZERO; grid.len()];
            plan.run(&mut image, Control::default()).unwrap();
            let wide = |v: &Complex32| Complex64::new(f64::from(v.re), f64::from(v.im));
            let (mut left, mut right) = (Complex64::ZERO, Complex64::ZERO);
            let (mut sizes, mut powers) = ([0.0; 2], [0.0; 2]);
            for (e, d) in echo.iter().zip(&campaign.spectrum) {
                left += e.conj() * d;
                sizes[0] += e.norm_sqr();
                powers[0] += d.norm_sqr();
            }
            for (s, i) in sigma.iter().zip(&image) {
                right += wide(s).conj() * wide(i);
                sizes[1] += wide(s).norm_sqr();
                powers[1] += wide(i).norm_sqr();
            }
            // What either side may err by, given the accuracy of the echoes and of the image.
            let scale = (sizes[0] * powers[0])
                .sqrt()
                .min((sizes[1] * powers[1]).sqrt());
            let error = (left - right).norm() / scale;
            assert!(
                error <= accuracy,
                "{level} {engine:?} {accuracy:e}: {left} {right}, {error:e}"
            );
        }
    }
}

#[test]
fn the_same_bits_on_any_number_of_threads() {
    let campaign = track(2.0, 4.0);
    let grid = PlaneGrid::new([-0.6, -0.6, 0.0], 0.01, [131, 120]).unwrap();
    let image = random_image(grid.len(), 9);
    for engine in [Engine::Direct, Engine::Factorized] {
        let options = PlanOptions::default().with_engine(engine);
        let forward = Forward::new(campaign.pulses(), grid, &options).unwrap();
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            let mut echo = vec![Complex64::ZERO; campaign.spectrum.len()];
            pool.install(|| forward.run(&image, &mut echo, Control::default()))
                .unwrap();
            echo
        };
        let one = run(1);
        assert!(one == run(2) && one == run(5) && one == run(1));
    }
}

#[test]
fn wrong_lengths_and_too_little_memory_are_refused() {
    let campaign = track(2.0, 4.0);
    let grid = PlaneGrid::new([-0.6, -0.6, 0.0], 0.01, [131, 120]).unwrap();
    let forward = Forward::new(campaign.pulses(), grid, &PlanOptions::default()).unwrap();
    let mut echo = vec![Complex64::ZERO; campaign.spectrum.len()];
    let image = random_image(grid.len() - 1, 9);
    match forward.run(&image, &mut echo, Control::default()) {
        Err(ImagingError::Length { what, found, .. }) => {
            assert_eq!((what, found), ("image", grid.len() - 1));
        }
        other => panic!("{other:?}"),
    }
    let options = PlanOptions::default().with_memory_limit_bytes(100_000);
    match Forward::new(campaign.pulses(), grid, &options) {
        Err(ImagingError::TooLarge {
            bytes, limit_bytes, ..
        }) => assert!(bytes > limit_bytes),
        other => panic!("{other:?}"),
    }
}
