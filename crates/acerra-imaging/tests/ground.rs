//! Images below ground and of antennas apart: the accuracy holds against the double-precision sum along rays, at
//! every SIMD level, and targets stand where they are.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

#[macro_use]
mod common;
use common::{C, Random};

use acerra_imaging::plan::Decision;
use acerra_imaging::refraction::{Ground, Layer, Relief, Soil, Surface};
use acerra_imaging::{
    Complex32, Complex64, Control, Engine, Forward, ImagingError, ImagingPlan, IncidenceWeight,
    PlanOptions, PlaneGrid, PulseArrays, Pulses, SimdLevel, Spreading, VolumeGrid,
    image_volume_planned_once, reference,
};

/// A flight over ground: positions, band and echoes.
struct Scene {
    position_m: Vec<[f64; 3]>,
    transmitter_m: Vec<[f64; 3]>,
    receiver_m: Vec<[f64; 3]>,
    frequency_hz: Vec<f64>,
    spectrum: Vec<Complex64>,
    weight: Vec<f64>,
    ground: Option<Ground>,
    is_bistatic: bool,
}

impl Scene {
    /// Echoes of random scatterers about `depth_m` below ground, and noise, at positions without order.
    fn new(height_m: f64, depth_m: f64, ground: Option<Ground>, apart_m: f64, seed: u64) -> Self {
        let mut r = Random(seed);
        let lateral = height_m.max(0.5);
        let position_m = (0..40)
            .map(|_| {
                [
                    lateral * r.next(),
                    lateral * r.next(),
                    height_m * (1.0 + 0.1 * r.next()),
                ]
            })
            .collect();
        Self::seen_from(position_m, depth_m, ground, apart_m, r)
    }

    /// The same from given positions.
    fn seen_from(
        position_m: Vec<[f64; 3]>,
        depth_m: f64,
        ground: Option<Ground>,
        apart_m: f64,
        mut r: Random,
    ) -> Self {
        let moved = |by: f64| position_m.iter().map(|p| [p[0] + by, p[1], p[2]]).collect();
        let [low, high] = [0.4e9 + 1e9 * r.next().abs(), 1.0e9 + 3e9 * r.next().abs()];
        let count = 60;
        let frequency_hz: Vec<f64> = (0..count)
            .map(|n| low + high * n as f64 / (count - 1) as f64)
            .collect();
        let mut scene = Self {
            transmitter_m: moved(-0.5 * apart_m),
            receiver_m: moved(0.5 * apart_m),
            spectrum: vec![Complex64::ZERO; position_m.len() * count],
            weight: (0..position_m.len())
                .map(|_| 1.0 + 0.3 * r.next())
                .collect(),
            position_m,
            frequency_hz,
            ground,
            is_bistatic: apart_m > 0.0,
        };
        let scatterers: Vec<_> = (0..8)
            .map(|_| reference::Scatterer {
                position_m: [
                    0.4 * r.next(),
                    0.4 * r.next(),
                    -depth_m * (1.0 + 0.2 * r.next()),
                ],
                reflectivity: r.complex(),
            })
            .collect();
        let spreading = Spreading::InverseSquare;
        let mut echoes =
            reference::forward_along_rays(&scene.pulses(), &scatterers, spreading).unwrap();
        let rms = (echoes.iter().map(|e| e.norm_sqr()).sum::<f64>() / echoes.len() as f64).sqrt();
        for e in &mut echoes {
            *e += r.complex() * (0.3 * rms);
        }
        scene.spectrum = echoes;
        scene
    }

    fn pulses(&self) -> Pulses<'_> {
        let mut pulses = Pulses::new(PulseArrays {
            position_m: &self.position_m,
            frequency_hz: &self.frequency_hz,
            spectrum: &self.spectrum,
            weight: &self.weight,
            light_speed_m_s: C,
        })
        .unwrap();
        if self.is_bistatic {
            pulses = pulses
                .with_antennas(&self.transmitter_m, &self.receiver_m)
                .unwrap();
        }
        match &self.ground {
            Some(ground) => pulses.with_ground(ground).unwrap(),
            None => pulses,
        }
    }
}

