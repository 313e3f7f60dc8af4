//! The field solver of the validation book's scenes beside gprMax.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use std::path::Path;

use acerra_npz::NpzReader;
use serde::Deserialize;
use xtask::ground::fdtd::{Fields, STEPS_PER_SAMPLE, step_s};
use xtask::ground::scene::{RECEIVER_CELLS, Scene};

#[derive(Deserialize)]
struct Traces {
    traces: Vec<Trace>,
}

#[derive(Deserialize)]
struct Trace {
    scene: String,
    trace: usize,
    field_v_m: Vec<f64>,
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    dot(a, b) / (dot(a, a) * dot(b, b)).sqrt()
}

/// Samples from `from` on, `later` samples (not whole) after them.
fn shifted(values: &[f64], from: usize, count: usize, later: f64) -> Vec<f64> {
    let at = |place: f64| {
        let k = place.floor() as usize;
        values[k] + (place - k as f64) * (values[k + 1] - values[k])
    };
    (from..from + count).map(|k| at(k as f64 + later)).collect()
}

/// Coupling, echo of the surface and echoes from below it are those of gprMax over lossy soil, layers and relief. Buried
/// bodies are rounded to cells otherwise there (outwards by half a cell, their centres to the grid): their echoes agree but
/// for as much time, 3 mm of depth.
#[test]
fn fields_are_those_of_gprmax() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("tests/gprmax-traces.json")).unwrap();
    let traces: Traces = serde_json::from_str(&text).unwrap();
    assert_eq!(traces.traces.len(), 3);
    let sample_s = STEPS_PER_SAMPLE as f64 * step_s();
    let sample = |time_s: f64| (time_s / sample_s).ceil() as usize;
    for Trace {
        scene: name,
        trace,
        field_v_m,
    } in traces.traces
    {
        let file = root.join(format!("../docs/validation/ground/{name}.json"));
        let scene = Scene::read(&file).unwrap();
        let [x, z] = scene.transmitter_cells().unwrap()[trace];
        let steps = field_v_m.len() * STEPS_PER_SAMPLE;
        let own = Fields::new(&scene.materials()).trace([x, z], [x + RECEIVER_CELLS, z], steps);
        let own: Vec<f64> = own.into_iter().map(f64::from).collect();
        let agree = |from_s: f64, later_s: f64| {
            let (from, to) = (sample(from_s), sample(13.8e-9));
            let other = shifted(&field_v_m, from, to - from, later_s / sample_s);
            correlation(&own[from..to], &other)
        };
        let whole = agree(0.0, 0.0);
        let after_coupling = agree(4.5e-9, 0.0);
        let buried = (-10..=10)
            .map(|k| agree(7.6e-9, f64::from(k) * 4e-12))
            .fold(0.0, f64::max);
        println!("{name}: {whole:.5}, after the coupling {after_coupling:.4}, buried {buried:.4}");
        assert!(whole > 0.9998, "{name}: {whole}");
        assert!(after_coupling > 0.975, "{name}: {after_coupling}");
        assert!(buried > 0.93, "{name}: {buried}");
    }
}

/// The committed traces are what the solver gives of the committed statements: one trace of each scene.
#[test]
fn the_traces_of_the_book_are_those_of_its_scenes() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/validation/ground");
    let names = Scene::names(&folder).unwrap();
    assert!(names.len() >= 10, "{names:?}");
    for (number, name) in names.iter().enumerate() {
        let scene = Scene::read(&folder.join(format!("{name}.json"))).unwrap();
        let file = std::fs::File::open(folder.join(format!("{name}.npz"))).unwrap();
        let (shape, values) = NpzReader::new(file)
            .unwrap()
            .values("data", 1_000_000)
            .unwrap();
        let [traces, samples] = [shape[0], shape[1]].map(|n| n as usize);
        let positions = scene.transmitter_cells().unwrap();
        assert_eq!(positions.len(), traces);
        let trace = (7 * number + 5) % traces;
        let [x, z] = positions[trace];
        let steps = samples * STEPS_PER_SAMPLE;
        let own = Fields::new(&scene.materials()).trace([x, z], [x + RECEIVER_CELLS, z], steps);
        let committed = &values[trace * samples..(trace + 1) * samples];
        let difference: f64 = own
            .iter()
            .zip(committed)
            .map(|(a, b)| (f64::from(*a) - b.0).powi(2))
            .sum();
        let power: f64 = committed.iter().map(|v| v.0 * v.0).sum();
        let share = (difference / power).sqrt();
        assert!(share < 1e-4, "{name}, trace {trace}: {share}");
    }
}
