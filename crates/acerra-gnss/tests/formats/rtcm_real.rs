//! RTCM 3 logs of real receivers against the RINEX that another program (RTKLIB-EX convbin) made
//! of them.

use crate::common;

use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufReader, Read};

use acerra_geo::time::{Calendar, GpsTime};
use acerra_gnss::input::{DropReason, Limits, Lines, ReadError};
use acerra_gnss::rinex::{ObservationRecord, RinexObservations};
use acerra_gnss::rtcm::{DateSource, RtcmHints, RtcmLog, read_rtcm};
use acerra_gnss::{
    Ephemeris, KeplerEphemeris, RecordedEpoch, SatelliteId, SatelliteObservation, SignalCode,
    SignalObservation, System, read_gnss, read_gnss_near, read_navigation,
};
use flate2::read::GzDecoder;

const FOLDER: &str = "gnss-walk-lg69t";

fn unzipped(name: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let file = common::open(&format!("{FOLDER}/{name}"))?;
    GzDecoder::new(file).read_to_end(&mut bytes).unwrap();
    Some(bytes)
}

fn rinex(name: &str) -> Option<Vec<RecordedEpoch>> {
    let bytes = unzipped(name)?;
    let lines = Lines::new(BufReader::new(&bytes[..]), Limits::default());
    let mut reader = RinexObservations::new(lines).unwrap();
    let mut out = Vec::new();
    while let Some(record) = reader.next_record().unwrap() {
        if let ObservationRecord::Epoch(epoch) = record {
            out.push(epoch);
        }
    }
    Some(out)
}

fn date() -> GpsTime {
    GpsTime::from_calendar(&Calendar::new(2023, 5, 19, 12, 0, 0.0).unwrap())
}

fn by_signal(epoch: &RecordedEpoch) -> BTreeMap<(SatelliteId, SignalCode), SignalObservation> {
    epoch
        .satellites
        .iter()
        .flat_map(|s| {
            s.signals
                .iter()
                .map(|signal| ((s.satellite, signal.code), *signal))
        })
        .filter(|(_, s)| s.pseudorange_m.is_some() || s.phase_cycles.is_some())
        .collect()
}

/// What a comparison of two logs found.
#[derive(Debug, Default, PartialEq)]
struct Compared {
    signals: usize,
    phases: usize,
    /// Phases that both call slipped, that only the log does, and that only RINEX does though the
    /// phase had been there before.
    slips: [usize; 3],
    half_cycles: usize,
}

/// Every signal of every epoch is in both, equal to the decimals that RINEX prints.
fn compare(log: &RtcmLog, rinex: &[RecordedEpoch]) -> Compared {
    assert_eq!(log.epochs.len(), rinex.len());
    let mut out = Compared::default();
    let mut seen = BTreeSet::new();
    for ((_, ours), theirs) in log.epochs.iter().zip(rinex) {
        assert!(
            (ours.time - theirs.time).abs() < 1e-6,
            "{} {}",
            ours.time,
            theirs.time
        );
        let time = ours.time;
        let (ours, theirs) = (by_signal(ours), by_signal(theirs));
        for key in ours.keys() {
            // The other program knows no BeiDou satellites past 46.
            let known = key.0.system() != System::Beidou || key.0.number() <= 46;
            assert_eq!(theirs.contains_key(key), known, "{key:?}");
        }
        for (key, b) in &theirs {
            let Some(a) = ours.get(key) else {
                panic!("{key:?} is missing at {time}")
            };
            let near = |x: Option<f64>, y: Option<f64>, by: f64, what: &str| match (x, y) {
                (Some(x), Some(y)) => assert!((x - y).abs() <= by, "{key:?} {what}: {x} {y}"),
                (x, y) => assert_eq!(x, y, "{key:?} {what}"),
            };
            out.signals += 1;
            near(a.pseudorange_m, b.pseudorange_m, 6e-4, "code");
            near(a.cn0_db_hz, b.cn0_db_hz, 6e-4, "C/N0");
            // The other program keeps Doppler shifts in single precision.
            near(a.doppler_hz, b.doppler_hz, 8e-4, "Doppler");
            near(a.phase_cycles, b.phase_cycles, 6e-4, "phase");
            if a.phase_cycles.is_none() {
                continue;
            }
            out.phases += 1;
            let first_sight = seen.insert(*key);
            match (a.loss_of_lock.slipped(), b.loss_of_lock.slipped()) {
                (true, true) => out.slips[0] += 1,
                (true, false) => out.slips[1] += 1,
                (false, true) if !first_sight => out.slips[2] += 1,
                _ => {}
            }
            let half_cycle = a.loss_of_lock.half_cycle_unknown();
            assert_eq!(half_cycle, b.loss_of_lock.half_cycle_unknown(), "{key:?}");
            out.half_cycles += usize::from(half_cycle);
        }
    }
    out
}

