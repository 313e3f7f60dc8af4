//! Precise orbits and clocks from files made here: the format's columns, gaps, damage.

use acerra_geo::time::GpsTime;
use acerra_gnss::input::{DropReason, FileKind, Limits, ReadError};
use acerra_gnss::{
    Ephemeris, GnssFile, KeplerEphemeris, Navigation, PreciseGap, SPEED_OF_LIGHT_M_S, SatelliteId,
    System, read_gnss,
};

const EPOCHS: usize = 25;

fn start() -> GpsTime {
    GpsTime::from_week_tow(2262, 432_000.0)
}

fn satellite() -> SatelliteId {
    SatelliteId::new(System::Gps, 5).unwrap()
}

/// An orbit without harmonic terms, so that it is smooth over hours.
fn ephemeris() -> Ephemeris {
    Ephemeris::Kepler(KeplerEphemeris {
        satellite: satellite(),
        iode: 1,
        iodc: 1,
        health: 0,
        data_source: 0,
        accuracy_m: 2.4,
        toc: start() + 10_800.0,
        toe: start() + 10_800.0,
        transmission_time: start(),
        toe_seconds_of_week: 442_800.0,
        sqrt_semi_major_axis: 5_153.7,
        eccentricity: 0.012,
        inclination_rad: 0.97,
        ascending_node_rad: 1.1,
        perigee_rad: 0.4,
        mean_anomaly_rad: -0.8,
        mean_motion_correction_rad_s: 0.0,
        ascending_node_rate_rad_s: -8e-9,
        inclination_rate_rad_s: 0.0,
        latitude_correction_rad: [0.0; 2],
        radius_correction_m: [0.0; 2],
        inclination_correction_rad: [0.0; 2],
        clock: [1.25e-4, 3e-12, 0.0],
        group_delay_s: [0.0; 2],
    })
}

/// SP3 of the orbit above, 15 minutes apart; `line` may change or leave out a position line.
fn sp3(version: char, scale: &str, line: impl Fn(usize, String) -> Option<String>) -> String {
    let mut out = format!(
        "#{version}P2023  5 19  0  0  0.00000000 {EPOCHS:7} ORBIT IGS20 HLM  IGS\n\
         ## 2262 432000.00000000   900.00000000 60083 0.0000000000000\n\
         +    1   G05  0  0\n\
         ++         2  0  0\n\
         %c M  cc {scale} ccc cccc cccc cccc cccc ccccc ccccc ccccc ccccc\n\
         %c cc cc ccc ccc cccc cccc cccc cccc ccccc ccccc ccccc ccccc\n\
         %f  1.2500000  1.025000000  0.00000000000  0.000000000000000\n\
         %i    0    0    0    0      0      0      0      0         0\n\
         /* made by a test of acerra-gnss\n"
    );
    for k in 0..EPOCHS {
        let t = start() + 900.0 * k as f64;
        let c = t.to_calendar();
        out.push_str(&format!(
            "*  {} {:2} {:2} {:2} {:2} {:11.8}\n",
            c.year,
            c.month,
            c.day,
            c.hour,
            c.minute,
            c.second_f64()
        ));
        let orbit = ephemeris().orbit_at(t);
        let [x, y, z] = orbit.position_ecef_m.map(|m| m / 1e3);
        let clock = ephemeris().clock_without_relativity_s(t) * 1e6;
        let text = format!("PG05{x:14.6}{y:14.6}{z:14.6}{clock:14.6}  6  5  8 102\n");
        out.push_str(&line(k, text).unwrap_or_default());
    }
    out + "EOF\n"
}

fn whole() -> String {
    sp3('d', "GPS", |_, line| Some(line))
}

fn read(text: &str) -> GnssFile {
    read_gnss(text.as_bytes(), Limits::default()).unwrap()
}

fn products(text: &str) -> Navigation {
    read(text).navigation.unwrap()
}

