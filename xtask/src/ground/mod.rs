//! Full-wave scenes of the validation book: the record of a radar above the ground over buried cylinders, by
//! finite differences in the time domain, independent of Acerra's ray paths.
//!
//! `docs/validation/ground/NAME.json` states a scene ([`scene::Scene`]), `NAME.npz` holds its traces. [`fdtd`] solves
//! Maxwell's equations in the plane of the flight; traces by gprMax of the same scenes (`gprmax.json`) are compared with
//! it.

pub mod fdtd;
pub mod scene;

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use acerra_npz::NpzWriter;
use anyhow::Context;

use fdtd::{Fields, STEPS_PER_SAMPLE, step_s};
use scene::{RECEIVER_CELLS, Scene};

/// Steps computed of each trace: 17 ns.
const STEPS: usize = 1800;
/// Time between traces, s: nominal, since the antennas keep still during each.
const TRACE_INTERVAL_S: f64 = 0.05;

/// Computes the scenes named in `names` (all those of `folder` if none is) and writes their traces to `folder`; `done` is
/// called with a line on each.
///
/// # Errors
/// If a scene cannot be read, or its traces not be written.
pub fn write(folder: &Path, names: &[String], done: impl Fn(&str)) -> anyhow::Result<()> {
    for name in if names.is_empty() {
        Scene::names(folder)?
    } else {
        names.to_vec()
    } {
        let scene = Scene::read(&folder.join(format!("{name}.json")))?;
        let start = std::time::Instant::now();
        let traces = traces(&scene)?;
        save(&scene, &traces, &folder.join(format!("{name}.npz")))?;
        done(&format!(
            "{name}: {} traces in {:.0} s",
            traces.len(),
            start.elapsed().as_secs_f64()
        ));
    }
    Ok(())
}

/// The traces of a scene, one a position of the antennas; two threads share them.
///
/// # Errors
/// If a trace's antennas lie outside the domain.
pub fn traces(scene: &Scene) -> anyhow::Result<Vec<Vec<f32>>> {
    let material = scene.materials();
    let positions = scene.transmitter_cells()?;
    let (first, second) = positions.split_at(positions.len() / 2);
    let run = |part: &[[usize; 2]]| -> Vec<Vec<f32>> {
        let mut fields = Fields::new(&material);
        let trace = |[x, z]: &[usize; 2]| fields.trace([*x, *z], [x + RECEIVER_CELLS, *z], STEPS);
        part.iter().map(trace).collect()
    };
    std::thread::scope(|scope| {
        let later = scope.spawn(|| run(second));
        let mut traces = run(first);
        let later = later
            .join()
            .map_err(|_| anyhow::anyhow!("a thread of the field solver failed"))?;
        traces.extend(later);
        Ok(traces)
    })
}

fn save(scene: &Scene, traces: &[Vec<f32>], path: &Path) -> anyhow::Result<()> {
    let mut npz = NpzWriter::deflated(BufWriter::new(
        File::create(path).with_context(|| path.display().to_string())?,
    ));
    let (count, samples) = (traces.len() as u64, traces[0].len() as u64);
    npz.array("data", &[count, samples], traces.iter().flatten().copied())?;
    let sample_s = step_s() * STEPS_PER_SAMPLE as f64;
    npz.array(
        "fast_time_s",
        &[samples],
        (0..samples).map(|k| k as f64 * sample_s),
    )?;
    npz.array(
        "time_s",
        &[count],
        (0..count).map(|k| k as f64 * TRACE_INTERVAL_S),
    )?;
    let [transmitters, receivers] = scene.antennas_m();
    npz.array(
        "transmitter_m",
        &[count, 3],
        transmitters.into_iter().flatten(),
    )?;
    npz.array("receiver_m", &[count, 3], receivers.into_iter().flatten())?;
    npz.finish()?;
    Ok(())
}
