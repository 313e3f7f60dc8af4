//! Small images, as previews, selections and sliders ask for: planning and run, in milliseconds.
//!
//! `cargo bench -p acerra-imaging --bench small_images` images squares of 50 to 400 pixels of 1 and of
//! 4 cm from the pulses of the common scene, once with all targets within the image and once with
//! most of the echoes' power outside it, where planning needs more than one attempt. Medians of nine
//! runs by the clock, and of processor time in brackets; `engine=direct`, `engine=factorized` or
//! `engine=reference` asks for an engine, `accuracy=1e-6` for another accuracy than the default, `size=200` for
//! one size, `about=targets` or `about=dark` for one place, `runs=99` for more runs; `plan` prints the plans.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

mod scene;

use acerra_imaging::{Complex32, Control, Engine, ImagingPlan, PlanOptions, PlaneGrid};
use scene::{Scene, processor_time_s};
use std::time::Instant;

const RUNS: usize = 9;

/// The value of an argument that begins with `key`.
fn asked(key: &str) -> Option<String> {
    std::env::args().find_map(|a| a.strip_prefix(key).map(str::to_owned))
}

fn main() {
    if std::env::args().any(|a| a == "--test") {
        return;
    }
    let scene = Scene::of_pixels(0.01, 331);
    println!("| image | about | plan (ms) | run (ms) | engine | attempts | error bound |");
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    for pixel_m in [0.01, 0.04] {
        for size in [50, 100, 200, 400] {
            if asked("size=").is_some_and(|only| only != size.to_string()) {
                continue;
            }
            for (about, corner_m) in [("targets", -0.5 * pixel_m * size as f64), ("dark", 6.0)] {
                if asked("about=").is_some_and(|only| only != about) {
                    continue;
                }
                let corner_m = [corner_m, corner_m, 0.0];
                let grid = PlaneGrid::new(corner_m, pixel_m, [size, size]).unwrap();
                time(&scene, grid, about);
            }
        }
    }
}

fn time(scene: &Scene, grid: PlaneGrid, about: &str) {
    let engine = match asked("engine=").as_deref() {
        Some("direct") => Engine::Direct,
        Some("factorized") => Engine::Factorized,
        Some("reference") => Engine::Reference,
        _ => Engine::Auto,
    };
    let runs = asked("runs=").map_or(RUNS, |n| n.parse().unwrap());
    let mut options = PlanOptions::default().with_engine(engine);
    if let Some(accuracy) = asked("accuracy=") {
        options = options.with_accuracy(accuracy.parse().unwrap());
    }
    let mut image = vec![Complex32::ZERO; grid.len()];
    let mut times = [(); 4].map(|()| Vec::new());
    let mut last = None;
    for _ in 0..runs {
        let now = || (Instant::now(), processor_time_s());
        let start = now();
        let plan = ImagingPlan::new(scene.pulses(), grid, &options).unwrap();
        let planned = now();
        plan.run(&mut image, Control::default()).unwrap();
        let end = now();
        let spent = [
            (planned.0 - start.0).as_secs_f64(),
            planned.1 - start.1,
            (end.0 - planned.0).as_secs_f64(),
            end.1 - planned.1,
        ];
        for (list, s) in times.iter_mut().zip(spent) {
            list.push(1e3 * s);
        }
        last = Some(plan);
    }
    let [plan_ms, plan_cpu_ms, run_ms, run_cpu_ms] = times.map(|mut list| {
        list.sort_by(f64::total_cmp);
        list[runs / 2]
    });
    let plan = last.unwrap();
    let report = plan.report().to_string();
    let attempts = 1 + report
        .lines()
        .filter(|l| l.contains("a finer plan"))
        .count();
    println!(
        "| {}² × {} cm | {about} | {plan_ms:.1} ({plan_cpu_ms:.1}) | {run_ms:.1} ({run_cpu_ms:.1}) | {:?} | {attempts} | {:.1e} |",
        grid.nx,
        100.0 * grid.pixel_m,
        plan.engine(),
        plan.self_check().map_or(f64::NAN, |c| c.error_bound),
    );
    if std::env::args().any(|a| a == "plan") {
        println!("{report}");
    }
}
