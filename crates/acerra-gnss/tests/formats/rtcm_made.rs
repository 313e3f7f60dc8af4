//! RTCM 3 messages made here, field by field in the order of the standard's tables.

use acerra_geo::time::{Calendar, GpsTime};
use acerra_gnss::input::{DropReason, FileKind, Limits, ReadError, sniff};
use acerra_gnss::rtcm::frame::encode;
use acerra_gnss::rtcm::{DateSource, RtcmHints, RtcmLog, read_rtcm};
use acerra_gnss::{
    Ephemeris, RecordedEpoch, SPEED_OF_LIGHT_M_S, SignalCode, SignalObservation, read_gnss,
};

/// A message of fields (value, width), padded to whole bytes.
fn message(fields: &[(i64, usize)]) -> Vec<u8> {
    let mut bits: Vec<bool> = Vec::new();
    for &(value, width) in fields {
        bits.extend((0..width).rev().map(|i| value >> i & 1 == 1));
    }
    let bytes: Vec<u8> = bits
        .chunks(8)
        .map(|byte| {
            let value = byte.iter().fold(0, |v, &bit| v << 1 | u8::from(bit));
            value << (8 - byte.len())
        })
        .collect();
    encode(&bytes).unwrap()
}

fn hints() -> RtcmHints {
    RtcmHints {
        near: Some(GpsTime::from_week_tow(2262, 200_000.0)),
        ..RtcmHints::default()
    }
}

fn read(log: &[u8]) -> RtcmLog {
    read_rtcm(log, &hints())
}

fn signal<'a>(epoch: &'a RecordedEpoch, satellite: &str, code: &str) -> &'a SignalObservation {
    let of = epoch
        .satellites
        .iter()
        .find(|s| s.satellite.to_string() == satellite)
        .unwrap();
    of.signals
        .iter()
        .find(|s| s.code.to_string() == code)
        .unwrap()
}

/// Message 1004 with one satellite; `excess` and `lock` are of its L1 phase.
fn gps_1004(tow_ms: i64, excess: i64, lock: i64) -> Vec<u8> {
    message(&[
        (1004, 12),
        (77, 12),
        (tow_ms, 30),
        (0, 1),
        (1, 5),
        (0, 1),
        (0, 3),
        (5, 6),
        (0, 1),
        (5_000_000, 24),
        (excess, 20),
        (lock, 7),
        (70, 8),
        (180, 8),
        (3, 2),
        (-250, 14),
        (4000, 20),
        (lock, 7),
        (0, 8),
    ])
}

#[test]
fn a_satellite_of_1004() {
    let log = read(&gps_1004(345_600_250, -2000, 40));
    let (offset, epoch) = &log.epochs[0];
    assert_eq!(*offset, 0);
    assert_eq!(epoch.time, GpsTime::from_week_tow(2262, 345_600.25));
    let l1 = signal(epoch, "G05", "1C");
    let range_m = 100_000.0 + 70.0 * 299_792.458;
    assert!((l1.pseudorange_m.unwrap() - range_m).abs() < 1e-6);
    let cycles = (range_m - 1.0) * 1_575.42e6 / SPEED_OF_LIGHT_M_S;
    assert!((l1.phase_cycles.unwrap() - cycles).abs() < 1e-6);
    assert_eq!((l1.cn0_db_hz, l1.loss_of_lock.0), (Some(45.0), 0));
    let l2 = signal(epoch, "G05", "2W");
    assert!((l2.pseudorange_m.unwrap() - (range_m - 5.0)).abs() < 1e-6);
    let cycles = (range_m + 2.0) * 1_227.6e6 / SPEED_OF_LIGHT_M_S;
    assert!((l2.phase_cycles.unwrap() - cycles).abs() < 1e-6);
    assert_eq!(l2.cn0_db_hz, None);
}

