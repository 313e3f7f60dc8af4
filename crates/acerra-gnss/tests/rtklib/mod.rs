//! Real data sets and RTKLIB's solutions of them, for tests that compare.
#![allow(dead_code, clippy::unwrap_used, clippy::print_stdout)]

pub mod derived;
pub mod deviations;
pub mod motion;
pub mod sets;
pub mod settings;
pub mod trust;

use acerra_geo::geodesy::{EnuFrame, Geodetic, ecef_from_geodetic};
use acerra_geo::time::{Calendar, GpsTime};
use acerra_gnss::input::Limits;
use acerra_gnss::{Navigation, ObservationData, read_navigation, read_observations};
use std::fs::File;
use std::path::PathBuf;

/// The folder of the shared data sets, or `None` (saying so) where it is absent.
pub fn data(folder: &str) -> Option<PathBuf> {
    let path = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data"));
    let path = path.join(folder);
    if !path.is_dir() {
        println!("skipped: {} is not here", path.display());
        return None;
    }
    Some(path)
}

pub fn observations(path: PathBuf) -> ObservationData {
    read_observations(File::open(&path).unwrap(), Limits::default())
        .unwrap()
        .0
}

pub fn navigation(paths: &[PathBuf]) -> Navigation {
    let mut all = Navigation::default();
    for path in paths {
        all.merge(
            read_navigation(File::open(path).unwrap(), Limits::default())
                .unwrap()
                .0,
        );
    }
    all
}

/// An epoch of a `.pos` file.
#[derive(Debug, Clone, Copy)]
pub struct PosEpoch {
    pub time: GpsTime,
    /// As printed: ECEF or east, north, up (m).
    pub position_m: [f64; 3],
    pub quality: u8,
    pub satellites: usize,
    pub ratio: f64,
}

/// Reads a `.pos` file with calendar times and metric columns.
pub fn read_pos(path: PathBuf) -> Vec<PosEpoch> {
    let text = std::fs::read_to_string(&path).unwrap();
    let mut epochs: Vec<PosEpoch> = text
        .lines()
        .filter(|l| !l.starts_with('%') && !l.trim().is_empty())
        .map(|l| {
            let f: Vec<&str> = l.split_whitespace().collect();
            let date: Vec<i32> = f[0].split('/').map(|v| v.parse().unwrap()).collect();
            let clock: Vec<f64> = f[1].split(':').map(|v| v.parse().unwrap()).collect();
            let calendar = Calendar::new(
                date[0],
                date[1] as u8,
                date[2] as u8,
                clock[0] as u8,
                clock[1] as u8,
                clock[2],
            )
            .unwrap();
            PosEpoch {
                time: GpsTime::from_calendar(&calendar),
                position_m: std::array::from_fn(|k| f[2 + k].parse().unwrap()),
                quality: f[5].parse().unwrap(),
                satellites: f[6].parse().unwrap(),
                ratio: f[14].parse().unwrap(),
            }
        })
        .collect();
    // Backward solutions are written last epoch first.
    epochs.sort_by_key(|e| e.time);
    epochs
}

pub fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// The value below which a share of `values` lies.
pub fn percentile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    if values.is_empty() {
        return f64::NAN;
    }
    values[((values.len() - 1) as f64 * share).round() as usize]
}

/// East, north, up of an ECEF position about a base.
pub fn enu(base_ecef_m: [f64; 3], position_ecef_m: [f64; 3]) -> [f64; 3] {
    EnuFrame::from_ecef(base_ecef_m).enu_from_ecef(position_ecef_m)
}

/// Latitude, longitude (degrees) and ellipsoidal height (m) of a file, as ECEF.
pub fn position_file(folder: &str, file: &str) -> [f64; 3] {
    let text = std::fs::read_to_string(data(folder).unwrap().join(file)).unwrap();
    let v: Vec<f64> = text
        .split_whitespace()
        .map(|v| v.parse().unwrap())
        .collect();
    ecef_from_geodetic(&Geodetic::from_degrees(v[0], v[1], v[2]))
}

/// The walk's receiver's own fixed solution: GPS time and east, north, up from the base (m).
pub fn onboard_fixes() -> Vec<(GpsTime, [f64; 3])> {
    let path = data(sets::WALK.folder)
        .unwrap()
        .join("reference/onboard_rtk.csv");
    let text = std::fs::read_to_string(path).unwrap();
    let rows = text.lines().skip(1).filter_map(|line| {
        let f: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
        let gps_s = f[0] as i64 - 315_964_800;
        (f[4] == 4.0).then(|| (GpsTime::new(gps_s, f[0].fract()), [f[1], f[2], f[3]]))
    });
    rows.collect()
}
