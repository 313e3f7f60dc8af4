//! Transmitter and receiver apart in air: the engines in single precision keep the accuracy against the
//! double-precision sum along both ways, at every SIMD level, and the forward operator is the adjoint of imaging.

#![allow(clippy::unwrap_used)]

mod common;
use common::{C, Random, band};

use acerra_imaging::{
    Complex32, Complex64, Control, Engine, Forward, ImageGrid, ImagingError, ImagingPlan,
    IncidenceWeight, PlanOptions, PlaneGrid, PulseArrays, Pulses, SimdLevel, Spreading,
    SurfaceGrid, reference,
};

/// A wavering track, antennas either side of it, and noisy echoes of targets.
struct Flight {
    position_m: Vec<[f64; 3]>,
    transmitter_m: Vec<[f64; 3]>,
    receiver_m: Vec<[f64; 3]>,
    frequency_hz: Vec<f64>,
    spectrum: Vec<Complex64>,
    weight: Vec<f64>,
}

impl Flight {
    /// `pulses` along `track_m` at `height_m`, antennas `apart_m` from each other in turning directions.
    fn new(height_m: f64, apart_m: f64, (pulses, track_m): (usize, f64), seed: u64) -> Self {
        let mut r = Random(seed);
        let position_m: Vec<[f64; 3]> = (0..pulses)
            .map(|m| {
                let s = m as f64 / (pulses - 1) as f64;
                let waver = 0.02 * height_m.min(2.0);
                [
                    waver * (9.0 * s).sin() - 0.2 * height_m,
                    track_m * (s - 0.5),
                    height_m + waver * (7.0 * s).cos(),
                ]
            })
            .collect();
        let moved = |sign: f64| -> Vec<[f64; 3]> {
            let antenna = |(m, p): (usize, &[f64; 3])| {
                let (heading, half) = (0.3 * (0.05 * m as f64).sin(), 0.5 * sign * apart_m);
                let along = [heading.sin(), heading.cos(), 0.1 * heading];
                std::array::from_fn(|axis| p[axis] + half * along[axis])
            };
            position_m.iter().enumerate().map(antenna).collect()
        };
        let frequency_hz = band(100);
        let mut flight = Self {
            transmitter_m: moved(-1.0),
            receiver_m: moved(1.0),
            weight: (0..pulses).map(|_| 1.0 + 0.3 * r.next()).collect(),
            spectrum: vec![Complex64::ZERO; pulses * frequency_hz.len()],
            position_m,
            frequency_hz,
        };
        let scene: Vec<_> = (0..10)
            .map(|_| reference::Scatterer {
                position_m: [0.4 * r.next(), 0.4 * r.next(), 0.02 * r.next()],
                reflectivity: r.complex(),
            })
            .collect();
        let mut echoes =
            reference::forward_along_rays(&flight.pulses(), &scene, Spreading::InverseSquare)
                .unwrap();
        let rms = (echoes.iter().map(|e| e.norm_sqr()).sum::<f64>() / echoes.len() as f64).sqrt();
        for e in &mut echoes {
            *e += r.complex() * (0.3 * rms);
        }
        flight.spectrum = echoes;
        flight
    }

    fn pulses(&self) -> Pulses<'_> {
        let pulses = Pulses::new(PulseArrays {
            position_m: &self.position_m,
            frequency_hz: &self.frequency_hz,
            spectrum: &self.spectrum,
            weight: &self.weight,
            light_speed_m_s: C,
        });
        pulses
            .unwrap()
            .with_antennas(&self.transmitter_m, &self.receiver_m)
            .unwrap()
    }

    /// Images `grid` at every SIMD level and checks the accuracy at its pixels.
    fn check(&self, grid: ImageGrid, points_m: &[[f64; 3]], cases: &[PlanOptions]) {
        let spreading = cases[0].spreading;
        let expected = reference::adjoint(&self.pulses(), points_m, spreading).unwrap();
        for (options, &level) in (cases.iter())
            .flat_map(|options| SimdLevel::available().iter().map(move |l| (options, l)))
        {
            let options = options.with_level(level);
            let plan = ImagingPlan::new(self.pulses(), grid, &options).unwrap();
            assert_eq!(plan.engine(), options.engine, "{plan}");
            let mut image = vec![Complex32::ZERO; plan.pixels()];
            plan.run(&mut image, Control::default()).unwrap();
            let found: Vec<_> = image.iter().map(wide).collect();
            let error = reference::relative_l2(&found, &expected).unwrap();
            let accuracy = options.accuracy;
            assert!(error <= accuracy, "{error:e} for {accuracy:e}\n{plan}");
        }
    }

    fn check_plane(&self, grid: PlaneGrid, cases: &[PlanOptions]) {
        let points_m: Vec<_> = (0..grid.len()).map(|k| grid.point_m(k)).collect();
        self.check(grid.into(), &points_m, cases);
    }
}