/// Past 750 cycles a sender takes 1500 off: the phase itself goes on.
#[test]
fn phases_of_1004_go_on_over_their_modulus() {
    let wavelength_m = SPEED_OF_LIGHT_M_S / 1_575.42e6;
    let step = |cycles: f64| (cycles * wavelength_m / 0.0005).round() as i64;
    let mut log = gps_1004(1000, step(740.0), 40);
    log.extend(gps_1004(2000, step(760.0 - 1500.0), 40));
    log.extend(gps_1004(3000, step(780.0 - 1500.0), 40));
    // After a loss of lock the phase may begin anywhere.
    log.extend(gps_1004(4000, step(-700.0), 0));
    let log = read(&log);
    let phase = |k: usize| signal(&log.epochs[k].1, "G05", "1C").phase_cycles.unwrap();
    assert!((phase(1) - phase(0) - 20.0).abs() < 0.01);
    assert!((phase(2) - phase(1) - 20.0).abs() < 0.01);
    assert!((phase(3) - phase(2) + 1480.0).abs() < 0.01);
    let slipped = |k: usize| signal(&log.epochs[k].1, "G05", "1C").loss_of_lock.slipped();
    assert_eq!([0, 1, 2, 3].map(slipped), [false, false, false, true]);
}

#[test]
fn values_that_say_not_valid_are_absent() {
    let log = read(&message(&[
        (1004, 12),
        (77, 12),
        (1000, 30),
        (0, 1),
        (2, 5),
        (0, 4),
        // No L1 pseudorange: nothing to refer the rest to.
        (44, 6),
        (0, 1),
        (0x80_0000, 24),
        (5, 20),
        (9, 7),
        (70, 8),
        (180, 8),
        (0, 2),
        (3, 14),
        (5, 20),
        (9, 7),
        (180, 8),
        // No phases, no L2 pseudorange.
        (6, 6),
        (0, 1),
        (100, 24),
        (-0x8_0000, 20),
        (9, 7),
        (70, 8),
        (180, 8),
        (0, 2),
        (-0x2000, 14),
        (-0x8_0000, 20),
        (9, 7),
        (180, 8),
    ]));
    let epoch = &log.epochs[0].1;
    for (satellite, code) in [("S24", "1C"), ("S24", "2X"), ("G06", "2X")] {
        let s = signal(epoch, satellite, code);
        assert_eq!(
            (s.pseudorange_m, s.phase_cycles),
            (None, None),
            "{satellite} {code}"
        );
    }
    assert!(signal(epoch, "G06", "1C").pseudorange_m.is_some());
    assert_eq!(signal(epoch, "G06", "1C").phase_cycles, None);
}

#[test]
fn a_satellite_of_1012() {
    // 03:00:00.5 in Moscow is 00:00:18.5 GPS time; that nearest to the hint is Tuesday's.
    let log = read(&message(&[
        (1012, 12),
        (77, 12),
        (10_800_500, 27),
        (0, 1),
        (1, 5),
        (0, 4),
        (11, 6),
        (0, 1),
        (7 - 3, 5),
        (1_000_000, 25),
        (400, 20),
        (50, 7),
        (35, 7),
        (160, 8),
        (1, 2),
        (100, 14),
        (-400, 20),
        (50, 7),
        (140, 8),
    ]));
    let epoch = &log.epochs[0].1;
    assert_eq!(epoch.time, GpsTime::from_week_tow(2262, 172_818.5));
    assert_eq!(log.glonass_channels[&11], -3);
    let range_m = 20_000.0 + 35.0 * 599_584.916;
    let l1 = signal(epoch, "R11", "1C");
    assert!((l1.pseudorange_m.unwrap() - range_m).abs() < 1e-6);
    let frequency_hz = 1_602e6 - 3.0 * 0.5625e6;
    let cycles = (range_m + 0.2) * frequency_hz / SPEED_OF_LIGHT_M_S;
    assert!((l1.phase_cycles.unwrap() - cycles).abs() < 1e-6);
    let l2 = signal(epoch, "R11", "2P");
    assert!((l2.pseudorange_m.unwrap() - range_m - 2.0).abs() < 1e-6);
}

