//! Images made tile by tile by several processes, and put together.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use assert_cmd::cargo::cargo_bin;
use serde_json::Value;

use crate::{SINGLE, focus, number, track, values, write_flight};

const TARGET: [f64; 3] = [3.0, 0.2, 0.1];
const RANGES: &str =
    "[image]\nx_m = [2.0, 4.0]\ny_m = [-0.6, 1.0]\nband_ghz = [3.1, 4.8]\naccuracy = 1e-5\n";

/// A folder with a flight and a campaign.
struct Survey {
    folder: tempfile::TempDir,
    text: String,
}

impl Survey {
    fn of(image: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        write_flight(folder.path(), "a", &track(0.0, 4.0), &[TARGET]);
        let text = format!("{SINGLE}{RANGES}{image}");
        let survey = Self { folder, text };
        survey.write(&survey.text);
        survey
    }

    fn write(&self, text: &str) {
        fs::write(self.folder.path().join("tiled.toml"), text).unwrap();
    }

    fn products(&self) -> PathBuf {
        self.folder.path().join("tiled-products")
    }

    fn command(&self, command: &str, arguments: &[&str]) -> Command {
        let mut process = Command::new(cargo_bin("acerra"));
        process
            .arg(command)
            .arg(self.folder.path().join("tiled.toml"));
        process.args(arguments);
        process
    }

    fn said(&self, command: &str, arguments: &[&str]) -> String {
        text_of(&self.command(command, arguments).output().unwrap())
    }
}

fn text_of(output: &Output) -> String {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    if output.status.success() {
        return text(&output.stdout);
    }
    assert_eq!(output.status.code(), Some(1));
    text(&output.stderr)
}

/// Relative L2 difference of an array of two runs.
fn difference(one: &Path, other: &Path, array: &'static str) -> f64 {
    let (a, b) = (values(one, array), values(other, array));
    assert_eq!(a.len(), b.len());
    let square = |(re, im): (f64, f64)| re * re + im * im;
    let apart = a
        .iter()
        .zip(&b)
        .map(|(a, b)| square((a.0 - b.0, a.1 - b.1)));
    (apart.sum::<f64>() / b.iter().copied().map(square).sum::<f64>()).sqrt()
}

#[test]
fn shares_of_the_tiles_make_the_image() {
    let terrain = "terrain = 'dem.asc'\nterrain_crs = 'local'\npixel_m = 0.01\n";
    let volume = "z_m = [-0.3, 0.5]\npixel_m = 0.02\npixel_z_m = 0.05\n";
    for (image, file, array) in [
        ("pixel_m = 0.01\n", "image.npz", "image"),
        (
            "pixel_m = 0.01\nmax_incidence_deg = 50\n",
            "image.npz",
            "image",
        ),
        (terrain, "image.npz", "image"),
        (volume, "volume.npz", "volume"),
    ] {
        let survey = Survey::of(image);
        let heights = "0.1 0.11 0.12\n0.09 0.1 0.11\n0.1 0.1 0.1\n";
        let raster =
            format!("ncols 3\nnrows 3\nxllcorner 0\nyllcorner -3\ncellsize 2.2\n{heights}");
        fs::write(survey.folder.path().join("dem.asc"), raster).unwrap();
        let (whole, _) = focus(survey.folder.path(), "whole", &survey.text).unwrap();

        // At the same time, as on a cluster.
        let shares: Vec<_> = ["1/3", "2/3", "3/3"]
            .map(|share| {
                survey
                    .command("focus", &["--tiles", share])
                    .spawn()
                    .unwrap()
            })
            .into_iter()
            .collect();
        for mut share in shares {
            assert!(share.wait().unwrap().success());
        }
        survey.said("merge", &[]);
        let products = survey.products();
        let [made, expected] =
            [&products, &survey.folder.path().join("whole")].map(|p| p.join(file));
        let apart = difference(&made, &expected, array);
        assert!(apart < 3e-5, "{image}: {apart}");
        assert!(!products.join("tiles.zarr").exists());

        let read = |file: &str| -> Value {
            serde_json::from_str(&fs::read_to_string(products.join(file)).unwrap()).unwrap()
        };
        let targets = read("targets.json");
        for key in ["x_m", "y_m", "z_m"] {
            let [a, b] = [&targets, &whole].map(|t| number(&t["targets"][0], key));
            assert!((a - b).abs() < 1e-3, "{key}: {a} {b}");
        }
        let run = read("run.json");
        let plan = run["plan"].as_str().unwrap();
        assert!(plan.contains("tiles, each planned by itself"), "{plan}");
        assert!(number(&run, "plan_checked_error") < 1e-5);
    }
}

#[test]
fn what_is_missing_or_of_another_run_is_said() {
    let survey = Survey::of("pixel_m = 0.02\n");
    let none = survey.said("merge", &[]);
    assert!(
        none.contains("tiles.zarr: expected tiles made by"),
        "{none}"
    );
    assert!(!survey.products().exists());

    let first = survey.said("focus", &["--tiles", "1/2"]);
    assert!(
        first.contains("3 made, 0 there before, 3 of 6 missing"),
        "{first}"
    );
    let again = survey.said("focus", &["--tiles", "1/2"]);
    assert!(again.contains("0 made, 3 there before"), "{again}");
    let missing = survey.said("merge", &[]);
    assert!(
        missing.contains("3 of 6 tiles are missing, the first is tile 2"),
        "{missing}"
    );

    survey.write(&survey.text.replace("[2.0, 4.0]", "[2.1, 4.0]"));
    for command in [&["focus", "--tiles", "2/2"][..], &["merge"]] {
        let message = survey.said(command[0], &command[1..]);
        assert!(message.contains("found another run's"), "{message}");
    }
    survey.write(&survey.text);
    survey.said("focus", &["--tiles", "2/2"]);
    let chunk = survey.products().join("tiles.zarr/image/c/4/0");
    let bytes = fs::read(&chunk).unwrap();
    fs::write(&chunk, &bytes[..100]).unwrap();
    let cut = survey.said("merge", &[]);
    assert!(
        cut.contains("tile 5") && cut.contains("bytes, found 100"),
        "{cut}"
    );
    assert!(!survey.products().join("image.npz").exists());
    fs::write(&chunk, bytes).unwrap();
    assert!(survey.said("merge", &[]).contains("targets"));
}

#[test]
fn what_no_tile_can_make_is_refused() {
    for (key, expected) in [
        ("method = 'cgls'\n", "solved for together"),
        ("looks = 3\n", "looks and tiles"),
    ] {
        let survey = Survey::of(&format!("pixel_m = 0.02\n{key}"));
        let message = survey.said("focus", &["--tiles", "1/2"]);
        assert!(message.contains(expected), "{message}");
        assert!(!survey.products().exists());
    }
    let survey = Survey::of("pixel_m = 0.02\n");
    let usage = survey
        .command("focus", &["--tiles", "3/2"])
        .output()
        .unwrap();
    assert_eq!(usage.status.code(), Some(2));
    let said = String::from_utf8_lossy(&usage.stderr).into_owned();
    assert!(
        said.contains("expected K/N with K from 1 to N, found 3/2"),
        "{said}"
    );
}
