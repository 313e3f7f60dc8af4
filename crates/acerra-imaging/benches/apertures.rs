//! Apertures from 300 to 100,000 pulses over 1000 × 1000 pixels, and tables that exceed the memory allowed.
//!
//! `cargo bench -p acerra-imaging --bench apertures` prints for each what a plan chooses by itself: seconds
//! to plan and to run on all threads, Gbp/s (10⁹ pixel × pulse contributions a second), nanoseconds a pixel,
//! the memory promised and the relative L2 error at sparse pixels. `-- batches` makes the cases with 4 GB
//! for tables and image; its last column is the most memory that the process held, echoes included.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

mod scene;

use acerra_imaging::plan::Decision;
use acerra_imaging::{Complex32, Control, ImagingPlan, PlanOptions, Spreading};
use scene::Scene;
use std::time::Instant;

/// Memory of the cases in batches, bytes.
const FOUR_GB: u128 = 4_000_000_000;

fn main() {
    if std::env::args().any(|a| a == "--test") {
        return;
    }
    if std::env::args().any(|a| a == "batches") {
        println!(
            "| case | engine | batches | plan s | run s | Gbp/s | promised MB | error | peak MB |"
        );
        println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- |");
        for (pulses, track_m, pixel_m) in [(120, 2000.0, 0.4), (20_000, 483.0, 0.036)] {
            let scene = Scene::along(track_m, pulses, pixel_m);
            line(
                &scene,
                1e-5,
                FOUR_GB,
                &format!("{pulses} pulses over {track_m} m, 1e-5"),
            );
        }
        return;
    }
    println!(
        "| pulses | engine | batches | plan s | run s | Gbp/s | promised MB | error | peak MB |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    for pulses in [300, 1000, 3000, 10_000, 30_000, 100_000] {
        // 2.4 cm apart: the aperture grows with the pulses.
        let scene = Scene::along(0.024 * pulses as f64, pulses, 0.02);
        line(&scene, 1e-3, 1 << 36, &pulses.to_string());
    }
}

fn line(scene: &Scene, accuracy: f64, limit_bytes: u128, name: &str) {
    let options = PlanOptions::default()
        .with_accuracy(accuracy)
        .with_spreading(Spreading::None)
        .with_memory_limit_bytes(limit_bytes);
    let start = Instant::now();
    let plan = ImagingPlan::new(scene.pulses(), scene.grid, &options).unwrap();
    let planned_s = start.elapsed().as_secs_f64();
    let mut image = vec![Complex32::ZERO; scene.grid.len()];
    let mut took_s = f64::INFINITY;
    for _ in 0..if scene.gbp() < 5.0 { 3 } else { 1 } {
        let start = Instant::now();
        plan.run(&mut image, Control::default()).unwrap();
        took_s = took_s.min(start.elapsed().as_secs_f64());
    }
    let batches = plan.report().decisions.iter().rev().find_map(|d| match d {
        Decision::Batches { batches } => Some(*batches),
        _ => None,
    });
    let sparse = 127;
    println!(
        "| {name} | {:?} | {} | {planned_s:.3} | {took_s:.3} | {:.2} | {:.0} | {:.1e} | {:.0} |",
        plan.engine(),
        batches.unwrap_or(1),
        scene.gbp() / took_s,
        plan.memory_bytes() as f64 * 1e-6,
        scene.error(&image, sparse, &scene.expected(sparse)),
        peak_mb(),
    );
    if std::env::args().any(|a| a == "explain") {
        println!("{plan}");
    }
}

/// Most memory that this process has held, MB; 0 where the system does not tell.
fn peak_mb() -> f64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find(|l| l.starts_with("VmHWM:"));
    line.and_then(|l| l.split_whitespace().nth(1)?.parse::<f64>().ok())
        .map_or(0.0, |kib| kib * 1.024e-3)
}
