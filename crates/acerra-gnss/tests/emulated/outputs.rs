//! What a solution is written as, read back by the readers of trajectories.

use crate::synthetic::{BASE_ECEF_M, L1, base, flight, navigation, rover, start};
use acerra_geo::geodesy::EnuFrame;
use acerra_geo::geoid::GeoidGrid;
use acerra_geo::read::{ReadOptions, read_trajectory};
use acerra_geo::trajectory::{Frame, SolutionStatus};
use acerra_gnss::output::{
    ImageError, position_images, within_sigma, write_images, write_nmea, write_residuals,
};
use acerra_gnss::pos::{PosFormat, PosFrame, write_pos};
use acerra_gnss::{
    BasePosition, Dynamics, EventKind, EventRecord, PpkOptions, PpkSolution, Quality, System,
    SystemSet, process,
};

fn options() -> PpkOptions {
    PpkOptions::default()
        .with_systems(SystemSet::GPS.with(System::Galileo))
        .with_base_position(BasePosition::Ecef(BASE_ECEF_M))
        .with_dynamics(Some(Dynamics {
            horizontal_noise: 3.0,
            vertical_noise: 1.0,
        }))
}

/// A flight of a minute with three shutter pulses, the last after the end.
fn solution() -> PpkSolution {
    let navigation = navigation();
    let mut rover = rover(&navigation, 60, &L1);
    rover.events = [10.3, 40.75, 90.0]
        .map(|t| EventRecord {
            time: start() + t,
            kind: EventKind::RisingEdge,
            count: None,
            accuracy_s: None,
        })
        .to_vec();
    let solution = process(&rover, &base(&navigation, 60, &L1), &navigation, &options()).unwrap();
    assert!(
        solution
            .epochs
            .iter()
            .filter(|e| e.quality == Quality::Fixed)
            .count()
            > 50
    );
    solution
}

/// A geoid 47.5 m above the ellipsoid everywhere.
fn geoid() -> GeoidGrid {
    let mut bytes = Vec::new();
    for value in [-90.0_f64, -180.0, 90.0, 90.0] {
        bytes.extend(value.to_be_bytes());
    }
    bytes.extend(3_i32.to_be_bytes());
    bytes.extend(4_i32.to_be_bytes());
    for _ in 0..12 {
        bytes.extend(47.5_f32.to_be_bytes());
    }
    GeoidGrid::from_reader(&bytes[..]).unwrap()
}

#[test]
fn nmea_comes_back_with_positions_status_and_deviations() {
    let solution = solution();
    for geoid in [None, Some(geoid())] {
        let mut text = Vec::new();
        write_nmea(&mut text, &solution, geoid.as_ref()).unwrap();
        let sentences = String::from_utf8(text.clone()).unwrap();
        let separation = if geoid.is_some() {
            ",M,47.5000,M,"
        } else {
            ",M,0.0000,M,"
        };
        assert!(sentences.lines().next().unwrap().contains(separation));
        let (trajectory, report) = read_trajectory(&text[..], &ReadOptions::default()).unwrap();
        assert_eq!(report.skipped_total(), 0, "{report}");
        assert_eq!(trajectory.fixes().len(), solution.epochs.len());
        let Frame::Enu(frame) = trajectory.frame() else {
            panic!()
        };
        for (fix, epoch) in trajectory.fixes().iter().zip(&solution.epochs) {
            let place = frame.ecef_from_enu(fix.position_m);
            for (a, b) in place.iter().zip(epoch.position_ecef_m) {
                assert!((a - b).abs() < 6e-4, "{} {a} {b}", epoch.time);
            }
            let status = match epoch.quality {
                Quality::Fixed => SolutionStatus::Fixed,
                _ => SolutionStatus::Float,
            };
            assert_eq!(fix.status, status);
            let here = EnuFrame::from_ecef(epoch.position_ecef_m);
            let truth = here.enu_covariance_from_ecef(&epoch.covariance_ecef_m2);
            let found = fix.covariance_m2.unwrap();
            for k in 0..3 {
                assert!((found[k][k].sqrt() - truth[k][k].sqrt()).abs() < 2e-4);
            }
        }
    }
}

#[test]
fn rmc_tells_speed_and_course() {
    let solution = solution();
    let epoch = &solution.epochs[45];
    let mut text = Vec::new();
    write_nmea(&mut text, &solution, None).unwrap();
    let text = String::from_utf8(text).unwrap();
    let rmc: Vec<&str> = text.lines().filter(|l| l.starts_with("$GNRMC")).collect();
    let fields: Vec<&str> = rmc[45].split(',').collect();
    let (speed, course): (f64, f64) = (fields[7].parse().unwrap(), fields[8].parse().unwrap());
    let (sin, cos) = course.to_radians().sin_cos();
    let here = EnuFrame::from_ecef(epoch.position_ecef_m);
    let [east, north, _] = here.enu_vector_from_ecef(epoch.velocity_ecef_m_s.unwrap());
    let speed_m_s = speed * 1852.0 / 3600.0;
    assert!((speed_m_s * sin - east).abs() < 2e-3 && (speed_m_s * cos - north).abs() < 2e-3);
    assert!(fields[12].starts_with('R'));
}

