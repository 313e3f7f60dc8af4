//! Measuring an image of noise, with thousands of local maxima, beside making it.
//!
//! `cargo bench -p acerra-imaging --bench measure` prints the processor time of imaging and of measuring
//! 1800 × 1800 pixels of 1 cm from 331 pulses, for pure noise and for a clean scene with noise.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

mod scene;

use acerra_imaging::metrics::{ImageView, MeasureOptions, measure_targets_in};
use acerra_imaging::{Complex32, Complex64, Control, ImagingPlan, PlanOptions};
use scene::{Scene, processor_time_s};

fn main() {
    if std::env::args().any(|a| a == "--test") {
        return;
    }
    let clean = Scene::common();
    let mut noise = Scene::common();
    let mut state = 1_u64;
    let mut random = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    for e in &mut noise.spectrum {
        *e = Complex64::new(random(), random());
    }
    for (name, scene) in [("targets", &clean), ("noise", &noise)] {
        let pulses = scene.pulses();
        let mut image = vec![Complex32::ZERO; scene.grid.len()];
        let start = processor_time_s();
        let plan = ImagingPlan::new(pulses, scene.grid, &PlanOptions::default()).unwrap();
        plan.run(&mut image, Control::default()).unwrap();
        let imaged = processor_time_s();
        let view = ImageView::new(&image, scene.grid).unwrap();
        let options = MeasureOptions::default();
        let found = measure_targets_in(&view, &pulses, &options, Control::default()).unwrap();
        let measured = processor_time_s();
        println!(
            "{name}: imaging {:.2} s, measuring {:.2} s; {} maxima, {} targets, {} sidelobes, {} ghosts, \
             {} skipped",
            imaged - start,
            measured - imaged,
            found.maxima,
            found.targets.len(),
            found.sidelobes,
            found.ghosts,
            found.skipped
        );
    }
}
