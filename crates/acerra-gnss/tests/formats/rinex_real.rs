//! Real RINEX files: the counts were made by an independent scan of the text.

use crate::common;

use acerra_geo::time::GpsTime;
use acerra_gnss::input::{DropReason, Limits};
use acerra_gnss::{
    Ephemeris, ObservationData, SignalCode, System, read_navigation, read_observations,
};

/// Pseudoranges, phases, Dopplers, slips and half cycles of one frequency slot.
fn counts(data: &ObservationData, slot: usize) -> [usize; 5] {
    let all = || {
        data.epochs
            .iter()
            .flat_map(|e| &e.satellites)
            .filter_map(move |s| s.signals[slot])
    };
    [
        all().filter(|s| s.pseudorange_m.is_some()).count(),
        all().filter(|s| s.phase_cycles.is_some()).count(),
        all().filter(|s| s.doppler_hz.is_some()).count(),
        all().filter(|s| s.loss_of_lock.slipped()).count(),
        all()
            .filter(|s| s.loss_of_lock.half_cycle_unknown())
            .count(),
    ]
}

const OBSERVATIONS: [(&str, usize, [[usize; 5]; 3]); 8] = [
    (
        "gnss-geonet/rover_0759.05o",
        120,
        [[948, 944, 0, 10, 0], [924, 924, 0, 9, 0], [0, 0, 0, 0, 0]],
    ),
    (
        "gnss-geonet/base_3040.05o",
        120,
        [
            [1039, 1039, 0, 6, 0],
            [1036, 1036, 0, 5, 0],
            [0, 0, 0, 0, 0],
        ],
    ),
    (
        "gnss-static-1hz/rover.obs",
        301,
        [
            [16988, 16758, 16988, 3, 0],
            [12819, 12818, 12819, 3, 0],
            [12696, 12695, 12696, 1, 0],
        ],
    ),
    (
        "gnss-static-1hz/base.obs",
        301,
        [
            [16960, 16911, 16960, 1, 0],
            [12656, 11625, 12656, 4, 0],
            [12040, 11637, 12040, 0, 0],
        ],
    ),
    (
        "gnss-wettzell/rover_WTZZ.rnx",
        120,
        [
            [5864, 5864, 5864, 52, 0],
            [3576, 3576, 3697, 11, 0],
            [3246, 3246, 3279, 10, 0],
        ],
    ),
    (
        "gnss-wettzell/base_WTZR.rnx",
        120,
        [
            [4658, 4647, 4658, 3, 0],
            [3495, 3491, 3495, 2, 0],
            [2210, 2209, 2210, 0, 0],
        ],
    ),
    (
        "gnss-walk-m8p/rover.obs",
        2072,
        [
            [42204, 37395, 42203, 5588, 7313],
            [0, 0, 0, 0, 0],
            [0, 0, 0, 0, 0],
        ],
    ),
    (
        "gnss-walk-m8p/base.obs",
        452,
        [
            [10126, 9831, 10126, 502, 396],
            [0, 0, 0, 0, 0],
            [0, 0, 0, 0, 0],
        ],
    ),
];

#[test]
fn observation_counts() {
    for (name, epochs, expected) in OBSERVATIONS {
        let Some(file) = common::open(name) else {
            continue;
        };
        let (data, report) = read_observations(file, Limits::default()).unwrap();
        assert_eq!(data.epochs.len(), epochs, "{name}");
        assert_eq!(
            [0, 1, 2].map(|slot| counts(&data, slot)),
            expected,
            "{name}"
        );
        let pseudo = report.count(&DropReason::PseudoObservation("X1".to_owned()));
        assert_eq!(
            pseudo,
            report.dropped.iter().map(|d| d.count).sum(),
            "{name}: {report}"
        );
        assert!(
            data.epochs.windows(2).all(|w| w[0].time < w[1].time),
            "{name}"
        );
    }
}