fn soil(relative_permittivity: f64, conductivity_s_m: f64) -> Soil {
    Soil {
        relative_permittivity,
        conductivity_s_m,
    }
}

fn level(layers: &[Layer]) -> Option<Ground> {
    Some(Ground::new(Surface::Level { z_m: 0.0 }, layers, 1.5e9).unwrap())
}

/// Relative error of an image against the sum along rays, and the engine that made it.
fn error(pulses: Pulses, grid: PlaneGrid, options: &PlanOptions) -> (f64, Engine) {
    let plan = ImagingPlan::new(pulses, grid, options).unwrap();
    let mut image = vec![Complex32::ZERO; plan.pixels()];
    plan.run(&mut image, Control::default()).unwrap();
    (
        deviation(&pulses, &grid, &image, options.spreading),
        plan.engine(),
    )
}

fn deviation(pulses: &Pulses, grid: &PlaneGrid, image: &[Complex32], spreading: Spreading) -> f64 {
    let points: Vec<_> = (0..grid.len()).map(|k| grid.point_m(k)).collect();
    let expected = reference::adjoint(pulses, &points, spreading).unwrap();
    let image: Vec<_> = image
        .iter()
        .map(|v| Complex64::new(f64::from(v.re), f64::from(v.im)))
        .collect();
    reference::relative_l2(&image, &expected).unwrap()
}

fn level_ground_keeps_the_accuracy(simd: SimdLevel) {
    let mut r = Random(40);
    for seed in 0..12 {
        let height_m = 0.3 * (25.0f64 / 0.3).powf(r.next().abs());
        let depth_m = 0.02 * 100f64.powf(r.next().abs());
        let top = Layer {
            soil: soil(2.0 + 6.0 * r.next().abs(), 0.0),
            thickness_m: 0.5 * depth_m,
        };
        let last = Layer::below_all(soil(2.0 + 14.0 * r.next().abs(), 0.002 * (seed % 2) as f64));
        let both = [top, last];
        let layers = if seed % 3 == 0 { &both[..] } else { &both[1..] };
        let scene = Scene::new(height_m, depth_m, level(layers), 0.0, 100 + seed);
        let grid = PlaneGrid::new([-0.3, -0.25, -depth_m], 0.02, [37, 29]).unwrap();
        let accuracy = [1e-2, 1e-3, 1e-4][seed as usize % 3];
        let spreading = [Spreading::InverseSquare, Spreading::None][seed as usize / 2 % 2];
        let options = PlanOptions::default()
            .with_level(simd)
            .with_accuracy(accuracy)
            .with_spreading(spreading);
        let (error, engine) = error(scene.pulses(), grid, &options);
        assert!(
            error <= accuracy,
            "{simd:?} {seed}: h {height_m:.2} d {depth_m:.3} {error:.2e} of {accuracy:e} by {engine:?}"
        );
        // Conductive soil may leave the tables, whose absorption is that of one frequency.
        assert!(
            engine == Engine::Direct || seed % 2 == 1,
            "{seed} {engine:?}"
        );
    }
}

fn rays_of_pixels_keep_the_accuracy(simd: SimdLevel) {
    let waves = |k: usize| {
        let (x, y) = ((k % 81) as f64 * 0.05 - 2.0, (k / 81) as f64 * 0.05 - 2.0);
        0.03 * (9.0 * x).sin() * (7.0 * y + 0.4).cos()
    };
    let relief = Relief::new([-2.0; 2], 0.05, 81, (0..81 * 81).map(waves).collect()).unwrap();
    let uneven = Ground::new(
        Surface::Relief(relief),
        &[Layer::below_all(soil(4.0, 0.0))],
        1.5e9,
    )
    .unwrap();
    let cases = [
        (Some(uneven.clone()), 0.0),
        (Some(uneven), 0.06),
        (level(&[Layer::below_all(soil(6.0, 0.001))]), 0.1),
        (None, 0.06),
    ];
    for (seed, (ground, apart_m)) in cases.into_iter().enumerate() {
        let scene = Scene::new(0.8, 0.25, ground, apart_m, 7 + seed as u64);
        let grid = PlaneGrid::new([-0.2, -0.2, -0.25], 0.04, [11, 9]).unwrap();
        let options = PlanOptions::default().with_level(simd).with_accuracy(1e-3);
        let (error, engine) = error(scene.pulses(), grid, &options);
        assert!(error <= 1e-3, "{simd:?} {seed} {error:.2e} by {engine:?}");
    }
}

