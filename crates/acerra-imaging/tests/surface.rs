//! Images on the ground: the accuracy holds at every SIMD level, and targets stand where they are.
#![allow(clippy::unwrap_used)]

mod common;
use common::{C, Campaign, Random, band};

use acerra_imaging::{
    Complex32, Complex64, Control, Engine, ImagingError, ImagingPlan, PlanOptions, PlaneGrid,
    SimdLevel, Spreading, SurfaceGrid, reference, resolution,
};

/// Pulses scattered about a patch at `range_m`, and eight targets up to 0.4 m high in it.
fn random(range_m: f64, pulses: usize, seed: u64) -> Campaign {
    let mut r = Random(seed);
    let position: Vec<_> = (0..pulses)
        .map(|_| {
            [
                -0.6 * range_m + r.next(),
                2.0 * r.next(),
                0.8 * range_m + 0.3 * r.next(),
            ]
        })
        .collect();
    let scene: Vec<_> = (0..8)
        .map(|_| [0.6 * r.next(), 0.6 * r.next(), 0.4 * r.next()])
        .collect();
    Campaign::new(position, band(80), &scene, seed ^ 77)
}

/// Ground with 1 m of relief: `cell_m` wide facets as a height raster gives them, or a smooth wave.
#[derive(Clone, Copy)]
enum Ground {
    Facets {
        cell_m: f64,
    },
    Wave {
        length_m: f64,
    },
    /// Every pixel at a height of its own, up to so many metres.
    Noise {
        height_m: f64,
    },
}

fn surface(base: PlaneGrid, ground: Ground) -> SurfaceGrid {
    let mut random = Random(5);
    let knot = |i: f64, j: f64| 0.5 * (1.7 * i + 0.9 * j).sin() + 0.2 * (2.9 * j).cos();
    SurfaceGrid::from_fn(base, |x, y| {
        Ok::<_, ImagingError>(match ground {
            Ground::Facets { cell_m } => {
                let (i, j) = (x / cell_m, y / cell_m);
                let (i0, j0) = (i.floor(), j.floor());
                let (u, v) = (i - i0, j - j0);
                let low = knot(i0, j0) * (1.0 - u) + knot(i0 + 1.0, j0) * u;
                let high = knot(i0, j0 + 1.0) * (1.0 - u) + knot(i0 + 1.0, j0 + 1.0) * u;
                low * (1.0 - v) + high * v
            }
            Ground::Wave { length_m } => {
                0.5 * (std::f64::consts::TAU * (x + 0.4 * y) / length_m).sin()
            }
            Ground::Noise { height_m } => height_m * random.next(),
        })
    })
    .unwrap()
}

fn check(data: &Campaign, surface: &SurfaceGrid, options: &PlanOptions) -> Engine {
    let pulses = data.pulses();
    let plan = ImagingPlan::new(pulses, surface, options).unwrap();
    let mut image = vec![Complex32::ZERO; plan.pixels()];
    plan.run(&mut image, Control::default()).unwrap();
    let points: Vec<_> = (0..surface.len()).map(|k| surface.point_m(k)).collect();
    let expected = reference::adjoint(&pulses, &points, options.spreading).unwrap();
    let image: Vec<_> = image
        .iter()
        .map(|v| Complex64::new(f64::from(v.re), f64::from(v.im)))
        .collect();
    let found = reference::relative_l2(&image, &expected).unwrap();
    assert!(
        found <= options.accuracy,
        "{found:e} for {:e}\n{plan}",
        options.accuracy
    );
    plan.engine()
}

/// Makes one test a level: `name(level)` at all levels of this processor.
macro_rules! at_every_level {
    ($($name:ident),* $(,)?) => {
        mod every_level {
            $(#[test] fn $name() {
                for &level in acerra_imaging::SimdLevel::available() {
                    super::$name(level);
                }
            })*
        }
    };
}

