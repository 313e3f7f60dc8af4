//! `acerra focus`, `simulate` and `info` as a user runs them.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use serde_json::Value;

const SCENE: &str = "seed = 3\n\
    [flight]\ntrack_start_m = [0, 0]\ntrack_end_m = [8, 0]\nheight_m = 4\ntrack_duration_s = 6\n\
    [radar]\nsamples = 960\n[ground]\nfacets_per_m2 = 1\nextent_m = 5\n\
    [[corner]]\nposition_m = [3, 1.5, 0]\n\
    [image]\nx_m = [2, 4]\ny_m = [0.5, 2.5]\npixel_m = 0.02\n";

fn acerra(arguments: &[&str]) -> std::process::Output {
    Command::cargo_bin("acerra")
        .unwrap()
        .args(arguments)
        .output()
        .unwrap()
}

fn simulated(folder: &Path, scene: &str) -> PathBuf {
    let file = folder.join("scene.toml");
    fs::write(&file, scene).unwrap();
    let logs = folder.join("logs");
    made("simulate", &file, &logs);
    logs
}

/// Runs a command that must succeed on a file, into a folder.
fn made(command: &str, file: &Path, folder: &Path) {
    let output = acerra(&[
        command,
        file.to_str().unwrap(),
        "-o",
        folder.to_str().unwrap(),
    ]);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

/// Runs `focus` on a campaign that must fail, and returns its one message.
fn failure(campaign: &Path) -> String {
    let products = campaign.with_file_name("never");
    let output = acerra(&[
        "focus",
        campaign.to_str().unwrap(),
        "-o",
        products.to_str().unwrap(),
    ]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(
        message.starts_with("acerra: ") && !message.contains("panicked"),
        "{message}"
    );
    assert!(!products.exists(), "a failed run left products");
    let left = fs::read_dir(campaign.parent().unwrap()).unwrap();
    let hidden = left.filter(|e| {
        e.as_ref()
            .unwrap()
            .file_name()
            .to_string_lossy()
            .starts_with(".acerra-")
    });
    assert_eq!(hidden.count(), 0, "a failed run left its work");
    message
}

#[test]
fn a_simulated_reflector_is_found_where_it_stands() {
    let folder = tempfile::tempdir().unwrap();
    let logs = simulated(folder.path(), SCENE);
    let products = folder.path().join("products");
    let campaign = logs.join("campaign.toml");
    let output = acerra(&[
        "focus",
        campaign.to_str().unwrap(),
        "-o",
        products.to_str().unwrap(),
    ]);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );

    let targets = json(&products.join("targets.json"));
    let first = &targets["targets"][0];
    assert!(
        (first["x_m"].as_f64().unwrap() - 3.0).abs() < 0.02,
        "{first}"
    );
    assert!(
        (first["y_m"].as_f64().unwrap() - 1.5).abs() < 0.05,
        "{first}"
    );
    assert_eq!(first["level_db"], 0.0);
    let along = first["along"]["rayleigh_m"].as_f64().unwrap();
    assert!((0.03..0.09).contains(&along), "{along}");

    let run = json(&products.join("run.json"));
    let names: Vec<&str> = run["stages"]
        .as_array()
        .unwrap()
        .iter()
        .map(|s| s["name"].as_str().unwrap())
        .collect();
    assert_eq!(
        names,
        [
            "read", "position", "align", "clean", "focus", "measure", "deliver"
        ]
    );
    // The radar's delay is 10 ns; zero-timing found it from the surface echo.
    let shift_ns = run["zero_timing"]["shift_ns"].as_f64().unwrap();
    assert!((shift_ns + 10.0).abs() < 0.1, "{shift_ns}");
    assert!(run["plan_checked_error"].as_f64().unwrap() <= 1e-3);
    assert_eq!(run["inputs"].as_array().unwrap().len(), 3);
    assert_eq!(run["configuration"]["image"]["frequencies"], 341);
    assert_eq!(run["traces"]["selected"], 86);

    for (name, head) in [
        ("image.npz", &b"PK"[..]),
        ("image.png", b"\x89PNG"),
        ("radargram-raw.png", b"\x89PNG"),
        ("radargram.png", b"\x89PNG"),
        ("trajectory.csv", b"trace,time_s"),
        ("report.html", b"<!DOCTYPE html>"),
    ] {
        assert!(
            fs::read(products.join(name)).unwrap().starts_with(head),
            "{name}"
        );
    }
}

#[test]
fn the_image_alone_is_the_same_image() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = simulated(folder.path(), SCENE).join("campaign.toml");
    let [all, only] = ["all", "only"].map(|name| folder.path().join(name));
    let text = |path: &Path| path.to_str().unwrap().to_owned();
    let campaign = text(&campaign);
    for arguments in [
        vec!["focus", &campaign, "-o", &text(&all)],
        vec!["focus", &campaign, "-o", &text(&only), "--only", "image"],
    ] {
        let output = acerra(&arguments);
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{message}");
    }
    let mut names: Vec<String> = fs::read_dir(&only)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, ["image.npz", "run.json"]);
    let [image, alone] = [&all, &only].map(|at| fs::read(at.join("image.npz")).unwrap());
    assert!(image == alone);
    let [run, alone] = [&all, &only].map(|at| json(&at.join("run.json")));
    for key in ["evidence", "warnings", "traces"] {
        assert_eq!(run[key], alone[key], "{key}");
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    let [a, b] = [0, 1].map(|_| tempfile::tempdir().unwrap());
    let scene = SCENE.replace("[radar]\n", "[radar]\nlost_packets = 0.05\n");
    let [a_logs, b_logs] = [&a, &b].map(|folder| simulated(folder.path(), &scene));
    for name in ["radar.mrm", "trajectory.csv", "campaign.toml", "truth.json"] {
        assert_eq!(
            fs::read(a_logs.join(name)).unwrap(),
            fs::read(b_logs.join(name)).unwrap()
        );
    }
    let output = acerra(&["info", "--json", a_logs.join("radar.mrm").to_str().unwrap()]);
    let info: Value = serde_json::from_slice(&output.stdout).unwrap();
    let (whole, torn) = (
        &info["facts"]["whole_scans"],
        &info["facts"]["incomplete_scans"],
    );
    assert!(torn.as_u64().unwrap() > 0, "{info}");
    assert!(
        whole.as_u64().unwrap() + torn.as_u64().unwrap() <= 86,
        "{info}"
    );
}