/// An MSM of two satellites and two signals with three cells, all fields of which follow from
/// `kind`.
fn msm(number: i64, epoch: i64, more: i64, lock: i64) -> Vec<u8> {
    let kind = number % 10;
    let rates = kind == 5 || kind == 7;
    let mut fields = vec![(number, 12), (77, 12), (epoch, 30), (more, 1), (0, 18)];
    // Satellites 3 and 9, signals 2 and 15, no second signal of satellite 9.
    fields.extend([
        (1 << 61 | 1 << 55, 64),
        (1 << 30 | 1 << 17, 32),
        (0b1110, 4),
    ]);
    fields.extend([(70, 8), (255, 8)]);
    if rates {
        fields.extend([(9, 4), (15, 4)]);
    }
    fields.extend([(512, 10), (0, 10)]);
    if rates {
        fields.extend([(-300, 14), (-8192, 14)]);
    }
    let (range, phase) = if kind >= 6 { (20, 24) } else { (15, 22) };
    let invalid = |width: usize| -(1 << (width - 1));
    fields.extend([(1000, range), (invalid(range), range), (5, range)]);
    fields.extend([(-2000, phase), (3000, phase), (5, phase)]);
    let (lock_width, cn0_width) = if kind >= 6 { (10, 10) } else { (4, 6) };
    fields.extend([(lock, lock_width); 3]);
    fields.extend([(0, 1), (1, 1), (0, 1)]);
    fields.extend([(40, cn0_width), (0, cn0_width), (41, cn0_width)]);
    if rates {
        fields.extend([(1234, 15), (-16384, 15), (1, 15)]);
    }
    message(&fields)
}

#[test]
fn every_kind_of_msm() {
    for kind in 4..=7 {
        let log = read(&msm(1070 + kind, 1500, 0, 12));
        let epoch = &log.epochs[0].1;
        assert_eq!(epoch.time, GpsTime::from_week_tow(2262, 1.5), "{kind}");
        let steps = |coarse: i32, fine: i32| 2f64.powi(if kind >= 6 { fine } else { coarse });
        let metres = |fine_ms: f64| (70.5 + fine_ms) * SPEED_OF_LIGHT_M_S * 1e-3;
        let l1 = signal(epoch, "G03", "1C");
        let range_m = metres(1000.0 * steps(-24, -29));
        assert!((l1.pseudorange_m.unwrap() - range_m).abs() < 1e-6, "{kind}");
        let to_cycles = 1_575.42e6 / SPEED_OF_LIGHT_M_S;
        let cycles = metres(-2000.0 * steps(-29, -31)) * to_cycles;
        assert!((l1.phase_cycles.unwrap() - cycles).abs() < 1e-5, "{kind}");
        assert_eq!(l1.loss_of_lock.0, 0);
        assert_eq!(l1.cn0_db_hz, Some(if kind >= 6 { 2.5 } else { 40.0 }));
        let doppler = matches!(kind, 5 | 7).then_some((300.0 - 0.1234) * to_cycles);
        match (l1.doppler_hz, doppler) {
            (Some(a), Some(b)) => assert!((a - b).abs() < 1e-9),
            (a, b) => assert_eq!(a, b),
        }
        let l2 = signal(epoch, "G03", "2S");
        assert_eq!(
            (l2.pseudorange_m, l2.cn0_db_hz, l2.doppler_hz),
            (None, None, None)
        );
        assert!(l2.phase_cycles.is_some());
        assert_eq!(l2.loss_of_lock.0, 2, "half cycle unresolved");
        // The rough range of the other satellite is not valid.
        let other = signal(epoch, "G09", "1C");
        assert_eq!((other.pseudorange_m, other.phase_cycles), (None, None));
    }
}

