//! Terrain, several tracks, looks and volumes, through files and the command.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

mod tiles;

use std::fs;
use std::fs::File;
use std::path::Path;

use acerra_imaging::reference::{self, Scatterer};
use acerra_imaging::resolution::displacement_m;
use acerra_imaging::{Complex64, SPEED_OF_LIGHT_M_S, Spreading};
use acerra_npz::NpzReader;
use acerra_radar::{NeutralContent, Spectrum};
use assert_cmd::Command;
use serde_json::Value;

/// Echoes of point targets from a track, as a spectrum file and a trajectory.
fn write_flight(folder: &Path, name: &str, position_m: &[[f64; 3]], targets_m: &[[f64; 3]]) {
    write_flight_with(folder, name, position_m, targets_m, |_, e| e);
}

fn write_flight_with(
    folder: &Path,
    name: &str,
    position_m: &[[f64; 3]],
    targets_m: &[[f64; 3]],
    instrument: impl Fn(f64, Complex64) -> Complex64,
) {
    let frequency_hz: Vec<f64> = (0..86).map(|n| 3.1e9 + 2e7 * f64::from(n)).collect();
    let scene: Vec<Scatterer> = targets_m
        .iter()
        .map(|&position_m| Scatterer {
            position_m,
            reflectivity: Complex64::ONE,
        })
        .collect();
    let mut values = reference::forward(
        position_m,
        &frequency_hz,
        &scene,
        SPEED_OF_LIGHT_M_S,
        Spreading::InverseSquare,
    )
    .unwrap();
    for row in values.chunks_mut(frequency_hz.len()) {
        for (e, f) in row.iter_mut().zip(&frequency_hz) {
            *e = instrument(*f, *e);
        }
    }
    let time_s: Vec<f64> = (0..position_m.len()).map(|m| 0.05 * m as f64).collect();
    let mut table = "time_s,x_m,y_m,z_m\n".to_owned();
    for (t, [x, y, z]) in time_s.iter().zip(position_m) {
        table += &format!("{t},{x},{y},{z}\n");
    }
    fs::write(folder.join(format!("{name}.csv")), table).unwrap();
    let content = NeutralContent::Spectrum(Spectrum {
        frequency_hz,
        values,
        time_s,
    });
    let file = File::create(folder.join(format!("{name}.npz"))).unwrap();
    acerra_radar::npz::write_npz(file, &content, None).unwrap();
}

/// Runs `focus` on a campaign of this text; its output, or its message.
fn focus(folder: &Path, name: &str, text: &str) -> Result<(Value, Value), String> {
    let campaign = folder.join(format!("{name}.toml"));
    fs::write(&campaign, text).unwrap();
    let products = folder.join(name);
    let output = Command::cargo_bin("acerra")
        .unwrap()
        .args([
            "focus",
            campaign.to_str().unwrap(),
            "-o",
            products.to_str().unwrap(),
        ])
        .output()
        .unwrap();
    if !output.status.success() {
        assert_eq!(output.status.code(), Some(1));
        assert!(!products.exists(), "a failed run left products");
        return Err(String::from_utf8_lossy(&output.stderr).into_owned());
    }
    let json = |file: &str| -> Value {
        serde_json::from_str(&fs::read_to_string(products.join(file)).unwrap()).unwrap()
    };
    Ok((json("targets.json"), json("run.json")))
}

fn shape(file: &Path, array: &'static str) -> Vec<u64> {
    let mut npz = NpzReader::new(File::open(file).unwrap()).unwrap();
    npz.shape(array).unwrap()
}

/// Real and imaginary parts of an array.
fn values(file: &Path, array: &'static str) -> Vec<(f64, f64)> {
    let mut npz = NpzReader::new(File::open(file).unwrap()).unwrap();
    npz.values(array, 1 << 24).unwrap().1
}

fn number(value: &Value, key: &str) -> f64 {
    value[key]
        .as_f64()
        .unwrap_or_else(|| panic!("{key} in {value}"))
}