#[test]
fn a_rover_log_of_msm7_is_its_rinex() {
    let (Some(bytes), Some(rinex)) = (unzipped("rover.rtcm3.gz"), rinex("rover.obs.gz")) else {
        return;
    };
    let log = read_rtcm(&bytes, &RtcmHints::default());
    assert_eq!(log.date, Some(DateSource::SystemParameters));
    let found = compare(&log, &rinex);
    println!("{found:?}\n{}", log.report);
    assert_eq!((found.signals, found.phases), (68_783, 59_007));
    // Every slip of the other program; besides, phases that were locked within the second since
    // the last epoch, which it does not look at.
    let [_, ours_alone, theirs_alone] = found.slips;
    assert_eq!(theirs_alone, 0);
    assert!(ours_alone < found.phases / 10, "{found:?}");
    assert!(found.half_cycles > 0);
    let unused = DropReason::UnusedRtcmMessage { number: 999 };
    assert_eq!(log.report.count(&unused), 12_080);
}

#[test]
fn a_base_log_of_msm4_is_its_rinex() {
    let (Some(bytes), Some(rinex)) = (unzipped("base.rtcm3.gz"), rinex("base.obs.gz")) else {
        return;
    };
    let dateless = read_gnss(&bytes[..], Limits::default());
    assert!(matches!(dateless, Err(ReadError::NoDate)), "{dateless:?}");
    let hints = RtcmHints {
        near: Some(date()),
        ..RtcmHints::default()
    };
    let log = read_rtcm(&bytes, &hints);
    assert_eq!(log.date, Some(DateSource::Stated));
    let found = compare(&log, &rinex);
    println!("{found:?}\n{}", log.report);
    assert_eq!((found.signals, found.phases), (122_848, 113_036));
    assert!(found.slips.iter().all(|&n| n <= 3), "{found:?}");
    // No message tells the channels of this log's GLONASS satellites.
    assert_eq!(log.report.count(&DropReason::UnknownChannel), 9_812);
    assert_eq!(log.station.receiver, "QXWZ VRS");
    assert_eq!(log.station.antenna, "ADVNULLANTENNA");
    let position = log.station.position_ecef_m.unwrap();
    for (found, header) in position
        .iter()
        .zip([-2_845_676.411, 4_661_619.402_2, 3_283_215.324_1])
    {
        assert!((found - header).abs() < 1e-4, "{position:?}");
    }
    // The same log by the common door, with one signal per frequency slot as RINEX leads to.
    let gzipped = common::open(&format!("{FOLDER}/base.rtcm3.gz")).unwrap();
    let file = read_gnss_near(gzipped, Limits::default(), &hints).unwrap();
    assert_eq!(file.report.format, "RTCM 3, gzip");
    let ours = file.observations.unwrap();
    let theirs = common::open(&format!("{FOLDER}/base.obs.gz")).unwrap();
    let theirs = read_gnss(theirs, Limits::default())
        .unwrap()
        .observations
        .unwrap();
    for (a, b) in ours.epochs.iter().zip(&theirs.epochs) {
        for b in &b.satellites {
            let a = a
                .satellites
                .iter()
                .find(|a| a.satellite == b.satellite)
                .unwrap();
            let codes = |s: &SatelliteObservation| s.signals.map(|s| s.map(|s| s.code));
            assert_eq!(codes(a), codes(b), "{}", b.satellite);
        }
    }
}

#[test]
fn ephemerides_of_a_log_are_its_rinex() {
    let Some(bytes) = unzipped("rover.rtcm3.gz") else {
        return;
    };
    let log = read_rtcm(&bytes, &RtcmHints::default());
    let file = common::open(&format!("{FOLDER}/rover.nav.gz")).unwrap();
    let (rinex, _) = read_navigation(file, Limits::default()).unwrap();
    let mut compared = 0;
    for theirs in &rinex.ephemerides {
        let Ephemeris::Kepler(b) = theirs else {
            panic!("{theirs:?}")
        };
        let same =
            |a: &KeplerEphemeris| (a.satellite, a.toe, a.iode) == (b.satellite, b.toe, b.iode);
        let ours = log.navigation.ephemerides.iter().find_map(|e| match e {
            Ephemeris::Kepler(a) if same(a) => Some(a),
            _ => None,
        });
        let Some(a) = ours else {
            panic!("{} {} is missing", b.satellite, b.toe)
        };
        assert_eq!(
            (
                a.toc,
                a.iodc,
                a.health,
                a.data_source,
                a.toe_seconds_of_week
            ),
            (
                b.toc,
                b.iodc,
                b.health,
                b.data_source,
                b.toe_seconds_of_week
            ),
            "{}",
            b.satellite
        );
        for (x, y) in a.group_delay_s.iter().zip(b.group_delay_s) {
            assert!((x - y).abs() < 1e-19, "{} {x:e} {y:e}", b.satellite);
        }
        let later = b.toe + 1800.0;
        let (x, y) = (
            Ephemeris::Kepler(*a).orbit_at(later),
            theirs.orbit_at(later),
        );
        for (x, y) in x.position_ecef_m.iter().zip(y.position_ecef_m) {
            assert!((x - y).abs() < 1e-3, "{} {x} {y}", b.satellite);
        }
        assert!((x.clock_s - y.clock_s).abs() < 1e-14, "{}", b.satellite);
        compared += 1;
    }
    println!("{compared} ephemerides");
    assert!(compared > 30);
    let systems: BTreeSet<System> = log
        .navigation
        .ephemerides
        .iter()
        .map(|e| e.satellite().system())
        .collect();
    assert_eq!(
        systems.len(),
        4,
        "GPS, Galileo, QZSS and BeiDou: {systems:?}"
    );
}