#[test]
fn messages_of_one_epoch_are_put_together_and_a_missing_one_is_counted() {
    let mut log = msm(1075, 1000, 1, 12);
    // BeiDou's clock is 14 s behind.
    log.extend(msm(1125, 604_787_000, 0, 12));
    log.extend(msm(1075, 2000, 1, 12));
    log.extend(msm(1075, 3000, 0, 12));
    log.extend(msm(1075, 7000, 0, 12));
    let log = read(&log);
    let times: Vec<f64> = log.epochs.iter().map(|(_, e)| e.time.tow_s()).collect();
    assert_eq!(times, [1.0, 2.0, 3.0, 7.0]);
    assert_eq!(log.epochs[0].1.satellites.len(), 4);
    assert_eq!(log.report.count(&DropReason::IncompleteEpoch), 1);
    let remarks = log.report.remarks.join("\n");
    assert!(
        remarks.contains("3 epochs of 1.000 s are missing in 1 gaps"),
        "{remarks}"
    );
}

#[test]
fn glonass_phases_wait_for_their_channel() {
    // MSM5 states the channel beside the range (9 - 7); MSM4 does not.
    let day = 4 << 27 | 10_800_500;
    let with_channel = read(&msm(1085, day, 0, 12));
    assert_eq!(with_channel.glonass_channels[&3], 2);
    assert!(
        signal(&with_channel.epochs[0].1, "R03", "1C")
            .phase_cycles
            .is_some()
    );
    let without = read(&msm(1084, day, 0, 12));
    assert_eq!(signal(&without.epochs[0].1, "R03", "1C").phase_cycles, None);
    assert!(
        signal(&without.epochs[0].1, "R03", "1C")
            .pseudorange_m
            .is_some()
    );
    assert_eq!(without.report.count(&DropReason::UnknownChannel), 1);
    let mut told = hints();
    told.glonass_channels.insert(3, 2);
    let told = read_rtcm(&msm(1084, day, 0, 12), &told);
    assert!(
        signal(&told.epochs[0].1, "R03", "1C")
            .phase_cycles
            .is_some()
    );
}

#[test]
fn other_stations_are_left_out_and_counted() {
    let mut log = msm(1075, 1000, 0, 12);
    log.extend(message(&[
        (1004, 12),
        (78, 12),
        (1000, 30),
        (0, 1),
        (0, 5),
        (0, 4),
    ]));
    assert_eq!(read(&log).report.count(&DropReason::OtherStation), 1);
}

fn text(content: &str) -> Vec<(i64, usize)> {
    let mut out = vec![(content.len() as i64, 8)];
    out.extend(content.bytes().map(|b| (i64::from(b), 8)));
    out
}

#[test]
fn the_station_describes_itself() {
    let mut log = message(&[
        (1006, 12),
        (77, 12),
        (0, 10),
        (-28_456_764_110, 38),
        (0, 2),
        (46_616_194_022, 38),
        (0, 2),
        (32_832_153_241, 38),
        (15_000, 16),
    ]);
    let mut fields = vec![(1033, 12), (77, 12)];
    fields.extend(text("TRM57971.00     NONE"));
    fields.push((0, 8));
    for content in ["1441", "TRIMBLE NETR9", "5.45", "5033"] {
        fields.extend(text(content));
    }
    log.extend(message(&fields));
    let station = read(&log).station;
    assert_eq!(station.antenna, "TRM57971.00     NONE");
    assert_eq!(station.receiver, "TRIMBLE NETR9");
    let position = station.position_ecef_m.unwrap();
    for (found, sent) in position
        .iter()
        .zip([-2_845_676.411, 4_661_619.402_2, 3_283_215.324_1])
    {
        assert!((found - sent).abs() < 1e-6);
    }
    assert_eq!(
        station.antenna_offset.up_m, 0.0,
        "the coordinates are the antenna's"
    );
}