/// Plans by an engine for several accuracies.
fn plans(engine: Engine, spreading: Spreading, accuracies: &[f64]) -> Vec<PlanOptions> {
    let plan = |accuracy: &f64| {
        PlanOptions::default()
            .with_accuracy(*accuracy)
            .with_spreading(spreading)
            .with_engine(engine)
    };
    accuracies.iter().map(plan).collect()
}

fn wide(v: &Complex32) -> Complex64 {
    Complex64::new(f64::from(v.re), f64::from(v.im))
}

fn random_image(pixels: usize, seed: u64) -> Vec<Complex32> {
    let mut r = Random(seed);
    let narrow = |v: Complex64| Complex32::new(v.re as f32, v.im as f32);
    (0..pixels).map(|_| narrow(r.complex())).collect()
}

const SPREADINGS: [Spreading; 2] = [Spreading::InverseSquare, Spreading::None];

#[test]
fn images_keep_the_accuracy_at_any_range() {
    let cases = [
        (0.3, 0.06),
        (0.5, 0.25),
        (2.0, 0.3),
        (5.0, 1.5),
        (3000.0, 60.0),
    ];
    for (seed, (height_m, apart_m)) in cases.into_iter().enumerate() {
        let flight = Flight::new(height_m, apart_m, (50, 1.5), seed as u64);
        let grid = PlaneGrid::new([-0.3, -0.35, 0.0], 0.01, [37, 27]).unwrap();
        let spreading = SPREADINGS[seed % 2];
        flight.check_plane(grid, &plans(Engine::Direct, spreading, &[1e-2, 1e-3, 1e-4]));
    }
}

/// Pixels read through squares of them and by gathers.
#[test]
fn coarse_pixels_keep_the_accuracy() {
    for (pixel_m, height_m, apart_m) in [(0.04, 4.0, 0.4), (0.15, 8.0, 0.4), (0.5, 8.0, 3.0)] {
        let flight = Flight::new(height_m, apart_m, (40, 4.0), 31);
        let grid = PlaneGrid::new([-15.0 * pixel_m; 3], pixel_m, [33, 31]).unwrap();
        let grid = PlaneGrid { z_m: 0.0, ..grid };
        let cases = plans(Engine::Direct, SPREADINGS[0], &[1e-2, 1e-3, 1e-4]);
        flight.check_plane(grid, &cases);
    }
}

#[test]
fn sub_apertures_keep_the_accuracy() {
    for (height_m, apart_m) in [(5.0, 0.3), (5.0, 2.0)] {
        let flight = Flight::new(height_m, apart_m, (200, 4.0), 41);
        let grid = PlaneGrid::new([-0.5, -0.5, 0.0], 0.01, [81, 77]).unwrap();
        let cases = plans(Engine::Factorized, SPREADINGS[0], &[2e-3, 3e-4]);
        flight.check_plane(grid, &cases);
    }
}

#[test]
fn uneven_ground_keeps_the_accuracy() {
    let flight = Flight::new(3.0, 0.3, (60, 3.0), 51);
    let base = PlaneGrid::new([-0.4, -0.4, 0.0], 0.01, [61, 59]).unwrap();
    let wave = |x: f64, y: f64| Ok::<_, ImagingError>(0.1 * (2.0 * x).sin() * (1.5 * y).cos());
    let ground = SurfaceGrid::from_fn(base, wave).unwrap();
    let points_m: Vec<_> = (0..base.len()).map(|k| ground.point_m(k)).collect();
    let cases = plans(Engine::Direct, SPREADINGS[0], &[1e-3]);
    flight.check((&ground).into(), &points_m, &cases);
}

