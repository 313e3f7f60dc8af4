//! Terrain beside the plane: 1800 × 1800 pixels of 1 cm, 331 pulses.
//!
//! `cargo bench -p acerra-imaging --bench surface` prints, for every SIMD level, accuracy, engine and ground,
//! Gbp/s (10⁹ pixel × pulse contributions a second) on one thread and on all, the share of the plane's speed, and
//! what the self-check found. Best of three runs. The name of a level, of an engine (`auto`, `direct`) or of a
//! ground as argument leaves the others out, `plan` prints the plans.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

use acerra_imaging::{
    Complex32, Complex64, Control, Engine, ImagingError, ImagingPlan, PlanOptions, PlaneGrid,
    PulseArrays, Pulses, SPEED_OF_LIGHT_M_S, SimdLevel, SurfaceGrid,
};
use std::time::Instant;

fn main() {
    let position_m: Vec<[f64; 3]> = (0..331)
        .map(|m| {
            let s = f64::from(m) / 330.0;
            let waver = |f: f64| 0.05 * (f * s).sin();
            [waver(9.0), -4.0 + 8.0 * s, 5.0 + waver(7.0)]
        })
        .collect();
    let frequency_hz: Vec<f64> = (0..213)
        .map(|n| 3.95e9 + 8e6 * (f64::from(n) - 106.0))
        .collect();
    let mut state = 1_u64;
    let mut random = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let spectrum: Vec<Complex64> = (0..331 * 213)
        .map(|_| Complex64::new(random(), random()))
        .collect();
    let weight = vec![1.0; 331];
    let pulses = Pulses::new(PulseArrays {
        position_m: &position_m,
        frequency_hz: &frequency_hz,
        spectrum: &spectrum,
        weight: &weight,
        light_speed_m_s: SPEED_OF_LIGHT_M_S,
    })
    .unwrap();
    let base = PlaneGrid::new([-9.0, -9.0, 0.0], 0.01, [1800, 1800]).unwrap();
    // A field as a height raster of 1 m gives it, linear and cubic between the knots.
    let field = SurfaceGrid::from_fn(base, |x, y| {
        Ok::<_, ImagingError>(bilinear(1.0, [x, y], field_m))
    });
    let field = field.unwrap();
    let smooth = SurfaceGrid::from_fn(base, |x, y| Ok::<_, ImagingError>(cubic([x, y], field_m)));
    let smooth = smooth.unwrap();
    let knot = |i: f64, j: f64| 0.35 * (1.1 * i + 0.7 * j).sin() + 0.15 * (1.9 * j).cos();
    let facets = SurfaceGrid::from_fn(base, |x, y| {
        Ok::<_, ImagingError>(bilinear(0.5, [x, y], knot))
    })
    .unwrap();
    let wave = |x: f64, y: f64| Ok::<_, ImagingError>(0.5 * (1.2 * x + 0.5 * y).sin());
    let wave = SurfaceGrid::from_fn(base, wave).unwrap();
    let contributions = 1e-9 * (base.len() * pulses.len()) as f64;
    // A level's name as argument leaves the others out, and so does an engine's.
    let arguments: Vec<String> = std::env::args().collect();
    let named = |name: &str| arguments.iter().any(|a| a == name);
    let levels = SimdLevel::available().iter().copied();
    let one_level = levels.clone().any(|level| named(level.name()));
    let engines = [("auto", Engine::Auto), ("direct", Engine::Direct)];
    let one_engine = engines.iter().any(|(name, _)| named(name));
    let one_ground = ["field", "smooth", "facets", "wave"].into_iter().any(named);
    for level in levels.filter(|l| !one_level || named(l.name())) {
        for (accuracy, (_, engine)) in [1.3e-3, 3.2e-4]
            .into_iter()
            .flat_map(|accuracy| engines.map(|engine| (accuracy, engine)))
            .filter(|(_, (name, _))| !one_engine || named(name))
        {
            let mut of_plane = [0.0; 2];
            for (name, ground) in [
                ("plane", None),
                ("field", Some(&field)),
                ("smooth", Some(&smooth)),
                ("facets", Some(&facets)),
                ("wave", Some(&wave)),
            ] {
                if one_ground && !named(name) && ground.is_some() {
                    continue;
                }
                let options = PlanOptions::default()
                    .with_accuracy(accuracy)
                    .with_level(level)
                    .with_engine(engine);
                let start = Instant::now();
                let plan = match ground {
                    Some(surface) => ImagingPlan::new(pulses, surface, &options),
                    None => ImagingPlan::new(pulses, base, &options),
                }
                .unwrap();
                let planned_s = start.elapsed().as_secs_f64();
                let foretold = contributions / plan.estimate_run_time_s(Control::default());
                let mut image = vec![Complex32::ZERO; base.len()];
                let mut speed = [0.0; 2];
                for (k, threads) in [(0, 1), (1, 0)] {
                    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
                    let pool = pool.build().unwrap();
                    let mut best = f64::INFINITY;
                    for _ in 0..3 {
                        let start = Instant::now();
                        pool.install(|| plan.run(&mut image, Control::default()))
                            .unwrap();
                        best = best.min(start.elapsed().as_secs_f64());
                    }
                    speed[k] = contributions / best;
                }
                if ground.is_none() {
                    of_plane = speed;
                }
                println!(
                    "{level:9} {accuracy:.1e} {:10} {name:6}: {:.2} Gbp/s on one thread ({:.0} %), {:.2} on all \
                     ({:.0} %, {foretold:.2} foretold), planned in {planned_s:.2} s, self-check {:.1e}",
                    format!("{:?}", plan.engine()),
                    speed[0],
                    100.0 * speed[0] / of_plane[0],
                    speed[1],
                    100.0 * speed[1] / of_plane[1],
                    plan.self_check().map_or(f64::NAN, |c| c.error)
                );
                if named("plan") {
                    println!("{plan}");
                }
            }
        }
    }
}

