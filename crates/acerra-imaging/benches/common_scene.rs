//! The common scene of backprojection benchmarks, 1800 × 1800 pixels of 1 cm and 331 pulses, and with
//! `scene=large` one of 4000 × 4000 pixels and 5000 pulses on three tracks.
//!
//! `cargo bench -p acerra-imaging --bench common_scene` prints, for every accuracy, SIMD level and
//! number of threads: Gbp/s (10⁹ pixel × pulse contributions a second) by the clock and a second of
//! processor time, the relative L2 error at every 17th pixel, and the share of the measured peak of
//! fused multiply-adds that the counted arithmetic takes. Best of several runs. `forward` times the
//! forward operator instead, `apart` both operators with transmitter and receiver 30 cm apart beside those of
//! antennas that are one, `table` prints a line a plan, `dump=DIR` writes the scene for others.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

mod scene;

use acerra_imaging::{
    Complex32, Complex64, Control, Engine, Forward, ImagingPlan, PlanOptions, SimdLevel, Spreading,
};
use scene::{Scene, processor_time_s};
use std::time::Instant;

fn main() {
    // `cargo test --benches` and the like only want to know that it builds.
    if std::env::args().any(|a| a == "--test") {
        return;
    }
    let scene = match std::env::args().any(|a| a == "scene=large") {
        true => Scene::large(),
        false => Scene::common(),
    };
    let (pulses, grid, gbp) = (scene.pulses(), scene.grid, scene.gbp());
    let sparse = if gbp > 10.0 { 101 } else { 17 };
    let expected = scene.expected(sparse);
    if let Some(folder) = std::env::args().find_map(|a| Some(a.strip_prefix("dump=")?.to_owned())) {
        scene.dump(std::path::Path::new(&folder), &expected);
        return;
    }
    let table = std::env::args().any(|a| a == "table");
    if !table {
        println!(
            "{}: {gbp:.4} Gbp, {} cores",
            scene.name,
            std::thread::available_parallelism().map_or(1, |n| n.get())
        );
    }
    if std::env::args().any(|a| a == "forward") {
        time_forward(&scene);
        return;
    }
    if std::env::args().any(|a| a == "apart") {
        time_apart(&scene);
        return;
    }
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
                let options = PlanOptions::default()
                    .with_accuracy(accuracy)
                    .with_spreading(Spreading::None)
                    .with_level(level)
                    .with_engine(engine);
                let start = Instant::now();
                let plan = ImagingPlan::new(pulses, grid, &options).unwrap();
                let planning = start.elapsed().as_secs_f64();
                if !table {
                    println!("\n{plan}\nplanned in {planning:.3} s");
                }
                let mut rates = Vec::new();
                for (threads, pool) in [1, 2].into_iter().zip(&pools) {
                    let estimate = pool.install(|| plan.estimate_run_time_s(Control::default()));
                    let (mut best, mut best_cpu) = (f64::INFINITY, f64::INFINITY);
                    let mut peak = 0f64;
                    for _ in 0..if gbp > 10.0 { 2 } else { 5 } {
                        peak = peak.max(level.measure_peak().unwrap());
                        let (start, cpu) = (Instant::now(), processor_time_s());
                        pool.install(|| plan.run(&mut image, Control::default()))
                            .unwrap();
                        best = best.min(start.elapsed().as_secs_f64());
                        best_cpu = best_cpu.min(processor_time_s() - cpu);
                    }
                    rates.push(gbp / best);
                    if !table {
                        println!(
                            "{:?}, {level}, accuracy {accuracy:.1e}, {threads} thread(s): {:.2} Gbp/s, {:.2} Gbp a processor second, error {:.2e}; {:.1} multiply-adds' time a pixel and pulse at the measured {:.0} GFLOP/s of one thread; estimated {:.3} s, took {best:.3} s",
                            plan.engine(),
                            gbp / best,
                            gbp / best_cpu,
                            scene.error(&image, sparse, &expected),
                            peak * best_cpu / (gbp * 1e9),
                            2e-9 * peak,
                            estimate,
                        );
                    }
                }
                if table {
                    println!(
                        "| {:34} | {:22} | {:8.3} | {:8.3} | {:.1e} |",
                        format!("Acerra, {:?}, {level}", plan.engine()),
                        format!("planned for {accuracy:.1e}"),
                        rates[0],
                        rates[1],
                        scene.error(&image, sparse, &expected),
                    );
                }
            }
        }
    }
}

