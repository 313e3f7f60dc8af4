//! Promises of accuracy on random scenes: all kinds of grids, pixels, tracks and frequencies, distances from
//! 1 m to 3 km, accuracies from 10⁻² to 10⁻⁷, at every SIMD level.
//!
//! `cargo bench -p acerra-imaging --bench random_scenes -- 1000` images as many scenes by every level and
//! compares all their pixels with the double-precision sum. It prints each promise that was broken, with
//! the number that draws its scene again (`-- 1 from=NUMBER`), and how close to the promise the errors came.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

use acerra_imaging::plan::Decision;
use acerra_imaging::{
    Complex32, Complex64, Control, Engine, ImageGrid, ImagingPlan, PlanOptions, PlaneGrid,
    PulseArrays, Pulses, SPEED_OF_LIGHT_M_S, SimdLevel, Spreading, SurfaceGrid, TiltedGrid,
    reference,
};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Terms of the double-precision sum that a scene may cost.
const MOST_TERMS: f64 = 1.5e8;

fn main() {
    if std::env::args().any(|a| a == "--test") {
        return;
    }
    let number = |a: String| a.parse::<u64>().ok();
    let count = std::env::args().find_map(number).unwrap_or(1000);
    let from = std::env::args().find_map(|a| a.strip_prefix("from=")?.parse().ok());
    let first: u64 = from.unwrap_or(0);
    let found: Vec<Found> = (first..first + count)
        .into_par_iter()
        .flat_map_iter(try_scene)
        .collect();
    for broken in found.iter().filter(|f| f.error > f.accuracy) {
        println!(
            "scene {}, {}: {:.2e} for {:.2e} ({}; {})\n{}",
            broken.number,
            broken.level,
            broken.error,
            broken.accuracy,
            broken.kind,
            broken.worst,
            broken.report
        );
    }
    tell(&found, count);
}

/// What an image kept of its promise.
struct Found {
    number: u64,
    level: SimdLevel,
    kind: String,
    engine: &'static str,
    accuracy: f64,
    error: f64,
    /// Where the error is.
    worst: String,
    report: String,
}

fn tell(found: &[Found], scenes: u64) {
    let broken = found.iter().filter(|f| f.error > f.accuracy).count();
    println!(
        "{scenes} scenes, {} images, {broken} broken promises",
        found.len()
    );
    println!("| engine, level | images | broken | median error / promise | largest |");
    println!("| --- | --- | --- | --- | --- |");
    let mut groups: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for f in found {
        let name = format!("{}, {}", f.engine, f.level);
        groups.entry(name).or_default().push(f.error / f.accuracy);
    }
    for (name, mut shares) in groups {
        shares.sort_by(f64::total_cmp);
        let broken = shares.iter().filter(|s| **s > 1.0).count();
        println!(
            "| {name} | {} | {broken} | {:.2} | {:.2} |",
            shares.len(),
            shares[shares.len() / 2],
            shares[shares.len() - 1]
        );
    }
}

/// Reproducible numbers.
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let x = (self.0 ^ (self.0 >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        ((x ^ (x >> 32)) >> 11) as f64 / (1u64 << 53) as f64
    }
    fn within(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.uniform()
    }
    fn log_within(&mut self, from: f64, to: f64) -> f64 {
        self.within(from.ln(), to.ln()).exp()
    }
    fn below(&mut self, n: usize) -> usize {
        ((self.uniform() * n as f64) as usize).min(n - 1)
    }
    fn normal(&mut self) -> f64 {
        (-2.0 * (self.uniform() + 1e-18).ln()).sqrt() * (TAU * self.uniform()).cos()
    }
    fn complex(&mut self) -> Complex64 {
        Complex64::new(self.normal(), self.normal())
    }
}

struct Scene {
    position_m: Vec<[f64; 3]>,
    frequency_hz: Vec<f64>,
    spectrum: Vec<Complex64>,
    weight: Vec<f64>,
    plane: TiltedGrid,
    surface: Option<SurfaceGrid>,
    spreading: Spreading,
    kind: String,
}

