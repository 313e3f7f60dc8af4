//! Scene files: what they can say, and what is refused.

#![allow(clippy::unwrap_used)] // helpers of tests panic like tests

use std::path::Path;

use acerra_simulate::scene::Scene;
use assert_cmd::Command;
use serde_json::Value;

const FLIGHT: &str = "[flight]\ntrack_start_m = [0, 0]\ntrack_end_m = [8, 0]\nheight_m = 4\n\
                      track_duration_s = 6\n";

#[test]
fn nonsense_is_refused_with_the_reason() {
    let corner = "[[corner]]\nposition_m = [3, 0, 0]\n";
    let gnss = |line: &str| format!("{FLIGHT}[gnss.rover]\n{line}\n");
    let cases = [
        (String::new(), "either [flight] or [trajectory]"),
        (
            format!("{FLIGHT}[trajectory]\nfile = \"a.csv\"\n"),
            "either [flight] or [trajectory]",
        ),
        (
            FLIGHT.replace("height_m = 4", "height_m = -4"),
            "height_m: expected above",
        ),
        (
            FLIGHT.replace("[8, 0]", "[0, 0]"),
            "track_end_m: expected a track",
        ),
        (
            FLIGHT.replace("duration_s = 6", "duration_s = 1e4"),
            "a speed of 0.01",
        ),
        (format!("{FLIGHT}speed = 3\n"), "unknown field `speed`"),
        (
            format!("{FLIGHT}[radar]\nsamples = 100\n"),
            "samples: expected a multiple of 96",
        ),
        (
            format!("{FLIGHT}[radar]\nband_ghz = [4.8, 3.1]\n"),
            "an upper edge above the lower",
        ),
        (
            format!("{FLIGHT}[radar]\nlost_packets = 2.0\n"),
            "lost_packets: expected 0 to 0.9",
        ),
        (
            format!("{FLIGHT}[radar]\nintegration_index = 40\n"),
            "integration_index: expected 6 to 15",
        ),
        (
            format!("{FLIGHT}[radar]\ncoupling_db = -30.0\n"),
            "coupling_db: expected 0 to 400",
        ),
        (
            format!("{FLIGHT}{corner}edge_m = -0.4\n"),
            "edge_m: expected 0 to 100 m",
        ),
        (
            format!("{FLIGHT}{corner}elevation_deg = 120.0\n"),
            "elevation_deg: expected -90 to 90",
        ),
        (
            format!("{FLIGHT}[[point]]\nposition_m = [0, 0, 0]\nrcs_m2 = 0.0\n"),
            "rcs_m2: expected above 0",
        ),
        (
            format!("{FLIGHT}[ground]\nreflection = 1.5\n"),
            "reflection: expected -1 to 1",
        ),
        (
            format!(
                "{FLIGHT}[[clutter]]\nfrom_m = [0, 0, 0]\nto_m = [1, 1, 1]\nscatterers = 0\nrcs_m2 = 1.0\n"
            ),
            "scatterers: expected 1 to a million, found 0",
        ),
        (gnss("interval_s = 0.0333"), "interval_s: expected"),
        (
            gnss("phase_noise_m = 1.0"),
            "phase_noise_m: expected 0 to 0.1 m",
        ),
        (gnss("half_cycle_time_s = [9.0, 2.0]"), "half_cycle_time_s"),
        (
            gnss("outages_s = [[5.0, 1.0]]"),
            "outages_s: expected begin before end",
        ),
        (
            format!("origin_deg_m = [95.0, 0.0, 0.0]\n{FLIGHT}"),
            "origin_deg_m",
        ),
        (
            format!("start_gpst = [2019, 13, 1, 0, 0, 0]\n{FLIGHT}"),
            "start_gpst",
        ),
        (format!("base_m = [1e9, 0.0, 0.0]\n{FLIGHT}"), "base_m"),
        (format!("{FLIGHT}[image]\npixel_m = 0.0\n"), "[image]"),
        (format!("{FLIGHT}[image\n"), "line 6"),
    ];
    for (text, reason) in cases {
        let said = Scene::parse(&text).map(|_| ()).unwrap_err().to_string();
        assert!(said.contains(reason), "expected {reason:?}, found {said:?}");
    }
}

fn acerra(folder: &Path, arguments: &[&str]) -> std::process::Output {
    Command::cargo_bin("acerra")
        .unwrap()
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap()
}

