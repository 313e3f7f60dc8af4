//! Solution files: as RTKLIB's, and read by others.

use crate::common;

use std::process::Command;

use acerra_geo::read::{ReadOptions, read_trajectory};
use acerra_gnss::pos::{PosFormat, PosFrame, PosTime, PosTimeScale, write_pos};
use acerra_gnss::{
    BasePosition, PpkOptions, PpkSolution, Quality, process, read_navigation, read_observations,
};

/// The GEONET set as RTKLIB's own test data have it, solved forward.
fn geonet() -> Option<(PpkSolution, PpkOptions)> {
    let limits = Default::default();
    let rover = read_observations(common::open("gnss-geonet/rover_0759.05o")?, limits)
        .unwrap()
        .0;
    let base = read_observations(common::open("gnss-geonet/base_3040.05o")?, limits)
        .unwrap()
        .0;
    let nav = read_navigation(common::open("gnss-geonet/nav.05n")?, limits)
        .unwrap()
        .0;
    let options = PpkOptions::rtklib().with_base_position(BasePosition::Ecef([
        -3_978_241.958,
        3_382_840.234,
        3_649_900.853,
    ]));
    Some((process(&rover, &base, &nav, &options).unwrap(), options))
}

fn text(solution: &PpkSolution, options: &PpkOptions, format: &PosFormat) -> String {
    let mut out = Vec::new();
    write_pos(
        &mut out,
        solution,
        options,
        &["rover_0759.05o".to_owned()],
        format,
    )
    .unwrap();
    String::from_utf8(out).unwrap()
}

/// Line by line beside RTKLIB's file: same tags, quality and satellites; positions to 0.2 mm,
/// deviations to 0.4 mm.
#[test]
fn baselines_stand_where_rtklib_prints_them() {
    let (Some((solution, options)), Some(reference)) = (
        geonet(),
        common::data("gnss-geonet/reference/b34_fixhold_forward.pos"),
    ) else {
        return;
    };
    let format = PosFormat {
        frame: PosFrame::EnuBaseline,
        ..PosFormat::default()
    };
    let ours = text(&solution, &options, &format);
    let theirs = std::fs::read_to_string(reference).unwrap();
    let data = |text: &str| -> Vec<String> {
        text.lines()
            .filter(|l| !l.starts_with('%'))
            .map(str::to_owned)
            .collect()
    };
    let (ours_data, theirs_data) = (data(&ours), data(&theirs));
    assert_eq!(ours_data.len(), theirs_data.len());
    for (a, b) in ours_data.iter().zip(&theirs_data) {
        assert_eq!(a.len(), b.trim_end().len(), "{a}\n{b}");
        assert_eq!(a[..23], b[..23]);
        assert_eq!(a[68..76], b[68..76], "quality and satellites\n{a}\n{b}");
        for (column, tolerance) in [(24..38, 2.1e-4), (39..53, 2.1e-4), (54..68, 2.1e-4)] {
            let value = |line: &str| line[column.clone()].trim().parse::<f64>().unwrap();
            assert!((value(a) - value(b)).abs() < tolerance, "{a}\n{b}");
        }
        let deviations = |line: &str| -> Vec<f64> {
            line[76..]
                .split_whitespace()
                .take(6)
                .map(|v| v.parse().unwrap())
                .collect()
        };
        let largest = deviations(b)
            .into_iter()
            .fold(0.0, |m: f64, v| m.max(v.abs()));
        for (x, y) in deviations(a).iter().zip(deviations(b)) {
            // As (co)variances: near zero the roots blow differences up.
            let difference = (x * x.abs() - y * y.abs()).abs();
            assert!(
                difference < 2e-2 * largest * largest + 4e-4 * largest,
                "{a}\n{b}"
            );
        }
    }
    // The comment lines that tools look at, but for the program's and files' names.
    let comments = |text: &str| -> Vec<String> {
        text.lines()
            .filter(|l| l.starts_with('%'))
            .filter(|l| !l.contains("program") && !l.contains("inp file") && !l.contains("obs "))
            .map(|l| l.trim_end().to_owned())
            .collect()
    };
    assert_eq!(comments(&ours), comments(&theirs));
}

