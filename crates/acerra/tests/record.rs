//! `acerra emulate`, `record` and `focus` as a user runs them.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use std::fs;
use std::io::{BufRead, BufReader};
use std::net::{TcpListener, UdpSocket};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};

use serde_json::Value;

/// A short flight with receivers, recorded from take-off to landing.
const SCENE: &str = "seed = 3\nrecord = \"flight\"\n\
    [flight]\ntrack_start_m = [0, 0]\ntrack_end_m = [8, 0]\nheight_m = 4\ntrack_duration_s = 6\n\
    [radar]\nsamples = 960\n[ground]\nfacets_per_m2 = 1\nextent_m = 5\n[gnss]\n\
    [[corner]]\nposition_m = [3, 1.5, 0]\n\
    [image]\nx_m = [2, 4]\ny_m = [0.5, 2.5]\npixel_m = 0.02\n";

fn acerra() -> Command {
    Command::new(env!("CARGO_BIN_EXE_acerra"))
}

fn run(arguments: &[&str]) -> Output {
    acerra().args(arguments).output().unwrap()
}

fn succeeds(arguments: &[&str]) -> String {
    let output = run(arguments);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{arguments:?}: {told}");
    String::from_utf8_lossy(&output.stdout).into_owned() + &told
}

/// A child that is ended with the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn path(folder: &Path, name: &str) -> String {
    folder.join(name).display().to_string()
}

/// The strongest target: place and level.
fn target(products: &Path) -> [f64; 3] {
    let text = fs::read_to_string(products.join("targets.json")).unwrap();
    let targets: Value = serde_json::from_str(&text).unwrap();
    ["x_m", "y_m", "level_db"].map(|key| targets["targets"][0][key].as_f64().unwrap())
}

/// Largest modulus of an image.
fn peak_db(products: &Path) -> f64 {
    let text = fs::read_to_string(products.join("run.json")).unwrap();
    let run: Value = serde_json::from_str(&text).unwrap();
    println!("{} {}", run["time_offset_s"], run["warnings"]);
    let file = fs::File::open(products.join("image.npz")).unwrap();
    let mut archive = acerra_npz::NpzReader::open(file).unwrap();
    let image = archive.complex("image").unwrap();
    let largest = image.iter().map(|value| value.norm()).fold(0.0, f64::max);
    20.0 * largest.log10()
}

#[test]
fn an_emulated_flight_is_recorded_and_focused_as_with_perfect_times() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("scene.toml"), SCENE).unwrap();
    let scene = path(folder, "scene.toml");
    let [radio, receiver] = [
        UdpSocket::bind("127.0.0.1:0")
            .unwrap()
            .local_addr()
            .unwrap(),
        TcpListener::bind("127.0.0.1:0")
            .unwrap()
            .local_addr()
            .unwrap(),
    ];
    let mut emulator = Running(
        acerra()
            .args(["emulate", &scene, "-o", &path(folder, "ground")])
            .args(["--radio", &radio.to_string()])
            .args(["--receiver", &receiver.to_string()])
            .args(["--speed", "4", "--drift-ppm", "20", "--jitter-ms", "5"])
            .args(["--loss", "0.002", "--reordering", "0.01"])
            .stdout(Stdio::piped())
            .spawn()
            .unwrap(),
    );
    // The session file ends with the image's last key.
    let mut session = String::new();
    let mut lines = BufReader::new(emulator.0.stdout.take().unwrap()).lines();
    while !session.contains("[campaign.trajectory]") || !session.ends_with("\n\n") {
        let Some(line) = lines.next() else { break };
        session += &(line.unwrap() + "\n");
        if session.contains("origin_deg_m") {
            break;
        }
    }
    session += "[flight]\nstop_after_s = 12.0\n";
    fs::write(folder.join("session.toml"), &session).unwrap();
    let flight = folder.join("flight");
    let told = succeeds(&[
        "record",
        &path(folder, "session.toml"),
        "-o",
        flight.to_str().unwrap(),
    ]);
    println!("{session}{told}");
    drop(emulator);
    println!(
        "{}",
        fs::read_to_string(flight.join("campaign.toml")).unwrap()
    );
    println!(
        "{}",
        fs::read_to_string(flight.join("radar.clock.json")).unwrap()
    );
    let recorded = folder.join("recorded");
    succeeds(&[
        "focus",
        &path(&flight, "campaign.toml"),
        "-o",
        recorded.to_str().unwrap(),
    ]);
    succeeds(&["simulate", &scene, "-o", &path(folder, "truth")]);
    let perfect = folder.join("perfect");
    succeeds(&[
        "focus",
        &path(&folder.join("truth"), "campaign.toml"),
        "-o",
        perfect.to_str().unwrap(),
    ]);
    let [found, expected] = [&recorded, &perfect].map(|products| target(products));
    let [found_db, expected_db] = [&recorded, &perfect].map(|products| peak_db(products));
    println!("{found:?} {expected:?}; {found_db:.3} dB, {expected_db:.3} dB");
}