/// The header lists `X1` first: skipping it would shift every later column.
#[test]
fn a_pseudo_type_shifts_nothing() {
    let Some(file) = common::open("gnss-static-1hz/rover.obs") else {
        return;
    };
    let (data, report) = read_observations(file, Limits::default()).unwrap();
    let c01 = &data.epochs[0]
        .satellites
        .iter()
        .find(|s| s.satellite.to_string() == "C01")
        .unwrap();
    let b1 = c01.signals[0].unwrap();
    assert_eq!(b1.code, SignalCode::new(2, 'I'));
    assert_eq!(b1.pseudorange_m, Some(36_842_422.530));
    assert_eq!(b1.phase_cycles, Some(191_848_164.080));
    assert_eq!(b1.doppler_hz, Some(161.587));
    assert_eq!(b1.cn0_db_hz, Some(44.438));
    assert_eq!(c01.signals[1].unwrap().pseudorange_m, Some(36_842_420.234));
    assert_eq!(
        report.count(&DropReason::PseudoObservation("X1".to_owned())),
        17_103
    );
    assert_eq!(data.glonass_channels.len(), 8);
    assert_eq!(data.glonass_channels[&18], -3);
}

#[test]
fn headers() {
    let Some(file) = common::open("gnss-wettzell/rover_WTZZ.rnx") else {
        return;
    };
    let (data, _) = read_observations(file, Limits::default()).unwrap();
    assert_eq!(data.station.marker, "WTZZ00DEU");
    assert_eq!(data.station.receiver, "JAVAD TRE_3 DELTA");
    assert_eq!(
        data.station.position_ecef_m,
        Some([4_075_578.4, 931_852.75, 4_801_569.98])
    );
    assert_eq!(data.station.antenna_offset.up_m, 0.284);
    let Some(file) = common::open("gnss-walk-m8p/rover.obs") else {
        return;
    };
    let (data, _) = read_observations(file, Limits::default()).unwrap();
    let t = data.epochs[0].time;
    assert_eq!(t.format_calendar(7), "2018/10/09 12:22:10.9900000");
}

const NAVIGATION: [(&str, [usize; 7]); 5] = [
    // GPS, GLONASS, Galileo, QZSS, BeiDou, NavIC, SBAS
    ("gnss-geonet/nav.05n", [164, 0, 0, 0, 0, 0, 0]),
    ("gnss-static-1hz/base.nav", [13, 19, 65, 3, 32, 0, 0]),
    ("gnss-wettzell/nav.rnx", [257, 0, 1602, 0, 357, 0, 0]),
    ("gnss-walk-m8p/rover.nav", [15, 18, 0, 0, 0, 0, 0]),
    ("gnss-walk-m8p/base.nav", [15, 27, 0, 0, 0, 0, 0]),
];

#[test]
fn navigation_counts() {
    for (name, expected) in NAVIGATION {
        let Some(file) = common::open(name) else {
            continue;
        };
        let (nav, report) = read_navigation(file, Limits::default()).unwrap();
        let count = |s| {
            nav.ephemerides
                .iter()
                .filter(|e| e.satellite().system() == s)
                .count()
        };
        assert_eq!(System::ALL.map(count), expected, "{name}");
        assert!(report.dropped.is_empty(), "{name}: {report}");
        assert!(nav.klobuchar.is_some());
    }
}

#[test]
fn navigation_values() {
    let Some(file) = common::open("gnss-walk-m8p/rover.nav") else {
        return;
    };
    let (nav, _) = read_navigation(file, Limits::default()).unwrap();
    assert_eq!(
        nav.klobuchar.unwrap().beta,
        [90_110.0, 0.0, -196_600.0, 0.0]
    );
    let of = |name: &str| {
        let found = nav
            .ephemerides
            .iter()
            .find(|e| e.satellite().to_string() == name);
        *found.unwrap()
    };
    let Ephemeris::Kepler(g01) = of("G01") else {
        panic!("G01")
    };
    assert_eq!(g01.toc, GpsTime::from_week_tow(2022, 223_184.0));
    assert_eq!(g01.toe, GpsTime::from_week_tow(2022, 223_184.0));
    assert_eq!(
        g01.transmission_time,
        GpsTime::from_week_tow(2022, 219_246.0)
    );
    assert_eq!((g01.iode, g01.iodc, g01.health), (30, 30, 0));
    assert_eq!(g01.sqrt_semi_major_axis, 5_153.656_871_80);
    assert_eq!(g01.eccentricity, 0.811_983_761_378e-2);
    assert_eq!(g01.inclination_rate_rad_s, 0.542_879_755_978e-9);
    assert_eq!(g01.radius_correction_m, [276.625, 68.7187500]);
    assert_eq!(g01.group_delay_s[0], 0.558_793_544_769e-8);
    assert_eq!(g01.accuracy_m, 2.4);
}
