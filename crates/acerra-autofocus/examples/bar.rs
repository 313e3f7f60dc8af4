//! Prints the table of the comparison scene: `bar [draws] [sigma_mm] [smoothed_m]`.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

#[path = "../tests/common/mod.rs"]
mod common;

use common::{Errors, Scene, twelve};

fn main() {
    let arguments: Vec<f64> = std::env::args()
        .skip(1)
        .map(|a| a.parse().unwrap())
        .collect();
    let draws = arguments.first().copied().unwrap_or(10.0) as u64;
    let sigmas = arguments.get(1).map_or(vec![3.0, 6.0, 12.0], |s| vec![*s]);
    let lengths = arguments.get(2).map_or(vec![0.0, 0.58, 2.0], |s| vec![*s]);
    for smoothed_m in lengths {
        for &sigma_mm in &sigmas {
            for seed in 0..draws {
                let sigma_m = 1e-3 * sigma_mm;
                let scene = Scene::new(
                    seed,
                    Errors {
                        sigma_m,
                        smoothed_m,
                    },
                    twelve,
                );
                let start = std::time::Instant::now();
                let found = scene.focus(&Scene::trendless_prior(sigma_m, smoothed_m));
                let seconds = start.elapsed().as_secs_f64();
                let corrected: Vec<[f64; 3]> = (0..scene.nominal_m.len())
                    .map(|m| [0, 1, 2].map(|a| scene.nominal_m[m][a] + found.correction_m[m][a]))
                    .collect();
                let mut square = [0.0; 3];
                for m in 0..scene.nominal_m.len() {
                    for a in 0..3 {
                        let e = corrected[m][a] - scene.true_m[m][a];
                        square[a] += (e / found.sigma_m[m][a]).powi(2) / 331.0;
                    }
                }
                let mut along = 0.0_f64;
                let mut chi = [0.0; 2];
                let mut paired = 0.0;
                for p in &found.points {
                    let d = |t: &common::Target| {
                        (t.position_m[0] - p.position_m[0]).hypot(t.position_m[1] - p.position_m[1])
                    };
                    let t = scene
                        .targets
                        .iter()
                        .min_by(|a, b| d(a).total_cmp(&d(b)))
                        .unwrap();
                    if d(t) < 0.15 {
                        along = along.max((t.position_m[1] - p.position_m[1]).abs());
                        for a in 0..2 {
                            chi[a] += ((t.position_m[a] - p.position_m[a]) / p.sigma_m[a]).powi(2);
                        }
                        paired += 1.0;
                    }
                }
                println!(
                    "s {sigma_mm} l {smoothed_m} seed {seed}: loss {:.2} -> {:.2} dB, slant {:.2} -> {:.2} mm, {:?} gain {:.2}+-{:.2}, points {} ({paired}), along {:.1} mm, chi2 path {:.2} {:.2} {:.2} places {:.2} {:.2}, sig {:.2}, {seconds:.2} s",
                    scene.loss_db(&scene.nominal_m),
                    scene.loss_db(&corrected),
                    1e3 * scene.slant_error_m(&scene.nominal_m),
                    1e3 * scene.slant_error_m(&corrected),
                    found.decision,
                    found.gain_db,
                    found.gain_sigma_db,
                    found.points.len(),
                    1e3 * along,
                    square[0],
                    square[1],
                    square[2],
                    chi[0] / paired,
                    chi[1] / paired,
                    found.correction_in_sigmas,
                );
            }
        }
    }
}
