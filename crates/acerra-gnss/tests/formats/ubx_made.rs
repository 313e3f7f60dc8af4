//! UBX messages made here, byte by byte.

use acerra_geo::time::GpsTime;
use acerra_gnss::input::{DropReason, Limits, ReadReport};
use acerra_gnss::ubx::frame::encode;
use acerra_gnss::{Ephemeris, EventKind, Navigation, ObservationData, SignalCode, read_gnss};

fn read(log: &[u8]) -> (ObservationData, Navigation, ReadReport) {
    let file = read_gnss(log, Limits::default()).unwrap();
    (
        file.observations.unwrap(),
        file.navigation.unwrap(),
        file.report,
    )
}

/// One satellite of RXM-RAW: number, quality, loss of lock.
fn raw_message(tow_ms: i32, week: u16, satellites: &[(u8, i8, u8)]) -> Vec<u8> {
    let mut payload = tow_ms.to_le_bytes().to_vec();
    payload.extend(week.to_le_bytes());
    payload.extend([u8::try_from(satellites.len()).unwrap(), 0]);
    for &(number, quality, lock) in satellites {
        payload.extend(1.0e8_f64.to_le_bytes());
        payload.extend(2.1e7_f64.to_le_bytes());
        payload.extend((-1234.5_f32).to_le_bytes());
        payload.extend([number, quality.cast_unsigned(), 41, lock]);
    }
    encode(0x02, 0x10, &payload).unwrap()
}

#[test]
fn raw_of_the_sixth_generation() {
    let satellites = [
        (7, 7, 0),
        (8, 7, 3),
        (9, 5, 0),
        (10, 4, 0),
        (11, 3, 0),
        (123, 7, 0),
        (99, 7, 0),
    ];
    let mut log = raw_message(475_200_200, 2445, &satellites);
    log.extend(raw_message(475_200_400, 0, &satellites[..1]));
    let (data, _, report) = read(&log);
    assert_eq!(data.epochs.len(), 1);
    assert_eq!(data.epochs[0].time, GpsTime::from_week_tow(2445, 475_200.2));
    let of = |name: &str| {
        let found = data.epochs[0]
            .satellites
            .iter()
            .find(|s| s.satellite.to_string() == name);
        found.and_then(|s| s.signals[0])
    };
    let g07 = of("G07").unwrap();
    assert_eq!(g07.code, SignalCode::new(1, 'C'));
    assert_eq!(
        (g07.phase_cycles, g07.pseudorange_m),
        (Some(1e8), Some(2.1e7))
    );
    assert_eq!((g07.doppler_hz, g07.cn0_db_hz), (Some(-1234.5), Some(41.0)));
    assert_eq!(g07.loss_of_lock.0, 0);
    assert_eq!(of("G08").unwrap().loss_of_lock.0, 3);
    assert_eq!(
        of("G09").unwrap().loss_of_lock.0,
        1,
        "quality 5: lock probably lost before"
    );
    assert_eq!(of("G10").unwrap().phase_cycles, None);
    assert_eq!(of("G11").unwrap().pseudorange_m, None);
    assert!(of("S23").is_some());
    assert_eq!(report.count(&DropReason::PhaseNotUsable), 2);
    assert_eq!(report.count(&DropReason::UnknownSignal), 1);
    assert_eq!(report.count(&DropReason::NoWeek), 1);
}

/// One signal of RXM-RAWX with lock time (ms) and tracking status.
fn rawx_message(tow_s: f64, lock_ms: u16, status: u8) -> Vec<u8> {
    let mut payload = tow_s.to_le_bytes().to_vec();
    payload.extend(2445_u16.to_le_bytes());
    payload.extend([18, 1, 1, 1, 0, 0]);
    payload.extend(2.1e7_f64.to_le_bytes());
    payload.extend(1.1e8_f64.to_le_bytes());
    payload.extend(500.0_f32.to_le_bytes());
    payload.extend([0, 7, 0, 0]);
    payload.extend(lock_ms.to_le_bytes());
    payload.extend([45, 3, 1, 2, status, 0]);
    encode(0x02, 0x15, &payload).unwrap()
}