#[test]
fn a_product_gives_back_the_orbit_it_was_made_of() {
    for version in ['c', 'd'] {
        let file = read(&sp3(version, "GPS", |_, line| Some(line)));
        assert_eq!(file.kind, FileKind::Sp3);
        assert_eq!(file.report.format, format!("SP3-{version}"));
        assert_eq!(file.report.dropped, []);
        let precise = file.navigation.unwrap().precise;
        for after_s in [4_600.0, 9_000.0, 10_801.5, 16_123.0] {
            let t = start() + after_s;
            let (found, truth) = (
                precise.state_at(satellite(), t).unwrap(),
                ephemeris().orbit_at(t),
            );
            for (a, b) in found.position_ecef_m.iter().zip(truth.position_ecef_m) {
                assert!((a - b).abs() < 5e-3, "{after_s}: {a} {b}");
            }
            // Clocks are linear here; relativity follows from position and velocity.
            let error_m = (found.clock_s - truth.clock_s) * SPEED_OF_LIGHT_M_S;
            assert!(error_m.abs() < 1e-3, "{after_s}: {error_m}");
            let (a, b) = (
                precise.rates_at(satellite(), t).unwrap(),
                ephemeris().rates_at(t),
            );
            for (a, b) in a.velocity_ecef_m_s.iter().zip(b.velocity_ecef_m_s) {
                assert!((a - b).abs() < 1e-3, "{after_s}: {a} {b}");
            }
        }
    }
}

#[test]
fn time_systems_are_brought_to_gps_time() {
    let first = |scale: &str| {
        products(&sp3('d', scale, |_, l| Some(l)))
            .precise
            .span()
            .unwrap()
            .0
    };
    assert_eq!(first("GPS"), start());
    assert_eq!(first("GAL"), start());
    assert_eq!(first("UTC") - start(), 18.0);
    assert_eq!(first("BDT") - start(), 14.0);
    assert_eq!(start() - first("TAI"), 19.0);
    let unknown = sp3('d', "XYZ", |_, l| Some(l));
    let error = read_gnss(unknown.as_bytes(), Limits::default()).unwrap_err();
    assert!(
        matches!(error, ReadError::Format { line: 5, .. }),
        "{error}"
    );
}

#[test]
fn gaps_are_refused_and_missing_values_are_gaps() {
    let gap = sp3('c', "GPS", |k, line| (k != 12).then_some(line));
    let precise = products(&gap).precise;
    let at = |after_s: f64| precise.state_at(satellite(), start() + after_s);
    assert_eq!(at(10_800.0), Err(PreciseGap::Orbit));
    assert_eq!(
        at(6_500.0).map(|_| ()),
        Err(PreciseGap::Orbit),
        "it is among the nearest"
    );
    assert_eq!(at(-1.0), Err(PreciseGap::Orbit));
    let other = SatelliteId::new(System::Gps, 6).unwrap();
    assert_eq!(precise.state_at(other, start()), Err(PreciseGap::Satellite));
    // Positions of zero and clocks of 999999 are not there.
    let zero = |line: String| format!("PG05{:14.6}{:14.6}{:14.6}{}", 0.0, 0.0, 0.0, &line[46..]);
    let holes = sp3('c', "GPS", |k, line| {
        Some(match k {
            12 => zero(line),
            _ => line,
        })
    });
    let precise = products(&holes).precise;
    let t = start() + 10_800.0;
    assert_eq!(precise.state_at(satellite(), t), Err(PreciseGap::Orbit));
    let clockless = sp3('c', "GPS", |k, line| {
        Some(if k == 12 {
            format!("{} 999999.999999\n", &line[..46])
        } else {
            line
        })
    });
    let precise = products(&clockless).precise;
    assert_eq!(
        precise.state_at(satellite(), t + 1.0),
        Err(PreciseGap::Clock)
    );
    assert!(precise.state_at(satellite(), t + 1000.0).is_ok());
}

fn clock_file(version: &str, shift: usize) -> String {
    let label =
        |content: &str, name: &str| format!("{content:<width$}{name}\n", width = 60 + shift);
    let mut out = label(
        &format!("{version:>9}           {}C", " ".repeat(shift.min(1))),
        "RINEX VERSION / TYPE",
    );
    out += &label("   GPS", "TIME SYSTEM ID");
    out += &label("", "END OF HEADER");
    for k in 0..=720 {
        let t = start() + 30.0 * f64::from(k);
        let c = t.to_calendar();
        let time = format!(
            "{} {:02} {:02} {:02} {:02} {:9.6}",
            c.year,
            c.month,
            c.day,
            c.hour,
            c.minute,
            c.second_f64()
        );
        out += &format!("AR WTZR {time}  1    1.000000000000E-09\n");
        let clock = ephemeris().clock_without_relativity_s(t) + 1e-7;
        out += &format!("AS G05  {time}  2   {clock:19.12E}  1.000000000000E-11\n");
    }
    out
}