#[test]
fn velocities_of_solution_files_come_back() {
    let solution = solution();
    for frame in [PosFrame::Geodetic, PosFrame::Ecef, PosFrame::EnuBaseline] {
        let format = PosFormat {
            frame,
            velocity: true,
            ..PosFormat::default()
        };
        let mut text = Vec::new();
        write_pos(&mut text, &solution, &options(), &[], &format).unwrap();
        let (trajectory, report) = read_trajectory(&text[..], &ReadOptions::default()).unwrap();
        assert_eq!(report.skipped_total(), 0, "{frame:?} {report}");
        let Frame::Enu(axes) = trajectory.frame() else {
            panic!()
        };
        for (fix, epoch) in trajectory.fixes().iter().zip(&solution.epochs) {
            let found = fix.velocity_m_s.unwrap();
            let truth = axes.enu_vector_from_ecef(epoch.velocity_ecef_m_s.unwrap());
            for (a, b) in found.iter().zip(truth) {
                assert!((a - b).abs() < 2e-4, "{frame:?} {found:?} {truth:?}");
            }
        }
    }
    // Without the option nothing changes.
    let mut text = Vec::new();
    write_pos(&mut text, &solution, &options(), &[], &PosFormat::default()).unwrap();
    assert!(!String::from_utf8(text).unwrap().contains("(m/s)"));
}

#[test]
fn residuals_have_a_line_for_every_satellite() {
    let solution = solution();
    let mut text = Vec::new();
    write_residuals(&mut text, &solution).unwrap();
    let text = String::from_utf8(text).unwrap();
    let expected: usize = solution.epochs.iter().map(|e| e.residuals.len()).sum();
    assert!(expected > 500);
    assert_eq!(text.lines().count(), expected + 1);
    assert!(text.lines().all(|line| line.split(',').count() == 10));
}

#[test]
fn images_get_the_positions_of_their_events() {
    let solution = solution();
    let names: Vec<String> = ["a.jpg", "b, second.jpg", "c.jpg"]
        .map(str::to_owned)
        .to_vec();
    let images = position_images(&names, &solution).unwrap();
    let mut text = Vec::new();
    write_images(&mut text, &images, Some(&geoid())).unwrap();
    let text = String::from_utf8(text).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 4);
    let fields: Vec<&str> = lines[1].split(',').collect();
    let number = |k: usize| fields[k].parse::<f64>().unwrap();
    let truth = EnuFrame::from_ecef(flight(10.3));
    let place = truth.origin();
    assert_eq!(fields[0], "a.jpg");
    assert!((number(2) - place.latitude_deg()).abs() < 1e-6);
    assert!((number(3) - place.longitude_deg()).abs() < 1e-6);
    assert!(
        (number(4) + 47.5 - place.height_m).abs() < 0.1,
        "{}",
        lines[1]
    );
    assert!(number(5) > 0.0 && number(5) < 0.05);
    assert!(lines[2].starts_with("\"b, second.jpg\","));
    assert!(lines[3].ends_with(",,,,,,"), "after the end: {}", lines[3]);
    assert_eq!(
        position_images(&names[..2], &solution),
        Err(ImageError::Counts {
            events: 3,
            images: 2
        })
    );
}

#[test]
fn uncertain_positions_are_left_out_where_asked() {
    let solution = solution();
    let (all, none) = within_sigma(&solution, 100.0);
    assert_eq!((all.epochs.len(), none), (solution.epochs.len(), 0));
    let largest = |e: &acerra_gnss::Solution| {
        (0..3)
            .map(|k| e.covariance_ecef_m2[k][k].sqrt())
            .fold(0.0, f64::max)
    };
    let mut sigmas: Vec<f64> = solution.epochs.iter().map(largest).collect();
    sigmas.sort_by(f64::total_cmp);
    let median = sigmas[sigmas.len() / 2];
    let (kept, dropped) = within_sigma(&solution, median);
    assert_eq!(kept.epochs.len() + dropped, solution.epochs.len());
    assert!(dropped > 0 && kept.epochs.iter().all(|e| largest(e) <= median));
}

#[test]
fn geodetic_heights_of_a_solution_file_count_from_the_geoid_and_say_so() {
    let solution = solution();
    let text = |format: &PosFormat| {
        let mut text = Vec::new();
        write_pos(&mut text, &solution, &options(), &[], format).unwrap();
        String::from_utf8(text).unwrap()
    };
    let heights = |text: &str| -> Vec<f64> {
        let lines = text.lines().filter(|line| !line.starts_with('%'));
        let height = |line: &str| line.split_whitespace().nth(4).unwrap().parse().unwrap();
        lines.map(height).collect()
    };
    let ellipsoidal = text(&PosFormat::default());
    let above_geoid = text(&PosFormat {
        geoid: Some(geoid().into()),
        ..PosFormat::default()
    });
    assert!(ellipsoidal.contains("lat/lon/height=WGS84/ellipsoidal"));
    assert!(above_geoid.contains("lat/lon/height=WGS84/geodetic"));
    let [a, b] = [&ellipsoidal, &above_geoid].map(|text| heights(text));
    assert!(!a.is_empty() && a.len() == b.len());
    for (ellipsoidal_m, above_m) in a.iter().zip(&b) {
        assert!(
            (ellipsoidal_m - above_m - 47.5).abs() < 1e-3,
            "{ellipsoidal_m} {above_m}"
        );
    }
}