at_every_level!(
    the_accuracy_holds_on_any_ground_at_any_range,
    large_pixels,
    one_pulse_one_pixel_one_row,
    pulses_on_and_just_above_the_ground,
    repeated_positions,
);

fn the_accuracy_holds_on_any_ground_at_any_range(level: SimdLevel) {
    let grounds = [
        Ground::Facets { cell_m: 0.25 },
        Ground::Wave { length_m: 3.0 },
        Ground::Noise { height_m: 0.003 },
        Ground::Noise { height_m: 0.3 },
    ];
    for (range_m, seed) in [(3.0, 1), (100.0, 3), (3000.0, 4)] {
        let data = random(range_m, 30, seed);
        let base = PlaneGrid::new([-0.4, -0.2, 0.0], 0.01, [83, 37]).unwrap();
        for ground in grounds {
            let surface = surface(base, ground);
            for accuracy in [1e-2, 1e-3, 1e-4, 1e-5] {
                let options = PlanOptions::default()
                    .with_accuracy(accuracy)
                    .with_level(level);
                let engine = check(&data, &surface, &options);
                if accuracy > 5e-5 {
                    assert_eq!(engine, Engine::Direct);
                }
            }
        }
    }
}

fn large_pixels(level: SimdLevel) {
    let data = random(8.0, 25, 5);
    let base = PlaneGrid::new([-3.0, -3.0, 0.3], 0.15, [70, 40]).unwrap();
    for ground in [
        Ground::Facets { cell_m: 1.0 },
        Ground::Wave { length_m: 4.0 },
    ] {
        for accuracy in [1e-3, 1e-5] {
            let options = PlanOptions::default()
                .with_accuracy(accuracy)
                .with_level(level);
            check(&data, &surface(base, ground), &options);
        }
    }
}

fn one_pulse_one_pixel_one_row(level: SimdLevel) {
    let options = PlanOptions::default().with_level(level);
    for pulses in [1, 33] {
        let data = random(5.0, pulses, 7);
        for (nx, ny) in [(1, 1), (1, 300), (300, 1), (9, 2), (700, 3)] {
            let base = PlaneGrid::new([-0.5, -0.5, 0.0], 0.01, [nx, ny]).unwrap();
            check(
                &data,
                &surface(base, Ground::Facets { cell_m: 0.3 }),
                &options,
            );
        }
    }
}

fn pulses_on_and_just_above_the_ground(level: SimdLevel) {
    let base = PlaneGrid::new([-0.3, -0.3, 0.0], 0.01, [61, 61]).unwrap();
    let ground = surface(base, Ground::Wave { length_m: 2.0 });
    for height in [0.0, 0.02, 0.5] {
        // Along the ground, half a pixel off the centres.
        let position: Vec<_> = (0..25)
            .map(|m| {
                let (x, y) = (0.005, -0.3 + 0.0237 * f64::from(m));
                [x, y, ground.height_m(x, y) + height]
            })
            .collect();
        let data = Campaign::new(position, band(80), &[[0.2, 0.1, 0.1]], 9);
        for (accuracy, spreading) in [(1e-3, Spreading::InverseSquare), (1e-4, Spreading::None)] {
            let options = PlanOptions::default()
                .with_accuracy(accuracy)
                .with_spreading(spreading)
                .with_level(level);
            check(&data, &ground, &options);
        }
    }
}

fn repeated_positions(level: SimdLevel) {
    let data = Campaign::new(vec![[0.0, 0.0, 4.0]; 40], band(80), &[[0.3, 0.0, 0.2]], 10);
    let base = PlaneGrid::new([-0.5, -0.5, 0.0], 0.02, [50, 50]).unwrap();
    let options = PlanOptions::default().with_level(level);
    check(
        &data,
        &surface(base, Ground::Facets { cell_m: 0.5 }),
        &options,
    );
}

