//! Positions from the simulated logs against the flight, by our own PPK and by RTKLIB.

use super::*;
use acerra_gnss::input::Limits;
use acerra_gnss::{BasePosition, PpkOptions, Quality, read_navigation, read_observations};
use std::process::Command;

/// Horizontal and vertical misses of fixed positions against the flight (m), and their share.
struct Misses {
    horizontal: Vec<f64>,
    vertical: Vec<f64>,
    epochs: usize,
}

impl Misses {
    fn of(list: impl Iterator<Item = (GpsTime, [f64; 3], bool)>) -> Self {
        let mut out = Self {
            horizontal: Vec::new(),
            vertical: Vec::new(),
            epochs: 0,
        };
        for (time, ecef, fixed) in list {
            out.epochs += 1;
            if fixed {
                let truth = flight(time.seconds_since(start()));
                let enu = frame().enu_from_ecef(ecef);
                out.horizontal
                    .push((enu[0] - truth[0]).hypot(enu[1] - truth[1]));
                out.vertical.push((enu[2] - truth[2]).abs());
            }
        }
        out.horizontal.sort_by(f64::total_cmp);
        out.vertical.sort_by(f64::total_cmp);
        out
    }

    fn share(&self) -> f64 {
        self.horizontal.len() as f64 / self.epochs.max(1) as f64
    }

    fn quantile(list: &[f64], share: f64) -> f64 {
        list[((list.len() - 1) as f64 * share).round() as usize]
    }
}

#[test]
fn our_own_ppk_fixes_the_flight_within_two_centimetres() {
    let navigation = constellation(start(), 240.0, 11);
    let logs = simulate(&GnssModel::default(), &setting(&navigation, 240.0, 11)).unwrap();
    let read = |text: String| {
        read_observations(text.as_bytes(), Limits::default())
            .unwrap()
            .0
    };
    let (rover, base) = (
        read(logs.rover.to_rinex("R")),
        read(logs.base.to_rinex("B")),
    );
    let misses = own_ppk(&rover, &base, &navigation, logs.base.position_ecef_m);
    println!(
        "fixed {:.1} %, 95 % within {:.4} m horizontally, {:.4} m vertically",
        100.0 * misses.share(),
        Misses::quantile(&misses.horizontal, 0.95),
        Misses::quantile(&misses.vertical, 0.95)
    );
    assert!(
        misses.epochs > 1000 && misses.share() > 0.9,
        "{}",
        misses.share()
    );
    assert!(Misses::quantile(&misses.horizontal, 0.95) < 0.02);
    assert!(Misses::quantile(&misses.vertical, 0.95) < 0.04);
}

