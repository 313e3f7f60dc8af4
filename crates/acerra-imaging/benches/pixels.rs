//! Rates at other pixel sizes and aperture lengths than the common scene's: 1000 × 1000 pixels.
//!
//! `cargo bench -p acerra-imaging --bench pixels` prints, for pixels of 0.5 to 10 cm and 331 pulses, the
//! engine chosen, Gbp/s of the run and of planning and running together, and the relative L2 error;
//! `pulses=20000` takes another aperture at the common scene's speed, `pixel=4` one size (cm),
//! `volume` images 51 slices of 400 × 400 pixels of 2 cm beside 51 runs of one slice's plan,
//! `accuracy=1e-3` asks for another accuracy, `level=avx2` an instruction set, `plan` prints the plans.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

mod scene;

use acerra_imaging::{
    Complex32, Control, Engine, ImagingError, ImagingPlan, PlanOptions, PlaneGrid, SimdLevel,
    Spreading, VolumeGrid, image_volume_planned_once,
};
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
    if std::env::args().any(|a| a == "volume") {
        return time_volume();
    }
    println!("| pixel (cm) | engine | run (Gbp/s) | plan and run (Gbp/s) | memory (MB) | error |");
    println!("| --- | --- | --- | --- | --- | --- |");
    for size_cm in sizes_cm {
        let scene = Scene::of_pixels(0.01 * size_cm, pulses);
        let expected = scene.expected(if pulses > 1000 { 101 } else { 19 });
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
                101
            } else {
                19
            },
            expected
        ),
    );
    if std::env::args().any(|a| a == "plan") {
        println!("{plan}");
    }
}

/// A volume beside as many runs of a plan that is already made.
fn time_volume() {
    let scene = Scene::of_pixels(0.02, 331);
    let base = PlaneGrid::new([-4.0, -4.0, 0.0], 0.02, [400, 400]).unwrap();
    let volume = VolumeGrid::new(base, 0.02, 51).unwrap();
    let options = PlanOptions::default();
    let plan = ImagingPlan::new(scene.pulses(), base, &options).unwrap();
    let mut image = vec![Complex32::ZERO; base.len()];
    let (mut volume_s, mut slices_s) = (f64::INFINITY, f64::INFINITY);
    let mut report = None;
    for _ in 0..3 {
        let start = Instant::now();
        let take = |_: usize, _: &PlaneGrid, _: &[Complex32]| Ok::<(), ImagingError>(());
        let run =
            image_volume_planned_once(&volume, scene.pulses(), &options, Control::default(), take)
                .unwrap();
        volume_s = volume_s.min(start.elapsed().as_secs_f64());
        report = Some(run.report);
        let start = Instant::now();
        for _ in 0..volume.nz {
            plan.run(&mut image, Control::default()).unwrap();
        }
        slices_s = slices_s.min(start.elapsed().as_secs_f64());
    }
    println!(
        "51 slices of 400 × 400, 331 pulses: {volume_s:.3} s; 51 runs of one plan ({:?}): {slices_s:.3} s",
        plan.engine()
    );
    if let Some(report) = report.filter(|_| std::env::args().any(|a| a == "plan")) {
        println!("{report}");
    }
}