/// Message 1020 of 19 May 2023 (day 1235 of the seventh four years since 1996), 09:30 in Moscow.
fn glonass_1020(x: i64) -> Vec<u8> {
    let sign_magnitude =
        |value: i64, width: usize| (i64::from(value < 0) << (width - 1) | value.abs(), width);
    message(&[
        (1020, 12),
        (4, 6),
        (7 - 2, 5),
        (0, 4),
        (9, 5),
        (30, 6),
        (1, 1),
        (0, 1),
        (0, 1),
        (39, 7),
        sign_magnitude(-1_048_576, 24),
        sign_magnitude(x, 27),
        sign_magnitude(-3, 5),
        sign_magnitude(2_097_152, 24),
        sign_magnitude(-30_720_000, 27),
        sign_magnitude(0, 5),
        sign_magnitude(0, 24),
        sign_magnitude(20_480_000, 27),
        sign_magnitude(2, 5),
        (0, 1),
        sign_magnitude(-8, 11),
        (0, 3),
        sign_magnitude(-30_000, 22),
        (0, 5),
        (1, 5),
        (0, 1 + 4),
        (1235, 11),
        (1, 2),
        (1, 1),
        (0, 11 + 32),
        (7, 5),
        (0, 22 + 1 + 7),
    ])
}

#[test]
fn a_glonass_ephemeris_and_the_date_it_states() {
    let mut log = glonass_1020(36_864_000);
    log.extend(glonass_1020(1));
    let log = read_rtcm(&log, &RtcmHints::default());
    assert_eq!(log.date, Some(DateSource::Ephemerides));
    assert_eq!(log.report.count(&DropReason::InvalidNavigationFrame), 1);
    assert_eq!(log.report.remarks, [""; 0]);
    // A date stated wrongly does not go before the log's own, and that is said.
    let wrong = RtcmHints {
        near: Some(GpsTime::from_week_tow(2000, 0.0)),
        ..RtcmHints::default()
    };
    let told = read_rtcm(&glonass_1020(36_864_000), &wrong);
    assert_eq!(told.navigation, log.navigation);
    assert!(told.report.remarks[0].contains("own date is used"));
    let Ephemeris::Glonass(e) = log.navigation.ephemerides[0] else {
        panic!()
    };
    let utc = |h, m, s| GpsTime::from_utc(&Calendar::new(2023, 5, 19, h, m, s).unwrap()).unwrap();
    assert_eq!(e.toe, utc(6, 45, 0.0));
    assert_eq!(e.transmission_time, utc(6, 30, 30.0));
    assert_eq!((e.channel, e.age_days, e.health), (-2, 1, 0));
    assert_eq!(e.position_ecef_m, [18e6, -15e6, 10e6]);
    assert_eq!(e.velocity_ecef_m_s, [-1000.0, 2000.0, 0.0]);
    assert_eq!(e.acceleration_ecef_m_s2[0], -3000.0 * 2f64.powi(-30));
    assert_eq!(e.clock_offset_s, 30_000.0 * 2f64.powi(-30));
    assert_eq!(e.clock_rate, -8.0 * 2f64.powi(-40));
}

/// The orbit that messages 1019, 1042, 1044, 1045 and 1046 share, for harmonic terms of `width`
/// bits and reference times of `toe`.
fn elements(width: usize, toe: (i64, usize)) -> Vec<(i64, usize)> {
    let mut out = vec![(100, width), (9000, 16), (-1_000_000, 32), (300, width)];
    out.extend([(10_000_000, 32), (-400, width), (2_702_000_000, 32), toe]);
    out.extend([(7, width), (5_000_000, 32), (-8, width), (700_000_000, 32)]);
    out.extend([(900, width), (-2_000_000, 32), (-21_000, 24)]);
    out
}

/// Reference time of the ephemerides (s of the week).
const TOC_S: i64 = 388_800;