/// Images of drawn scenes by the engines that count, and those that break their accuracy.
#[derive(Default)]
struct Drawn {
    made: u64,
    /// Largest error relative to the accuracy among the images by these engines.
    worst: f64,
    broken: Vec<String>,
}

impl Drawn {
    /// Adds an image of a scene; `place` says which scene it is.
    fn add(
        &mut self,
        (scene, grid): (&Scene, PlaneGrid),
        options: &PlanOptions,
        (counted, place): (&[Engine], String),
    ) {
        let (error, engine) = error(scene.pulses(), grid, options);
        let accuracy = options.accuracy;
        if error > accuracy {
            (self.broken).push(format!(
                "{place}: {error:.2e} of {accuracy:e} by {engine:?}"
            ));
        }
        if counted.contains(&engine) {
            self.made += 1;
            self.worst = self.worst.max(error / accuracy);
        }
    }

    /// No image is broken, and most of `scenes` are by engines that count.
    fn judge(&self, simd: SimdLevel, scenes: u64) {
        let Self {
            made,
            worst,
            broken,
        } = self;
        println!(
            "{simd:?}: {made} of {scenes} counted, with errors up to {worst:.2} of the accuracy"
        );
        assert!(broken.is_empty(), "{simd:?}: {broken:#?}");
        assert!(2 * made > scenes, "{made}");
    }
}

/// Antennas apart over level ground: from the surface to 25 m high, to slices from 2 cm to 2 m deep, in air of one height or of
/// separate ones. `DRAWN_SCENES=500 cargo test --test ground apart_over -- --nocapture` draws more scenes.
fn antennas_apart_over_level_ground_keep_the_accuracy(simd: SimdLevel) {
    let scenes = std::env::var("DRAWN_SCENES").map_or(12, |n| n.parse().unwrap());
    let mut drawn = Drawn::default();
    for seed in 0..scenes {
        let mut r = Random(4000 + seed);
        let height_m = 0.01 * 2500f64.powf(r.next().abs());
        let depth_m = 0.02 * 100f64.powf(r.next().abs());
        let apart_m = 0.5 * r.next().powi(2);
        let pixel_m = 0.005 * 10f64.powf(r.next().abs());
        let top = Layer {
            soil: soil(2.0 + 6.0 * r.next().abs(), 0.0),
            thickness_m: 0.5 * depth_m,
        };
        let loss_s_m = 0.001 * (seed % 4 / 3) as f64;
        let last = Layer::below_all(soil(2.0 + 14.0 * r.next().abs(), loss_s_m));
        let both = [top, last];
        let layers = if seed % 3 == 0 { &both[..] } else { &both[1..] };
        let mut scene = Scene::new(height_m, depth_m, level(layers), apart_m, 900 + seed);
        if seed % 2 == 0 {
            // A cart: all antennas at one height.
            for antenna_m in (scene.transmitter_m.iter_mut()).chain(&mut scene.receiver_m) {
                antenna_m[2] = height_m;
            }
        }
        let size = [37 + 16 * (seed as usize % 3), 29];
        let origin_m = [
            -0.5 * pixel_m * size[0] as f64,
            -0.5 * pixel_m * size[1] as f64,
            -depth_m,
        ];
        let grid = PlaneGrid::new(origin_m, pixel_m, size).unwrap();
        let accuracy = [1e-3, 1e-2, 1e-4][seed as usize % 3];
        let spreading = [Spreading::InverseSquare, Spreading::None][usize::from(seed % 5 == 4)];
        let options = PlanOptions::default()
            .with_level(simd)
            .with_accuracy(accuracy)
            .with_spreading(spreading);
        let place = format!("{seed}: {height_m:.3} m high, {depth_m:.3} m deep");
        drawn.add((&scene, grid), &options, (&[Engine::Direct], place));
    }
    drawn.judge(simd, scenes);
}

