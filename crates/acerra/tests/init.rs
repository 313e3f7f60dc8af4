//! `acerra init` on the logs of a simulated flight.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use acerra_chain::campaign::{Campaign, Permittivity, TimeOffset};
use acerra_formats::Positions;
use acerra_formats::segy::{SegyTraces, write_segy};

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
        "# Found: the rover: its single-point positions spread over",
        "# Found: MRM capture,",
        "# frequencies = 341",
        "# x_m = [0.0, 18.0]    # for example",
        "# z_m = 0.0    # for example",
        "s of them the rover's",
    ] {
        let unbroken = text.replace("\n# ", " # ").replace(" # ", " ");
        assert!(unbroken.contains(&said.replace("# ", "")), "{said}\n{text}");
    }
}

#[test]
fn the_keys_that_matter_come_first_and_all_others_follow() {
    let text = init(&named(&["base.ubx", "radar.mrm", "rover.ubx"])).unwrap();
    let (first, rest) = text.split_once("# The other keys.").unwrap();
    assert!(first.lines().count() < 60, "{first}");
    for key in [
        "file",
        "delay_ns",
        "rover",
        "base",
        "base_deg_m",
        "time_offset_s",
        "lever_arm_m",
        "x_m",
        "pixel_m",
    ] {
        let is_key = |line: &str| {
            line.trim_start_matches("# ")
                .starts_with(&format!("{key} = "))
        };
        assert!(first.lines().any(is_key), "{key}: {first}");
    }
    assert!(!first.contains("frequencies") && rest.contains("# frequencies = 341"));
    // One log makes no tracks; keys are nowhere set twice.
    let is_of_tracks = |line: &str| {
        let header = line.trim_start_matches("# ");
        ["[[track", "[track", "[[radar.lines"]
            .iter()
            .any(|name| header.starts_with(name))
    };
    assert!(!text.lines().any(is_of_tracks), "{text}");
    let tables = text
        .lines()
        .filter(|line| line.trim_start_matches("# ") == "[image]");
    assert_eq!(tables.count(), 2, "{text}");
    assert!(!rest.lines().any(|line| line == "[image]"), "{rest}");
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
    let run = |more: &[&str]| {
        let output = match more.contains(&"-o") {
            true => &[][..],
            false => &["-o", "flight.toml"],
        };
        Command::new(env!("CARGO_BIN_EXE_acerra"))
            .current_dir(folder.path())
            .args(["init", "radar.mrm", "truth-trajectory.csv"])
            .args(output)
            .args(more)
            .output()
            .unwrap()
    };
    assert!(run(&[]).status.success());
    let text = fs::read_to_string(&file).unwrap();
    assert!(text.contains("\nfile = \"radar.mrm\"\n"), "{text}");
    fs::write(&file, "mine").unwrap();
    let second = run(&[]);
    assert_eq!(second.status.code(), Some(1));
    assert!(stderr(&second).contains("flight.toml: is there already"));
    assert!(stderr(&second).contains("--force"));
    assert_eq!(fs::read_to_string(&file).unwrap(), "mine");
    assert!(run(&["--force"]).status.success());
    assert_eq!(fs::read_to_string(&file).unwrap(), text);
    // A log is no campaign to be replaced.
    let log = folder.path().join("radar.mrm");
    let logged = fs::read(&log).unwrap();
    let third = run(&["--force", "-o", "radar.mrm"]);
    assert!(!third.status.success());
    assert_eq!(fs::read(&log).unwrap(), logged);
}

/// A line of `traces` traces, 0.02 m apart by its header, with antennas 6 cm apart.
fn write_rd3(folder: &Path, name: &str, traces: usize) -> PathBuf {
    let wave =
        |k: usize| 3e3 * (k as f64 * 0.4).sin() * (-((k as f64 - 60.0) / 12.0).powi(2)).exp();
    let samples =
        (0..traces).flat_map(|t| (0..200).map(move |k| wave(k) as i16 + (t * k % 7) as i16));
    let bytes: Vec<u8> = samples.flat_map(i16::to_le_bytes).collect();
    let path = folder.join(format!("{name}.rd3"));
    fs::write(&path, bytes).unwrap();
    let header = format!(
        "SAMPLES:200\r\nFREQUENCY:20000.0\r\nLAST TRACE:{traces}\r\nDISTANCE FLAG:1\r\nDISTANCE INTERVAL:0.02\r\n\
         TIMEWINDOW:10.0\r\nANTENNA SEPARATION:0.06\r\nCHANNELS:1\r\n"
    );
    fs::write(folder.join(format!("{name}.rad")), header).unwrap();
    path
}