fn gps_1019() -> Vec<(i64, usize)> {
    let mut gps = vec![
        (1019, 12),
        (5, 6),
        (2262 % 1024, 10),
        (0, 4),
        (1, 2),
        (-50, 14),
        (66, 8),
    ];
    gps.extend([(TOC_S / 16, 16), (0, 8), (-9, 16), (12_345, 22), (66, 10)]);
    gps.extend(elements(16, (TOC_S / 16, 16)));
    gps.extend([(-128, 8), (0, 6), (0, 2)]);
    gps
}

fn qzss_1044() -> Vec<(i64, usize)> {
    let mut qzss = vec![
        (1044, 12),
        (2, 4),
        (TOC_S / 16, 16),
        (0, 8),
        (-9, 16),
        (12_345, 22),
        (66, 8),
    ];
    qzss.extend(elements(16, (TOC_S / 16, 16)));
    qzss.extend([
        (-50, 14),
        (1, 2),
        (2262 % 1024, 10),
        (0, 4),
        (1, 6),
        (-5, 8),
        (66, 10),
        (0, 1),
    ]);
    qzss
}

fn galileo_1046() -> Vec<(i64, usize)> {
    let mut inav = vec![
        (1046, 12),
        (11, 6),
        (2262 - 1024, 12),
        (66, 10),
        (107, 8),
        (-50, 14),
    ];
    inav.extend([(TOC_S / 60, 14), (-1, 6), (-9, 21), (12_345, 31)]);
    inav.extend(elements(16, (TOC_S / 60, 14)));
    inav.extend([(-3, 10), (4, 10), (2, 2), (1, 1), (1, 2), (0, 1), (0, 2)]);
    inav
}

fn galileo_1045() -> Vec<(i64, usize)> {
    let mut fnav = galileo_1046();
    fnav[0].0 = 1045;
    fnav.truncate(fnav.len() - 6);
    fnav.extend([(1, 2), (0, 1), (0, 7)]);
    fnav
}

fn beidou_1042() -> Vec<(i64, usize)> {
    let mut beidou = vec![
        (1042, 12),
        (23, 6),
        (2262 - 1356, 13),
        (1, 4),
        (-50, 14),
        (6, 5),
    ];
    beidou.extend([(TOC_S / 8, 17), (0, 11), (-9, 22), (12_345, 24), (7, 5)]);
    beidou.extend(elements(18, (TOC_S / 8, 17)));
    beidou.extend([(-30, 10), (40, 10), (0, 1)]);
    beidou
}

