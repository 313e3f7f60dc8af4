//! RTKLIB's own solutions of real data: every number here was found by an independent script.

mod common;

use acerra_geo::matrix::distance;
use acerra_geo::read::TrajectoryFormat;
use acerra_geo::trajectory::SolutionStatus::{Dgps, Fixed, Float, Single};
use acerra_geo::trajectory::TimeOrigin;

struct Expected {
    file: &'static str,
    epochs: usize,
    reversed: bool,
    fixed: usize,
    float: usize,
    tow_s: (f64, f64),
    mean_m: [f64; 3],
    satellites: u64,
}

const fn solution(
    file: &'static str,
    (epochs, fixed, float): (usize, usize, usize),
    reversed: bool,
    tow_s: (f64, f64),
    mean_m: [f64; 3],
    satellites: u64,
) -> Expected {
    Expected {
        file,
        epochs,
        reversed,
        fixed,
        float,
        tow_s,
        mean_m,
        satellites,
    }
}

#[rustfmt::skip]
const SOLUTIONS: [Expected; 14] = [
    solution("gnss-geonet/reference/b34_fixhold_backward.pos", (115, 108, 7), true, (518_400.0, 521_820.0), [-953.3637, 3196.2454, -6.3684], 725),
    solution("gnss-geonet/reference/b34_fixhold_combined.pos", (115, 115, 0), false, (518_400.0, 521_820.0), [-953.3369, 3196.2391, -6.3965], 725),
    solution("gnss-geonet/reference/b34_fixhold_forward.pos", (115, 114, 1), false, (518_400.0, 521_820.0), [-953.3416, 3196.2388, -6.3911], 725),
    solution("gnss-static-1hz/reference/b34_fixhold_backward.pos", (301, 301, 0), true, (116_400.0, 116_700.0), [-0.2238, -0.9649, 0.0073], 12_642),
    solution("gnss-static-1hz/reference/b34_fixhold_combined_xyz.pos", (301, 301, 0), false, (116_400.0, 116_700.0), [-0.2239, -0.9649, 0.0075], 12_642),
    solution("gnss-static-1hz/reference/b34_fixhold_forward.pos", (301, 301, 0), false, (116_400.0, 116_700.0), [-0.2239, -0.9649, 0.0076], 12_642),
    solution("gnss-walk-m8p/reference/b34_fixhold_backward.pos", (1877, 463, 1414), true, (217_331.0, 219_284.0), [-21.3926, 47.2291, 3.4913], 26_099),
    solution("gnss-walk-m8p/reference/b34_fixhold_combined_xyz.pos", (1863, 1230, 633), false, (217_331.0, 219_284.0), [-20.4256, 46.4746, -0.0989], 25_875),
    solution("gnss-walk-m8p/reference/b34_fixhold_forward.pos", (1878, 954, 924), false, (217_331.0, 219_284.0), [-20.2445, 46.7224, -0.8234], 26_056),
    solution("gnss-walk-m8p/reference/ex251_eratio300_combined.pos", (2052, 1852, 77), false, (217_331.0, 219_398.0), [-20.4676, 44.5454, -0.3654], 26_759),
    solution("gnss-wettzell/reference/b34_continuous_forward.pos", (120, 119, 1), false, (345_600.0, 349_170.0), [-0.4161, 1.5385, 0.0767], 712),
    solution("gnss-wettzell/reference/b34_fixhold_backward.pos", (120, 109, 11), true, (345_600.0, 349_170.0), [-0.4265, 1.5541, 0.0909], 712),
    solution("gnss-wettzell/reference/b34_fixhold_combined.pos", (119, 119, 0), false, (345_630.0, 349_170.0), [-0.4169, 1.5354, 0.0846], 706),
    solution("gnss-wettzell/reference/b34_fixhold_forward.pos", (120, 119, 1), false, (345_600.0, 349_170.0), [-0.4161, 1.5385, 0.0767], 712),
];