#[test]
fn slips_of_the_eighth_generation() {
    // Seconds, lock time, status, expected (phase there, slip).
    let steps = [
        (0.0, 5000, 0b0111, Some(false)),
        (1.0, 6000, 0b0111, Some(false)),
        // Lock time fell.
        (2.0, 500, 0b0111, Some(true)),
        // The half cycle was subtracted in between.
        (3.0, 1500, 0b1111, Some(true)),
        // No phase while lock was lost: the slip is remembered …
        (4.0, 0, 0b0001, None),
        (5.0, 0, 0b0001, None),
        // … until the first phase.
        (6.0, 900, 0b1111, Some(true)),
        (7.0, 1900, 0b1111, Some(false)),
        // A gap of 10 s with a lock time that grew, but is younger than the gap.
        (17.0, 5000, 0b1111, Some(true)),
        (18.0, 64_500, 0b1111, Some(false)),
        (82.0, 64_500, 0b1111, Some(false)),
        // Beyond what the counter can tell.
        (150.0, 64_500, 0b1111, Some(true)),
        // Half cycle not resolved.
        (151.0, 64_500, 0b1011, Some(false)),
    ];
    let log: Vec<u8> = steps
        .iter()
        .flat_map(|&(t, lock, status, _)| rawx_message(1000.0 + t, lock, status))
        .collect();
    let (data, _, report) = read(&log);
    assert!(report.dropped.is_empty(), "{report}");
    for (epoch, (t, _, status, expected)) in data.epochs.iter().zip(steps) {
        let signal = epoch.satellites[0].signals[0].unwrap();
        assert_eq!(signal.phase_cycles.is_some(), expected.is_some(), "at {t}");
        assert_eq!(
            signal.loss_of_lock.slipped(),
            expected == Some(true),
            "at {t}"
        );
        let half = expected.is_some() && status & 4 == 0;
        assert_eq!(signal.loss_of_lock.half_cycle_unknown(), half, "at {t}");
    }
}

#[test]
fn time_marks_of_both_edges_and_bases() {
    let mark = |flags: u8, ns: u32| {
        let mut payload = vec![0, flags];
        payload.extend(17_u16.to_le_bytes());
        payload.extend(2445_u16.to_le_bytes());
        payload.extend(2445_u16.to_le_bytes());
        for word in [123_456_u32, 345_678, 123_459, 345_678, ns] {
            payload.extend(word.to_le_bytes());
        }
        encode(0x0D, 0x03, &payload).unwrap()
    };
    let mut log = mark(0b1100_1100, 25);
    log.extend(mark(0b1101_0000, 25));
    log.extend(mark(0b1000_0000, 25));
    let (data, _, report) = read(&log);
    let gps = GpsTime::from_week_tow(2445, 123.456_345_678);
    assert_eq!(data.events.len(), 3);
    assert_eq!(data.events[0].kind, EventKind::RisingEdge);
    assert!((data.events[0].time - gps).abs() < 1e-12);
    assert_eq!(data.events[1].kind, EventKind::FallingEdge);
    assert!((data.events[1].time - data.events[0].time - 0.003).abs() < 1e-12);
    assert!(
        (data.events[2].time - gps - 18.0).abs() < 1e-12,
        "UTC time base"
    );
    assert_eq!(
        (data.events[0].count, data.events[0].accuracy_s),
        (Some(17), Some(25.0 * 1e-9))
    );
    assert_eq!(report.count(&DropReason::TimeNotValid), 1);
}

/// Packs fields of (value, width) into 24-bit words.
fn words(fields: &[(i64, u32)]) -> Vec<u32> {
    let bits: Vec<u32> = fields
        .iter()
        .flat_map(|&(value, width)| (0..width).rev().map(move |i| (value >> i & 1) as u32))
        .collect();
    assert_eq!(bits.len(), 240);
    bits.chunks(24)
        .map(|c| c.iter().fold(0, |w, b| w << 1 | b))
        .collect()
}

/// Subframes 1 to 3 of GPS as IS-GPS-200 lays them out, parity removed.
fn subframes(satellite_clock: i64) -> [Vec<u32>; 3] {
    let head = |id: i64| {
        vec![
            (0x8B, 8),
            (0, 16),
            (475_200 / 6 + id, 17),
            (0, 2),
            (id, 3),
            (0, 2),
        ]
    };
    let mut one = head(1);
    one.extend([
        (2445 % 1024, 10),
        (1, 2),
        (0, 4),
        (0, 6),
        (0, 2),
        (0, 1),
        (0, 23),
        (0, 24),
        (0, 24),
        (0, 16),
    ]);
    one.extend([
        (-11, 8),
        (93, 8),
        (475_200 / 16, 16),
        (0, 8),
        (-300, 16),
        (satellite_clock, 22),
        (0, 2),
    ]);
    let mut two = head(2);
    two.extend([
        (93, 8),
        (-2000, 16),
        (12_000, 16),
        (-1_000_000_000, 32),
        (-3000, 16),
    ]);
    two.extend([
        (80_000_000, 32),
        (4000, 16),
        (2_701_970_000, 32),
        (475_200 / 16, 16),
        (0, 8),
    ]);
    let mut three = head(3);
    three.extend([
        (50, 16),
        (1_500_000_000, 32),
        (-60, 16),
        (650_000_000, 32),
        (8000, 16),
    ]);
    three.extend([
        (-900_000_000, 32),
        (-22_000, 24),
        (93, 8),
        (-700, 14),
        (0, 2),
    ]);
    [words(&one), words(&two), words(&three)]
}