#[test]
fn keplerian_ephemerides_of_every_message() {
    let mut log = Vec::new();
    let all = [
        gps_1019(),
        qzss_1044(),
        galileo_1046(),
        galileo_1045(),
        beidou_1042(),
    ];
    for fields in all {
        log.extend(message(&fields));
    }
    let log = read_rtcm(&log, &RtcmHints::default());
    assert_eq!(log.report.dropped, []);
    assert_eq!(log.date, Some(DateSource::Ephemerides));
    let of = |name: &str, source: u32| {
        let found = log.navigation.ephemerides.iter().find_map(|e| match e {
            Ephemeris::Kepler(e) if e.satellite.to_string() == name => {
                (e.data_source == source).then_some(*e)
            }
            _ => None,
        });
        found.unwrap()
    };
    let found = [
        of("G05", 1),
        of("J02", 1),
        of("E11", 517),
        of("E11", 258),
        of("C23", 0),
    ];
    for e in &found {
        let own_s = if e.satellite.to_string() == "C23" {
            14.0
        } else {
            0.0
        };
        assert_eq!(
            e.toe,
            GpsTime::from_week_tow(2262, TOC_S as f64 + own_s),
            "{}",
            e.satellite
        );
        assert_eq!(e.toc, e.toe);
        assert_eq!(e.toe_seconds_of_week, TOC_S as f64);
        assert_eq!(e.sqrt_semi_major_axis, 2_702_000_000.0 * 2f64.powi(-19));
        assert_eq!(e.eccentricity, 1e7 * 2f64.powi(-33));
    }
    let [gps, qzss, inav, fnav, beidou] = found;
    assert_eq!((gps.iode, gps.iodc, gps.health), (66, 66, 0));
    assert_eq!(
        (gps.group_delay_s[0], qzss.group_delay_s[0]),
        (0.0, -5.0 * 2f64.powi(-31))
    );
    assert_eq!(
        gps.clock,
        [12_345.0 * 2f64.powi(-31), -9.0 * 2f64.powi(-43), 0.0]
    );
    assert_eq!(gps.radius_correction_m, [900.0 / 32.0, 100.0 / 32.0]);
    assert_eq!(
        gps.latitude_correction_rad,
        [300.0, -400.0].map(|x| x * 2f64.powi(-29))
    );
    assert_eq!(
        gps.inclination_correction_rad,
        [7.0, -8.0].map(|x| x * 2f64.powi(-29))
    );
    assert_eq!(qzss.health, 1);
    assert_eq!(inav.health, 2 << 7 | 1 << 6 | 1 << 1);
    assert_eq!(inav.group_delay_s, [-3.0, 4.0].map(|x| x * 2f64.powi(-32)));
    assert!((inav.accuracy_m - 3.12).abs() < 1e-12);
    assert_eq!((fnav.health, fnav.group_delay_s[1]), (1 << 4, 0.0));
    assert_eq!(beidou.group_delay_s, [-30e-10, 40e-10]);
    assert_eq!((beidou.iode, beidou.iodc), (6, 7));
    assert_eq!(beidou.radius_correction_m, [900.0 / 64.0, 100.0 / 64.0]);
    assert_eq!(beidou.clock[0], 12_345.0 * 2f64.powi(-33));
}

/// Ten bits of the week leave eras of 1024 weeks: said, and decided by a time that is stated.
#[test]
fn ten_bits_of_the_week() {
    let mut gps = vec![
        (1019, 12),
        (5, 6),
        (214, 10),
        (0, 4),
        (1, 2),
        (-50, 14),
        (66, 8),
    ];
    gps.extend([(24_300, 16), (0, 8), (-9, 16), (12_345, 22), (66, 10)]);
    gps.extend(elements(16, (24_300, 16)));
    gps.extend([(0, 8), (0, 6), (0, 2)]);
    let mut log = message(&gps);
    log.extend(msm(1075, 388_000_000, 0, 12));
    let found = read_rtcm(&log, &RtcmHints::default());
    assert_eq!(found.date, Some(DateSource::TenBits));
    assert_eq!(
        found.epochs[0].1.time,
        GpsTime::from_week_tow(2262, 388_000.0)
    );
    assert!(
        found.report.remarks[0].contains("week 2262"),
        "{:?}",
        found.report.remarks
    );
    let stated = RtcmHints {
        near: Some(GpsTime::from_week_tow(1238, 300_000.0)),
        ..RtcmHints::default()
    };
    let found = read_rtcm(&log, &stated);
    assert_eq!(found.date, Some(DateSource::TenBitsAndStated));
    assert_eq!(found.epochs[0].1.time.week(), 1238);
    assert_eq!(found.report.remarks, [""; 0]);
    // A file written in 2018 holds no log of 2023: week 2262 less 1024.
    let file = RtcmHints {
        not_after: Some(GpsTime::from_week_tow(2022, 0.0)),
        ..RtcmHints::default()
    };
    let found = read_rtcm(&log, &file);
    assert_eq!(found.date, Some(DateSource::TenBitsAndFile));
    assert_eq!(found.epochs[0].1.time.week(), 1238);
    assert!(found.report.remarks[0].contains("before the file was written"));
}