fn try_scene(number: u64) -> Vec<Found> {
    let mut random = Random(number.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x1234_5678);
    for _ in 0..8 {
        random.uniform();
    }
    let scene = draw(&mut random);
    let grid: ImageGrid = match &scene.surface {
        Some(surface) => surface.into(),
        None => scene.plane.into(),
    };
    let points: Vec<[f64; 3]> = (0..grid.len())
        .map(|k| grid.point_m(k % grid.columns(), k / grid.columns()))
        .collect();
    let pulses = Pulses::new(PulseArrays {
        position_m: &scene.position_m,
        frequency_hz: &scene.frequency_hz,
        spectrum: &scene.spectrum,
        weight: &scene.weight,
        light_speed_m_s: SPEED_OF_LIGHT_M_S,
    })
    .unwrap();
    let expected = reference::adjoint(&pulses, &points, scene.spreading).unwrap();
    let accuracy = random.log_within(1e-7, 1e-2);
    let engine = [
        Engine::Auto,
        Engine::Auto,
        Engine::Direct,
        Engine::Factorized,
    ][random.below(4)];
    let in_batches = random.below(4) == 0;
    let levels = SimdLevel::available();
    levels
        .iter()
        .map(|&level| {
            let options = PlanOptions::default()
                .with_accuracy(accuracy)
                .with_spreading(scene.spreading)
                .with_level(level)
                .with_engine(engine);
            let mut plan = ImagingPlan::new(pulses, grid, &options).unwrap();
            if in_batches {
                let limit_bytes = 16 * grid.len() as u128 + plan.memory_bytes() / 2;
                let few = options.with_memory_limit_bytes(limit_bytes);
                plan = ImagingPlan::new(pulses, grid, &few).unwrap_or(plan);
            }
            let mut image = vec![Complex32::ZERO; grid.len()];
            plan.run(&mut image, Control::default()).unwrap();
            let image: Vec<Complex64> = (image.iter())
                .map(|v| Complex64::new(v.re.into(), v.im.into()))
                .collect();
            let batched = |d: &Decision| matches!(d, Decision::Batches { .. });
            Found {
                number,
                level,
                kind: scene.kind.clone(),
                engine: match (plan.engine(), plan.report().decisions.iter().any(batched)) {
                    (Engine::Direct, false) => "direct",
                    (Engine::Direct, true) => "direct in batches",
                    (Engine::Factorized, false) => "factorized",
                    (Engine::Factorized, true) => "factorized in batches",
                    (Engine::Double, _) => "double precision",
                    _ => "reference",
                },
                accuracy,
                error: reference::relative_l2(&image, &expected).unwrap(),
                worst: worst(&image, &expected, grid.columns()),
                report: plan.report().to_string(),
            }
        })
        .collect()
}

/// The pixels that hold half of the error's power, as a number of all, and the worst of them.
fn worst(image: &[Complex64], expected: &[Complex64], columns: usize) -> String {
    let mut powers: Vec<(f64, usize)> = (image.iter().zip(expected))
        .map(|(found, expected)| (found - expected).norm_sqr())
        .zip(0..)
        .collect();
    powers.sort_by(|a, b| b.0.total_cmp(&a.0));
    let half = 0.5 * powers.iter().map(|p| p.0).sum::<f64>();
    let mut sum = 0.0;
    let count = (powers.iter())
        .take_while(|p| {
            let before = sum;
            sum += p.0;
            before < half
        })
        .count();
    let at = powers.first().map_or(0, |p| p.1);
    let (i, j) = (at % columns, at / columns);
    format!(
        "{count} of {} pixels hold half of the error, pixel ({i}, {j}) most",
        powers.len()
    )
}

fn draw(random: &mut Random) -> Scene {
    let range_m = random.log_within(1.0, 3000.0);
    let frequency_hz = frequencies(random);
    let pixel_m = random.log_within(0.005, 0.3);
    let (columns, rows) = (4 + random.below(140), 4 + random.below(140));
    let extent_m = pixel_m * columns.max(rows) as f64;
    let most = MOST_TERMS / (columns * rows * frequency_hz.len()) as f64;
    let pulses = (random.log_within(1.0, 1500.0).min(most) as usize).max(1);
    let (position_m, track) = track(random, pulses, range_m, extent_m);
    let (plane, surface, ground) = ground(random, pixel_m, [columns, rows], range_m);
    let spreading = [Spreading::None, Spreading::InverseSquare][random.below(2)];
    let targets = [0, 1, 12][random.below(3)];
    let scatterers: Vec<_> = (0..targets)
        .map(|_| {
            let (i, j) = (random.uniform(), random.uniform());
            reference::Scatterer {
                position_m: plane.point_m(i * (columns - 1) as f64, j * (rows - 1) as f64),
                reflectivity: random.complex(),
            }
        })
        .collect();
    let (light, spread) = (SPEED_OF_LIGHT_M_S, spreading);
    let mut spectrum =
        reference::forward(&position_m, &frequency_hz, &scatterers, light, spread).unwrap();
    let power: f64 = spectrum.iter().map(|e| e.norm_sqr()).sum();
    let rms = (power / spectrum.len() as f64).sqrt();
    let noise = if targets == 0 {
        1.0
    } else {
        rms * random.log_within(1e-3, 1.0)
    };
    let scale = random.log_within(1e-6, 1e6);
    for e in &mut spectrum {
        *e = (*e + random.complex() * noise) * scale;
    }
    Scene {
        weight: (0..pulses).map(|_| random.within(0.0, 2.0)).collect(),
        kind: format!(
            "{track}, {ground}, {columns} × {rows} pixels of {:.1} cm, {pulses} pulses at {range_m:.1} m, {} frequencies, {targets} targets, {spreading:?}",
            100.0 * pixel_m,
            frequency_hz.len()
        ),
        position_m,
        frequency_hz,
        spectrum,
        plane,
        surface,
        spreading,
    }
}