#[test]
fn every_reference_solution_is_read_to_the_last_epoch() {
    for want in &SOLUTIONS {
        let Some((track, report)) = common::read_shared(want.file) else {
            return;
        };
        let file = want.file;
        assert_eq!(report.format, TrajectoryFormat::RtklibPos);
        assert_eq!(track.fixes().len(), want.epochs, "{file}");
        assert_eq!(report.reversed, want.reversed, "{file}");
        assert_eq!(
            (report.skipped_total(), report.warnings.len()),
            (0, 0),
            "{file}"
        );
        let counts = track.status_counts();
        assert_eq!(
            (counts.of(Fixed), counts.of(Float)),
            (want.fixed, want.float),
            "{file}"
        );
        assert_eq!((track.start_s(), track.end_s()), want.tow_s, "{file}");
        let mean = [0, 1, 2].map(|axis| {
            track
                .fixes()
                .iter()
                .map(|f| f.position_m[axis])
                .sum::<f64>()
                / want.epochs as f64
        });
        assert!(distance(mean, want.mean_m) < 1.5e-4, "{file} {mean:?}");
        let satellites: u64 = track
            .fixes()
            .iter()
            .map(|f| u64::from(f.satellites.expect("ns")))
            .sum();
        assert_eq!(satellites, want.satellites, "{file}");
        assert!(
            track
                .fixes()
                .iter()
                .all(|f| { f.covariance_m2.is_some() && f.age_s.is_some() && f.ratio.is_some() })
        );
        assert!(track.frame().enu().is_some());
    }
}

/// The same epochs as a baseline and as ECEF: same frame, same place, same covariance.
#[test]
fn layouts_of_one_solution_agree() {
    let Some((enu, _)) = common::read_shared("gnss-static-1hz/reference/b34_fixhold_forward.pos")
    else {
        return;
    };
    let name = "gnss-static-1hz/reference/b34_fixhold_combined_xyz.pos";
    let Some((xyz, _)) = common::read_shared(name) else {
        return;
    };
    let (TimeOrigin::Gps(a), TimeOrigin::Gps(b)) = (enu.time_origin(), xyz.time_origin()) else {
        panic!("both are of GPS time");
    };
    assert_eq!((a, a.week(), a.tow_s()), (b, 2320, 0.0));
    // The first epoch of a forward and of a combined solution is the same one.
    let (e, x) = (enu.fixes()[0], xyz.fixes()[0]);
    assert!(distance(e.position_m, [-0.2246, -0.9647, 0.0071]) < 1e-9);
    assert!(
        distance(x.position_m, e.position_m) < 1e-3,
        "{:?}",
        x.position_m
    );
    let (e, x) = (
        e.standard_deviation_m().expect("sd"),
        x.standard_deviation_m().expect("sd"),
    );
    assert!(distance(e, [0.0033, 0.0033, 0.0091]) < 1e-6);
    // Combining halves the variance at most; four digits of five-millimetre deviations.
    for axis in 0..3 {
        assert!(
            x[axis] > 0.65 * e[axis] && x[axis] < 1.1 * e[axis],
            "{e:?} {x:?}"
        );
    }
}

#[test]
fn the_receivers_own_solution_is_a_plain_table() {
    let Some((track, report)) = common::read_shared("gnss-walk-m8p/reference/onboard_rtk.csv")
    else {
        return;
    };
    assert_eq!(report.format, TrajectoryFormat::Csv);
    let counts = track.status_counts();
    assert_eq!(
        (
            counts.total(),
            counts.of(Fixed),
            counts.of(Float),
            counts.of(Dgps),
            counts.of(Single)
        ),
        (2072, 621, 1060, 112, 279)
    );
    assert_eq!((track.start_s(), track.end_s()), (217_331.0, 219_402.0));
    assert_eq!(track.gaps(1.5).count(), 0);
}
