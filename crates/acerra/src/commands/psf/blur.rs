//! How positioning errors blur the image of the target: analysis, answer and table.

use std::fmt::Write as _;

use acerra_imaging::Control;
use acerra_imaging::sensitivity::{
    Blur, ErrorModel, Estimate, MonteCarlo, Simulated, predict, simulate,
};
use anyhow::{Context, ensure};
use serde::Serialize;

use super::args::BlurArgs;
use super::scene::Scene;

/// Assumptions and results.
#[derive(Serialize)]
pub(super) struct Answer {
    /// One standard deviation for all axes and pulses; null where the file gave them.
    position_sigma_m: Option<f64>,
    correlation_m: Option<f64>,
    correlation_s: Option<f64>,
    theory: Blur,
    /// With 95 % confidence intervals.
    monte_carlo: Option<Simulated>,
}

/// Predicts and simulates.
pub(super) fn analyse(args: &BlurArgs, scene: &Scene) -> anyhow::Result<Option<Answer>> {
    if !args.asked() {
        return Ok(None);
    }
    let flight = &scene.flight;
    let target_m = scene.target_m[0];
    ensure!(
        (scene.grid.z_m - target_m[2]).abs() < 1e-9,
        "the sensitivity is that of a target on the image plane: --plane-z {} is not the target's \
         z = {}",
        scene.grid.z_m,
        target_m[2]
    );
    let pulses = flight.position_m.len();
    let sigma_m = match args.position_sigma_m {
        Some(sigma) => vec![[sigma; 3]; pulses],
        None => flight
            .sigma_m
            .clone()
            .context("--position-sigma-from-file: the trajectory states no standard deviations")?,
    };
    let none = vec![[0.0; 3]; pulses];
    let model = match (args.correlation_m, args.correlation_s) {
        (Some(length_m), _) => {
            ErrorModel::new(none, sigma_m, path_m(&flight.position_m), length_m)?
        }
        (_, Some(time_s)) => {
            let stamps = flight
                .time_s
                .clone()
                .context("--correlation-s needs the times of a --trajectory")?;
            ErrorModel::new(none, sigma_m, stamps, time_s)?
        }
        _ => ErrorModel::new(sigma_m, none, path_m(&flight.position_m), 1.0)?,
    };
    let theory = predict(&scene.spread, target_m, &model)?;
    let monte_carlo = match args.trials {
        0 => None,
        n => Some(simulate(
            &scene.spread,
            target_m,
            &model,
            MonteCarlo {
                trials: n,
                seed: args.seed,
            },
            Control::default(),
        )?),
    };
    Ok(Some(Answer {
        position_sigma_m: args.position_sigma_m,
        correlation_m: args.correlation_m,
        correlation_s: args.correlation_s,
        theory,
        monte_carlo,
    }))
}

fn path_m(position_m: &[[f64; 3]]) -> Vec<f64> {
    let mut passed = 0.0;
    let mut path = Vec::with_capacity(position_m.len());
    for (m, p) in position_m.iter().enumerate() {
        if m > 0 {
            let before = position_m[m - 1];
            passed += (0..3)
                .map(|i| (p[i] - before[i]).powi(2))
                .sum::<f64>()
                .sqrt();
        }
        path.push(passed);
    }
    path
}

/// The answer for people.
pub(super) fn text(answer: &Answer) -> String {
    let sigma = answer.position_sigma_m.map_or_else(
        || "those of the file".to_owned(),
        |s| format!("{:.2} cm", 100.0 * s),
    );
    let kind = match (answer.correlation_m, answer.correlation_s) {
        (Some(l), _) => format!("drifting over {l} m"),
        (_, Some(t)) => format!("drifting over {t} s"),
        _ => "new at every pulse".to_owned(),
    };
    let mut text = format!("position errors of {sigma}, {kind}\n");
    let drawn = answer.monte_carlo;
    if let Some(drawn) = drawn {
        let _ = writeln!(
            text,
            "{:<28}{:>10}   {} draws [95 %]",
            "", "theory", drawn.trials
        );
    }
    let t = answer.theory;
    let of = |get: fn(&Simulated) -> Option<Estimate>| drawn.as_ref().and_then(get);
    let lines = [
        (
            "loss at the target, dB",
            1.0,
            Some(t.loss_at_target_db),
            of(|d| Some(d.loss_at_target_db)),
        ),
        (
            "loss at the peak, dB",
            1.0,
            t.peak_loss_db,
            of(|d| Some(d.peak_loss_db)),
        ),
        (
            "shift along, cm rms",
            100.0,
            t.shift_along_m,
            of(|d| Some(d.shift_along_m)),
        ),
        (
            "shift across, cm rms",
            100.0,
            t.shift_across_m,
            of(|d| Some(d.shift_across_m)),
        ),
        (
            "width along, × ideal",
            1.0,
            t.widening_along,
            of(|d| d.widening_along),
        ),
        (
            "width across, × ideal",
            1.0,
            t.widening_across,
            of(|d| d.widening_across),
        ),
    ];
    for (name, scale, theory, drawn) in lines {
        let theory = theory.map_or_else(|| "–".to_owned(), |v| format!("{:.3}", scale * v));
        let drawn = drawn.map_or_else(String::new, |e| {
            let [value, low, high] = [e.value, e.low, e.high].map(|v| scale * v);
            format!("{value:.3} [{low:.3}, {high:.3}]")
        });
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{name:<28}{theory:>10}   {drawn}");
    }
    if !t.focused {
        text.push_str("note: no peak exceeds the speckle by these errors\n");
    }
    text
}