#[test]
fn clocks_of_clock_files_go_before_those_of_orbit_files() {
    for (version, shift) in [("2.00", 0), ("3.00", 0), ("3.04", 5)] {
        let clocks = read(&clock_file(version, shift));
        assert_eq!(clocks.kind, FileKind::RinexClock, "{version}");
        assert_eq!(clocks.report.format, format!("RINEX {version} clock"));
        assert_eq!(clocks.report.dropped, []);
        let mut navigation = products(&whole());
        navigation.merge(clocks.navigation.unwrap());
        let t = start() + 10_811.0;
        let found = navigation.precise.state_at(satellite(), t).unwrap().clock_s;
        let truth = ephemeris().orbit_at(t).clock_s + 1e-7;
        assert!(
            (found - truth).abs() < 3e-12,
            "{version}: {found:e} {truth:e}"
        );
    }
}

#[test]
fn other_files_are_told_apart() {
    let error = |text: &str| read_gnss(text.as_bytes(), Limits::default()).unwrap_err();
    let old = whole().replacen("#dP", "#aP", 1);
    assert!(matches!(
        error(&old),
        ReadError::Unsupported { line: 1, .. }
    ));
    let utc = clock_file("3.00", 0).replace("   GPS", "   UTC");
    assert!(matches!(
        error(&utc),
        ReadError::Unsupported { line: 2, .. }
    ));
    let cut = &clock_file("3.00", 0)[..170];
    assert!(
        matches!(error(cut), ReadError::MissingHeader { .. }),
        "{}",
        error(cut)
    );
}

#[test]
fn damage_costs_its_line_and_is_counted() {
    let damaged = whole()
        .replacen("PG05", "PX05", 1)
        .replacen("PG05  ", "PG05 x", 1)
        .replacen("*  2023  5 19  0 30", "*  2023  5 39  0 30", 1);
    let report = read(&damaged).report;
    assert_eq!(
        report.count(&DropReason::UnknownSatellite("X05".to_owned())),
        1
    );
    assert_eq!(report.count(&DropReason::UnreadableNumber), 1, "{report}");
    assert_eq!(report.count(&DropReason::UnreadableEpoch), 1);
    // Cut anywhere: read or refused, and never a number cut short.
    let text = whole();
    let precise = products(&text).precise;
    for cut in (1..text.len()).step_by(7) {
        let Ok(file) = read_gnss(&text.as_bytes()[..cut], Limits::default()) else {
            continue;
        };
        let t = start() + 7_000.0;
        let part = file.navigation.unwrap().precise;
        if let Ok(found) = part.state_at(satellite(), t) {
            let whole = precise.state_at(satellite(), t).unwrap();
            for (a, b) in found.position_ecef_m.iter().zip(whole.position_ecef_m) {
                assert!((a - b).abs() < 0.1, "cut at {cut}");
            }
        }
    }
    let clocks = clock_file("3.00", 0);
    for cut in (1..clocks.len()).step_by(97) {
        if let Ok(file) = read_gnss(&clocks.as_bytes()[..cut], Limits::default()) {
            let part = file.navigation.unwrap().precise;
            if let Ok(clock) = part.clock_at(satellite(), start() + 15.0) {
                assert!((clock - 1.25e-4).abs() < 1e-6, "cut at {cut}");
            }
        }
    }
}

/// Writes seeds of the fuzz target `products` where `ACERRA_FUZZ_SEEDS` names a folder.
#[test]
fn fuzz_seeds() {
    let Some(folder) = std::env::var_os("ACERRA_FUZZ_SEEDS") else {
        return;
    };
    let write = |name: &str, text: &str| {
        std::fs::write(std::path::Path::new(&folder).join(name), text).unwrap();
    };
    write("orbits.sp3", &whole());
    write("clocks.clk", &clock_file("3.04", 5)[..2000]);
}
