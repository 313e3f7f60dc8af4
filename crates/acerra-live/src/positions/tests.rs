//! Places between positions, beyond them, and before any motion.

use super::*;
use acerra_geo::trajectory::SolutionStatus;

const ORIGIN: [f64; 3] = [40.9, 14.2, 60.0];

fn origin() -> Geodetic {
    Geodetic::from_degrees(ORIGIN[0], ORIGIN[1], ORIGIN[2])
}

fn start() -> GpsTime {
    GpsTime::from_week_tow(2075, 207_000.0)
}

/// Flying north at 2 m/s with a sway of a decimetre.
fn truth_m(time_s: f64) -> [f64; 3] {
    [
        0.1 * (1.5 * time_s).sin(),
        2.0 * time_s,
        10.0 + 0.05 * time_s.cos(),
    ]
}

fn position(time_s: f64, status: SolutionStatus) -> Position {
    let frame = EnuFrame::new(origin());
    let ecef_m = frame.ecef_from_enu(truth_m(time_s));
    Position {
        time: start() + time_s,
        place: acerra_geo::geodesy::geodetic_from_ecef(ecef_m),
        sigma_m: Some([0.01, 0.01, 0.02]),
        status,
    }
}

fn flown(interval_s: f64, count: i32, arm_m: [f64; 3]) -> Positions {
    let mut positions = Positions::new(Some(origin()), arm_m);
    for k in 0..count {
        positions.push(&position(interval_s * f64::from(k), SolutionStatus::Fixed));
    }
    positions
}

#[test]
fn a_place_is_found_between_positions_and_never_beyond_the_last() {
    let mut positions = flown(0.2, 40, [0.0; 3]);
    for time_s in [0.05, 3.33, 7.79] {
        let Placed::At(place) = positions.at(start() + time_s) else {
            panic!("{time_s}");
        };
        let truth = truth_m(time_s);
        let off_m = (0..3).map(|k| (place.position_m[k] - truth[k]).abs());
        assert!(off_m.fold(0.0, f64::max) < 5e-4, "{time_s}: {place:?}");
        assert!((place.sigma_m.unwrap()[2] - 0.02).abs() < 1e-9);
    }
    assert_eq!(positions.at(start() + 7.81), Placed::Waiting);
    assert_eq!(
        positions.at(start() + -0.1),
        Placed::Nowhere(Missing::BeforeFirst)
    );
}

#[test]
fn what_lies_in_a_gap_is_nowhere() {
    let mut positions = flown(0.2, 10, [0.0; 3]);
    for k in 20..30 {
        positions.push(&position(0.2 * f64::from(k), SolutionStatus::Fixed));
    }
    assert_eq!(positions.at(start() + 3.0), Placed::Nowhere(Missing::Gap));
    assert!(matches!(positions.at(start() + 4.5), Placed::At(_)));
}

#[test]
fn the_lever_arm_turns_with_the_flight_and_waits_for_a_heading() {
    let mut standing = Positions::new(Some(origin()), [0.5, 0.0, -0.2]);
    for k in 0..5 {
        let mut still = position(0.0, SolutionStatus::Fixed);
        still.time = start() + 0.2 * f64::from(k);
        standing.push(&still);
    }
    let Placed::WithoutHeading { up_m } = standing.at(start() + 0.3) else {
        panic!("a heading");
    };
    assert!((up_m - truth_m(0.0)[2] + 0.2).abs() < 1e-3);
    assert!(standing.is_without_heading());
    // Once it moves, the first heading holds for the time before as well.
    for k in 0..20 {
        let mut moving = position(0.2 * f64::from(k), SolutionStatus::Fixed);
        moving.time = start() + 1.0 + 0.2 * f64::from(k);
        standing.push(&moving);
    }
    let Placed::At(place) = standing.at(start() + 0.3) else {
        panic!("no place");
    };
    assert!((place.position_m[1] - 0.5).abs() < 0.01, "{place:?}");
    let mut positions = flown(0.2, 40, [0.5, 0.0, -0.2]);
    let Placed::At(place) = positions.at(start() + 4.0) else {
        panic!("no place");
    };
    let truth = truth_m(4.0);
    assert!((place.position_m[1] - truth[1] - 0.5).abs() < 0.01);
    assert!((place.position_m[2] - truth[2] + 0.2).abs() < 1e-3);
    // Hovering for longer than positions are kept: the heading before holds.
    let end = position(7.8, SolutionStatus::Fixed);
    for k in 0..300 {
        let mut still = end;
        still.time = start() + 8.0 + 0.2 * f64::from(k);
        positions.push(&still);
    }
    let Placed::At(place) = positions.at(start() + 60.0) else {
        panic!("no place");
    };
    assert!((place.position_m[1] - truth_m(7.8)[1] - 0.5).abs() < 0.02);
}

#[test]
fn positions_between_kinds_are_called_the_worse() {
    let mut positions = flown(0.2, 10, [0.0; 3]);
    for k in 10..20 {
        positions.push(&position(0.2 * f64::from(k), SolutionStatus::Float));
    }
    let Placed::At(place) = positions.at(start() + 3.0) else {
        panic!("no place");
    };
    assert_eq!(place.status, SolutionStatus::Float);
}

#[test]
fn positions_are_kept_for_pulses_that_wait_and_no_longer() {
    let mut positions = flown(0.1, 1, [0.0; 3]);
    let fly = |positions: &mut Positions, range: std::ops::Range<i32>| {
        for k in range {
            positions.push(&position(0.1 * f64::from(k), SolutionStatus::Fixed));
        }
        positions.fixes.len()
    };
    // The one at 5 s is the last of those before.
    positions.need_from(Some(start() + 5.0));
    assert_eq!(fly(&mut positions, 1..400), 400 - 51 + KEPT_BEFORE);
    assert!(matches!(positions.at(start() + 5.0), Placed::At(_)));
    positions.need_from(None);
    assert_eq!(fly(&mut positions, 400..401), KEPT);
    positions.need_from(Some(start() + 40.0));
    assert_eq!(fly(&mut positions, 401..5000), MOST_KEPT);
}