/// Along y at these x and this height, 3 m long.
fn track(x_m: f64, height_m: f64) -> Vec<[f64; 3]> {
    (0..121)
        .map(|m| [x_m, -1.5 + 0.025 * f64::from(m), height_m])
        .collect()
}

const SINGLE: &str = "[radar]\nfile = 'a.npz'\n[trajectory]\nfile = 'a.csv'\n";

#[test]
fn on_terrain_a_target_stands_where_it_is_and_on_the_plane_elsewhere() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // A metre of relief, rising away from the track, as a raster of 25 cm.
    let ground =
        |x: f64| 0.5 - 0.5 * (std::f64::consts::PI * ((x - 0.5) / 5.0).clamp(0.0, 1.0)).cos();
    let mut grid = "ncols 33\nnrows 25\nxllcenter -1\nyllcenter -3\ncellsize 0.25\n".to_owned();
    for _ in 0..25 {
        for i in 0..33 {
            grid += &format!("{:.4} ", 250.0 + ground(-1.0 + 0.25 * f64::from(i)));
        }
        grid += "\n";
    }
    fs::write(folder.join("dem.asc"), &grid).unwrap();
    let (x, height_m) = (4.0, 5.0);
    let target = [x, 0.2, ground(x)];
    write_flight(folder, "a", &track(0.0, height_m), &[target]);
    let image =
        "[image]\nx_m = [2.0, 5.0]\ny_m = [-0.4, 0.8]\npixel_m = 0.02\nband_ghz = [3.1, 4.8]\n";

    let terrain = format!("{SINGLE}{image}terrain = 'dem.asc'\ngeoid_height_m = -250\n");
    let (targets, run) = focus(folder, "terrain", &terrain).unwrap();
    let first = &targets["targets"][0];
    for (key, truth) in ["x_m", "y_m", "z_m"].into_iter().zip(target) {
        assert!((number(first, key) - truth).abs() < 0.02, "{key}: {first}");
    }
    assert!(run["plan"].as_str().unwrap().contains("a surface"), "{run}");
    assert_eq!(run["inputs"].as_array().unwrap().len(), 4);
    let npz = folder.join("terrain/image.npz");
    assert_eq!(shape(&npz, "image"), [61, 151]);
    assert_eq!(shape(&npz, "z_m"), [61, 151]);
    let page = fs::read_to_string(folder.join("terrain/report.html")).unwrap();
    assert!(page.contains("on the terrain, z = "), "the report says so");

    let (targets, run) = focus(folder, "plane", &format!("{SINGLE}{image}")).unwrap();
    let first = &targets["targets"][0];
    let offset = displacement_m(height_m - target[2], x, -target[2])
        .unwrap()
        .unwrap();
    assert!(offset < -0.5, "{offset}");
    assert!(
        (number(first, "x_m") - x - offset).abs() < 0.04,
        "{first}, Eq. (14) {offset}"
    );
    assert_eq!(run["configuration"]["image"]["z_m"], 0.0);

    // Beyond the raster, both heights, a file that is none.
    let far = terrain.replace("5.0]", "9.0]");
    let message = focus(folder, "far", &far).unwrap_err();
    assert!(
        message.contains("dem.asc") && message.contains("x = ") && message.contains("33 × 25"),
        "{message}"
    );
    let both = focus(folder, "both", &format!("{terrain}z_m = 1\n")).unwrap_err();
    assert!(
        both.contains("[image] terrain and [image] z_m exclude"),
        "{both}"
    );
    fs::write(folder.join("dem.asc"), grid.replacen("250.", "deep", 1)).unwrap();
    let message = focus(folder, "broken", &terrain).unwrap_err();
    assert!(
        message.contains("dem.asc") && message.contains("line 6"),
        "{message}"
    );
}