#[test]
fn first_mistakes_are_answered_by_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let logs = simulated(folder.path(), SCENE);
    // Logs in place of settings.
    for (command, file, said) in [
        ("focus", "radar.mrm", "acerra init"),
        ("focus", "trajectory.csv", "acerra init"),
        ("merge", "radar.mrm", "acerra init"),
        ("plan", "radar.mrm", "acerra plan --example"),
    ] {
        let path = logs.join(file);
        let output = acerra(&[command, path.to_str().unwrap()]);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{message}");
        assert!(
            message.contains(file) && message.contains(said),
            "{message}"
        );
        assert_eq!(message.lines().count(), 1, "{message}");
    }
    let output = acerra(&["view", logs.join("radar.mrm").to_str().unwrap()]);
    assert!(String::from_utf8_lossy(&output.stderr).contains("expected the directory of a run"));
    // Slips in a campaign, which stay what they are.
    let campaign = logs.join("campaign.toml");
    let good = fs::read_to_string(&campaign).unwrap();
    let with = |from: &str, to: &str| {
        assert!(good.contains(from), "{from}");
        fs::write(&campaign, good.replace(from, to)).unwrap();
        failure(&campaign)
    };
    let message = with("pixel_m", "pixle_m");
    assert!(
        message.trim_end().ends_with("did you mean `pixel_m`?"),
        "{message}"
    );
    let message = with("[image]", "[image");
    assert!(
        message.contains("line") && !message.contains("init"),
        "{message}"
    );
    let message = with("pixel_m = 0.02", "pixel_m = 1e-5");
    for part in ["x_m, y_m, pixel_m", "TB", "pixel_m = "] {
        assert!(
            message.contains(part) || message.contains("GB"),
            "{part}: {message}"
        );
    }
    // An image of a single pixel; one of a row is legal.
    let message = with(
        "x_m = [2.0, 4.0]\ny_m = [0.5, 2.5]",
        "x_m = [3.0, 3.0]\ny_m = [1.5, 1.5]",
    );
    assert!(
        message.contains("[image] x_m, y_m: expected an extent of two pixels"),
        "{message}"
    );
    fs::write(
        &campaign,
        good.replace("y_m = [0.5, 2.5]", "y_m = [1.5, 1.5]"),
    )
    .unwrap();
    let output = acerra(&["focus", campaign.to_str().unwrap(), "--only", "image"]);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
