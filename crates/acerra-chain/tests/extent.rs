//! Images that do not hold the scene, and logs whose clocks cannot belong together.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use std::f64::consts::TAU;

use acerra_chain::align::AlignOptions;
use acerra_chain::choices::TimeOffset;
use acerra_chain::clean::CleanOptions;
use acerra_chain::findings::{Finding, Verdict, weigh_image};
use acerra_chain::{
    Control, ImageRequest, Journal, MemorySink, Progress, Recording, Scene, prepare,
};
use acerra_geo::trajectory::{Fix, Frame, TimeOrigin, Trajectory};
use acerra_imaging::{PlaneGrid, SPEED_OF_LIGHT_M_S};
use acerra_radar::{Radargram, Samples};

/// A target beside the track, and one below it.
const TARGET_M: [f64; 2] = [0.3, 2.5];
const BELOW_M: [f64; 2] = [0.3, 0.1];

/// Place of the radar: 4 m up, past the target at 1 m/s, on a path that winds.
fn place_m(time_s: f64) -> [f64; 3] {
    let sideways = 0.25 * (1.3 * time_s).sin();
    [time_s - 4.0, sideways, 4.0 + 0.1 * (0.9 * time_s).cos()]
}

fn flight(target_m: [f64; 2], trajectory_s: impl Iterator<Item = f64>) -> Recording {
    let time_s: Vec<f64> = (0..200).map(|k| 0.04 * f64::from(k)).collect();
    let echo = |t: f64, n: i32| {
        let [x, y, z] = place_m(t);
        let range_m = (x - target_m[0]).hypot(y - target_m[1]).hypot(z);
        let s = 61e-12 * f64::from(n) - 2.0 * range_m / SPEED_OF_LIGHT_M_S;
        ((-(s / 0.3e-9).powi(2)).exp() * (TAU * 4e9 * s).cos()) as f32
    };
    let samples = time_s
        .iter()
        .flat_map(|t| (0..1000).map(move |n| echo(*t, n)));
    let radargram = Radargram::new(
        time_s.clone(),
        0.0,
        61e-12,
        Samples::Real(samples.collect()),
    )
    .unwrap();
    let fixes = trajectory_s.map(|t| Fix::new(t, place_m(t))).collect();
    let trajectory = Trajectory::new(Frame::Local, TimeOrigin::Relative, fixes).unwrap();
    Recording::new("flight", radargram, trajectory).clean_by(CleanOptions::none())
}

/// The finding on an image of this rectangle; none where nothing focuses outside.
fn extent(target_m: [f64; 2], x_m: [f64; 2], y_m: [f64; 2]) -> Option<Finding> {
    let grid = PlaneGrid::from_ranges(x_m, y_m, 0.0, 0.02).unwrap();
    let control = Control::default();
    let recording = flight(target_m, (0..90).map(|k| 0.1 * f64::from(k)));
    let (journal, calibration) = (&mut Journal::default(), Default::default());
    let scene = Scene::plane(grid);
    let prepared = prepare(vec![recording], scene, &calibration, journal, &control).unwrap();
    let sink = &mut MemorySink::default();
    let focused = prepared
        .image(&ImageRequest::on(grid), sink, &control)
        .unwrap();
    let findings = weigh_image(&prepared, &focused, &control).unwrap();
    findings.into_iter().find(|f| f.name == "image_extent")
}

#[test]
fn an_image_without_the_scene_is_doubtful_with_the_place_of_it() {
    let agrees = |found: &Finding| found.verdict == Verdict::Agrees;
    // The reflector in the middle, 5 cm inside an edge, and 1 cm outside.
    for (x_m, y_m) in [
        ([-1.0, 1.5], [1.0, 4.0]),
        ([0.25, 1.5], [1.0, 4.0]),
        ([0.31, 1.5], [1.0, 4.0]),
        ([-1.0, 1.5], [2.45, 4.0]),
        ([-1.0, 1.5], [2.51, 4.0]),
    ] {
        let held = extent(TARGET_M, x_m, y_m);
        assert!(held.as_ref().is_none_or(agrees), "{x_m:?} {y_m:?} {held:?}");
    }
    // Beside the reflector by metres and by half a metre, on the mirrored side, and with the axis negated.
    let elsewhere = [
        (TARGET_M, [0.8, 2.5], [1.0, 4.0]),
        (TARGET_M, [-1.8, -0.2], [1.0, 4.0]),
        (TARGET_M, [0.5, 2.5], [1.0, 4.0]),
        (TARGET_M, [-1.0, 1.5], [3.0, 4.0]),
        (TARGET_M, [-1.0, 1.5], [1.0, 2.0]),
        (TARGET_M, [-3.0, -1.5], [1.0, 4.0]),
        (TARGET_M, [-1.0, 1.5], [-4.0, -1.0]),
        (TARGET_M, [-1.5, 1.0], [-4.0, -1.0]),
        (BELOW_M, [-3.0, -1.5], [1.0, 4.0]),
    ];
    for (target_m, x_m, y_m) in elsewhere {
        let found = extent(target_m, x_m, y_m).unwrap();
        assert_eq!(
            found.verdict,
            Verdict::Doubtful,
            "{x_m:?} {y_m:?} {found:?}"
        );
        let said = &found.explanation;
        let (_, place) = said.split_once("focuses at (").unwrap();
        let (place, _) = place.split_once(") m").unwrap();
        let (x, y) = place.split_once(", ").unwrap();
        let off_m = (x.parse::<f64>().unwrap() - target_m[0])
            .hypot(y.parse::<f64>().unwrap() - target_m[1]);
        assert!(off_m < 0.3, "{said}");
    }
}

/// A search that begins.
struct NoSearch;

impl Progress for NoSearch {
    fn start(&self, name: &str, _: u64) {
        panic!("{name} began");
    }
    fn at(&self, _: u64) {}
    fn finish(&self) {}
}

#[test]
fn clocks_that_cannot_belong_together_are_refused_before_anything_is_searched() {
    let hour = || (0..18_000).map(|k| 1000.0 + 0.2 * f64::from(k));
    let milliseconds = || (0..300).map(|k| 100.0 * f64::from(k));
    let day = || (0..9_000).map(|k| 10.0 + 5.0 * f64::from(k));
    let refused = |recording: Recording, offset| {
        let recording = recording.align_by(AlignOptions {
            time_offset: Some(offset),
            ..AlignOptions::default()
        });
        let grid = PlaneGrid::from_ranges([0.0, 1.0], [0.0, 1.0], 0.0, 0.1).unwrap();
        let control = Control::default().reporting_to(&NoSearch);
        let (journal, calibration) = (&mut Journal::default(), Default::default());
        let error = prepare(
            vec![recording],
            Scene::plane(grid),
            &calibration,
            journal,
            &control,
        );
        error.unwrap_err().to_string()
    };
    let apart = refused(flight(TARGET_M, hour()), TimeOffset::Seconds(0.0));
    assert!(apart.contains("0.000 to 7.960 s"), "{apart}");
    assert!(apart.contains("1000.000 to 4599.800 s"), "{apart}");
    for offset in [TimeOffset::Auto, TimeOffset::Seconds(500.0)] {
        let rare = refused(flight(TARGET_M, milliseconds()), offset);
        assert!(
            rare.contains("one every 100.000 s over 29900.0 s"),
            "{rare}"
        );
    }
    let long = refused(flight(TARGET_M, day()), TimeOffset::Auto);
    assert!(long.contains("less than 14400 s, found 44995 s"), "{long}");
}
