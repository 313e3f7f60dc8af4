//! The common scene of backprojection benchmarks: 1800 × 1800 pixels of 1 cm, 331 pulses.
//!
//! `cargo bench -p acerra-imaging --bench common_scene` prints, for every accuracy, SIMD level and
//! number of threads: Gbp/s (10⁹ pixel × pulse contributions a second) by the clock and a second of
//! processor time, the relative L2 error at every 18th pixel, and the share of the measured peak of
//! fused multiply-adds that the counted arithmetic takes. Best of several runs.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

use acerra_imaging::{
    Complex32, Complex64, Engine, Plan, PlanOptions, PlaneGrid, Pulses, SPEED_OF_LIGHT_M_S,
    SimdLevel, Spreading, reference,
};
use rand_free::Random;
use std::time::Instant;

mod rand_free {
    /// Reproducible numbers without a dependency.
    pub struct Random(pub u64);
    impl Random {
        pub fn uniform(&mut self) -> f64 {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            ((self.0 >> 11) as f64 + 0.5) / (1u64 << 53) as f64
        }
        pub fn normal(&mut self) -> f64 {
            (-2.0 * self.uniform().ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
        }
    }
}

struct Scene {
    position_m: Vec<[f64; 3]>,
    frequency_hz: Vec<f64>,
    spectrum: Vec<Complex64>,
    weight: Vec<f64>,
}

fn common_scene() -> Scene {
    let mut random = Random(2020);
    let pulses = 331;
    let position_m: Vec<[f64; 3]> = (0..pulses)
        .map(|m| {
            let s = f64::from(m) / f64::from(pulses - 1);
            [
                0.05 * (9.0 * s).sin(),
                -4.0 + 8.0 * s,
                5.0 + 0.05 * (7.0 * s).cos(),
            ]
        })
        .collect();
    let frequency_hz: Vec<f64> = (0..213)
        .map(|n| 3.95e9 + 8e6 * (f64::from(n) - 106.0))
        .collect();
    let scene: Vec<_> = (0..40)
        .map(|_| reference::Scatterer {
            position_m: [
                16.0 * random.uniform() - 8.0,
                16.0 * random.uniform() - 8.0,
                0.0,
            ],
            reflectivity: Complex64::new(random.normal(), random.normal()),
        })
        .collect();
    let mut spectrum = reference::forward(
        &position_m,
        &frequency_hz,
        &scene,
        SPEED_OF_LIGHT_M_S,
        Spreading::None,
    )
    .unwrap();
    for row in spectrum.chunks_mut(213) {
        for (n, e) in row.iter_mut().enumerate() {
            let noise = Complex64::new(random.normal(), random.normal()) * (0.3 / 2f64.sqrt());
            let hann = 0.5 - 0.5 * (std::f64::consts::TAU * n as f64 / 212.0).cos();
            *e = (*e + noise) * hann;
        }
    }
    let weight = vec![1.0; pulses as usize];
    Scene {
        position_m,
        frequency_hz,
        spectrum,
        weight,
    }
}

/// Processor time of all threads so far, s (Linux; zero elsewhere).
fn processor_time_s() -> f64 {
    let Ok(tasks) = std::fs::read_dir("/proc/self/task") else {
        return 0.0;
    };
    tasks
        .flatten()
        .filter_map(|t| std::fs::read_to_string(t.path().join("schedstat")).ok())
        .filter_map(|s| s.split(' ').next()?.parse::<f64>().ok())
        .sum::<f64>()
        * 1e-9
}

fn main() {
    // `cargo test --benches` and the like only want to know that it builds.
    if std::env::args().any(|a| a == "--test") {
        return;
    }
    let scene = common_scene();
    let pulses = Pulses::new(
        &scene.position_m,
        &scene.frequency_hz,
        &scene.spectrum,
        &scene.weight,
        SPEED_OF_LIGHT_M_S,
    )
    .unwrap();
    let grid = PlaneGrid::new(-9.0, -9.0, 0.0, 0.01, 1800, 1800).unwrap();
    let places: Vec<usize> = (0..100 * 100)
        .map(|k| (k / 100) * 18 * 1800 + (k % 100) * 18)
        .collect();
    let every_18th = PlaneGrid::new(-9.0, -9.0, 0.0, 0.18, 100, 100).unwrap();
    let options = PlanOptions {
        engine: Engine::Reference,
        spreading: Spreading::None,
        ..Default::default()
    };
    let expected: Vec<Complex64> = acerra_imaging::image(pulses, every_18th, &options)
        .unwrap()
        .into_iter()
        .map(|v| Complex64::new(f64::from(v.re), f64::from(v.im)))
        .collect();
    let gbp = grid.len() as f64 * 331.0 * 1e-9;
    println!(
        "common scene: {gbp:.4} Gbp, {} cores",
        std::thread::available_parallelism().map_or(1, |n| n.get())
    );
    let pools = [1, 2].map(|n| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(n)
            .build()
            .unwrap()
    });
    let mut image = vec![Complex32::ZERO; grid.len()];
    // Numbers on the command line are the accuracies to time instead of these.
    let mut accuracies: Vec<f64> = std::env::args().filter_map(|a| a.parse().ok()).collect();
    if accuracies.is_empty() {
        accuracies = vec![2e-3, 1e-3, 3.2e-4, 1e-5];
    }
    let level_wanted = |level: SimdLevel| {
        let named: Vec<String> = std::env::args()
            .filter(|a| a.starts_with("level="))
            .collect();
        named.is_empty() || named.iter().any(|a| a[6..] == *level.name())
    };
    let engines: &[Engine] = match std::env::args().find(|a| a.starts_with("engine=")) {
        Some(a) if a.ends_with("direct") => &[Engine::Direct],
        Some(a) if a.ends_with("factorized") => &[Engine::Factorized],
        _ => &[Engine::Direct, Engine::Factorized],
    };
    for accuracy in accuracies {
        for &level in SimdLevel::available()
            .iter()
            .rev()
            .filter(|l| level_wanted(**l))
        {
            for engine in engines.iter().copied() {
                let options = PlanOptions {
                    accuracy,
                    spreading: Spreading::None,
                    level,
                    engine,
                    ..Default::default()
                };
                let start = Instant::now();
                let plan = Plan::new(pulses, grid, &options).unwrap();
                let planning = start.elapsed().as_secs_f64();
                println!("\n{plan}\nplanned in {planning:.3} s");
                for (threads, pool) in [1, 2].into_iter().zip(&pools) {
                    let (mut best, mut best_cpu) = (f64::INFINITY, f64::INFINITY);
                    let mut peak = 0f64;
                    for _ in 0..5 {
                        peak = peak.max(level.measure_peak().unwrap());
                        let (start, cpu) = (Instant::now(), processor_time_s());
                        pool.install(|| plan.run(&mut image, &|_| ())).unwrap();
                        best = best.min(start.elapsed().as_secs_f64());
                        best_cpu = best_cpu.min(processor_time_s() - cpu);
                    }
                    let found: Vec<_> = places
                        .iter()
                        .map(|&k| Complex64::new(f64::from(image[k].re), f64::from(image[k].im)))
                        .collect();
                    println!(
                        "{:?}, {level}, accuracy {accuracy:.1e}, {threads} thread(s): {:.2} Gbp/s, {:.2} Gbp a processor second, error {:.2e}; {:.1} multiply-adds' time a pixel and pulse at the measured {:.0} GFLOP/s of one thread",
                        plan.engine(),
                        gbp / best,
                        gbp / best_cpu,
                        reference::relative_l2(&found, &expected).unwrap(),
                        peak * best_cpu / (gbp * 1e9),
                        2e-9 * peak,
                    );
                }
            }
        }
    }
}