/// Receivers send UBX and RTCM 3 on one port: the observations count, and both are told.
#[test]
fn rtcm_with_ubx_frames_between() {
    let frame = acerra_gnss::ubx::frame::encode(0x01, 0x07, &[0; 92]).unwrap();
    let mut log = message(&gps_1019());
    for k in 0..5 {
        log.extend(&frame);
        log.extend(msm(1075, 388_000_000 + 1000 * k, 0, 12));
    }
    assert_eq!(sniff(&log), FileKind::Ubx);
    let hints = RtcmHints {
        near: Some(GpsTime::from_week_tow(2262, 388_000.0)),
        ..hints()
    };
    let file = acerra_gnss::read_gnss_near(&log[..], Limits::default(), &hints).unwrap();
    assert_eq!(file.kind, FileKind::Rtcm3);
    assert_eq!(file.observations.unwrap().epochs.len(), 5);
    assert_eq!(
        file.report.format,
        "RTCM 3 (6 messages) with UBX (5 frames) between"
    );
    assert_eq!(file.navigation.unwrap().ephemerides.len(), 1);
    // Without any measurements the configuration that lacks is named.
    let error = read_gnss(&frame[..], Limits::default()).unwrap_err();
    assert!(matches!(error, ReadError::NoMeasurements));
    assert!(error.to_string().contains("UBX-RXM-RAWX"), "{error}");
}

#[test]
fn a_log_without_a_date_is_refused() {
    let log = msm(1075, 1000, 0, 12);
    assert_eq!(sniff(&log), FileKind::Rtcm3);
    let answer = read_gnss(&log[..], Limits::default());
    assert!(matches!(answer, Err(ReadError::NoDate)));
    assert_eq!(read_rtcm(&log, &RtcmHints::default()).epochs, []);
}

#[test]
fn damaged_and_impossible_messages_cost_themselves() {
    let whole = msm(1077, 1000, 0, 12);
    // Cut anywhere, in whole frames: never a panic, and no epoch of a message cut short.
    for length in 0..whole.len() - 6 {
        let cut = encode(&whole[3..3 + length]).unwrap();
        let log = read(&cut);
        assert_eq!(log.epochs.len(), 0, "{length}");
    }
    // More cells than a message may have.
    let mut fields = vec![(1077, 12), (0, 12), (1000, 30), (0, 1), (0, 18)];
    fields.extend([(-1, 64), (-1, 32), (-1, 64), (0, 64)]);
    let log = read(&message(&fields));
    assert_eq!(
        log.report
            .count(&DropReason::MalformedRtcmMessage { number: 1077 }),
        1
    );
    // A time that no week has.
    let log = read(&msm(1077, 604_800_000, 0, 12));
    assert_eq!(log.report.count(&DropReason::UnreadableEpoch), 1);
    // A flipped bit, noise, and a log that ends within a message.
    let mut log = whole.clone();
    log[30] ^= 1;
    log.extend(b"noise");
    log.extend(&whole);
    log.extend(&whole[..20]);
    let log = read(&log);
    assert_eq!(log.epochs.len(), 1);
    assert_eq!(log.report.count(&DropReason::Checksum), 1);
    assert_eq!(log.report.count(&DropReason::CutOff), 1);
    let unknown = SignalCode::new(1, 'C');
    assert!(
        log.epochs[0]
            .1
            .satellites
            .iter()
            .all(|s| s.signals[0].code == unknown)
    );
}

/// Writes the seeds of the fuzz target `rtcm` where `ACERRA_FUZZ_SEEDS` names a folder.
#[test]
fn fuzz_seeds() {
    let Some(folder) = std::env::var_os("ACERRA_FUZZ_SEEDS") else {
        return;
    };
    let mut log = glonass_1020(36_864_000);
    log.extend(gps_1004(388_000_000, -2000, 40));
    for kind in 4..=7 {
        log.extend(msm(1070 + kind, 388_000_000 + 1000 * kind, 0, 12));
    }
    log.extend(msm(1087, 4 << 27 | 10_800_500, 0, 12));
    std::fs::write(
        std::path::Path::new(&folder).join("observations.rtcm3"),
        log,
    )
    .unwrap();
}
