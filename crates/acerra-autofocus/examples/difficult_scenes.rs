//! Scenes that give an autofocus little to go by, and priors that are wrong: `difficult_scenes [draws]`.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

#[path = "../tests/common/mod.rs"]
mod common;

use common::{Errors, Scene, Target, clutter, twelve};
use rand_chacha::ChaCha8Rng;

/// The scene whose pixels are on both sides of the track.
const GHOSTS: &str = "full of ghosts";

type Targets = fn(&mut ChaCha8Rng) -> Vec<Target>;

fn one(_: &mut ChaCha8Rng) -> Vec<Target> {
    vec![Target::at(4.0, 0.5)]
}

fn speckle(rng: &mut ChaCha8Rng) -> Vec<Target> {
    clutter(rng, 1500, 0.05)
}

fn among_clutter(rng: &mut ChaCha8Rng) -> Vec<Target> {
    let mut all = twelve(rng);
    all.extend(clutter(rng, 1500, 0.02));
    all
}

fn swaying(rng: &mut ChaCha8Rng) -> Vec<Target> {
    let mut all = twelve(rng);
    all[0].sway_m = 0.05;
    all[1].drift_m = [0.5, 0.0, 0.0];
    all
}

fn one_swaying(_: &mut ChaCha8Rng) -> Vec<Target> {
    vec![Target {
        sway_m: 0.05,
        ..Target::at(4.0, 0.5)
    }]
}

fn three_one_swaying(_: &mut ChaCha8Rng) -> Vec<Target> {
    let mover = Target {
        sway_m: 0.03,
        ..Target::at(4.0, 0.5)
    };
    vec![mover, Target::at(6.0, -3.0), Target::at(5.0, 3.0)]
}

/// Targets on both sides of a straight track: each has a ghost as strong as itself.
fn both_sides(rng: &mut ChaCha8Rng) -> Vec<Target> {
    let mut all = twelve(rng);
    for target in all.iter_mut().step_by(2) {
        target.position_m[0] = -target.position_m[0];
    }
    all
}

fn main() {
    let draws = std::env::args().nth(1).map_or(3, |a| a.parse().unwrap());
    let only = std::env::args().nth(2);
    let scenes: [(&str, Targets, f64); 10] = [
        ("twelve, prior x3", twelve, 3.0),
        ("twelve, prior /3", twelve, 1.0 / 3.0),
        ("clutter only", speckle, 1.0),
        ("among clutter", among_clutter, 1.0),
        ("one target", one, 1.0),
        ("two of twelve move", swaying, 1.0),
        ("one target, moving", one_swaying, 1.0),
        ("three, one moving", three_one_swaying, 1.0),
        ("one target, prior x3", one, 3.0),
        (GHOSTS, both_sides, 1.0),
    ];
    for (name, targets, factor) in scenes {
        if only.as_ref().is_some_and(|o| !name.starts_with(o)) {
            continue;
        }
        for sigma_m in [0.0, 0.003, 0.012] {
            for seed in 0..draws {
                let scene = Scene::new(
                    seed,
                    Errors {
                        sigma_m: f64::max(sigma_m, 1e-6),
                        smoothed_m: 0.58,
                    },
                    targets,
                );
                let prior = Scene::prior(factor * sigma_m.max(0.003), 0.58);
                let grid = match name {
                    GHOSTS => Scene::both_sides(),
                    _ => Scene::grid(),
                };
                let found = scene.focus_on(grid, &prior);
                let mut strong: Vec<&Target> = scene.targets.iter().collect();
                strong.sort_by(|a, b| b.amplitude.norm().total_cmp(&a.amplitude.norm()));
                let still = strong
                    .iter()
                    .take(12)
                    .filter(|t| t.sway_m == 0.0 && t.drift_m == [0.0; 3]);
                let gains: Vec<f64> = still
                    .map(|t| {
                        let before = scene.peak(&scene.nominal_m, t).0;
                        10.0 * (scene.peak(&found.position_m, t).0 / before).log10()
                    })
                    .collect();
                let mean = gains.iter().sum::<f64>() / gains.len().max(1) as f64;
                let worst = gains.iter().copied().fold(f64::INFINITY, f64::min);
                println!(
                    "{name}, s {:.0} mm seed {seed}: {:?} mean {mean:.2} worst {worst:.2} dB, held out {:.2}+-{:.2}, points {}, slant {:.2} -> {:.2} mm, sig {:.2}",
                    1e3 * sigma_m,
                    found.decision,
                    found.gain_db,
                    found.gain_sigma_db,
                    found.points.len(),
                    1e3 * scene.slant_error_m(&scene.nominal_m),
                    1e3 * scene.slant_error_m(&found.position_m),
                    found.correction_in_sigmas,
                );
            }
        }
    }
}