/// Antennas apart along the track beside antennas that are one: imaging and the forward operator by both engines, with
/// 1/R², in turn, by the processor time of one thread.
fn time_apart(scene: &Scene) {
    const APART_M: f64 = 0.3;
    let moved = |by_m: f64| -> Vec<[f64; 3]> {
        let places = scene.position_m.iter();
        places.map(|p| [p[0], p[1] + by_m, p[2]]).collect()
    };
    let (sent_m, received_m) = (moved(-0.5 * APART_M), moved(0.5 * APART_M));
    let one = scene.pulses();
    let apart = one.with_antennas(&sent_m, &received_m).unwrap();
    let sigma: Vec<Complex32> = (0..scene.grid.len())
        .map(|k| Complex32::new((k % 17) as f32 - 8.0, (k % 23) as f32 - 11.0))
        .collect();
    let mut image = vec![Complex32::ZERO; scene.grid.len()];
    let mut echo = vec![Complex64::ZERO; scene.spectrum.len()];
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let pool = pool.unwrap();
    println!(
        "| operator | engine | level | accuracy | one (Gbp/s) | apart (Gbp/s) | ratio | errors |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- |");
    let row = |name: &str,
               [engine, level, accuracy]: [&str; 3],
               best_s: [f64; 2],
               errors: [f64; 2]| {
        let [of_one, of_apart] = best_s.map(|s| scene.gbp() / s);
        println!(
            "| {name} | {engine} | {level} | {accuracy} | {of_one:.2} | {of_apart:.2} | {:.2} | {:.1e}, {:.1e} |",
            of_apart / of_one,
            errors[0],
            errors[1],
        );
    };
    for (engine, &level) in [Engine::Direct, Engine::Factorized]
        .into_iter()
        .flat_map(|engine| {
            SimdLevel::available()
                .iter()
                .rev()
                .map(move |l| (engine, l))
        })
    {
        for accuracy in [2e-3, 1e-4] {
            let options = PlanOptions::default()
                .with_accuracy(accuracy)
                .with_level(level)
                .with_engine(engine);
            let names = [
                format!("{engine:?}"),
                level.to_string(),
                format!("{accuracy:.0e}"),
            ];
            let names = [&names[0], &names[1], &names[2]].map(String::as_str);
            let plans = [one, apart].map(|p| ImagingPlan::new(p, scene.grid, &options).unwrap());
            let best_s = in_turn(|k| {
                pool.install(|| plans[k].run(&mut image, Control::default()))
                    .unwrap();
            });
            assert!(plans.iter().all(|plan| plan.engine() == engine));
            let errors = plans
                .each_ref()
                .map(|p| p.self_check().map_or(0.0, |c| c.error));
            row("imaging", names, best_s, errors);
            drop(plans);
            let plans = [one, apart].map(|p| Forward::new(p, scene.grid, &options).unwrap());
            let best_s = in_turn(|k| {
                pool.install(|| plans[k].run(&sigma, &mut echo, Control::default()))
                    .unwrap();
            });
            let errors = plans
                .each_ref()
                .map(|p| p.self_check().map_or(0.0, |c| c.error));
            row("forward", names, best_s, errors);
        }
    }
}

/// The least processor time of each of two runs, which take turns three times, s.
fn in_turn(mut run: impl FnMut(usize)) -> [f64; 2] {
    let mut best_s = [f64::INFINITY; 2];
    for _ in 0..3 {
        for (k, best_s) in best_s.iter_mut().enumerate() {
            let start_s = processor_time_s();
            run(k);
            *best_s = best_s.min(processor_time_s() - start_s);
        }
    }
    best_s
}

/// The forward operator on an image of random pixels, by both engines at every level.
fn time_forward(scene: &Scene) {
    let image: Vec<Complex32> = (0..scene.grid.len())
        .map(|k| Complex32::new((k % 17) as f32 - 8.0, (k % 23) as f32 - 11.0))
        .collect();
    let mut echo = vec![Complex64::ZERO; scene.spectrum.len()];
    for &level in SimdLevel::available().iter().rev() {
        for engine in [Engine::Direct, Engine::Factorized] {
            let options = PlanOptions::default()
                .with_accuracy(2e-3)
                .with_spreading(Spreading::None)
                .with_level(level)
                .with_engine(engine);
            let forward = Forward::new(scene.pulses(), scene.grid, &options).unwrap();
            for threads in [1, 2] {
                let pool = rayon::ThreadPoolBuilder::new()
                    .num_threads(threads)
                    .build()
                    .unwrap();
                let mut best = f64::INFINITY;
                for _ in 0..3 {
                    let start = Instant::now();
                    pool.install(|| forward.run(&image, &mut echo, Control::default()))
                        .unwrap();
                    best = best.min(start.elapsed().as_secs_f64());
                }
                println!(
                    "forward, {:?}, {level}, {threads} thread(s): {:.2} Gbp/s, self-check {:.1e}",
                    forward.engine(),
                    scene.gbp() / best,
                    forward.self_check().map_or(0.0, |c| c.error),
                );
            }
        }
    }
}
