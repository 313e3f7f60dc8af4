//! `acerra psf` and `acerra resolution`, run as a user runs them.

#![allow(clippy::unwrap_used)] // helpers of tests

use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;

fn acerra(arguments: &str, directory: &Path) -> std::process::Output {
    Command::cargo_bin("acerra")
        .unwrap()
        .current_dir(directory)
        .args(arguments.split_whitespace())
        .output()
        .unwrap()
}

fn json(arguments: &str, directory: &Path) -> Value {
    let output = acerra(arguments, directory);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{arguments}: {error}");
    serde_json::from_slice(&output.stdout).unwrap()
}

fn refused(arguments: &str, directory: &Path, code: i32, reason: &str) {
    let output = acerra(arguments, directory);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{arguments}: {error}");
    assert!(error.contains(reason), "{arguments}: {error}");
    assert!(output.stdout.is_empty());
}

#[test]
fn psf_answers_by_the_contract() {
    let here = tempfile::tempdir().unwrap();
    let a = json(
        "psf --height 5 --offset 2 --track cosine:0.15:24 --light-speed 3e8 --json",
        here.path(),
    );
    let number = |pointer: &str| a.pointer(pointer).and_then(Value::as_f64).unwrap();
    for (pointer, expected, tolerance) in [
        ("/peak/x_m", 0.0, 0.005),
        ("/peak/y_m", 2.0, 0.01),
        ("/along/rayleigh_m", 0.041, 0.03 * 0.041),
        ("/along/width_3db_m", 0.035, 0.001),
        ("/along/width_6db_m", 0.048, 0.001),
        ("/across/rayleigh_m", 0.265, 0.03 * 0.265),
        ("/across/inner_m", 0.280, 0.03 * 0.280),
        ("/across/outer_m", 0.250, 0.03 * 0.250),
        ("/ghost/level", 0.504, 0.01),
        ("/ghost/x_m", 0.0, 0.1),
        ("/ghost/y_m", -1.7, 0.05),
        ("/theory/range_m", 3e8 / 3.4e9, 1e-9),
    ] {
        assert!(
            (number(pointer) - expected).abs() <= tolerance,
            "{pointer}: {}",
            number(pointer)
        );
    }
    for pointer in [
        "/across/width_3db_m",
        "/across/width_6db_m",
        "/pslr_db",
        "/islr_db",
        "/theory/along_m",
        "/theory/across_m",
    ] {
        assert!(number(pointer).is_finite(), "{pointer}");
    }
    // A target under the track is one with its ghost.
    let nadir = json("psf --height 5 --offset 0 --json", here.path());
    assert!(nadir["ghost"].is_null() && nadir["across"]["rayleigh_m"].is_f64());
}

#[test]
fn psf_follows_a_recorded_flight() {
    let here = tempfile::tempdir().unwrap();
    let mut table = "time_s,x_m,y_m,z_m\n".to_owned();
    for k in 0..=300 {
        // North-bound at 7 m east.
        let s = 0.02 * f64::from(k) - 3.0;
        table += &format!("{:.2},7.0,{s:.3},5.0\n", 0.02 * f64::from(k));
    }
    std::fs::write(here.path().join("flight.csv"), table).unwrap();
    let a = json(
        "psf --trajectory flight.csv --target 5,0,0 --json -o out",
        here.path(),
    );
    assert!((a["peak"]["x_m"].as_f64().unwrap() - 5.0).abs() < 0.01);
    assert!((a["across"]["rayleigh_m"].as_f64().unwrap() - 0.247).abs() < 0.008);
    assert!((a["ghost"]["x_m"].as_f64().unwrap() - 9.0).abs() < 0.02);
    let sampled = json(
        "psf --trajectory flight.csv --step-m 0.01 --target 5,0,0 --json",
        here.path(),
    );
    let along = |v: &Value| v["along"]["rayleigh_m"].as_f64().unwrap();
    assert!((along(&sampled) / along(&a) - 1.0).abs() < 0.01);
    for name in ["psf.png", "cuts.png", "cuts.csv", "track.csv", "psf.json"] {
        assert!(
            here.path().join("out").join(name).metadata().unwrap().len() > 100,
            "{name}"
        );
    }
}

#[test]
fn targets_off_the_plane_are_tabulated() {
    let here = tempfile::tempdir().unwrap();
    std::fs::write(
        here.path().join("t.csv"),
        "x_m,y_m,z_m\n-1.5,0,0\n0,0,0.2\n",
    )
    .unwrap();
    let common = "psf --height 5 --targets t.csv --half-width-m 2 --pixel-m 0.04";
    let a = json(
        &format!("{common} --plane-z 0.2 --json -o out"),
        here.path(),
    );
    let t = &a["targets"];
    assert!((t[0]["retrieved"]["y_m"].as_f64().unwrap() - 1.40).abs() < 0.05);
    assert!((t[0]["expected"]["y_m"].as_f64().unwrap() - 1.40).abs() < 0.005);
    assert_eq!(t[0]["mirrored"], true);
    assert!(t[1]["retrieved"]["y_m"].as_f64().unwrap().abs() < 0.05);
    assert!(
        here.path().join("out/targets.json").exists() && here.path().join("out/psf.png").exists()
    );
    let b = json(&format!("{common} --plane-z 0 --json"), here.path());
    assert!(b["targets"][1]["retrieved"].is_null() && b["targets"][1]["expected"].is_null());
    assert!(b["targets"][1]["level_db"].as_f64().unwrap() < -20.0);
}

