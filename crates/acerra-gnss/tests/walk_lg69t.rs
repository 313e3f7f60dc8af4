//! A walk with a cheap five-system receiver against a better one carried beside it.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

mod rtklib;

use acerra_geo::geodesy::{EnuFrame, Geodetic, ecef_from_geodetic};
use acerra_geo::time::GpsTime;
use acerra_gnss::{BasePosition, PpkOptions, PpkSolution, Quality, process};
use flate2::read::GzDecoder;
use nalgebra::{DMatrix, DVector};
use rtklib::{data, navigation, observations};
use std::fs::File;
use std::io::Read;

const FOLDER: &str = "gnss-walk-lg69t";
const BASE_ECEF_M: [f64; 3] = [-2_845_676.411_0, 4_661_619.402_2, 3_283_215.324_1];
/// GPS less UTC in May 2023.
const LEAP_S: f64 = 18.0;
/// Midnight (UTC) of 19 May 2023 in GPS time without leap seconds: week 2262, Friday.
const MIDNIGHT_GPS_S: i64 = (2262 * 7 + 5) * 86_400;
/// Horizontal distance between the two receivers' positions that nothing explains (m).
const LARGEST_M: f64 = 0.5;

/// Degrees of an NMEA angle.
fn degrees(field: &str, hemisphere: &str) -> f64 {
    let value: f64 = field.parse().unwrap();
    let whole = (value / 100.0).floor();
    let angle = whole + (value - 100.0 * whole) / 60.0;
    if matches!(hemisphere, "S" | "W") {
        -angle
    } else {
        angle
    }
}

/// Fixed positions of the other receiver: GPS time and east, north, up from the base (m).
fn others() -> Vec<(GpsTime, [f64; 3])> {
    let path = data(FOLDER).unwrap().join("um960.nmea.gz");
    let mut text = String::new();
    GzDecoder::new(File::open(path).unwrap())
        .read_to_string(&mut text)
        .unwrap();
    let frame = EnuFrame::from_ecef(BASE_ECEF_M);
    let fix = |line: &str| {
        let f: Vec<&str> = line.split(',').collect();
        if f.len() < 12 || !f[0].ends_with("GGA") || f[6] != "4" {
            return None;
        }
        let clock: f64 = f[1].parse().ok()?;
        let (hours, minutes) = ((clock / 1e4).floor(), (clock / 100.0).floor() % 100.0);
        let second = hours * 3600.0 + minutes * 60.0 + clock % 100.0 + LEAP_S;
        let height_m = f[9].parse::<f64>().ok()? + f[11].parse::<f64>().ok()?;
        let place = Geodetic::from_degrees(degrees(f[2], f[3]), degrees(f[4], f[5]), height_m);
        Some((
            GpsTime::new(MIDNIGHT_GPS_S, 0.0) + second,
            frame.enu_from_ecef(ecef_from_geodetic(&place)),
        ))
    };
    text.lines().filter_map(fix).collect()
}

/// Horizontal distances (m) of our positions from the other receiver's, after the offset between
/// the two that fits best: a constant one, and a lever arm that turns with the direction of walk.
fn distances_m(solution: &PpkSolution, counts: impl Fn(Quality) -> bool) -> Vec<f64> {
    let frame = EnuFrame::from_ecef(BASE_ECEF_M);
    let others = others();
    let at = |t: GpsTime| {
        let near = others.partition_point(|(time, _)| time.seconds_since(t) < -0.02);
        let (time, place) = others.get(near)?;
        (time.seconds_since(t).abs() < 0.02).then_some(*place)
    };
    let (mut differences, mut headings) = (Vec::new(), Vec::new());
    for e in solution.epochs.iter().filter(|e| counts(e.quality)) {
        let neighbours = (at(e.time), at(e.time + -1.0), at(e.time + 1.0));
        let (Some(place), Some(before), Some(after)) = neighbours else {
            continue;
        };
        let found = frame.enu_from_ecef(e.position_ecef_m);
        differences.push([found[0] - place[0], found[1] - place[1]]);
        let [east, north] = [after[0] - before[0], after[1] - before[1]];
        let speed = east.hypot(north);
        // Who stands still has no direction of walk.
        headings.push(if speed > 1.0 {
            [east / speed, north / speed]
        } else {
            [0.0; 2]
        });
    }
    let n = differences.len();
    let design = DMatrix::from_fn(2 * n, 4, |row, column| {
        let [east, north] = headings[row / 2];
        match (row % 2, column) {
            (0, 0) | (1, 1) => 1.0,
            (0, 2) => east,
            (1, 2) => north,
            (0, 3) => north,
            (1, 3) => -east,
            _ => 0.0,
        }
    });
    let right = DVector::from_fn(2 * n, |row, _| differences[row / 2][row % 2]);
    let offsets = (design.tr_mul(&design))
        .cholesky()
        .unwrap()
        .solve(&design.tr_mul(&right));
    println!(
        "constant offset and lever arm: {:.2?} m",
        offsets.as_slice()
    );
    let left = right - design * offsets;
    (0..n).map(|k| left[2 * k].hypot(left[2 * k + 1])).collect()
}

#[test]
#[ignore = "five attempts at a log of five systems; cargo xtask validate, as CI does"]
fn validation_every_epoch_has_a_position_and_no_fix_is_far_from_the_other_receiver() {
    let Some(folder) = data(FOLDER) else { return };
    let rover = observations(folder.join("rover.obs.gz"));
    let base = observations(folder.join("base.obs.gz"));
    let navigation = navigation(&[folder.join("rover.nav.gz")]);
    let options = PpkOptions::default().with_base_position(BasePosition::Ecef(BASE_ECEF_M));
    let solution = process(&rover, &base, &navigation, &options).unwrap();
    let fixed = solution.summary.fixed;
    println!("{} positions, {fixed} fixed", solution.epochs.len());
    assert_eq!(solution.epochs.len(), 1206);
    assert!(fixed >= 1036, "{fixed} fixed");
    let of_fixes = distances_m(&solution, |q| q == Quality::Fixed);
    let of_all = distances_m(&solution, |_| true);
    let beyond = |of: &[f64]| of.iter().filter(|d| **d > LARGEST_M).count();
    println!(
        "beyond {LARGEST_M} m: {} of {} fixes compared, {} of {} positions",
        beyond(&of_fixes),
        of_fixes.len(),
        beyond(&of_all),
        of_all.len()
    );
    assert!(of_fixes.len() > 900, "{} compared", of_fixes.len());
    assert_eq!(beyond(&of_fixes), 0);
}
