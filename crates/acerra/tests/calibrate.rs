//! `acerra calibrate` as a user runs it, on a simulated flight over three reflectors.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;

const SCENE: &str = "seed = 5\n\
    [flight]\ntrack_start_m = [0, 0]\ntrack_end_m = [16, 0]\nheight_m = 5\n\
    track_duration_s = 10\n\
    [radar]\nsamples = 960\ndelay_ns = 12.6\nlever_arm_m = [0.05, 0.0, -0.2]\n\
    [ground]\nfacets_per_m2 = 1\nextent_m = 5\n\
    [[point]]\nposition_m = [4, 1.5, 0]\nrcs_m2 = 4\n\
    [[point]]\nposition_m = [9, -2, 0]\nrcs_m2 = 4\n\
    [[point]]\nposition_m = [12, 2.5, 0.2]\nrcs_m2 = 4\n\
    [image]\nx_m = [2, 4]\ny_m = [0.5, 2.5]\npixel_m = 0.02\n";

fn acerra(arguments: &[&str]) -> std::process::Output {
    Command::cargo_bin("acerra")
        .unwrap()
        .args(arguments)
        .output()
        .unwrap()
}

fn stderr(output: &std::process::Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn estimate<'a>(record: &'a Value, name: &str) -> &'a Value {
    let all = record["estimates"].as_array().unwrap();
    all.iter().find(|e| e["name"] == name).unwrap()
}

/// Simulates the flight, and makes its campaign one that knows the offset to half a second only.
fn campaign(folder: &Path) -> (std::path::PathBuf, f64) {
    campaign_of(folder, SCENE)
}

fn campaign_of(folder: &Path, flight: &str) -> (std::path::PathBuf, f64) {
    let scene = folder.join("scene.toml");
    fs::write(&scene, flight).unwrap();
    let logs = folder.join("logs");
    let output = acerra(&[
        "simulate",
        scene.to_str().unwrap(),
        "-o",
        logs.to_str().unwrap(),
    ]);
    assert!(output.status.success(), "{}", stderr(&output));
    let file = logs.join("campaign.toml");
    let truth: Value =
        serde_json::from_str(&fs::read_to_string(logs.join("truth.json")).unwrap()).unwrap();
    let offset_s = truth["time_offset_s"].as_f64().unwrap();
    let text = fs::read_to_string(&file).unwrap();
    let line = format!("time_offset_s = {offset_s}");
    assert!(text.contains(&line));
    let text = text.replace(
        &line,
        &format!("time_offset_s = {} # by watch", offset_s - 0.5),
    );
    fs::write(&file, text).unwrap();
    (file, offset_s)
}

#[test]
fn a_simulated_flight_over_reflectors_is_calibrated_and_its_campaign_written() {
    let folder = tempfile::tempdir().unwrap();
    let (file, offset_s) = campaign(folder.path());
    let survey = folder.path().join("points.csv");
    fs::write(
        &survey,
        "name,x_m,y_m,z_m\nA,4,1.5,0\nB,9,-2,0\nC,12,2.5,0.2\n",
    )
    .unwrap();
    let products = folder.path().join("calibration");
    let output = acerra(&[
        "calibrate",
        file.to_str().unwrap(),
        "--survey",
        survey.to_str().unwrap(),
        "--survey-sigma-m",
        "0.001",
        "-o",
        products.to_str().unwrap(),
        "--json",
        "--write",
    ]);
    assert!(output.status.success(), "{}", stderr(&output));
    let record: Value = serde_json::from_slice(&output.stdout).unwrap();
    println!("{record:#}");
    let delay = estimate(&record, "delay");
    assert!(
        (delay["value"].as_f64().unwrap() - 12.6).abs() < 0.05,
        "{delay}"
    );
    let offset = estimate(&record, "clock offset");
    assert!(
        (offset["value"].as_f64().unwrap() - offset_s).abs() < 0.003,
        "{offset}"
    );
    for (name, arm_m) in [
        ("lever arm forward", 0.05),
        ("lever arm left", 0.0),
        ("lever arm up", -0.2),
    ] {
        let arm = estimate(&record, name);
        let error_m = (arm["value"].as_f64().unwrap() - arm_m).abs();
        assert!(arm["observable"] == false || error_m < 0.02, "{arm}");
    }
    let page = fs::read_to_string(products.join("report.html")).unwrap();
    assert!(page.contains("What the geometry cannot determine") && page.contains("<svg"));
    assert!(products.join("calibration.json").exists());
    // The campaign keeps its comments and says what was found.
    let text = fs::read_to_string(&file).unwrap();
    assert!(text.starts_with("# Written by acerra simulate."), "{text}");
    assert!(
        text.contains("# by watch") && text.contains("delay_ns = 12."),
        "{text}"
    );
    let offset_line = text
        .lines()
        .find(|l| l.starts_with("time_offset_s"))
        .unwrap();
    let written: f64 = offset_line
        .split(['=', '#'])
        .nth(1)
        .and_then(|v| v.trim().parse().ok())
        .unwrap();
    assert!((written - offset_s).abs() < 0.003, "{offset_line}");
}