#[test]
fn subframes_of_both_generations_give_one_ephemeris() {
    let sfrb = |words: &[u32]| {
        let mut payload = vec![3, 7];
        payload.extend(words.iter().flat_map(|w| (w | 0xAA00_0000).to_le_bytes()));
        encode(0x02, 0x11, &payload).unwrap()
    };
    let sfrbx = |words: &[u32]| {
        let mut payload = vec![0, 7, 0, 0, 10, 2, 1, 0];
        payload.extend(words.iter().flat_map(|w| (w << 6 | 0x2A).to_le_bytes()));
        encode(0x02, 0x13, &payload).unwrap()
    };
    let parts = subframes(-123_456);
    let mut old: Vec<u8> = parts.iter().flat_map(|w| sfrb(w)).collect();
    old.extend(raw_message(475_210_000, 2445, &[(7, 7, 0)]));
    let mut new: Vec<u8> = parts.iter().flat_map(|w| sfrbx(w)).collect();
    new.extend(rawx_message(475_210.0, 5000, 7));
    let (_, a, report) = read(&old);
    assert!(report.dropped.is_empty(), "{report}");
    let (_, b, _) = read(&new);
    assert_eq!(a, b);
    let [Ephemeris::Kepler(e)] = a.ephemerides[..] else {
        panic!("{a:?}")
    };
    let semicircle = "3.1415926535898".parse::<f64>().unwrap();
    assert_eq!(e.toe, GpsTime::from_week_tow(2445, 475_200.0));
    assert_eq!(e.transmission_time, GpsTime::from_week_tow(2445, 475_200.0));
    assert_eq!((e.iode, e.iodc, e.health, e.accuracy_m), (93, 93, 0, 2.4));
    assert_eq!(
        e.clock,
        [-123_456.0 * 2f64.powi(-31), -300.0 * 2f64.powi(-43), 0.0]
    );
    assert_eq!(e.group_delay_s[0], -11.0 * 2f64.powi(-31));
    assert_eq!(e.sqrt_semi_major_axis, 2_701_970_000.0 * 2f64.powi(-19));
    assert_eq!(e.eccentricity, 80_000_000.0 * 2f64.powi(-33));
    assert_eq!(e.mean_anomaly_rad, -1e9 * 2f64.powi(-31) * semicircle);
    assert_eq!(
        e.mean_motion_correction_rad_s,
        12_000.0 * 2f64.powi(-43) * semicircle
    );
    assert_eq!(e.radius_correction_m, [250.0, -62.5]);
    assert_eq!(
        e.latitude_correction_rad,
        [-3000.0 * 2f64.powi(-29), 4000.0 * 2f64.powi(-29)]
    );
    assert_eq!(
        e.inclination_correction_rad,
        [50.0 * 2f64.powi(-29), -60.0 * 2f64.powi(-29)]
    );
    assert_eq!(e.ascending_node_rad, 1.5e9 * 2f64.powi(-31) * semicircle);
    assert_eq!(e.inclination_rad, 6.5e8 * 2f64.powi(-31) * semicircle);
    assert_eq!(e.perigee_rad, -9e8 * 2f64.powi(-31) * semicircle);
    assert_eq!(
        e.ascending_node_rate_rad_s,
        -22_000.0 * 2f64.powi(-43) * semicircle
    );
    assert_eq!(
        e.inclination_rate_rad_s,
        -700.0 * 2f64.powi(-43) * semicircle
    );

    // Without any measurement there is no week, so no ephemeris.
    let (_, none, report) = read(&old[..3 * 50]);
    assert!(none.ephemerides.is_empty());
    assert_eq!(report.count(&DropReason::NoWeek), 3);
}

/// A log cut anywhere, or with any byte damaged, never yields a measurement that was not sent.
#[test]
fn cuts_and_damage_invent_nothing() {
    let log: Vec<u8> = (0..4)
        .flat_map(|i| rawx_message(1000.0 + f64::from(i), 5000, 7))
        .collect();
    let whole = read(&log).0;
    let message = log.len() / 4;
    for cut in message..log.len() {
        let data = read(&log[..cut]).0;
        assert_eq!(data.epochs[..], whole.epochs[..cut / message]);
    }
    for at in 0..log.len() {
        let mut damaged = log.clone();
        damaged[at] ^= 0x55;
        let data = read(&damaged).0;
        assert_eq!(data.epochs.len(), 3, "byte {at}");
        for epoch in &data.epochs {
            assert!(whole.epochs.iter().any(|w| w.time == epoch.time));
        }
    }
}