/// Five tracks 1 m apart, 5 m up, over a target at x = 2 m; each instrument but the first adds a
/// delay and a phase.
fn five_tracks(folder: &Path, target: [f64; 3]) -> String {
    let errors = [
        (0.0, 0.0),
        (0.42, 100.0),
        (-0.71, -60.0),
        (0.9, 170.0),
        (-0.35, 30.0),
    ];
    let mut text = String::new();
    for (k, (x, (delay_ns, phase_deg))) in
        [0.0, -2.0, -1.0, 1.0, 2.0].iter().zip(errors).enumerate()
    {
        let name = format!("t{k}");
        write_flight_with(folder, &name, &track(*x, 5.0), &[target], |f, e| {
            let turn = f64::to_radians(phase_deg) - std::f64::consts::TAU * f * delay_ns * 1e-9;
            e * Complex64::cis(turn)
        });
        text += &format!(
            "[[track]]\nname = 'line {k}'\n[track.radar]\nfile = '{name}.npz'\n\
             [track.trajectory]\nfile = '{name}.csv'\n"
        );
    }
    text
}

/// Greatest modulus of image.npz within 0.3 m of x, dB.
fn level_db(products: &Path, x_m: f64) -> f64 {
    let file = products.join("image.npz");
    let (x, image) = (values(&file, "x_m"), values(&file, "image"));
    let most = image
        .iter()
        .enumerate()
        .filter(|(k, _)| (x[k % x.len()].0 - x_m).abs() < 0.3)
        .map(|(_, (re, im))| re.hypot(*im))
        .fold(0.0, f64::max);
    20.0 * most.log10()
}

/// Two recordings of one flight, each with its offset from the flight's clock, make the image that they make when each
/// names a file of its own.
#[test]
fn recordings_of_one_flight_share_its_positions() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let target_m = [1.0, 0.0, 0.0];
    for (name, x_m) in [("a", 0.0), ("b", -1.0)] {
        write_flight(folder, name, &track(x_m, 5.0), &[target_m]);
    }
    let rows = |name: &str, later_s: f64| -> String {
        let table = fs::read_to_string(folder.join(format!("{name}.csv"))).unwrap();
        let later = |row: &str| {
            let (time_s, place) = row.split_once(',').unwrap();
            format!("{},{place}\n", time_s.parse::<f64>().unwrap() + later_s)
        };
        table.lines().skip(1).map(later).collect()
    };
    let flight = format!("time_s,x_m,y_m,z_m\n{}{}", rows("a", 0.0), rows("b", 10.0));
    for copy in ["flight.csv", "copy.csv"] {
        fs::write(folder.join(copy), &flight).unwrap();
    }
    let image = |name: &str, second: &str| {
        let text = format!(
            "[[track]]\nname = 'a'\n[track.radar]\nfile = 'a.npz'\n[track.trajectory]\nfile = 'flight.csv'\n\
             [[track]]\nname = 'b'\n[track.radar]\nfile = 'b.npz'\n\
             [track.trajectory]\nfile = '{second}'\ntime_offset_s = 10.0\n\
             [image]\nx_m = [0.5, 1.5]\ny_m = [-0.5, 0.5]\npixel_m = 0.02\n"
        );
        let (targets, run) = focus(folder, name, &text).unwrap();
        assert_eq!(run["traces"]["in_log"], 242);
        let first = &targets["targets"][0];
        assert!((number(first, "x_m") - 1.0).abs() < 0.02, "{first}");
        values(&folder.join(name).join("image.npz"), "image")
    };
    assert_eq!(image("shared", "flight.csv"), image("apart", "copy.csv"));
}