#[test]
fn what_cannot_be_calibrated_is_refused_and_the_campaign_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let (file, _) = campaign(folder.path());
    let before = fs::read(&file).unwrap();
    let name = file.to_str().unwrap();
    let far = acerra(&["calibrate", name, "--reflector", "300,0,0", "--write"]);
    assert_eq!(far.status.code(), Some(1));
    assert!(
        stderr(&far).contains("no echo follows the reflectors"),
        "{}",
        stderr(&far)
    );
    let survey = folder.path().join("points.csv");
    fs::write(&survey, "x_m,y_m,z_m\n1,2\n").unwrap();
    let cut = acerra(&["calibrate", name, "--survey", survey.to_str().unwrap()]);
    assert_eq!(cut.status.code(), Some(1));
    assert!(
        stderr(&cut).contains("points.csv: line 2: expected"),
        "{}",
        stderr(&cut)
    );
    assert_eq!(acerra(&["calibrate", name]).status.code(), Some(2));
    assert_eq!(fs::read(&file).unwrap(), before);
}

/// A straight pass at constant speed without take-off: height and motion leave the offset open by half a minute, which
/// one reflector at a known place settles.
#[test]
fn an_offset_that_the_logs_leave_open_is_settled_by_one_reflector() {
    const PASS: &str = "seed = 7\n\
        [flight]\ntrack_start_m = [0, 0]\ntrack_end_m = [16, 0]\nheight_m = 5\n\
        track_duration_s = 10\nwander_m = [0, 0, 0]\n\
        [radar]\nsamples = 960\ndelay_ns = 12.6\n\
        [ground]\nfacets_per_m2 = 1\nextent_m = 5\n\
        [[point]]\nposition_m = [4, 1.5, 0]\nrcs_m2 = 4\n\
        [image]\nx_m = [2, 6]\ny_m = [0, 3]\npixel_m = 0.02\n";
    let folder = tempfile::tempdir().unwrap();
    let (file, offset_s) = campaign_of(folder.path(), PASS);
    let text = fs::read_to_string(&file).unwrap();
    let stated = format!("time_offset_s = {} # by watch", offset_s - 0.5);
    fs::write(&file, text.replace(&stated, "time_offset_s = \"auto\"")).unwrap();
    let name = file.to_str().unwrap();
    let products = folder.path().join("products");
    let refused = acerra(&["focus", name, "-o", products.to_str().unwrap()]);
    assert_eq!(refused.status.code(), Some(1));
    let message = stderr(&refused);
    assert!(
        message.contains("acerra calibrate --reflector"),
        "{message}"
    );

    let output = acerra(&[
        "calibrate",
        name,
        "--reflector",
        "4,1.5,0",
        "--json",
        "--write",
    ]);
    assert!(output.status.success(), "{}", stderr(&output));
    let record: Value = serde_json::from_slice(&output.stdout).unwrap();
    let offset = estimate(&record, "clock offset");
    let error_s = (offset["value"].as_f64().unwrap() - offset_s).abs();
    assert!(
        error_s < 0.003 && error_s < 3.0 * offset["sigma"].as_f64().unwrap(),
        "{offset}"
    );
    let delay = estimate(&record, "delay");
    assert!(
        (delay["value"].as_f64().unwrap() - 12.6).abs() < 0.05,
        "{delay}"
    );
    let focused = acerra(&["focus", name, "-o", products.to_str().unwrap()]);
    assert!(focused.status.success(), "{}", stderr(&focused));
}
