//! A run's contents from its directory.

use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;

use acerra_npz::NpzReader;
use anyhow::{Context, ensure};
use num_complex::Complex32;
use serde_json::Value;

use crate::provenance::without_folders;

use super::contents::{ImageContents, RunContents, TargetPlace};
use super::table::Table;

/// Bytes of a pixel.
const PIXEL_BYTES: u64 = 8;

/// Data of the run in `folder`, without spectra and radargrams.
///
/// # Errors
/// A product that is absent or broken, with its name and the place.
pub(super) fn contents(folder: &Path) -> anyhow::Result<RunContents<'static>> {
    let at = |name: &str| format!("{}", folder.join(name).display());
    let run = json(folder, "run.json")?;
    let targets = json(folder, "targets.json")?;
    let text = fs::read_to_string(folder.join("trajectory.csv")).map_err(anyhow::Error::from);
    let trajectory = text.and_then(|text| Table::parse(&text));
    let trajectory = trajectory.with_context(|| at("trajectory.csv"))?;
    let mut items = items(&run, folder).with_context(|| at("run.json"))?;
    if let Some([first, last]) = trajectory.time_span() {
        items.push(("TIME_SPAN_GPST".to_owned(), format!("{first} to {last}")));
    }
    Ok(RunContents {
        name: name_of(folder),
        items,
        image: read_image(&folder.join("image.npz")).with_context(|| at("image.npz"))?,
        trajectory,
        targets: places(&targets).with_context(|| at("targets.json"))?,
        pulses: None,
    })
}

/// Name of a run in a directory.
fn name_of(folder: &Path) -> String {
    let whole = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
    let name = whole.file_name().unwrap_or(whole.as_os_str());
    name.to_string_lossy().into_owned()
}

fn json(folder: &Path, name: &str) -> anyhow::Result<Value> {
    let path = folder.join(name);
    let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    serde_json::from_str(&text).with_context(|| path.display().to_string())
}

/// Reads `image.npz`.
///
/// # Errors
/// A file that cannot be read, arrays that are absent or whose shapes disagree.
pub fn read_image(path: &Path) -> anyhow::Result<ImageContents<'static>> {
    let file = File::open(path)?;
    let file_bytes = file.metadata()?.len();
    let mut npz = NpzReader::new(BufReader::new(file))?;
    let shape = npz.shape("image")?;
    let [ny, nx] = shape[..] else {
        anyhow::bail!("image: expected two dimensions, found {}", shape.len());
    };
    let pixels = ny.saturating_mul(nx);
    ensure!(
        pixels <= file_bytes / PIXEL_BYTES,
        "image: expected {pixels} pixels, found a file of {file_bytes} bytes"
    );
    ensure!(pixels > 0, "image: expected pixels, found none");
    let mut values = Vec::with_capacity(usize::try_from(pixels)?);
    npz.with("image", |header, mut reader| {
        header.read_values(&mut reader, pixels as usize, |re, im| {
            values.push(Complex32::new(re as f32, im as f32));
        })
    })?;
    let mut numbers = |name: &'static str, most: u64| -> anyhow::Result<Vec<f64>> {
        let (_, values) = npz.values(name, most as usize)?;
        Ok(values.into_iter().map(|(v, _)| v).collect())
    };
    let (x_m, y_m) = (numbers("x_m", nx)?, numbers("y_m", ny)?);
    let z_m = numbers("z_m", pixels)?;
    for (name, found, expected) in [("x_m", x_m.len(), nx), ("y_m", y_m.len(), ny)] {
        ensure!(
            found as u64 == expected,
            "{name}: expected {expected} values, as the image has, found {found}"
        );
    }
    ensure!(
        z_m.len() == 1 || z_m.len() == values.len(),
        "z_m: expected one height or {pixels}, found {}",
        z_m.len()
    );
    Ok(ImageContents {
        values: values.into(),
        x_m,
        y_m,
        z_m,
    })
}