/// Heights between the knots of a raster with cells of `cell_m`.
fn bilinear(cell_m: f64, at_m: [f64; 2], knot: impl Fn(f64, f64) -> f64) -> f64 {
    let [i, j] = at_m.map(|x| x / cell_m);
    let (i0, j0) = (i.floor(), j.floor());
    let (u, v) = (i - i0, j - j0);
    let low = knot(i0, j0) * (1.0 - u) + knot(i0 + 1.0, j0) * u;
    let high = knot(i0, j0 + 1.0) * (1.0 - u) + knot(i0 + 1.0, j0 + 1.0) * u;
    low * (1.0 - v) + high * v
}

/// Heights by cubic convolution between knots a metre apart.
fn cubic([x, y]: [f64; 2], knot: impl Fn(f64, f64) -> f64) -> f64 {
    let weights = |u: f64| {
        [
            u * (-0.5 + u * (1.0 - 0.5 * u)),
            1.0 + u * u * (-2.5 + 1.5 * u),
            u * (0.5 + u * (2.0 - 1.5 * u)),
            u * u * (-0.5 + 0.5 * u),
        ]
    };
    let (i0, j0) = (x.floor(), y.floor());
    let mut sum = 0.0;
    for (b, across) in (-1..3).zip(weights(y - j0)) {
        for (a, along) in (-1..3).zip(weights(x - i0)) {
            sum += along * across * knot(i0 + f64::from(a), j0 + f64::from(b));
        }
    }
    sum
}

/// Heights of the knots of a field: a knoll of 1 m, and random heights of ±10 cm.
fn field_m(i: f64, j: f64) -> f64 {
    let noise = (12.9898 * i + 78.233 * j).sin() * 43_758.545_3;
    (-0.02 * (i * i + j * j)).exp() + 0.2 * (noise - noise.floor() - 0.5)
}
