//! The table of the comparison scene in `docs/validation/autofocus.md`:
//! `comparison_scene [draws] [σ in mm] [Gaussian smoothing in m]`.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

#[path = "../tests/common/mod.rs"]
mod common;

use std::time::Instant;

use acerra_autofocus::{Autofocused, Decision};
use common::{Errors, PULSES, Scene, twelve};

/// What one draw gives.
struct Draw {
    loss_db: [f64; 2],
    slant_mm: [f64; 2],
    along_mm: f64,
    path_square: f64,
    place_square: f64,
    applied: bool,
    seconds: f64,
}

fn main() {
    let arguments: Vec<f64> = std::env::args()
        .skip(1)
        .map(|a| a.parse().unwrap())
        .collect();
    let draws = arguments.first().copied().unwrap_or(10.0) as u64;
    let sigmas_mm = arguments.get(1).map_or(vec![3.0, 6.0, 12.0], |s| vec![*s]);
    let lengths_m = arguments.get(2).map_or(vec![0.0, 0.58, 2.0], |s| vec![*s]);
    println!(
        "| smoothed by | σ | loss before → after | slant error before → after | applied | worse | places \
         along, worst | path χ² | places χ² | time |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |"
    );
    for &smoothed_m in &lengths_m {
        for &sigma_mm in &sigmas_mm {
            let errors = Errors {
                sigma_m: 1e-3 * sigma_mm,
                smoothed_m,
            };
            let row: Vec<Draw> = (0..draws).map(|seed| draw(seed, errors)).collect();
            print(sigma_mm, smoothed_m, &row);
        }
    }
}

fn draw(seed: u64, errors: Errors) -> Draw {
    let scene = Scene::new(seed, errors, twelve);
    let prior = Scene::trendless_prior(errors.sigma_m, errors.smoothed_m);
    let start = Instant::now();
    let found = scene.focus(&prior);
    let seconds = start.elapsed().as_secs_f64();
    let places = [&scene.nominal_m, &found.position_m];
    let along = |t: &common::Target| 1e3 * scene.shift_along_m(&found.position_m, t);
    Draw {
        loss_db: places.map(|p| scene.loss_db(p)),
        slant_mm: places.map(|p| 1e3 * scene.slant_error_m(p)),
        along_mm: scene.lone_targets().map(along).fold(0.0, f64::max),
        path_square: path_square(&scene, &found),
        place_square: place_square(&scene, &found),
        applied: found.decision == Decision::Applied,
        seconds,
    }
}

/// Mean square error of the path in units of its posterior deviations.
fn path_square(scene: &Scene, found: &Autofocused) -> f64 {
    let each = scene
        .nominal_m
        .iter()
        .zip(&scene.true_m)
        .zip(&found.correction_m);
    let squares = each
        .zip(&found.sigma_m)
        .flat_map(|(((p, q), d), s)| [0, 1, 2].map(|a| ((p[a] + d[a] - q[a]) / s[a]).powi(2)));
    squares.sum::<f64>() / (3 * PULSES) as f64
}

/// The same of the points' places, of those within 5 cm of a target.
fn place_square(scene: &Scene, found: &Autofocused) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for point in &found.points {
        for t in &scene.targets {
            let off = [0, 1].map(|a| t.position_m[a] - point.position_m[a]);
            if off[0].hypot(off[1]) < 0.05 {
                sum += (off[0] / point.sigma_m[0]).powi(2) + (off[1] / point.sigma_m[1]).powi(2);
                count += 2.0;
            }
        }
    }
    sum / f64::max(count, 1.0)
}

fn print(sigma_mm: f64, smoothed_m: f64, row: &[Draw]) {
    let median = |of: &dyn Fn(&Draw) -> f64| {
        let mut values: Vec<f64> = row.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        0.5 * (values[(values.len() - 1) / 2] + values[values.len() / 2])
    };
    let mean = |of: &dyn Fn(&Draw) -> f64| row.iter().map(of).sum::<f64>() / row.len() as f64;
    let worse = row.iter().filter(|d| d.slant_mm[1] > d.slant_mm[0]).count();
    let worst = row.iter().map(|d| d.along_mm).fold(0.0, f64::max);
    println!(
        "| {smoothed_m} m | {sigma_mm} mm | {:.2} → {:.2} dB | {:.1} → {:.2} mm | {} | {worse} of {} | {worst:.0} mm \
         | {:.2} | {:.2} | {:.1} s |",
        median(&|d| d.loss_db[0]),
        median(&|d| d.loss_db[1]).abs(),
        median(&|d| d.slant_mm[0]),
        median(&|d| d.slant_mm[1]),
        row.iter().filter(|d| d.applied).count(),
        row.len(),
        mean(&|d| d.path_square),
        mean(&|d| d.place_square),
        median(&|d| d.seconds),
    );
}