/// What is written in any frame, time and scale is what `acerra-geo` reads back.
#[test]
fn every_form_reads_back() {
    let Some((solution, options)) = geonet() else {
        return;
    };
    let frame = acerra_geo::geodesy::EnuFrame::from_ecef(solution.base_position_ecef_m.unwrap());
    for pos_frame in [PosFrame::Geodetic, PosFrame::Ecef, PosFrame::EnuBaseline] {
        for time in [PosTime::Calendar, PosTime::WeekTow] {
            for scale in [PosTimeScale::Gps, PosTimeScale::Utc, PosTimeScale::Jst] {
                let format = PosFormat {
                    frame: pos_frame,
                    time,
                    scale,
                    ..PosFormat::default()
                };
                let text = text(&solution, &options, &format);
                let read = read_trajectory(text.as_bytes(), &ReadOptions::default());
                let (trajectory, report) = read.unwrap();
                assert_eq!(
                    trajectory.fixes().len(),
                    solution.epochs.len(),
                    "{report:?}"
                );
                for (fix, epoch) in trajectory.fixes().iter().zip(&solution.epochs) {
                    let what = || format!("{format:?}\n{fix:?}");
                    let expected = frame.enu_from_ecef(epoch.position_ecef_m);
                    for (x, y) in fix.position_m.iter().zip(expected) {
                        // Degrees are printed to 0.1 mm.
                        assert!((x - y).abs() < 1.7e-4, "{}", what());
                    }
                    let time = trajectory.gps_time_at(fix.time_s).unwrap();
                    assert!((time - epoch.time).abs() < 6e-4, "{}", what());
                    assert_eq!(fix.status.is_fixed(), epoch.quality == Quality::Fixed);
                    let here = frame.enu_covariance_from_ecef(&epoch.covariance_ecef_m2);
                    // Square roots are printed to 0.1 mm.
                    let largest = (0..3).map(|i| here[i][i]).fold(0.0, f64::max);
                    let tolerance = 4e-4 * largest.sqrt();
                    for (row, expected) in fix.covariance_m2.unwrap().iter().zip(here) {
                        for (x, y) in row.iter().zip(expected) {
                            assert!((x - y).abs() < tolerance, "{x} {y} {}", what());
                        }
                    }
                }
            }
        }
    }
}

/// RTKLIB's own `pos2kml` takes the file (where the program is installed).
#[test]
fn rtklib_reads_it() {
    let Some((solution, options)) = geonet() else {
        return;
    };
    if Command::new("pos2kml").arg("-?").output().is_err() {
        println!("skipped: RTKLIB's pos2kml is not installed");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for frame in [PosFrame::Geodetic, PosFrame::Ecef] {
        let pos = folder.path().join("a.pos");
        let kml = folder.path().join("a.kml");
        let format = PosFormat {
            frame,
            ..PosFormat::default()
        };
        std::fs::write(&pos, text(&solution, &options, &format)).unwrap();
        let run = Command::new("pos2kml")
            .arg("-o")
            .arg(&kml)
            .arg(&pos)
            .output()
            .unwrap();
        assert!(run.status.success());
        let kml_text = std::fs::read_to_string(&kml).unwrap();
        let points = kml_text.matches("<Point>").count();
        // A mark for every epoch, and one where the track begins or ends.
        assert!(points >= solution.epochs.len(), "{points}");
        let first = acerra_geo::geodesy::geodetic_from_ecef(solution.epochs[0].position_ecef_m);
        let shown = format!("{:.5}", first.longitude_deg());
        assert!(kml_text.contains(&shown), "{shown}\n{}", &kml_text[..2000]);
        std::fs::remove_file(&kml).unwrap();
    }
}