#[test]
fn a_level_surface_is_the_plane() {
    let data = random(5.0, 30, 21);
    let base = PlaneGrid::new([-0.3, -0.3, 0.25], 0.01, [70, 40]).unwrap();
    let options = PlanOptions::default()
        .with_accuracy(1e-4)
        .with_engine(Engine::Direct);
    let plane = acerra_imaging::image(data.pulses(), base, &options, Control::default()).unwrap();
    let level = SurfaceGrid::new(base, &vec![0.25; base.len()]).unwrap();
    let plan = ImagingPlan::new(data.pulses(), &level, &options).unwrap();
    let mut image = vec![Complex32::ZERO; plan.pixels()];
    plan.run(&mut image, Control::default()).unwrap();
    let power: f32 = plane.iter().map(|v| v.norm_sqr()).sum();
    let apart: f32 = image
        .iter()
        .zip(&plane)
        .map(|(a, b)| (a - b).norm_sqr())
        .sum();
    assert!((apart / power).sqrt() < 2e-4, "{}", (apart / power).sqrt());
}

#[test]
fn an_antenna_on_a_pixel_is_refused_and_one_above_it_is_not() {
    let base = PlaneGrid::new([0.0, 0.0, 0.0], 0.25, [5, 5]).unwrap();
    let ground = SurfaceGrid::from_fn(base, |x, _| Ok::<_, ImagingError>(x)).unwrap();
    let options = PlanOptions::default();
    let at = ground.point_m(7);
    let on = Campaign::new(vec![at], band(80), &[[3.0, 0.0, 0.0]], 1);
    assert_eq!(
        ImagingPlan::new(on.pulses(), &ground, &options).unwrap_err(),
        ImagingError::ZeroRange { pulse: 0, point: 7 }
    );
    let above = Campaign::new(
        vec![[at[0], at[1], at[2] + 3.0]],
        band(80),
        &[[3.0, 0.0, 0.0]],
        1,
    );
    check(&above, &ground, &options);
}

#[test]
fn the_same_bits_on_any_number_of_threads() {
    let data = random(5.0, 40, 12);
    let base = PlaneGrid::new([-1.0, -1.0, 0.0], 0.01, [201, 90]).unwrap();
    let ground = surface(base, Ground::Facets { cell_m: 0.4 });
    let plan = ImagingPlan::new(data.pulses(), &ground, &PlanOptions::default()).unwrap();
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let mut image = vec![Complex32::ZERO; ground.len()];
        pool.install(|| plan.run(&mut image, Control::default()))
            .unwrap();
        image
    };
    assert_eq!(run(1), run(3));
}

/// Of 1.4 million pixels on smooth ground a boulder concerns one in five hundred: few random pixels meet it.
#[test]
fn a_boulder_on_smooth_ground_is_not_overlooked() {
    let position: Vec<_> = (0..160)
        .map(|m| [0.0, 0.03 * f64::from(m) - 2.4, 5.0])
        .collect();
    let data = Campaign::new(position, band(40), &[[1.0, 0.5, 0.1], [-3.0, 2.0, 0.0]], 31);
    let base = PlaneGrid::new([-6.0, -6.0, 0.0], 0.01, [1200, 1200]).unwrap();
    let ground = |boulder: Option<[f64; 3]>| {
        SurfaceGrid::from_fn(base, |x, y| {
            let on_it = |[a, b, _]: &[f64; 3]| (x - a).abs() < 0.05 && (y - b).abs() < 0.05;
            let boulder = boulder.filter(on_it).map_or(0.0, |b| b[2]);
            Ok::<_, ImagingError>(0.1 * (0.5 * x + 0.2 * y).sin() + boulder)
        })
        .unwrap()
    };
    let accuracy = 2e-3;
    let image = |surface: &SurfaceGrid, options: &PlanOptions| {
        let plan = ImagingPlan::new(data.pulses(), surface, options).unwrap();
        let mut image = vec![Complex32::ZERO; plan.pixels()];
        plan.run(&mut image, Control::default()).unwrap();
        (image, plan.engine())
    };
    let options = PlanOptions::default().with_accuracy(accuracy);
    assert_eq!(image(&ground(None), &options).1, Engine::Factorized);
    for place in [
        [2.33, -0.97, 0.3],
        [-1.2, 3.1, 0.3],
        [1.9, 1.7, 0.3],
        // Flat ones under the targets, where most of the image's power is.
        [1.0, 0.5, 0.03],
        [1.0, 0.5, 0.01],
        [1.0, 0.5, 0.005],
        [-3.0, 2.0, 0.005],
    ] {
        let rough = ground(Some(place));
        let (found, engine) = image(&rough, &options);
        let exact = options.with_accuracy(1e-4).with_engine(Engine::Direct);
        let (expected, _) = image(&rough, &exact);
        let power: f32 = expected.iter().map(|v| v.norm_sqr()).sum();
        let pairs = found.iter().zip(&expected);
        let error = (pairs.map(|(a, b)| (a - b).norm_sqr()).sum::<f32>() / power).sqrt();
        println!("{place:?}, {engine:?}: {error:e}");
        assert!(
            f64::from(error) < accuracy + 1e-4,
            "{place:?}, {engine:?}: {error:e}"
        );
    }
}