#[test]
fn echoes_keep_the_accuracy() {
    for (height_m, apart_m, pixel_m) in [(0.4, 0.06, 0.01), (4.0, 0.4, 0.01), (8.0, 0.4, 0.1)] {
        let flight = Flight::new(height_m, apart_m, (30, 3.0), 61);
        let grid = PlaneGrid::new([-20.0 * pixel_m; 3], pixel_m, [44, 40]).unwrap();
        let grid = PlaneGrid { z_m: 0.0, ..grid };
        let image = random_image(grid.len(), 5);
        let scene: Vec<_> = (image.iter().enumerate())
            .map(|(k, v)| reference::Scatterer {
                position_m: grid.point_m(k),
                reflectivity: wide(v),
            })
            .collect();
        for (accuracy, spreading) in [(1e-2, SPREADINGS[1]), (1e-3, SPREADINGS[0])] {
            let expected =
                reference::forward_along_rays(&flight.pulses(), &scene, spreading).unwrap();
            let engines = [Engine::Direct, Engine::Factorized];
            for (engine, &level) in (engines.iter())
                .flat_map(|engine| SimdLevel::available().iter().map(move |l| (*engine, l)))
            {
                let options = plans(engine, spreading, &[accuracy])[0].with_level(level);
                let forward = Forward::new(flight.pulses(), grid, &options).unwrap();
                let is_fast = matches!(forward.engine(), Engine::Direct | Engine::Factorized);
                assert!(is_fast, "{forward}");
                let mut echo = vec![Complex64::ZERO; expected.len()];
                forward.run(&image, &mut echo, Control::default()).unwrap();
                let error = reference::relative_l2(&echo, &expected).unwrap();
                assert!(error <= accuracy, "{error:e} for {accuracy:e}\n{forward}");
            }
        }
    }
}

/// ⟨Lσ, d⟩ = ⟨σ, L⁺d⟩.
#[test]
fn the_forward_operator_is_the_adjoint() {
    let flight = Flight::new(2.0, 0.3, (80, 2.0), 71);
    let grid = PlaneGrid::new([-0.5, -0.5, 0.0], 0.01, [100, 96]).unwrap();
    let sigma = random_image(grid.len(), 9);
    for engine in [Engine::Direct, Engine::Factorized] {
        let options = plans(engine, SPREADINGS[0], &[1e-3])[0];
        let mut echo = vec![Complex64::ZERO; flight.spectrum.len()];
        let forward = Forward::new(flight.pulses(), grid, &options).unwrap();
        forward.run(&sigma, &mut echo, Control::default()).unwrap();
        let plan = ImagingPlan::new(flight.pulses(), grid, &options).unwrap();
        let mut image = vec![Complex32::ZERO; grid.len()];
        plan.run(&mut image, Control::default()).unwrap();
        let left: Complex64 = (echo.iter().zip(&flight.spectrum))
            .map(|(a, b)| a.conj() * b)
            .sum();
        let right: Complex64 = (sigma.iter().zip(&image))
            .map(|(a, b)| wide(a).conj() * wide(b))
            .sum();
        let norm = |v: &[Complex64]| v.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt();
        let scale = norm(&echo) * norm(&flight.spectrum);
        let error = (left - right).norm() / scale;
        assert!(error <= 2e-3, "{error:e} by {engine:?}");
    }
}

/// Patterns of antennas apart count along both ways, which no table holds.
#[test]
fn patterns_are_summed_in_double_precision() {
    let flight = Flight::new(2.0, 0.3, (40, 2.0), 81);
    let grid = PlaneGrid::new([-0.2, -0.2, 0.0], 0.02, [21, 21]).unwrap();
    let weight = IncidenceWeight {
        max_rad: 1.0,
        taper_rad: 0.3,
        cosine_power: 2.0,
    };
    let options = PlanOptions::default().with_incidence(Some(weight));
    let plan = ImagingPlan::new(flight.pulses(), grid, &options).unwrap();
    assert_eq!(plan.engine(), Engine::Double);
}

/// An antenna exactly on a pixel, where 1/R has no value, is refused wherever the middle of both is.
#[test]
fn an_antenna_on_a_pixel_is_refused() {
    let mut flight = Flight::new(1.0, 0.2, (10, 1.0), 91);
    let grid = PlaneGrid::new([-0.2, -0.2, 0.0], 0.02, [21, 21]).unwrap();
    flight.receiver_m[3] = grid.point_m(60);
    let found = ImagingPlan::new(flight.pulses(), grid, &PlanOptions::default()).unwrap_err();
    let expected = ImagingError::ZeroRange {
        pulse: 3,
        point: 60,
    };
    assert_eq!(found, expected);
}