#[test]
fn positioning_errors_are_told_by_theory_and_draws() {
    let here = tempfile::tempdir().unwrap();
    let common = "psf --height 5 --offset 2 --step-m 0.03 --json --position-sigma-m 0.005";
    let a = json(&format!("{common} --trials 100"), here.path());
    let s = &a["sensitivity"];
    let number = |pointer: &str| s.pointer(pointer).and_then(Value::as_f64).unwrap();
    // 0.83 rad at the middle of the band.
    assert!((number("/theory/peak_loss_db") + 2.95).abs() < 0.1);
    // Three times the 95 % interval: what fails by chance once in 10⁸ runs, and seeds are fixed.
    for key in [
        "loss_at_target_db",
        "peak_loss_db",
        "shift_along_m",
        "shift_across_m",
        "widening_along",
    ] {
        let value = number(&format!("/monte_carlo/{key}/value"));
        let reach = number(&format!("/monte_carlo/{key}/high")) - value;
        let theory = number(&format!("/theory/{key}"));
        assert!(
            (theory - value).abs() < 3.0 * reach,
            "{key}: {theory} {value} {reach}"
        );
    }
    assert_eq!(a, json(&format!("{common} --trials 100"), here.path()));
    let theory_only = json(
        &format!("{common} --trials 0 --correlation-m 20"),
        here.path(),
    );
    let s = &theory_only["sensitivity"];
    assert!(s["monte_carlo"].is_null() && s["theory"]["peak_loss_db"].as_f64().unwrap() > -0.2);

    // A recorded flight with its own standard deviations: those of the table, 5 mm.
    let mut table = "time_s,x_m,y_m,z_m,sd_x,sd_y,sd_z\n".to_owned();
    for k in 0..=200 {
        // Digits down to nanometres: the step of the last digit adds nothing to the stated deviations.
        let (t, x) = (0.03 * f64::from(k), 0.03 * f64::from(k) - 3.0);
        let x = x + 1e-9 * f64::from(k % 7);
        table += &format!("{t:.2},{x:.9},0.0,5.0,0.005,0.005,0.005\n");
    }
    std::fs::write(here.path().join("flight.csv"), table).unwrap();
    let b = json(
        "psf --trajectory flight.csv --target 0,2,0 --json --position-sigma-from-file --trials 0",
        here.path(),
    );
    let loss = |v: &Value| {
        v["sensitivity"]["theory"]["loss_at_target_db"]
            .as_f64()
            .unwrap()
    };
    assert!((loss(&b) - loss(&a)).abs() < 1e-6);
}

#[test]
fn resolution_answers_and_maps() {
    let here = tempfile::tempdir().unwrap();
    let a = json(
        "resolution --height 10 --offset 2 --half-aperture-m 9 --light-speed 3e8 --json -o map",
        here.path(),
    );
    let number = |key: &str| a[key].as_f64().unwrap();
    assert!((number("across_m") - 0.410).abs() < 5e-4);
    assert!((number("along_m") - 0.0287).abs() < 5e-5);
    assert!((number("range_m") - 0.08824).abs() < 1e-5);
    let csv = std::fs::read_to_string(here.path().join("map/resolution-map.csv")).unwrap();
    assert_eq!(csv.lines().count(), 101);
    let last: Vec<f64> = csv
        .lines()
        .last()
        .unwrap()
        .split(',')
        .map(|v| v.parse().unwrap())
        .collect();
    // 10 m up: Eq. (10) at offset 0. The map uses the speed asked for.
    assert!((last[0] - 10.0).abs() < 1e-9 && (last[1] - 1.331).abs() < 5e-4);
    assert!(here.path().join("map/resolution-map.png").exists());
    let without = json("resolution --height 5 --offset 2 --json", here.path());
    assert!(without["along_m"].is_null());
}

#[test]
fn impossible_input_is_refused_with_the_reason() {
    let here = tempfile::tempdir().unwrap();
    let at = here.path();
    std::fs::write(at.join("bad.csv"), "1,2\n").unwrap();
    for (arguments, code, reason) in [
        ("resolution --height -5 --offset 2", 2, "above 0"),
        ("resolution --height 5 --offset -2", 2, "not below 0"),
        (
            "resolution --height 5 --offset 2 --band-ghz 4:4",
            2,
            "no bandwidth",
        ),
        ("resolution --height 5", 2, "--offset"),
        ("psf --height -5 --offset 2", 2, "above 0"),
        ("psf --height 5", 2, "--offset"),
        ("psf --offset 2", 2, "--height"),
        (
            "psf --height 5 --offset 2 --band-ghz 4:4",
            2,
            "no bandwidth",
        ),
        (
            "psf --height 5 --offset 2 --track circle",
            2,
            "cosine:AMPLITUDE_M:PERIOD_M",
        ),
        (
            "psf --height 5 --offset 2 --frequencies 1",
            2,
            "1 is not in",
        ),
        ("psf --height 5 --target 0,0,6", 1, "not below the drone"),
        (
            "psf --height 5 --offset 2 --plane-z 5",
            1,
            "not below the drone",
        ),
        ("psf --height 5 --offset 2 --step-m 0.05", 1, "alias"),
        (
            "psf --height 5 --offset 2 --frequencies 20",
            1,
            "repeat every",
        ),
        ("psf --height 5 --offset 2 --pixel-m 1e-6 -o x", 1, "bytes"),
        ("psf --height 5 --targets missing.csv", 1, "missing.csv"),
        ("psf --height 5 --targets bad.csv", 1, "line 1"),
        (
            "psf --trajectory missing.pos --target 0,0,0",
            1,
            "missing.pos",
        ),
    ] {
        refused(arguments, at, code, reason);
    }
    assert!(!at.join("x").exists());
}
