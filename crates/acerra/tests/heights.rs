//! Heights as poor as single-point positions give them: told where they are used, and replaced by those
//! of the surface echo where that is asked for.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use acerra::demo::TRACKS;
use acerra_simulate::write::simulate_campaign;
use assert_cmd::Command;
use serde_json::Value;

/// East and north of the demonstration's reflectors (m).
const REFLECTORS_M: [[f64; 2]; 2] = [[4.0, 0.0], [14.0, 0.0]];

/// The demonstration's second track, with heights of its trajectory 1 m too great that wander slowly by
/// half a metre.
fn flight(folder: &Path) -> f64 {
    let scene = TRACKS[1].on_track().unwrap();
    for file in simulate_campaign(&scene).unwrap().files {
        fs::write(folder.join(&file.name), &file.bytes).unwrap();
    }
    let text = fs::read_to_string(folder.join("truth-trajectory.csv")).unwrap();
    let mut lines = text.lines();
    let mut wandering = format!("{}\n", lines.next().unwrap());
    for line in lines {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        let [time_s, height_m] = [0, 3].map(|k| cells[k].parse::<f64>().unwrap());
        let error_m = 1.0 + 0.5 * (0.11 * time_s).sin() + 0.2 * (0.31 * time_s).cos();
        cells[3] = format!("{:.5}", height_m + error_m);
        let _ = writeln!(wandering, "{}", cells.join(","));
    }
    fs::write(folder.join("wandering.csv"), wandering).unwrap();
    let truth = fs::read_to_string(folder.join("truth.json")).unwrap();
    let truth: Value = serde_json::from_str(&truth).unwrap();
    truth["time_offset_s"].as_f64().unwrap()
}

/// Exit code, standard error, and the products' `run.json` and `targets.json` of a campaign.
fn focused(folder: &Path, offset_s: f64, height: &str) -> (Option<i32>, String, Value, Value) {
    let campaign = format!(
        "[radar]\nfile = 'radar.mrm'\ndelay_ns = 10.0\n[trajectory]\nfile = 'wandering.csv'\n\
         time_offset_s = {offset_s}\nlever_arm_m = [0.05, 0.0, -0.2]\n{height}\n\
         [image]\nx_m = [0, 18]\ny_m = [-9, 9]\npixel_m = 0.03\n"
    );
    let file = folder.join("heights.toml");
    fs::write(&file, campaign).unwrap();
    let products = folder.join("products");
    let output = Command::cargo_bin("acerra")
        .unwrap()
        .args([
            "focus",
            file.to_str().unwrap(),
            "-o",
            products.to_str().unwrap(),
        ])
        .output()
        .unwrap();
    let json = |name: &str| {
        let text = fs::read_to_string(products.join(name)).unwrap_or_default();
        serde_json::from_str(&text).unwrap_or(Value::Null)
    };
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    (
        output.status.code(),
        told,
        json("run.json"),
        json("targets.json"),
    )
}

#[test]
fn wandering_heights_are_doubted_and_those_of_the_radar_put_the_reflectors_in_place() {
    let folder = tempfile::tempdir().unwrap();
    let offset_s = flight(folder.path());
    let (_, told, _, _) = focused(folder.path(), offset_s, "");
    assert!(told.contains("surface_height"), "{told}");
    let (code, told, run, targets) = focused(folder.path(), offset_s, "height = 'radar'");
    assert_eq!(code, Some(0), "{told}");
    let doubts: Vec<&Value> = run["evidence"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|finding| finding["verdict"] != "agrees")
        .collect();
    assert!(doubts.is_empty(), "{doubts:?}");
    let targets = targets["targets"].as_array().unwrap();
    assert_eq!(targets.len(), 2, "{targets:?}");
    for [x_m, y_m] in REFLECTORS_M {
        let is_near = |target: &&Value| {
            let off = |axis: &str, at: f64| (target[axis].as_f64().unwrap() - at).abs();
            off("x_m", x_m) < 0.1 && off("y_m", y_m) < 0.35
        };
        assert!(targets.iter().any(|t| is_near(&t)), "{targets:?}");
    }
}