#[test]
fn targets_focus_on_the_ground_where_a_plane_misplaces_them() {
    // A track along y at x = 0, 5 m above a plane; the ground rises by a metre from x = 0.5 to x = 5.5.
    let height_m = 5.0;
    let rise =
        |x: f64| 0.5 - 0.5 * (std::f64::consts::PI * ((x - 0.5) / 5.0).clamp(0.0, 1.0)).cos();
    let position: Vec<_> = (0..201)
        .map(|m| [0.0, -2.0 + 0.02 * f64::from(m), height_m])
        .collect();
    let base = PlaneGrid::new([0.5, -0.4, 0.0], 0.02, [301, 41]).unwrap();
    let ground = SurfaceGrid::from_fn(base, |x, _| Ok::<_, ImagingError>(rise(x))).unwrap();
    for x in [3.0, 3.5, 4.2, 5.0] {
        let target = [x, 0.1, rise(x)];
        let mut data = Campaign::new(position.clone(), band(80), &[target], 1);
        data.spectrum = reference::forward(
            &position,
            &data.frequency_hz,
            &[reference::Scatterer {
                position_m: target,
                reflectivity: Complex64::ONE,
            }],
            C,
            Spreading::InverseSquare,
        )
        .unwrap();
        data.weight.fill(1.0);
        let options = PlanOptions::default();
        let peak = |image: &[Complex32]| {
            let best =
                (0..image.len()).max_by(|a, b| image[*a].norm().total_cmp(&image[*b].norm()));
            let k = best.unwrap();
            (
                [base.x_m(k % base.nx), base.y_m(k / base.nx)],
                image[k].norm(),
            )
        };
        let mut image = vec![Complex32::ZERO; base.len()];
        let plan = ImagingPlan::new(data.pulses(), &ground, &options).unwrap();
        plan.run(&mut image, Control::default()).unwrap();
        let (on_ground, level) = peak(&image);
        assert!(
            (on_ground[0] - x).abs() < 0.021 && (on_ground[1] - 0.1).abs() < 0.021,
            "{x}: {on_ground:?}"
        );
        let (on_plane, _) = peak(
            &acerra_imaging::image(data.pulses(), base, &options, Control::default()).unwrap(),
        );
        let offset = resolution::displacement_m(height_m - target[2], x, -target[2])
            .unwrap()
            .unwrap();
        assert!(
            (on_plane[0] - x - offset).abs() < 0.04 && offset < -0.5,
            "plane {on_plane:?}, Eq. (14) {offset}"
        );
        // On the ground every echo adds in phase: N Σ 1/R⁴.
        let ideal: f64 = position
            .iter()
            .map(|p| 80.0 * reference::range_m(*p, target).powi(-4))
            .sum();
        assert!(
            (f64::from(level) / ideal - 1.0).abs() < 1e-3,
            "{level} {ideal}"
        );
    }
}