#[test]
fn five_tracks_tell_left_from_right_once_calibrated() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let tracks = five_tracks(folder, [2.0, 0.0, 0.0]);
    let image = "[image]\nx_m = [-2.6, 2.6]\ny_m = [-0.3, 0.3]\npixel_m = 0.02\n";
    let ghost_db = |name: &str, text: &str| {
        let done = focus(folder, name, text).unwrap();
        let products = folder.join(name);
        (level_db(&products, -2.0) - level_db(&products, 2.0), done)
    };
    let (raw_db, _) = ghost_db("raw", &format!("{tracks}{image}"));
    let found = format!("{tracks}[tracks]\ncalibration = 'target'\n{image}");
    let (found_db, (targets, run)) = ghost_db("found", &found);
    assert!(
        found_db < -12.0 && raw_db > found_db + 4.0,
        "{raw_db} dB raw, {found_db} dB calibrated"
    );
    let first = &targets["targets"][0];
    assert!((number(first, "x_m") - 2.0).abs() < 0.03, "{first}");

    // What was found is what was put in, and is reported.
    let told = run["tracks"].as_array().unwrap();
    assert_eq!(told.len(), 5);
    for (track, delay_ns) in told.iter().zip([0.0, 0.42, -0.71, 0.9, -0.35]) {
        let found = &track["calibration"]["found"];
        assert!(
            (number(found, "delay_ns") - delay_ns).abs() < 0.02,
            "{track}"
        );
        assert!(number(found, "contrast_db") > 10.0, "{track}");
    }
    assert_eq!(run["traces"]["in_log"], 605);
    let page = fs::read_to_string(folder.join("found/report.html")).unwrap();
    assert!(page.contains("Track line 3") && page.contains("common target"));

    // The same as given numbers.
    let mut given = tracks.clone();
    for (k, (delay, phase)) in [(0.42, 100.0), (-0.71, -60.0), (0.9, 170.0), (-0.35, 30.0)]
        .iter()
        .enumerate()
    {
        let from = format!("name = 'line {}'\n", k + 1);
        given = given.replace(
            &from,
            &format!("{from}delay_ns = {delay}\nphase_deg = {phase}\n"),
        );
    }
    let (given_db, _) = ghost_db("given", &format!("{given}{image}"));
    assert!(given_db < -12.0, "{given_db} dB");
    // Powers do not cancel: the ghost of a sum of powers falls less than that of one of amplitudes.
    let (power_db, _) = ghost_db(
        "power",
        &format!("{given}[tracks]\nsum = 'incoherent'\n{image}"),
    );
    assert!(power_db > given_db + 3.0 && power_db < 0.0, "{power_db} dB");

    // A track in another band is none of this image.
    let text = fs::read_to_string(folder.join("t1.csv")).unwrap();
    fs::write(folder.join("t1.csv"), text.lines().next().unwrap()).unwrap();
    let message = focus(folder, "broken", &found).unwrap_err();
    assert!(message.contains("t1.csv"), "{message}");
}

#[test]
fn looks_are_written_one_by_one_and_summed() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_flight(
        folder,
        "a",
        &track(0.0, 4.0),
        &[[2.5, 0.1, 0.0], [3.1, -0.3, 0.0]],
    );
    let image = "[image]\nx_m = [2, 3.5]\ny_m = [-0.6, 0.6]\npixel_m = 0.02\n\
                 looks = 4\nlook_overlap = 0.25\nlook_window = 'hann'\n";
    let (_, run) = focus(folder, "looks", &format!("{SINGLE}{image}")).unwrap();
    let file = folder.join("looks/looks.npz");
    assert_eq!(shape(&file, "looks"), [4, 61, 76]);
    assert_eq!(shape(&file, "position_m"), [4, 3]);
    let looks = values(&file, "looks");
    let sum: Vec<f64> = values(&file, "multilook").iter().map(|v| v.0).collect();
    for k in (0..sum.len()).step_by(97) {
        let mean: f64 = (0..4)
            .map(|l| looks[l * sum.len() + k])
            .map(|(re, im)| re * re + im * im)
            .sum::<f64>()
            / 4.0;
        assert!(
            (mean - sum[k]).abs() <= 1e-5 * mean,
            "{k}: {mean} {}",
            sum[k]
        );
    }
    let ends = run["looks"].as_array().unwrap();
    assert_eq!((ends.len(), &ends[3][1]), (4, &Value::from(120)));
    assert!(
        fs::read(folder.join("looks/multilook.png"))
            .unwrap()
            .starts_with(b"\x89PNG")
    );
    let message = focus(
        folder,
        "many",
        &format!("{SINGLE}{image}").replace("looks = 4", "looks = 400"),
    );
    assert!(message.unwrap_err().contains("[image] looks"));
}