/// Heights about 0 at the nodes of a raster of `step_m`: waves in all directions, from four nodes to forty long, with slopes
/// of the root mean square `slope`, and heights without order as a tenth of these.
fn uneven(step_m: f64, slope: f64, r: &mut Random) -> Surface {
    let waves: Vec<[f64; 3]> = (0..5)
        .map(|_| {
            let turns = std::f64::consts::TAU / (step_m * 4.0 * 10f64.powf(r.next().abs()));
            let angle = 4.0 * r.next();
            [turns * angle.cos(), turns * angle.sin(), 4.0 * r.next()]
        })
        .collect();
    // Each wave has its share of the slopes' variance.
    let amplitude_m = |[a, b, _]: &[f64; 3]| slope * (2.0 / 5.0f64).sqrt() / a.hypot(*b);
    let side = 121;
    let first_m = -0.5 * step_m * (side - 1) as f64;
    let heights_m = (0..side * side).map(|k| {
        let [x, y] = [k % side, k / side].map(|at| first_m + step_m * at as f64);
        let height_m =
            |wave: &[f64; 3]| amplitude_m(wave) * (wave[0] * x + wave[1] * y + wave[2]).sin();
        waves.iter().map(height_m).sum::<f64>() + 0.03 * slope * step_m * r.next()
    });
    let heights_m = heights_m.collect();
    Surface::Relief(Relief::new([first_m; 2], step_m, side, heights_m).unwrap())
}

/// Uneven ground with slopes to 20° (root mean square), from 0.3 to 25 m below one antenna or two, along lines and at
/// positions without order, at slices through the surface and down to 2 m below it.
/// `DRAWN_SCENES=500 cargo test --test ground uneven -- --nocapture` draws more scenes.
fn uneven_ground_keeps_the_accuracy(simd: SimdLevel) {
    let scenes = std::env::var("DRAWN_SCENES").map_or(6, |n| n.parse().unwrap());
    let mut drawn = Drawn::default();
    for seed in 0..scenes {
        let mut r = Random(7000 + seed);
        let height_m = 0.3 * (25.0f64 / 0.3).powf(r.next().abs());
        let depth_m = 2.0 * r.next().powi(2);
        let step_m = 0.02 * 5f64.powf(r.next().abs());
        let slope = r.next().abs() * 20f64.to_radians().tan();
        let slope = slope.min(0.1 * height_m / step_m);
        let surface = uneven(step_m, slope, &mut r);
        let loss_s_m = 0.001 * (seed % 4 / 3) as f64;
        let layers = [Layer::below_all(soil(
            2.0 + 14.0 * r.next().abs(),
            loss_s_m,
        ))];
        let top_m = surface.span_m()[1];
        let ground = Some(Ground::new(surface, &layers, 1.5e9).unwrap());
        let apart_m = 0.3 * r.next() * (seed / 2 % 2) as f64;
        let motion_m = 0.05 * height_m * r.next().abs();
        let height_m = height_m.max(top_m + 0.1);
        let scene = if seed % 3 == 2 {
            Scene::new(height_m, depth_m, ground, apart_m.abs(), 300 + seed)
        } else {
            // A flight with the jitter of a multicopter.
            let jitter_m = 0.002 * (seed % 3) as f64;
            let place_m = |m: i32| {
                let s = f64::from(m - 20);
                [
                    motion_m * s + jitter_m * r.next(),
                    0.1 * motion_m * (0.3 * s).sin() + jitter_m * r.next(),
                    height_m * (1.0 + 0.01 * (0.2 * s).cos()) + jitter_m * r.next(),
                ]
            };
            let position_m = (0..40).map(place_m).collect();
            Scene::seen_from(
                position_m,
                depth_m,
                ground,
                apart_m.abs(),
                Random(300 + seed),
            )
        };
        let mut r = Random(5000 + seed);
        let pixel_m = 0.003 * 10f64.powf(r.next().abs());
        let size = [37, 29];
        let origin_m = [
            -0.5 * pixel_m * size[0] as f64,
            -0.5 * pixel_m * size[1] as f64,
            -depth_m,
        ];
        let grid = PlaneGrid::new(origin_m, pixel_m, size).unwrap();
        let accuracy = [1e-3, 1e-2, 1e-4][seed as usize % 5 % 3];
        let spreading = [Spreading::InverseSquare, Spreading::None][usize::from(seed % 5 == 4)];
        let options = PlanOptions::default()
            .with_level(simd)
            .with_accuracy(accuracy)
            .with_spreading(spreading);
        let place = format!("{seed}: {height_m:.3} m high, {depth_m:.3} m deep");
        drawn.add(
            (&scene, grid),
            &options,
            (&[Engine::Direct, Engine::Double], place),
        );
    }
    drawn.judge(simd, scenes);
}

