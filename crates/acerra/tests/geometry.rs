//! Terrain, several tracks, looks and volumes, through files and the command.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use std::fs;
use std::fs::File;
use std::path::Path;

use acerra_imaging::reference::{self, Scatterer};
use acerra_imaging::resolution::displacement_m;
use acerra_imaging::{Complex64, SPEED_OF_LIGHT_M_S, Spreading};
use acerra_radar::{NeutralContent, Spectrum};
use assert_cmd::Command;
use npyz::npz::NpzArchive;
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

fn shape(file: &Path, array: &str) -> Vec<u64> {
    let mut npz = NpzArchive::open(file).unwrap();
    npz.by_name(array).unwrap().unwrap().shape().to_vec()
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