fn places(targets: &Value) -> anyhow::Result<Vec<TargetPlace>> {
    let list = targets["targets"]
        .as_array()
        .context("expected an array `targets`, found none")?;
    let place = |(k, target): (usize, &Value)| {
        let number = |key: &str| {
            let found = target[key].as_f64();
            found.with_context(|| format!("target {}: expected a number `{key}`", k + 1))
        };
        Ok(TargetPlace {
            place_m: [number("x_m")?, number("y_m")?, number("z_m")?],
            level_db: number("level_db")?,
            place_deg_m: three(&target["place_deg_m"]),
        })
    };
    list.iter().enumerate().map(place).collect()
}

fn three(value: &Value) -> Option<[f64; 3]> {
    let [a, b, c] = value.as_array()?.as_slice() else {
        return None;
    };
    Some([a.as_f64()?, b.as_f64()?, c.as_f64()?])
}

/// The provenance, as the run recorded it.
fn items(run: &Value, folder: &Path) -> anyhow::Result<Vec<(String, String)>> {
    let version = run["version"].as_str();
    let version = version.context("expected the record of a run, found no `version`")?;
    let mut items = vec![
        ("ACERRA_VERSION".to_owned(), version.to_owned()),
        ("CAMPAIGN".to_owned(), name_of(folder)),
        ("EVIDENCE".to_owned(), evidence(&run["evidence"])),
    ];
    let unchecked = run["unchecked"].as_array().into_iter().flatten();
    let settings: Vec<&str> = unchecked
        .filter_map(|one| one["setting"].as_str())
        .collect();
    if !settings.is_empty() {
        items.push(("UNCHECKED".to_owned(), settings.join(", ")));
    }
    let inputs = run["inputs"].as_array().into_iter().flatten();
    let paths: Vec<&Path> = inputs
        .filter_map(|input| input["path"].as_str())
        .map(Path::new)
        .collect();
    let mut configuration = run["configuration"].clone();
    without_folders(&mut configuration, &paths);
    items.push(("CONFIGURATION".to_owned(), configuration.to_string()));
    let frame = &run["frame"];
    match three(&frame["origin_deg_m"]) {
        Some([latitude, longitude, height]) => items.extend([
            (
                "FRAME".to_owned(),
                "east, north, up about the origin".to_owned(),
            ),
            (
                "ORIGIN_DEG_M".to_owned(),
                format!("{latitude:.10} {longitude:.10} {height:.4}"),
            ),
            (
                "HORIZONTAL_DATUM".to_owned(),
                "WGS 84, as realised by the coordinates of the base".to_owned(),
            ),
            (
                "VERTICAL_DATUM".to_owned(),
                "WGS 84 ellipsoid (heights are not above the sea)".to_owned(),
            ),
        ]),
        None => items.push((
            "FRAME".to_owned(),
            "local; its place on the Earth is not known".to_owned(),
        )),
    }
    for input in run["inputs"].as_array().into_iter().flatten() {
        let (Some(path), Some(digest)) = (input["path"].as_str(), input["sha256"].as_str()) else {
            continue;
        };
        let name = Path::new(path)
            .file_name()
            .unwrap_or_default()
            .to_string_lossy();
        items.push((format!("INPUT_{name}"), format!("sha256 {digest}")));
    }
    Ok(items)
}

/// Number of findings that agree, and the names of the others.
fn evidence(findings: &Value) -> String {
    let findings: Vec<&Value> = findings.as_array().into_iter().flatten().collect();
    let named = |verdict: &str| -> Vec<&str> {
        let these = findings.iter().filter(|f| f["verdict"] == verdict);
        these.filter_map(|f| f["name"].as_str()).collect()
    };
    let mut line = format!(
        "{} of {} findings agree",
        named("agrees").len(),
        findings.len()
    );
    for (verdict, word) in [("contradicts", "contradicts"), ("doubtful", "doubtful")] {
        let names = named(verdict);
        if !names.is_empty() {
            line.push_str(&format!("; {word}: {}", names.join(", ")));
        }
    }
    line
}