/// Below gentle ground most pixels are summed over squares, with antennas together and apart.
fn gentle_ground_is_summed_over_squares(simd: SimdLevel) {
    let height_m = |k: usize| {
        let (x, y) = ((k % 121) as f64 * 0.05 - 3.0, (k / 121) as f64 * 0.05 - 3.0);
        0.03 * (2.1 * x).sin() * (2.5 * y + 1.0).cos() + 0.05 * x
    };
    for apart_m in [0.0, 0.15] {
        let heights_m = (0..121 * 121).map(height_m).collect();
        let surface = Surface::Relief(Relief::new([-3.0; 2], 0.05, 121, heights_m).unwrap());
        let ground = Ground::new(surface, &[Layer::below_all(soil(6.0, 0.0))], 1.5e9).unwrap();
        let place_m = |m: i32| {
            let s = 0.02 * f64::from(m - 40);
            [s, 0.05 * (3.0 * s).sin(), 1.0 + 0.02 * (5.0 * s).cos()]
        };
        let position_m = (0..80).map(place_m).collect();
        let scene = Scene::seen_from(position_m, 0.3, Some(ground), apart_m, Random(77));
        let grid = PlaneGrid::new([-0.4, -0.3, -0.3], 0.01, [80, 61]).unwrap();
        let options = PlanOptions::default().with_level(simd);
        let plan = ImagingPlan::new(scene.pulses(), grid, &options).unwrap();
        let paths = plan.report().decisions.iter().rev().find_map(|d| match d {
            Decision::Direct(choice) => choice.paths,
            _ => None,
        });
        assert_eq!(plan.engine(), Engine::Direct, "{simd:?} {plan}");
        assert!(paths.unwrap().windowed > 0.8, "{simd:?} {plan}");
        let (error, _) = error(scene.pulses(), grid, &options);
        assert!(error <= 1e-3, "{simd:?}: {error:.2e}");
    }
}

at_every_level!(
    level_ground_keeps_the_accuracy,
    uneven_ground_keeps_the_accuracy,
    gentle_ground_is_summed_over_squares,
    antennas_apart_over_level_ground_keep_the_accuracy,
    rays_of_pixels_keep_the_accuracy
);

#[test]
fn strong_losses_are_summed_by_frequency() {
    let wet = level(&[Layer::below_all(soil(9.0, 0.5))]);
    let scene = Scene::new(1.0, 0.15, wet, 0.0, 3);
    let grid = PlaneGrid::new([-0.2, -0.2, -0.15], 0.04, [11, 9]).unwrap();
    let (error, engine) = error(scene.pulses(), grid, &PlanOptions::default());
    assert!(error <= 1e-3, "{error:e}");
    assert_eq!(engine, Engine::Reference);
}

