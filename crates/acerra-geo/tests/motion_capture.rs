//! The motion-capture files of a real flight: every number was found by an independent script.

mod common;

use acerra_geo::interpolate::{
    Flag, InterpolationOptions, Interpolator, Method, path_length_per_trace_m,
};
use acerra_geo::lever_arm::{HeadingOptions, apply_lever_arm};
use acerra_geo::matrix::distance;
use acerra_geo::read::{SkipReason, TrajectoryFormat};
use acerra_geo::trajectory::{Frame, TimeOrigin};

const PLATFORM: &str = "uav-flight-2019/platform-mocap.csv";

#[test]
fn rows_gaps_and_axes() {
    let Some((track, report)) = common::read_shared(PLATFORM) else {
        return;
    };
    assert_eq!(report.format, TrajectoryFormat::Motive);
    assert_eq!((report.lines, report.records), (9_831, 9_824));
    assert_eq!(report.skipped_for(SkipReason::EmptyPosition), 19);
    assert_eq!(
        (report.skipped_total(), report.skipped[0].first_line),
        (19, 5_004)
    );
    assert!(report.warnings.is_empty());
    assert!(
        report
            .about
            .contains(&("rigid body".to_owned(), "Radar".to_owned()))
    );
    assert_eq!(
        (track.frame(), track.time_origin()),
        (&Frame::Local, TimeOrigin::Relative)
    );
    assert_eq!(track.fixes().len(), 9_805);
    assert_eq!((track.start_s(), track.end_s()), (0.0, 27.283_333));
    // Motive's (X, Y, Z) = (−4.528944, 1.163232, 3.603409).
    assert_eq!(
        track.fixes()[0].position_m,
        [-4.528_944, -3.603_409, 1.163_232]
    );
    let q = track.fixes()[0].attitude.expect("attitude").quaternion();
    for (q, want) in q.iter().zip([0.999_182, -0.039_188, -0.007_454, 0.006_710]) {
        assert!((q - want).abs() < 1e-6, "{q} {want}");
    }
    assert!((track.path_length_m() - 10.734_252).abs() < 1e-6);
    let (low, high) = track.bounds_m();
    assert!(distance(low, [-4.529_566, -4.577_746, 0.968_408]) < 1e-9);
    assert!(distance(high, [1.279_649, -2.487_596, 1.985_491]) < 1e-9);
    // Eleven runs of empty rows, one of them at the end; three longer than one row in between.
    let frame_s = 1.0 / 360.0;
    assert_eq!(track.gaps(1.5 * frame_s).count(), 10);
    assert_eq!(track.gaps(2.5 * frame_s).count(), 3);
}

#[test]
fn positions_between_frames() {
    let Some((track, _)) = common::read_shared(PLATFORM) else {
        return;
    };
    for method in [Method::Linear, Method::Smooth] {
        let options = InterpolationOptions::default().with_method(method);
        let at = Interpolator::new(&track, &options);
        // Short losses of sight are bridged by default; the strict see them.
        for (t, want) in [
            (14.0, [-3.861_247, -3.771_936, 1.175_816]),
            (14.246, [-3.725_807, -3.612_942, 1.084_852]),
            (18.333_3, [-0.858_088, -2.601_462, 1.467_779]),
        ] {
            let p = at.at(t);
            assert_eq!(p.flag, Flag::Ok);
            assert!(
                distance(p.position_m, want) < 2e-3,
                "{t} {:?}",
                p.position_m
            );
        }
        let times: Vec<f64> = (0..800).map(|i| 6.51 + 0.021_573 * f64::from(i)).collect();
        let (positions, coverage) = at.at_all(&times);
        assert_eq!(coverage.count(Flag::Ok), 800, "{coverage}");
        let path: Vec<[f64; 3]> = positions.iter().map(|p| p.position_m).collect();
        let total: f64 = path_length_per_trace_m(&path).iter().sum();
        // Straight lines between frames, by the independent script; the spline differs by noise.
        assert!((total - 8.609_250).abs() < if method == Method::Linear { 1e-5 } else { 0.02 });
    }
    let strict = InterpolationOptions::default().with_max_gap_s(2.5 / 360.0);
    let at = Interpolator::new(&track, &strict);
    assert_eq!(at.at(14.251).flag, Flag::InGap);
    assert_eq!(at.at(27.285).flag, Flag::AfterEnd);
}

#[test]
fn the_lever_arm_turns_with_the_body() {
    let Some((track, _)) = common::read_shared(PLATFORM) else {
        return;
    };
    let (moved, report) =
        apply_lever_arm(&track, [0.0, 0.0, 1.0], &HeadingOptions::default()).expect("attitudes");
    // At 14.853 and 17.256 s the body stands on its head for one frame of 2.8 ms.
    assert_eq!(
        (report.from_attitude, report.held, report.flipped),
        (9_803, 2, 2)
    );
    for (a, b) in track.fixes().iter().zip(moved.fixes()) {
        assert!((distance(a.position_m, b.position_m) - 1.0).abs() < 1e-9);
        // The drone stays within 60° of upright.
        assert!(b.position_m[2] - a.position_m[2] > 0.5);
    }
}

#[test]
fn the_reflector_stands_where_it_was_surveyed() {
    let Some((track, report)) = common::read_shared("uav-flight-2019/reflector-mocap.csv") else {
        return;
    };
    assert_eq!((track.fixes().len(), report.skipped_total()), (2_439, 0));
    let n = track.fixes().len() as f64;
    let mean = [0, 1, 2].map(|k| track.fixes().iter().map(|f| f.position_m[k]).sum::<f64>() / n);
    assert!(
        distance(mean, [1.792_873, 1.810_146, -0.017_217]) < 2e-6,
        "{mean:?}"
    );
}