#[test]
fn rtklib_accepts_the_rinex_and_fixes_the_flight_within_two_centimetres() {
    let Ok(found) = Command::new("rnx2rtkp").arg("-?").output() else {
        println!("skipped: rnx2rtkp (Debian package rtklib) is not installed");
        return;
    };
    drop(found);
    let navigation = constellation(start(), 240.0, 11);
    let logs = simulate(&GnssModel::default(), &setting(&navigation, 240.0, 11)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: String| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let rover = write("rover.18o", logs.rover.to_rinex("ROVER"));
    let base = write("base.18o", logs.base.to_rinex("BASE"));
    let nav = write("brdc.18n", navigation_to_rinex(&navigation));
    let out = folder.path().join("out.pos");
    let [x, y, z] = logs.base.position_ecef_m.map(|v| format!("{v:.5}"));
    let status = Command::new("rnx2rtkp")
        .args([
            "-p", "2", "-m", "15", "-f", "1", "-h", "-v", "3", "-e", "-d", "6", "-sys", "G",
        ])
        .args(["-r", &x, &y, &z, "-o"])
        .arg(&out)
        .args([&rover, &base, &nav])
        .output()
        .unwrap()
        .status;
    assert!(status.success());
    let text = std::fs::read_to_string(&out).unwrap();
    let misses = Misses::of(
        text.lines()
            .filter(|l| !l.starts_with('%'))
            .filter_map(|l| {
                let v: Vec<f64> = l
                    .split_whitespace()
                    .filter_map(|f| f.parse().ok())
                    .collect();
                let time = GpsTime::from_week_tow(*v.first()? as i64, *v.get(1)?);
                Some((time, [v[2], v[3], v[4]], v[5] == 1.0))
            }),
    );
    println!(
        "RTKLIB: {} epochs, fixed {:.1} %, 95 % within {:.4} m horizontally, {:.4} m vertically",
        misses.epochs,
        100.0 * misses.share(),
        Misses::quantile(&misses.horizontal, 0.95),
        Misses::quantile(&misses.vertical, 0.95)
    );
    assert!(
        misses.epochs > 1000 && misses.share() > 0.9,
        "{}",
        misses.share()
    );
    assert!(Misses::quantile(&misses.horizontal, 0.95) < 0.02);
    assert!(Misses::quantile(&misses.vertical, 0.95) < 0.04);
}

#[test]
fn the_ubx_logs_alone_are_enough_for_our_own_ppk() {
    let navigation = constellation(start(), 240.0, 11);
    let logs = simulate(&GnssModel::default(), &setting(&navigation, 240.0, 11)).unwrap();
    let read = |bytes: Vec<u8>| {
        let file = acerra_gnss::read_gnss(bytes.as_slice(), Limits::default()).unwrap();
        assert!(file.report.dropped.is_empty(), "{:?}", file.report);
        (file.observations.unwrap(), file.navigation.unwrap())
    };
    let (rover, mut heard) = read(logs.rover.to_ubx(&navigation));
    let (base, from_base) = read(logs.base.to_ubx(&navigation));
    assert_eq!(rover.epochs.len(), logs.rover.epochs.len());
    for (read, written) in rover.epochs.iter().zip(&logs.rover.epochs) {
        for (read, written) in read.satellites.iter().zip(&written.observed) {
            let signal = read.signals[0].unwrap();
            assert_eq!(signal.pseudorange_m, Some(written.pseudorange_m));
            assert_eq!(signal.phase_cycles, Some(written.phase_cycles));
            assert_eq!(signal.loss_of_lock, written.loss_of_lock);
        }
    }
    heard.merge(from_base);
    for ephemeris in &heard.ephemerides {
        let sent = Ephemeris::Kepler(kepler_of(&navigation, ephemeris.satellite(), start()));
        let t = start() + 100.0;
        let (a, b) = (ephemeris.orbit_at(t), sent.orbit_at(t));
        for k in 0..3 {
            assert!((a.position_ecef_m[k] - b.position_ecef_m[k]).abs() < 1e-4);
        }
    }
    let misses = own_ppk(&rover, &base, &heard, logs.base.position_ecef_m);
    assert!(misses.share() > 0.9, "{}", misses.share());
    assert!(Misses::quantile(&misses.horizontal, 0.95) < 0.02);
}

fn own_ppk(
    rover: &acerra_gnss::ObservationData,
    base: &acerra_gnss::ObservationData,
    navigation: &Navigation,
    base_ecef_m: [f64; 3],
) -> Misses {
    let options = PpkOptions::default().with_base_position(BasePosition::Ecef(base_ecef_m));
    let solution = acerra_gnss::process(rover, base, navigation, &options).unwrap();
    Misses::of(
        solution
            .epochs
            .iter()
            .map(|s| (s.time, s.position_ecef_m, s.quality == Quality::Fixed)),
    )
}

#[test]
fn a_real_constellation_serves_as_well() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/data/gnss-geonet/nav.05n"
    );
    let Ok(file) = std::fs::File::open(path) else {
        println!("skipped: {path} is not here");
        return;
    };
    let (navigation, _) = read_navigation(file, Limits::default()).unwrap();
    let start = GpsTime::from_calendar(&Calendar::new(2005, 4, 2, 0, 10, 0.0).unwrap());
    let frame = EnuFrame::from_ecef([-3_978_241.958, 3_382_840.234, 3_649_900.853]);
    let logs = simulate(
        &GnssModel::default(),
        &Setting {
            frame,
            start,
            duration_s: 300.0,
            rover_m: &flight,
            base_m: [0.0; 3],
            navigation: &navigation,
            seed: 4,
        },
    )
    .unwrap();
    let read = |text: String| {
        read_observations(text.as_bytes(), Limits::default())
            .unwrap()
            .0
    };
    let (rover, base) = (
        read(logs.rover.to_rinex("R")),
        read(logs.base.to_rinex("B")),
    );
    let options = PpkOptions::default().with_base_position(BasePosition::Header);
    let solution = acerra_gnss::process(&rover, &base, &navigation, &options).unwrap();
    let mut misses: Vec<f64> = solution
        .epochs
        .iter()
        .filter(|s| s.quality == Quality::Fixed)
        .map(|s| {
            let truth = flight(s.time.seconds_since(start));
            let enu = frame.enu_from_ecef(s.position_ecef_m);
            (enu[0] - truth[0]).hypot(enu[1] - truth[1])
        })
        .collect();
    misses.sort_by(f64::total_cmp);
    println!("{} of {} fixed", misses.len(), solution.epochs.len());
    assert!(2 * misses.len() > solution.epochs.len());
    assert!(
        Misses::quantile(&misses, 0.95) < 0.03,
        "{}",
        Misses::quantile(&misses, 0.95)
    );
}