#[test]
fn incidence_counts_where_rays_leave_the_antenna() {
    let weight = IncidenceWeight {
        max_rad: 0.6,
        taper_rad: 0.3,
        cosine_power: 2.0,
    };
    let scene = Scene::new(1.0, 0.3, level(&[Layer::below_all(soil(9.0, 0.0))]), 0.0, 5);
    let grid = PlaneGrid::new([-0.2, -0.2, -0.3], 0.04, [11, 9]).unwrap();
    let options = PlanOptions::default().with_incidence(Some(weight));
    let plan = ImagingPlan::new(scene.pulses(), grid, &options).unwrap();
    assert_eq!(plan.engine(), Engine::Direct);
    let mut image = vec![Complex32::ZERO; plan.pixels()];
    plan.run(&mut image, Control::default()).unwrap();
    let pulses = scene.pulses();
    // One pulse after another, each weighted by its own angle.
    let one = |k: usize| -> Complex64 {
        (0..pulses.len())
            .map(|m| {
                let point = grid.point_m(k);
                let cosine = -pulses.rays(m, point)[0].departure[2];
                let of_pulse = pulses.slice(m..m + 1).unwrap();
                let spreading = Spreading::InverseSquare;
                reference::adjoint(&of_pulse, &[point], spreading).unwrap()[0]
                    * weight.at(cosine.acos())
            })
            .sum()
    };
    let (mut difference, mut power) = (0.0, 0.0);
    for (k, v) in image.iter().enumerate() {
        let expected = one(k);
        let found = Complex64::new(f64::from(v.re), f64::from(v.im));
        difference += (found - expected).norm_sqr();
        power += expected.norm_sqr();
    }
    assert!(
        difference <= 1e-6 * power,
        "{:e}",
        (difference / power).sqrt()
    );
}

/// Slices below the surface, in it and above share a plan.
#[test]
fn slices_of_a_volume_share_plans() {
    let scene = Scene::new(1.2, 0.2, level(&[Layer::below_all(soil(5.0, 0.0))]), 0.0, 8);
    let base = PlaneGrid::new([-0.2, -0.2, -0.3], 0.02, [25, 21]).unwrap();
    let volume = VolumeGrid::new(base, 0.1, 5).unwrap();
    let (pulses, options) = (scene.pulses(), PlanOptions::default());
    let mut slices = 0;
    let run = image_volume_planned_once(
        &volume,
        pulses,
        &options,
        Control::default(),
        |k, grid, image| {
            let error = deviation(&pulses, grid, image, options.spreading);
            assert!(error <= 1e-3, "{k} {error:e}");
            slices += 1;
            Ok::<_, ImagingError>(())
        },
    )
    .unwrap();
    assert_eq!(slices, 5);
    assert!(run.plans.len() < 5, "{:?}", run.plans);
    assert_eq!(run.report.engine, Engine::Direct);
}

#[test]
fn the_forward_operator_is_the_transpose() {
    for apart_m in [0.0, 0.08] {
        let layers = [Layer::below_all(soil(5.0, 0.02))];
        let scene = Scene::new(1.0, 0.2, level(&layers), apart_m, 21);
        let pulses = scene.pulses();
        let grid = PlaneGrid::new([-0.1, -0.1, -0.2], 0.04, [7, 5]).unwrap();
        let options = PlanOptions::default().with_engine(Engine::Reference);
        let forward = Forward::new(pulses, grid, &options).unwrap();
        let mut r = Random(2);
        let sigma: Vec<Complex32> = (0..grid.len())
            .map(|_| Complex32::new(r.next() as f32, r.next() as f32))
            .collect();
        let mut modelled = vec![Complex64::ZERO; scene.spectrum.len()];
        forward
            .run(&sigma, &mut modelled, Control::default())
            .unwrap();
        let points: Vec<_> = (0..grid.len()).map(|k| grid.point_m(k)).collect();
        let image = reference::adjoint(&pulses, &points, options.spreading).unwrap();
        let left: Complex64 = modelled
            .iter()
            .zip(&scene.spectrum)
            .map(|(a, b)| a.conj() * b)
            .sum();
        let right: Complex64 = (sigma.iter().zip(&image))
            .map(|(a, b)| Complex64::new(f64::from(a.re), -f64::from(a.im)) * b)
            .sum();
        assert!(
            (left - right).norm() < 1e-10 * left.norm(),
            "{left} {right}"
        );
    }
}