fn bad_input_is_one_message_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let logs = simulated(folder.path(), SCENE);
    let campaign = logs.join("campaign.toml");
    let good = fs::read_to_string(&campaign).unwrap();
    let with = |from: &str, to: &str| {
        assert!(good.contains(from), "{from}");
        fs::write(&campaign, good.replace(from, to)).unwrap();
        failure(&campaign)
    };
    assert!(with("pixel_m", "pixle_m").contains("unknown field `pixle_m`"));
    assert!(with("pixel_m = 0.02", "pixel_m = -1").contains("[image] pixel_m: expected"));
    assert!(with("pixel_m = 0.02", "pixel_m = 1e-5").contains(" of memory"));
    assert!(with("radar.mrm", "absent.mrm").contains("absent.mrm"));
    assert!(with("radar.mrm", "trajectory.csv").contains("not a radar file"));
    let message = with("time_offset_s = ", "time_offset_s = 5");
    assert!(message.contains("do not overlap"), "{message}");
    assert!(with("[image]", "[radar2]\n[image]").contains("unknown field `radar2`"));

    // A trajectory with NaN, a cut-off and an empty log, a header that claims too much.
    let track = logs.join("trajectory.csv");
    let whole = fs::read_to_string(&track).unwrap();
    fs::write(&campaign, &good).unwrap();
    let second = whole.lines().nth(1).unwrap().to_owned();
    let broken = second.replacen(second.split(',').nth(1).unwrap(), "nan", 1);
    fs::write(&track, whole.replacen(&second, &broken, 1)).unwrap();
    let message = failure(&campaign);
    assert!(
        message.contains("trajectory.csv") && message.contains("line 2"),
        "{message}"
    );
    fs::write(&track, whole).unwrap();

    let log = logs.join("radar.mrm");
    let bytes = fs::read(&log).unwrap();
    fs::write(&log, &bytes[..32 + 700]).unwrap();
    assert!(failure(&campaign).contains("no whole scan"));
    fs::write(&log, b"").unwrap();
    assert!(failure(&campaign).contains("the file is empty"));
    // numSamplesTotal (u32 at byte 44 of a message) in every message claims 4 Gi samples.
    let mut claims = bytes.clone();
    for message in claims[32..].chunks_mut(1452) {
        message[44..48].fill(0xff);
    }
    fs::write(&log, &claims).unwrap();
    assert!(failure(&campaign).contains("radar.mrm"));
    let mut swapped = bytes;
    for pair in swapped[32..].chunks_exact_mut(2) {
        pair.swap(0, 1);
    }
    fs::write(&log, &swapped).unwrap();
    assert!(failure(&campaign).contains("radar.mrm"));
}

#[test]
fn wrong_usage_is_2_and_help_is_0() {
    assert_eq!(acerra(&["focus"]).status.code(), Some(2));
    assert_eq!(
        acerra(&["focus", "--no-such-flag", "x"]).status.code(),
        Some(2)
    );
    assert_eq!(acerra(&["--help"]).status.code(), Some(0));
    assert_eq!(acerra(&["info", "/nowhere/at/all"]).status.code(), Some(1));
}

/// The P440 flight of 2019: offset, reflector and level of the issue.
#[test]
fn a_real_flight_focuses_its_reflector() {
    let data = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/data/uav-flight-2019"
    );
    if !Path::new(data).exists() {
        eprintln!("skipped: {data} is absent");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let campaign = folder.path().join("flight.toml");
    fs::write(
        &campaign,
        format!(
            "[radar]\nfile = '{data}/flight.mrm'\ndelay_ns = 11.5\nselect = 'moving'\n\
             [trajectory]\nfile = '{data}/platform-mocap.csv'\ntime_offset_s = 'auto'\n\
             [preprocess]\ngate_ns = 'none'\n\
             [image]\nx_m = [0, 4]\ny_m = [0, 4]\npixel_m = 0.02\nweight = 'path'\n\
             [measure]\nsurvey = 'points.csv'\n"
        ),
    )
    .unwrap();
    fs::write(
        folder.path().join("points.csv"),
        "corner,1.793,1.810,-0.017\n",
    )
    .unwrap();
    let products = folder.path().join("products");
    let output = acerra(&[
        "focus",
        campaign.to_str().unwrap(),
        "-o",
        products.to_str().unwrap(),
    ]);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let run = json(&products.join("run.json"));
    let offset = run["time_offset_s"].as_f64().unwrap();
    assert!((6.50..=6.53).contains(&offset), "{offset}");
    let targets = json(&products.join("targets.json"));
    let first = &targets["targets"][0];
    let off =
        (first["x_m"].as_f64().unwrap() - 1.793).hypot(first["y_m"].as_f64().unwrap() - 1.810);
    assert!(off < 0.25, "{off} m");
    let surveyed = &targets["surveyed"][0];
    assert_eq!(surveyed["name"], "corner");
    assert_eq!(surveyed["nearest"]["target"], 1);
    let distance = surveyed["nearest"]["distance_m"].as_f64().unwrap();
    assert!((distance - off).abs() < 1e-9, "{distance}");
    assert!(targets["image"]["median_db"].as_f64().unwrap() < -15.0);
    assert_eq!(run["traces"]["in_log"], 799);
}

