//! Promises of accuracy on random scenes: all kinds of grids, pixels, tracks and frequencies, distances from
//! 1 m to 3 km, accuracies from 10⁻² to 10⁻⁷, at every SIMD level.
//!
//! `cargo bench -p acerra-imaging --bench random_scenes -- 1000` images as many scenes by every level and
//! compares all their pixels with the double-precision sum. It prints each promise that was broken, with
//! the number that draws its scene again (`-- 1 from=NUMBER`), and how close to the promise the errors came.
//! `factorized` asks for that engine, which plans of so few pixels seldom choose; `echoes`
//! does the same of what the forward operator of a volume models of a slice, or of all.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

mod echoes;
mod found;
mod scene;

use acerra_imaging::plan::Decision;
use acerra_imaging::{
    Complex32, Complex64, Control, Engine, ImageGrid, ImagingPlan, PlanOptions, SimdLevel,
    reference,
};
use found::{Found, tell};
use rayon::prelude::*;
use scene::{Random, draw};

fn main() {
    if std::env::args().any(|a| a == "--test") {
        return;
    }
    let number = |a: String| a.parse::<u64>().ok();
    let count = std::env::args().find_map(number).unwrap_or(1000);
    let from = std::env::args().find_map(|a| a.strip_prefix("from=")?.parse().ok());
    let first: u64 = from.unwrap_or(0);
    let of_echoes = std::env::args().any(|a| a == "echoes");
    let found: Vec<Found> = (first..first + count)
        .into_par_iter()
        .flat_map_iter(|number| match of_echoes {
            true => echoes::try_volume(number),
            false => try_scene(number),
        })
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

fn try_scene(number: u64) -> Vec<Found> {
    let mut random = Random::of(number);
    let scene = draw(&mut random);
    let grid: ImageGrid = match &scene.surface {
        Some(surface) => surface.into(),
        None => scene.plane.into(),
    };
    let points: Vec<[f64; 3]> = (0..grid.len())
        .map(|k| grid.point_m(k % grid.columns(), k / grid.columns()))
        .collect();
    let pulses = scene.pulses();
    let expected = reference::adjoint(&pulses, &points, scene.spreading).unwrap();
    let accuracy = random.log_within(1e-7, 1e-2);
    let drawn = [
        Engine::Auto,
        Engine::Auto,
        Engine::Direct,
        Engine::Factorized,
    ][random.below(4)];
    let engine = match std::env::args().any(|a| a == "factorized") {
        true => Engine::Factorized,
        false => drawn,
    };
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