#[test]
fn a_volume_shows_how_high_a_target_stands() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let target = [2.0, 0.1, 0.43];
    let mut tracks = five_tracks(folder, target);
    for (k, (delay, phase)) in [(0.42, 100.0), (-0.71, -60.0), (0.9, 170.0), (-0.35, 30.0)]
        .iter()
        .enumerate()
    {
        let from = format!("name = 'line {}'\n", k + 1);
        tracks = tracks.replace(
            &from,
            &format!("{from}delay_ns = {delay}\nphase_deg = {phase}\n"),
        );
    }
    // 2 × 2 × 1 m at 2 cm.
    let image = "[image]\nx_m = [1, 3]\ny_m = [-0.9, 1.1]\nz_m = [0, 1]\npixel_m = 0.02\n";
    let (targets, run) = focus(folder, "volume", &format!("{tracks}{image}")).unwrap();
    let first = &targets["targets"][0];
    for (key, truth) in ["x_m", "y_m", "z_m"].into_iter().zip(target) {
        assert!((number(first, key) - truth).abs() < 0.03, "{key}: {first}");
    }
    let products = folder.join("volume");
    assert_eq!(
        shape(&products.join("volume.npz"), "volume"),
        [51, 101, 101]
    );
    assert_eq!(shape(&products.join("image.npz"), "z_m"), [101, 101]);
    for name in ["volume-front.png", "volume-side.png"] {
        assert!(
            fs::read(products.join(name))
                .unwrap()
                .starts_with(b"\x89PNG")
        );
    }
    assert!(run["plan_checked_error"].as_f64().unwrap() <= 1e-3);

    // Too much for any memory, or any disk: refused before anything is read, with the bytes.
    let refused = |name: &str, image: &str| {
        // No log is there to be read.
        let text = format!("{tracks}{image}").replace("t0.npz", "absent.npz");
        focus(folder, name, &text).unwrap_err()
    };
    let message = refused("fine", &image.replace("0.02", "1e-5"));
    assert!(
        message.contains("GB of memory") && message.contains("pixel_m = "),
        "{message}"
    );
    // 50,000 slices of 32 MB: little in memory, 1.6 TB on disk.
    let tall = "[image]\nx_m = [1, 41]\ny_m = [-20, 20]\nz_m = [0, 1]\npixel_m = 0.02\n\
                pixel_z_m = 2e-5\n";
    let message = refused("tall", tall);
    assert!(message.contains(" on disk, "), "{message}");
}

#[test]
#[cfg(target_os = "linux")]
fn a_volume_takes_no_more_memory_than_promised() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_flight(folder, "a", &track(0.0, 5.0), &[[2.0, 0.1, 0.3]]);
    // 24 slices of 8 MB in a file of 190 MB.
    let image = "[image]\nx_m = [1, 5.99]\ny_m = [-2.5, 2.49]\nz_m = [0, 0.46]\npixel_m = 0.005\n\
                 pixel_z_m = 0.02\naccuracy = 1e-2\n[measure]\nmax_targets = 1\n";
    let (_, run) = focus(folder, "volume", &format!("{SINGLE}{image}")).unwrap();
    let stage = |name: &str| {
        let stages = run["stages"].as_array().unwrap();
        let stage = stages.iter().find(|s| s["name"] == name).unwrap();
        stage["peak_memory_bytes"].as_u64().unwrap()
    };
    let promised = run["memory"]["promised_bytes"].as_u64().unwrap();
    let taken = stage("focus").saturating_sub(stage("clean"));
    let file = fs::metadata(folder.join("volume/volume.npz"))
        .unwrap()
        .len();
    assert!(file > 24 * 8 * 999 * 999, "{file}");
    // Beside what was promised the allocator, threads and buffers take a little.
    assert!(
        taken < promised + promised / 10 + (16 << 20),
        "{taken} of {promised} promised"
    );
    assert!(promised < file / 2, "{promised} of {file}");
}
