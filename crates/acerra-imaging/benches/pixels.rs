//! Rates at other pixel sizes and aperture lengths than the common scene's: 1000 × 1000 pixels.
//!
//! `cargo bench -p acerra-imaging --bench pixels` prints, for pixels of 0.5 to 10 cm and 331 pulses, the
//! engine chosen, Gbp/s of the run and of planning and running together, and the relative L2 error;
//! `pulses=20000` takes another aperture at the common scene's speed, `pixel=4` one size (cm),
//! `accuracy=1e-3` another accuracy, `level=avx2` an instruction set, `plan` prints the plans.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

mod scene;

use acerra_imaging::{Complex32, Control, Engine, ImagingPlan, PlanOptions, SimdLevel, Spreading};
use scene::Scene;
use std::time::Instant;

fn argument(name: &str) -> Option<String> {
    std::env::args().find_map(|a| Some(a.strip_prefix(name)?.to_owned()))
}

fn main() {
    if std::env::args().any(|a| a == "--test") {
        return;
    }
    let number = |name: &str| argument(name).map(|v| v.parse::<f64>().unwrap());
    let accuracy = number("accuracy=").unwrap_or(2e-3);
    let pulses = number("pulses=").unwrap_or(331.0) as usize;
    let level = argument("level=").map_or(SimdLevel::detect(), |name| {
        *SimdLevel::available()
            .iter()
            .find(|l| l.name() == name)
            .unwrap()
    });
    let sizes_cm = number("pixel=").map_or(vec![0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 10.0], |p| vec![p]);
    println!("accuracy {accuracy:.1e}, {pulses} pulses, {level}");
    println!("| pixel (cm) | engine | run (Gbp/s) | plan and run (Gbp/s) | memory (MB) | error |");
    println!("| --- | --- | --- | --- | --- | --- |");
    for size_cm in sizes_cm {
        let scene = Scene::of_pixels(0.01 * size_cm, pulses);
        let expected = scene.expected(if pulses > 1000 { 100 } else { 20 });
        for engine in [Engine::Direct, Engine::Auto] {
            time(&scene, engine, (accuracy, level), size_cm, &expected);
        }
    }
}

fn time(
    scene: &Scene,
    engine: Engine,
    (accuracy, level): (f64, SimdLevel),
    size_cm: f64,
    expected: &[acerra_imaging::Complex64],
) {
    let options = PlanOptions::default()
        .with_accuracy(accuracy)
        .with_spreading(Spreading::None)
        .with_level(level)
        .with_engine(engine);
    let mut image = vec![Complex32::ZERO; scene.grid.len()];
    let runs = if scene.gbp() > 5.0 { 2 } else { 5 };
    let (mut run_s, mut whole_s) = (f64::INFINITY, f64::INFINITY);
    let mut plan = None;
    for _ in 0..runs {
        let start = Instant::now();
        let made = ImagingPlan::new(scene.pulses(), scene.grid, &options).unwrap();
        let planned = Instant::now();
        made.run(&mut image, Control::default()).unwrap();
        run_s = run_s.min(planned.elapsed().as_secs_f64());
        whole_s = whole_s.min(start.elapsed().as_secs_f64());
        plan = Some(made);
    }
    let plan = plan.unwrap();
    println!(
        "| {size_cm} | {:?} | {:.2} | {:.2} | {:.0} | {:.1e} |",
        plan.engine(),
        scene.gbp() / run_s,
        scene.gbp() / whole_s,
        plan.memory_bytes() as f64 * 1e-6,
        scene.error(
            &image,
            if scene.position_m.len() > 1000 {
                100
            } else {
                20
            },
            expected
        ),
    );
    if std::env::args().any(|a| a == "plan") {
        println!("{plan}");
    }
}