/// Transmitter and receiver 6 cm apart, 0.3 m over a reflector.
#[test]
fn reflectors_stand_where_they_are_with_antennas_apart() {
    let along: Vec<f64> = (0..81).map(|m| 0.01 * f64::from(m) - 0.4).collect();
    let transmitter_m: Vec<[f64; 3]> = along.iter().map(|x| [x - 0.03, 0.0, 0.3]).collect();
    let receiver_m: Vec<[f64; 3]> = along.iter().map(|x| [x + 0.03, 0.0, 0.3]).collect();
    let position_m: Vec<[f64; 3]> = along.iter().map(|x| [*x, 0.0, 0.3]).collect();
    let frequency_hz: Vec<f64> = (0..80).map(|n| 0.5e9 + 2.5e7 * f64::from(n)).collect();
    // Echoes by the distances themselves.
    let target = [0.052, 0.0, 0.0];
    let distance = |a: &[f64; 3]| (a[0] - target[0]).hypot(a[2] - target[2]);
    let mut spectrum = Vec::new();
    for (t, r) in transmitter_m.iter().zip(&receiver_m) {
        let both_m = distance(t) + distance(r);
        let echo = |f: &f64| Complex64::cis(-std::f64::consts::TAU * f * both_m / C);
        spectrum.extend(frequency_hz.iter().map(echo));
    }
    let weight = vec![1.0; along.len()];
    let peak = |position_m: &[[f64; 3]], is_apart: bool| {
        let mut pulses = Pulses::new(PulseArrays {
            position_m,
            frequency_hz: &frequency_hz,
            spectrum: &spectrum,
            weight: &weight,
            light_speed_m_s: C,
        })
        .unwrap();
        if is_apart {
            pulses = pulses.with_antennas(&transmitter_m, &receiver_m).unwrap();
        }
        let mut best = (0.0, [0.0; 2]);
        for k in -20..=20 {
            let z_m = 0.002 * f64::from(k);
            let grid = PlaneGrid::new([0.0, 0.0, z_m], 0.002, [61, 1]).unwrap();
            let options = PlanOptions::default().with_spreading(Spreading::None);
            let plan = ImagingPlan::new(pulses, grid, &options).unwrap();
            let mut image = vec![Complex32::ZERO; plan.pixels()];
            plan.run(&mut image, Control::default()).unwrap();
            for (i, v) in image.iter().enumerate() {
                if f64::from(v.norm()) > best.0 {
                    best = (f64::from(v.norm()), [0.002 * i as f64, z_m]);
                }
            }
        }
        best
    };
    let (level, [x_m, z_m]) = peak(&position_m, true);
    assert!(
        (x_m - 0.052).abs() < 0.005 && z_m.abs() < 0.005,
        "{x_m} {z_m}"
    );
    // All pulses and frequencies in phase.
    assert!((level / spectrum.len() as f64 - 1.0).abs() < 1e-3);
    let (_, [x_m, _]) = peak(&transmitter_m, false);
    assert!((x_m - 0.052).abs() > 0.02, "{x_m}");
}

#[test]
fn antennas_in_the_ground_and_wrong_numbers_of_them_are_refused() {
    let scene = Scene::new(1.0, 0.2, level(&[Layer::below_all(soil(5.0, 0.0))]), 0.0, 1);
    let high = Ground::new(
        Surface::Level { z_m: 1.0 },
        &[Layer::below_all(soil(5.0, 0.0))],
        1e9,
    )
    .unwrap();
    assert!(scene.pulses().with_ground(&high).is_err());
    let few = &scene.transmitter_m[1..];
    assert!(
        scene
            .pulses()
            .with_antennas(few, &scene.receiver_m)
            .is_err()
    );
    let far: Vec<_> = scene
        .receiver_m
        .iter()
        .map(|p| [p[0] + 200.0, p[1], p[2]])
        .collect();
    assert!(
        scene
            .pulses()
            .with_antennas(&scene.transmitter_m, &far)
            .is_err()
    );
}
