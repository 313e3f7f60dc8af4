//! Table 5 and Figure 14: three targets at heights of 0, 0.2 and 0.4 m imaged on three planes.

#![allow(clippy::unwrap_used)] // helpers of tests

use acerra_imaging::psf::{PointSpread, TrackShape, psf_image, retrieve, synthetic_track};
use acerra_imaging::{Control, PlaneGrid};

const TARGETS: [[f64; 3]; 3] = [[-2.0, 0.0, 0.0], [0.0, 0.0, 0.2], [2.0, 0.0, 0.4]];

#[test]
fn targets_are_found_where_equation_14_puts_them() {
    let track = synthetic_track(TrackShape::Straight, 3.0, 0.01, 5.0).unwrap();
    let frequency_hz = (0..341).map(|n| 3.1e9 + 5e6 * f64::from(n)).collect();
    let spread = PointSpread::new(track, None, frequency_hz, 3e8).unwrap();
    // |y| of T1, T2, T3 in metres (`None`: not detected), and the levels of an independent
    // evaluation for those that are absent.
    let planes = [
        (0.0, [Some(0.0), None, None], [0.0, -22.8, -29.1]),
        (0.2, [Some(1.40), Some(0.0), None], [0.0, 0.0, -24.1]),
        (0.4, [Some(1.96), Some(1.37), Some(0.0)], [0.0; 3]),
    ];
    for (z_m, expected, level_db) in planes {
        let grid = PlaneGrid::from_ranges([-2.6, 2.6], [-2.6, 2.6], z_m, 0.02).unwrap();
        let image = psf_image(&spread, &TARGETS, grid, Control::default()).unwrap();
        for (r, (y, level)) in retrieve(&spread, &TARGETS, &image, grid)
            .unwrap()
            .iter()
            .zip(expected.iter().zip(level_db))
        {
            println!("plane {z_m} m: {r:?}");
            assert_eq!(r.detected, y.is_some());
            assert_eq!(r.expected_m.is_some(), y.is_some());
            if let (Some(y), Some(theory)) = (y, r.expected_m) {
                assert!((r.found_m[0] - r.target_m[0]).abs() < 0.01);
                assert!((r.found_m[1].abs() - y).abs() < 0.05, "{:?}", r.found_m);
                assert!((theory[1] - y).abs() < 0.01);
                assert_eq!(r.mirrored, *y > 0.0);
                assert!(r.level_db > -6.0);
            } else {
                assert!(
                    r.level_db < -20.0 && (r.level_db - level).abs() < 0.3,
                    "{}",
                    r.level_db
                );
            }
        }
    }
}