/// Runs `focus` on a full-wave scene of the validation book with these lines for its ground: its folder of products.
fn burials(here: &Path, ground: &str, preprocess: &str) -> PathBuf {
    let traces =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/validation/ground/level-1.npz");
    let campaign = here.join("campaign.toml");
    let text = format!(
        "[radar]\nfile = '{}'\ndelay_ns = 1.088\n\
         [preprocess]\nzero_timing = 'none'\ngate_ns = 'none'\n{preprocess}\n\
         [image]\nband_ghz = [0.5, 2.5]\nfrequencies = 101\nx_m = [0.3, 2.1]\ny_m = [0.0, 0.0]\n\
         z_m = [-0.40, -0.02]\npixel_z_m = 0.005\n\
         [measure]\nthreshold_db = -18.0\n[ground]\n{ground}\n",
        traces.display()
    );
    fs::write(&campaign, text).unwrap();
    let products = here.join("products");
    made("focus", &campaign, &products);
    products
}

/// Verdict of a finding of a run, where it has one.
fn verdict(products: &Path, name: &str) -> Option<String> {
    let run = json(&products.join("run.json"));
    let findings = run["evidence"].as_array().unwrap().clone();
    let finding = findings.iter().find(|finding| finding["name"] == name)?;
    Some(finding["verdict"].as_str().unwrap().to_owned())
}

/// The truth: metal whose tops lie 8.9 cm deep at x = 1.777 m and 18.1 cm deep at 0.464 m, in a soil of 5.95.
#[test]
fn burials_have_depths_and_the_report_names_the_soil() {
    let here = tempfile::tempdir().unwrap();
    let products = burials(
        here.path(),
        "relative_permittivity = 5.95\nconductivity_s_m = 0.002",
        "",
    );
    let targets = json(&products.join("targets.json"))["targets"]
        .as_array()
        .unwrap()
        .clone();
    for [x_m, depth_m] in [[1.777, 0.089], [0.464, 0.181]] {
        let is_there = |target: &&Value| (target["x_m"].as_f64().unwrap() - x_m).abs() < 0.01;
        let target = targets.iter().find(is_there).unwrap();
        assert!(
            (target["depth_m"].as_f64().unwrap() - depth_m).abs() < 0.006,
            "{target}"
        );
        let sigma_m = target["depth_sigma_m"].as_f64().unwrap();
        assert!((0.002..0.05).contains(&sigma_m), "{target}");
    }
    for (name, expected) in [
        ("ground_permittivity", Some("agrees")),
        ("clutter_targets", Some("agrees")),
        ("ground_surface", Some("agrees")),
        ("depth_reach", Some("agrees")),
        // Images in air, whose sharpness says nothing of rays that are refracted.
        ("delay_sharpness", None),
        ("delay_focus", None),
    ] {
        assert_eq!(verdict(&products, name).as_deref(), expected, "{name}");
    }
    let report = fs::read_to_string(products.join("report.html")).unwrap();
    for text in [
        "Permittivity of the ground",
        "5.95",
        "as stated",
        "Surface of the ground",
        "level, at the stated height",
        "depth below the surface (m)",
    ] {
        assert!(report.contains(text), "{text}");
    }
}

/// The echo of the surface that was not removed is no target, and the image is doubted.
#[test]
fn a_surface_that_was_not_removed_is_no_target() {
    let here = tempfile::tempdir().unwrap();
    let soil = "relative_permittivity = 5.95\nconductivity_s_m = 0.002";
    let products = burials(here.path(), soil, "background = 'none'");
    let targets = json(&products.join("targets.json"))["targets"].clone();
    assert_eq!(targets.as_array().unwrap().len(), 0, "{targets}");
    for name in ["image_contrast", "still_echoes"] {
        assert_eq!(
            verdict(&products, name).as_deref(),
            Some("doubtful"),
            "{name}"
        );
    }
}