#[test]
fn lines_of_another_makers_radar_become_one_campaign_that_asks_where_they_lie() {
    let folder = tempfile::tempdir().unwrap();
    for (k, traces) in [11, 11, 21].into_iter().enumerate() {
        write_rd3(folder.path(), &format!("line-{}", k + 1), traces);
    }
    let text = init(&[folder.path().join("line-*.rd3")]).unwrap();
    assert!(
        text.starts_with("# QUESTION: [radar] line_start_m"),
        "{text}"
    );
    assert!(
        text.contains("0.200 to 0.400 m from the first trace"),
        "{text}"
    );
    let campaign = Campaign::parse(&text).unwrap();
    assert!(campaign.radar.grid().is_some() && campaign.radar.line().is_none());
    assert!(text.contains("line-*.rd3"), "{text}");
    assert_eq!(
        campaign.preprocess.zero_timing,
        Some(acerra_chain::campaign::ZeroTiming::DirectWave)
    );
    // Headers beside the samples are no lines of their own.
    let all =
        ["line-1.rd3", "line-1.rad", "line-2.rad", "line-2.rd3"].map(|n| folder.path().join(n));
    let text = init(&all).unwrap();
    let campaign = Campaign::parse(&text).unwrap();
    assert_eq!(campaign.radar.grid().unwrap().files().unwrap().len(), 2);
    // Nothing is imaged before the question is answered.
    let file = folder.path().join("area.toml");
    fs::write(&file, &text).unwrap();
    let output = acerra(&[Path::new("focus"), &file]);
    assert!(
        stderr(&output).contains("line_start_m"),
        "{}",
        stderr(&output)
    );
    // One line lies along x until its ends are stated.
    let text = init(&[folder.path().join("line-3.rd3")]).unwrap();
    assert!(
        text.starts_with("# QUESTION: [radar] line_start_m"),
        "{text}"
    );
    let line = Campaign::parse(&text).unwrap().radar.line().unwrap();
    assert_eq!(line.end_m, [0.4, 0.0, 0.01]);
    assert!(init(&[folder.path().join("none-*.rd3")]).is_err());
}

/// Runs `focus` on the text of a campaign in a folder; the folder of the products.
fn focused(folder: &Path, text: &str) -> PathBuf {
    let (file, products) = (folder.join("campaign.toml"), folder.join("products"));
    fs::write(&file, text).unwrap();
    let output = acerra(&[Path::new("focus"), &file, Path::new("-o"), &products]);
    assert!(output.status.success(), "{}", stderr(&output));
    products
}

/// The campaign of a line with an odometer images the ground below it without any edit.
#[test]
fn a_line_becomes_a_section_below_the_ground() {
    let folder = tempfile::tempdir().unwrap();
    let line = write_rd3(folder.path(), "line", 21);
    let text = init(&[line]).unwrap();
    let campaign = Campaign::parse(&text).unwrap();
    let soil = campaign.ground.as_ref().unwrap().relative_permittivity;
    assert_eq!(soil, Some(Permittivity::Relative(9.0)), "{text}");
    assert_eq!(campaign.image.y_m, Some([0.0, 0.0]));
    assert_eq!(campaign.radar.line().unwrap().start_m, [0.0, 0.0, 0.01]);
    // The record covers 10 ns at 0.1 m/ns.
    assert!(text.contains("z_m = [-0.49, -"), "{text}");
    assert!(focused(folder.path(), &text).join("volume.npz").is_file());
}

/// Traces with coordinates and without heights lie above the ground by the height of the antennas.
#[test]
fn places_without_heights_become_a_slice_below_the_ground() {
    let folder = tempfile::tempdir().unwrap();
    let pulse = |k: usize| (-((k as f64 - 30.0) / 5.0).powi(2)).exp() * (0.6 * k as f64).cos();
    let values: Vec<f32> = (0..21 * 200)
        .map(|i| (1e3 * pulse(i % 200)) as f32 + (i / 200 * i % 7) as f32)
        .collect();
    let place = |trace: i32, ahead_m: f64| [0.02 * f64::from(trace) + ahead_m, 3.0, 0.0];
    let places = |ahead_m: f64| (0..21).map(|trace| place(trace, ahead_m)).collect();
    let antennas_m: [Vec<[f64; 3]>; 2] = [places(0.03), places(-0.03)];
    let positions = Positions::Local(places(0.0));
    let traces = SegyTraces {
        values: &values,
        samples: 200,
        step_s: 50e-12,
        start_s: 0.0,
        positions: Some(&positions),
        antennas_m: Some(&antennas_m),
        text: &[],
    };
    let line = folder.path().join("line.sgy");
    write_segy(&mut fs::File::create(&line).unwrap(), &traces).unwrap();
    let text = init(&[line]).unwrap();
    assert!(
        text.starts_with("# QUESTION: [ground] relative_permittivity, surface_z_m"),
        "{text}"
    );
    assert_eq!(text.matches("QUESTION").count(), 1, "{text}");
    let ground = Campaign::parse(&text).unwrap().ground.unwrap();
    assert_eq!(ground.surface_z_m, -0.01);
    assert!(focused(folder.path(), &text).join("image.npz").is_file());
}

/// In a hall no echo follows the height, although some move with the platform for a while: a surface taken from one of
/// these would image the wrong place.
#[test]
fn a_hall_shows_no_surface() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/uav-flight-2019");
    if !folder.exists() {
        println!("skipped: ../shared/data/uav-flight-2019 is absent");
        return;
    }
    let campaign =
        init(&["flight.mrm", "platform-mocap.csv"].map(|name| folder.join(name))).unwrap();
    for line in [
        "gate_ns = \"none\"",
        "delay_ns = \"auto\"",
        "values = \"reflectivity\"",
    ] {
        assert!(
            campaign.lines().any(|found| found == line),
            "{line}: {campaign}"
        );
    }
    assert!(
        campaign.starts_with("# QUESTION: [image] z_m"),
        "{campaign}"
    );
}
