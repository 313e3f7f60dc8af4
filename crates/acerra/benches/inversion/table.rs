//! Rows of the page.

use std::fmt::Write as _;

use acerra_invert::PointResponse;

use crate::Imaged;
use crate::measure::{Measured, measure};
use crate::scene::Scene;
use crate::solve::Run;

/// One row for each target of each scene by each method: what it shows.
pub fn targets(imaged: &[Imaged]) -> String {
    let mut text = "| scene | method | along −3 dB, m | across −3 dB, m | off, m | artefacts, dB | ghost, dB | \
                    iterations |\n| --- | --- | --- | --- | --- | --- | --- | --- |\n"
        .to_owned();
    for (scene, runs) in imaged {
        for index in 0..scene.targets.len() {
            for run in runs {
                let measured = measure(scene, &run.focused.image, index);
                let name = format!("{}{}", scene.name, scene.targets[index].name);
                let _ = writeln!(
                    text,
                    "| {name} | {} | {} | {} |",
                    run.method.name(),
                    shown(&measured),
                    iterations(run),
                );
            }
        }
    }
    text
}

/// One row for each scene by each method: what it took.
pub fn costs(imaged: &[Imaged]) -> String {
    let mut text = COSTS_HEAD.to_owned();
    for (scene, runs) in imaged {
        let grid = scene.pixels.grid;
        let size = format!("{} × {} × {}", grid.nx, grid.ny, scene.aligned.traces.len());
        for run in runs {
            text.push_str(&cost(&format!("{}, {size}", scene.name), run));
        }
    }
    text
}

pub const COSTS_HEAD: &str = "| scene, pixels × pulses | method | iterations | elapsed, s | processor, s | s an \
                              iteration | announced, MB |\n\
                              | --- | --- | --- | --- | --- | --- | --- |\n";

/// A row of [`costs`].
pub fn cost(scene: &str, run: &Run) -> String {
    let cost = run.cost;
    format!(
        "| {scene} | {} | {} | {} | {} | {} | {:.0} |\n",
        run.method.name(),
        iterations(run),
        seconds(cost.seconds),
        seconds(cost.processor_s),
        number(run.iteration_s, 2),
        run.focused.promised_bytes as f64 * 1e-6,
    )
}

/// One row for each scene by each method: memory that it took and that it announced before.
pub fn memory(imaged: &[Imaged]) -> String {
    let mut text = "| scene | method | iterations | greatest, MB | announced, MB |\n\
                    | --- | --- | --- | --- | --- |\n"
        .to_owned();
    for (scene, runs) in imaged {
        for run in runs {
            let _ = writeln!(
                text,
                "| {} | {} | {} | {:.0} | {:.0} |",
                scene.name,
                run.method.name(),
                iterations(run),
                run.cost.memory_bytes * 1e-6,
                run.focused.promised_bytes as f64 * 1e-6,
            );
        }
    }
    text
}

/// What is told of a run while others go on.
pub fn progress(scene: &Scene, run: &Run) -> String {
    let stop = run.focused.inversion.as_ref().map(|record| record.stop);
    let shown = (0..scene.targets.len())
        .map(|index| shown(&measure(scene, &run.focused.image, index)))
        .collect::<Vec<_>>();
    let row = cost(&scene.name, run);
    format!(
        "{}  {shown:?}, stop {stop:?}, change {:?}",
        row.trim_end(),
        run.change()
    )
}

/// Iterations done, marked where they were spent before the solution had settled.
fn iterations(run: &Run) -> String {
    match (run.iterations(), run.is_settled()) {
        (Some(count), Some(true)) => count.to_string(),
        (Some(count), _) => format!("{count}*"),
        (None, _) => "–".to_owned(),
    }
}

fn shown(measured: &Measured) -> String {
    let of = |value: fn(&PointResponse) -> Option<f64>| measured.response.as_ref().and_then(value);
    [
        number(of(|r| r.along_3db_m), 3),
        number(of(|r| r.across_3db_m), 3),
        number(measured.off_m, 3),
        number(of(|r| r.artefact_db), 1),
        number(measured.ghost_db, 1),
    ]
    .join(" | ")
}

/// Seconds, to a tenth where they are few.
fn seconds(seconds: f64) -> String {
    let decimals = if seconds < 10.0 { 1 } else { 0 };
    format!("{seconds:.decimals$}")
}

fn number(value: Option<f64>, decimals: usize) -> String {
    value.map_or("–".to_owned(), |v| {
        // What rounds to zero has no sign.
        let unit = 10f64.powi(decimals as i32);
        format!("{:.decimals$}", (v * unit).round() / unit + 0.0)
    })
}
