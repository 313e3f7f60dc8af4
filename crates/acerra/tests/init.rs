//! `acerra init` on the logs of a simulated flight.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use acerra_chain::campaign::{Campaign, TimeOffset};

const SCENE: &str = "seed = 11\nbase_m = [-12, -8, 1.5]\n\
    [flight]\ntrack_start_m = [0, -2]\ntrack_end_m = [20, -2]\nheight_m = 6\n\
    track_duration_s = 15\nground_time_s = 20\n\
    [radar]\nsamples = 960\n[[corner]]\nposition_m = [4, 0, 0]\n\
    [gnss.rover]\ninterval_s = 1.0\n[gnss.base]\ninterval_s = 1.0\n";

fn acerra(arguments: &[&Path]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_acerra"))
        .args(arguments)
        .output()
        .unwrap()
}

/// A folder with the logs of the flight, simulated once.
fn logs() -> &'static Path {
    static LOGS: OnceLock<tempfile::TempDir> = OnceLock::new();
    let folder = LOGS.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let scene = folder.path().join("scene-given.toml");
        fs::write(&scene, SCENE).unwrap();
        let output = acerra(&[
            Path::new("simulate"),
            &scene,
            Path::new("-o"),
            folder.path(),
        ]);
        assert!(output.status.success(), "{}", stderr(&output));
        folder
    });
    folder.path()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Runs `init` on files of the folder, or elsewhere, and returns what it writes.
fn init(files: &[PathBuf]) -> Result<String, String> {
    let mut arguments = vec![Path::new("init")];
    arguments.extend(files.iter().map(PathBuf::as_path));
    let output = acerra(&arguments);
    match output.status.code() {
        Some(0) => Ok(String::from_utf8(output.stdout).unwrap()),
        Some(1) => Err(stderr(&output)),
        other => panic!("{other:?}: {}", stderr(&output)),
    }
}

fn named(names: &[&str]) -> Vec<PathBuf> {
    names.iter().map(|name| logs().join(name)).collect()
}

#[test]
fn raw_logs_become_a_campaign() {
    let text = init(&named(&["base.ubx", "radar.mrm", "rover.ubx"])).unwrap();
    let campaign = Campaign::parse(&text).unwrap();
    let gnss = campaign.gnss.as_ref().unwrap();
    assert!(campaign.radar.file.ends_with("radar.mrm"), "{text}");
    assert!(gnss.rover.0[0].ends_with("rover.ubx") && gnss.base.0[0].ends_with("base.ubx"));
    assert_eq!(campaign.trajectory.time_offset_s, Some(TimeOffset::Auto));
    // UBX says nothing of the base's place: the median of its positions is metres off at most.
    let [latitude, longitude, height] = gnss.base_deg_m.unwrap();
    assert!((latitude - 40.9596).abs() < 2e-4 && (longitude - 14.3696).abs() < 2e-4);
    assert!((height - 76.5).abs() < 15.0, "{height}");
    for said in [
        "# Found: the rover: its own single-point positions spread over",
        "# Found: MRM capture,",
        "# frequencies = 341",
        "# z_m = 0.0    # for example",
        "s of them the rover's",
    ] {
        let unbroken = text.replace("\n# ", " # ").replace(" # ", " ");
        assert!(unbroken.contains(&said.replace("# ", "")), "{said}\n{text}");
    }
}

#[test]
fn motion_tells_the_rover_whatever_the_files_are_called() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    fs::copy(logs().join("rover.obs"), place("base.obs")).unwrap();
    fs::copy(logs().join("base.obs"), place("rover.obs")).unwrap();
    let mut files = vec![place("base.obs"), place("rover.obs")];
    files.extend(named(&["radar.mrm", "broadcast.nav"]));
    let text = init(&files).unwrap();
    let gnss = Campaign::parse(&text).unwrap().gnss.unwrap();
    assert!(gnss.rover.0[0].ends_with("base.obs"), "{text}");
    assert!(gnss.navigation.0[0].ends_with("broadcast.nav"), "{text}");
}

#[test]
fn one_receiver_in_two_formats_is_one() {
    let names = [
        "rover.obs",
        "rover.ubx",
        "base.obs",
        "base.ubx",
        "radar.mrm",
        "broadcast.nav",
    ];
    let text = init(&named(&names)).unwrap();
    assert_eq!(
        text.matches("holds the same measurements as").count(),
        2,
        "{text}"
    );
}

#[test]
fn a_trajectory_becomes_the_campaign_s() {
    let text = init(&named(&["truth-trajectory.csv", "radar.mrm"])).unwrap();
    let campaign = Campaign::parse(&text).unwrap();
    assert!(campaign.gnss.is_none());
    assert!(
        campaign
            .trajectory
            .file
            .unwrap()
            .ends_with("truth-trajectory.csv")
    );
}

#[test]
fn what_makes_no_campaign_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let junk = folder.path().join("junk.bin");
    fs::write(&junk, [0x5a; 4_000]).unwrap();
    let empty = folder.path().join("empty.mrm");
    fs::write(&empty, "").unwrap();
    for (files, said) in [
        (
            named(&["rover.ubx", "base.ubx"]),
            "no radar log among the files",
        ),
        (named(&["radar.mrm"]), "no positions among the files"),
        (
            named(&["radar.mrm", "rover.ubx"]),
            "rover.ubx: the only log of a GNSS receiver",
        ),
        (
            named(&["radar.mrm", "rover.obs", "base.obs"]),
            "no navigation data",
        ),
        (vec![junk], "junk.bin: not a log that is known"),
        (vec![empty], "empty.mrm: the file is empty"),
        (named(&["absent.mrm"]), "absent.mrm: "),
    ] {
        let message = init(&files).unwrap_err();
        assert!(message.contains(said), "{said}: {message}");
    }
}

#[test]
fn a_campaign_is_written_beside_its_logs_and_never_over_another() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["radar.mrm", "truth-trajectory.csv"] {
        fs::copy(logs().join(name), folder.path().join(name)).unwrap();
    }
    let file = folder.path().join("flight.toml");
    let run = || {
        Command::new(env!("CARGO_BIN_EXE_acerra"))
            .current_dir(folder.path())
            .args([
                "init",
                "radar.mrm",
                "truth-trajectory.csv",
                "-o",
                "flight.toml",
            ])
            .output()
            .unwrap()
    };
    assert!(run().status.success());
    let text = fs::read_to_string(&file).unwrap();
    assert!(text.contains("\nfile = \"radar.mrm\"\n"), "{text}");
    fs::write(&file, "mine").unwrap();
    let second = run();
    assert_eq!(second.status.code(), Some(1));
    assert!(stderr(&second).contains("flight.toml: is there already"));
    assert_eq!(fs::read_to_string(&file).unwrap(), "mine");
}