/// A bent flight from a file, beside the scene file, is flown, imaged, and can be flown again from
/// what was written.
#[test]
fn a_given_trajectory_is_flown() {
    let here = tempfile::tempdir().unwrap();
    let folder = here.path();
    let mut csv = "time_s,x_m,y_m,z_m\n".to_owned();
    for k in 0..=100 {
        let t = 0.1 * f64::from(k);
        csv += &format!("{t:.1},{:.4},{:.4},4.0\n", 0.8 * t, 0.5 * (0.4 * t).sin());
    }
    std::fs::create_dir(folder.join("in")).unwrap();
    std::fs::write(folder.join("in/flown.csv"), csv).unwrap();
    std::fs::write(
        folder.join("in/scene.toml"),
        "[trajectory]\nfile = \"flown.csv\"\non_track_s = [1.0, 9.0]\n\
         [[point]]\nposition_m = [4.0, 1.5, 0.0]\nrcs_m2 = 3.0\n[radar]\nsamples = 960\n\
         [image]\nx_m = [3, 5]\ny_m = [0.5, 2.5]\npixel_m = 0.02\n",
    )
    .unwrap();
    let flown = acerra(folder, &["simulate", "in/scene.toml", "-o", "logs"]);
    assert!(
        flown.status.success(),
        "{}",
        String::from_utf8_lossy(&flown.stderr)
    );
    // 8 s at 14.28 Hz.
    assert!(String::from_utf8_lossy(&flown.stdout).starts_with("115 scans"));
    // Nothing tells the radio's delay where there is no ground.
    let campaign = std::fs::read_to_string(folder.join("logs/campaign.toml")).unwrap();
    let campaign = campaign.replace("radar.mrm\"", "radar.mrm\"\ndelay_ns = 10.0");
    std::fs::write(folder.join("logs/campaign.toml"), campaign).unwrap();
    let focused = acerra(folder, &["focus", "logs/campaign.toml", "-o", "out"]);
    assert!(
        focused.status.success(),
        "{}",
        String::from_utf8_lossy(&focused.stderr)
    );
    let targets = std::fs::read_to_string(folder.join("out/targets.json")).unwrap();
    let targets: Value = serde_json::from_str(&targets).unwrap();
    let at = |key: &str| targets["targets"][0][key].as_f64().unwrap();
    assert!(
        (at("x_m") - 4.0).abs() < 0.02 && (at("y_m") - 1.5).abs() < 0.03,
        "{targets}"
    );

    let again = acerra(folder, &["simulate", "logs/scene.toml", "-o", "again"]);
    assert!(
        again.status.success(),
        "{}",
        String::from_utf8_lossy(&again.stderr)
    );
    let log = |name: &str| std::fs::read(folder.join(name).join("radar.mrm")).unwrap();
    assert!(log("logs") == log("again"));

    std::fs::write(
        folder.join("in/lost.toml"),
        "[trajectory]\nfile = \"nowhere.csv\"\n",
    )
    .unwrap();
    let lost = acerra(folder, &["simulate", "in/lost.toml", "-o", "never"]);
    let said = String::from_utf8_lossy(&lost.stderr).into_owned();
    assert_eq!(lost.status.code(), Some(1));
    assert!(
        said.contains("in/nowhere.csv") && !folder.join("never").exists(),
        "{said}"
    );
}

/// The sky of a navigation file, which goes with the logs.
#[test]
fn a_navigation_file_brings_the_satellites() {
    let here = tempfile::tempdir().unwrap();
    let folder = here.path();
    let scene = |gnss: &str| {
        let flight = FLIGHT.replace("[flight]", "[flight]\nground_time_s = 2");
        format!("{flight}[radar]\nsamples = 96\n[gnss]\n{gnss}")
    };
    std::fs::write(folder.join("made.toml"), scene("")).unwrap();
    let made = acerra(folder, &["simulate", "made.toml", "-o", "made"]);
    assert!(
        made.status.success(),
        "{}",
        String::from_utf8_lossy(&made.stderr)
    );
    let given = scene("navigation = \"made/broadcast.nav\"\n");
    std::fs::write(folder.join("given.toml"), given).unwrap();
    let given = acerra(folder, &["simulate", "given.toml", "-o", "given"]);
    assert!(
        given.status.success(),
        "{}",
        String::from_utf8_lossy(&given.stderr)
    );
    let satellites = |name: &str| {
        let text = std::fs::read_to_string(folder.join(name).join("rover.obs")).unwrap();
        let first = text
            .lines()
            .skip_while(|l| !l.contains("END OF HEADER"))
            .nth(1);
        first.unwrap()[29..].trim_end().to_owned()
    };
    assert!(satellites("made").len() > 10);
    assert_eq!(satellites("made"), satellites("given"));
    let again = acerra(folder, &["simulate", "given/scene.toml", "-o", "again"]);
    assert!(
        again.status.success(),
        "{}",
        String::from_utf8_lossy(&again.stderr)
    );

    std::fs::write(folder.join("lost.toml"), scene("navigation = \"no.nav\"\n")).unwrap();
    let lost = acerra(folder, &["simulate", "lost.toml", "-o", "never"]);
    let said = String::from_utf8_lossy(&lost.stderr).into_owned();
    assert!(
        lost.status.code() == Some(1) && said.contains("no.nav"),
        "{said}"
    );
}