fn frequencies(random: &mut Random) -> Vec<f64> {
    let [low, high] = [[3.1e9, 4.8e9], [0.4e9, 1.2e9], [9.2e9, 10.2e9]][random.below(3)];
    let n = 2 + random.below(100);
    let uneven = random.below(4) == 0;
    let step = (high - low) / n as f64;
    (0..n)
        .map(|k| {
            let jitter = if uneven { random.within(0.0, 0.9) } else { 0.0 };
            low + step * (k as f64 + jitter)
        })
        .collect()
}

/// Antenna positions `range_m` from the middle of the image or nearer, and their name.
fn track(
    random: &mut Random,
    pulses: usize,
    range_m: f64,
    extent_m: f64,
) -> (Vec<[f64; 3]>, &'static str) {
    let kind = random.below(5);
    let height_m = range_m * random.within(0.2, 1.0);
    let beside_m = (range_m * range_m - height_m * height_m).sqrt();
    let turn = random.within(0.0, TAU);
    let length_m = match kind {
        // A track many times as long as it is far.
        1 => range_m.min(100.0) * random.within(5.0, 40.0),
        _ => extent_m.max(0.3 * range_m.min(50.0)) * random.within(0.2, 3.0),
    };
    let wander_m = random.log_within(1e-4, 0.2);
    let rates = [0; 3].map(|_| random.within(1.0, 30.0));
    let position_m = (0..pulses)
        .map(|m| {
            let s = if pulses > 1 {
                m as f64 / (pulses - 1) as f64
            } else {
                0.5
            };
            let w = rates.map(|rate| wander_m * (rate * s).sin());
            let (x, y) = match kind {
                2 => {
                    let angle = TAU * s;
                    (beside_m * angle.cos(), beside_m * angle.sin())
                }
                3 => (
                    -beside_m + random.within(-0.5, 0.5) * extent_m,
                    random.within(-0.5, 0.5) * length_m,
                ),
                4 if m % 2 == 0 => (-beside_m - 0.1 * extent_m, (s - 0.5) * length_m),
                _ => (-beside_m, (s - 0.5) * length_m),
            };
            let (x, y) = (x + w[0], y + w[1]);
            [
                x * turn.cos() - y * turn.sin(),
                x * turn.sin() + y * turn.cos(),
                height_m + w[2],
            ]
        })
        .collect();
    let name = [
        "line",
        "long line",
        "circle",
        "scattered",
        "two tracks by turns",
    ][kind];
    (position_m, name)
}

/// A level or tilted plane, or uneven ground on a level one, and its name.
fn ground(
    random: &mut Random,
    pixel_m: f64,
    [columns, rows]: [usize; 2],
    range_m: f64,
) -> (TiltedGrid, Option<SurfaceGrid>, &'static str) {
    let origin_m = [
        -0.5 * pixel_m * columns as f64,
        -0.5 * pixel_m * rows as f64,
        0.0,
    ];
    let level = PlaneGrid::new(origin_m, pixel_m, [columns, rows]).unwrap();
    match random.below(3) {
        0 => (level.into(), None, "level plane"),
        1 => {
            let [a, b, c] = [0; 3].map(|_| random.within(-0.5, 0.5) * pixel_m);
            let stretch = random.within(0.5, 2.0);
            let (u_m, v_m) = ([pixel_m, a, 0.3 * b], [c, pixel_m * stretch, 0.3 * a]);
            let tilted = TiltedGrid::new(origin_m, u_m, v_m, columns, rows).unwrap();
            (tilted, None, "tilted plane")
        }
        _ => {
            let relief_m = 0.1 * range_m.min(10.0) * random.uniform();
            let per_m = random.log_within(0.02, 2.0);
            let height = |x: f64, y: f64| {
                let z = relief_m * ((per_m * x).sin() + (0.7 * per_m * y).cos());
                Ok::<_, acerra_imaging::ImagingError>(z)
            };
            let surface = SurfaceGrid::from_fn(level, height).unwrap();
            (level.into(), Some(surface), "uneven ground")
        }
    }
}
