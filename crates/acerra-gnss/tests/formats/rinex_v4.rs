//! RINEX 4 observation and navigation data, made here after the tables of RINEX 4.00 to 4.02.

use acerra_geo::time::GpsTime;
use acerra_gnss::input::{DropReason, Limits};
use acerra_gnss::{Ephemeris, EventKind, GnssFile, SatelliteObservation, read_gnss};

fn line(content: &str, label: &str) -> String {
    format!("{content:<60}{label}\n")
}

fn observations(version: &str) -> String {
    let mut out = line(
        &format!("     {version}           OBSERVATION DATA    M"),
        "RINEX VERSION / TYPE",
    );
    for (content, label) in [
        (
            "acerra              test                20261121 120000 UTC",
            "PGM / RUN BY / DATE",
        ),
        ("https://doi.org/10.0000/acerra", "DOI"),
        ("CC BY 4.0", "LICENSE OF USE"),
        ("https://example.org/station.log", "STATION INFORMATION"),
        ("TEST00XXX", "MARKER NAME"),
        ("1                   TRM57971.00     NONE", "ANT # / TYPE"),
        (
            "  3978241.9580  3382840.2340  3649900.8530",
            "APPROX POSITION XYZ",
        ),
        (
            "        1.5000        0.0000        0.0000",
            "ANTENNA: DELTA H/E/N",
        ),
        ("G    6 C1C L1C S1C C5Q L5Q S5Q", "SYS / # / OBS TYPES"),
        ("J    6 C1C L1C S1C C1E L1E S1E", "SYS / # / OBS TYPES"),
        ("C    4 C2I L2I C7D L7D", "SYS / # / OBS TYPES"),
        ("I    3 C1P L1P C5A", "SYS / # / OBS TYPES"),
        (
            "  2026    11    21    12    00    0.0000000     GPS",
            "TIME OF FIRST OBS",
        ),
        ("  1 R07  5", "GLONASS SLOT / FRQ #"),
        ("", "END OF HEADER"),
    ] {
        out += &line(content, label);
    }
    out += "> 2026 11 21 12 00  0.0000000  0  4       0.000123456789\n";
    out += "G07  22000000.125   115611234.56715        45.250    22000003.500    86332145.123 6        40.000\n";
    out += "J04                                                   38000000.250   199691234.500          44.000\n";
    out += "C23  24000000.000   124977123.250    24000004.000    96639876.500\n";
    out += "I06  37000000.000   194436123.250    37000001.000\n";
    // An event (camera), then a comment inside the body.
    out += "> 2026 11 21 12 00  0.5000000  5  0\n";
    out += "> 2026 11 21 12 00  1.0000000  4  1\n";
    out += &line("a comment in mid-file", "COMMENT");
    out += "> 2026 11 21 12 00  1.0000000  0  1\n";
    out += "G07  22000100.125   115611760.067          45.250\n";
    out
}

fn read(text: &str) -> GnssFile {
    read_gnss(text.as_bytes(), Limits::default()).unwrap()
}

#[test]
fn observations_of_every_minor_version() {
    for version in ["4.00", "4.01", "4.02"] {
        let file = read(&observations(version));
        assert_eq!(file.report.format, format!("RINEX {version} observation"));
        assert_eq!(file.report.dropped, [], "{}", file.report);
        let data = file.observations.unwrap();
        let start = GpsTime::from_week_tow(2445, 6.0 * 86_400.0 + 43_200.0);
        assert_eq!(data.epochs.len(), 2);
        assert_eq!(data.epochs[0].time, start);
        assert_eq!(data.epochs[1].time, start + 1.0);
        assert_eq!(data.station.antenna, "TRM57971.00     NONE");
        assert_eq!(data.station.antenna_offset.up_m, 1.5);
        assert_eq!(data.glonass_channels[&7], 5);
        let of = |name: &str| -> SatelliteObservation {
            let found = data.epochs[0].satellites.iter();
            found
                .clone()
                .find(|s| s.satellite.to_string() == name)
                .unwrap()
                .clone()
        };
        let g07 = of("G07");
        let l1 = g07.signals[0].unwrap();
        assert_eq!(l1.pseudorange_m, Some(22_000_000.125));
        assert_eq!(l1.phase_cycles, Some(115_611_234.567));
        assert_eq!((l1.loss_of_lock.0, l1.cn0_db_hz), (1, Some(45.25)));
        let l5 = g07.signals[2].unwrap();
        assert_eq!(
            (l5.code.to_string().as_str(), l5.pseudorange_m),
            ("5Q", Some(22_000_003.5))
        );
        // B2b of BeiDou, and a system of which L5 alone is used.
        assert_eq!(
            of("C23").signals[1].unwrap().phase_cycles,
            Some(96_639_876.5)
        );
        assert_eq!(of("I06").signals[0].unwrap().code.to_string(), "5A");
        assert_eq!(
            (data.events.len(), data.events[0].kind),
            (1, EventKind::External)
        );
        assert_eq!(data.events[0].time, start + 0.5);
    }
}

/// The C/B code of newer QZSS satellites, in a file of them alone.
#[test]
fn the_code_that_follows_c_a_of_qzss() {
    let text = observations("4.02").replace(
        "J    6 C1C L1C S1C C1E L1E S1E",
        "J    6 X1C X1C X1C C1E L1E S1E",
    );
    let data = read(&text).observations.unwrap();
    let j04 = data.epochs[0]
        .satellites
        .iter()
        .find(|s| s.satellite.to_string() == "J04");
    let signal = j04.unwrap().signals[0].unwrap();
    assert_eq!(signal.code.to_string(), "1E");
    assert_eq!(signal.phase_cycles, Some(199_691_234.5));
    assert_eq!(
        signal
            .code
            .carrier_frequency_hz(acerra_gnss::System::Qzss, None),
        Some(1_575.42e6)
    );
}

/// Numbers of a navigation record, four to a line after the first three.
fn record(first: &str, count: usize, value: impl Fn(usize) -> f64) -> String {
    let number = |k: usize| format!("{:19.12E}", value(k)).replace('E', "D");
    let number = |k: usize| {
        // Rust writes exponents without padding.
        let text = number(k);
        let (mantissa, exponent) = text.trim().split_once('D').unwrap();
        let exponent: i32 = exponent.parse().unwrap();
        let sign = if exponent < 0 { '-' } else { '+' };
        format!("{:>19}", format!("{mantissa}D{sign}{:02}", exponent.abs()))
    };
    let mut out = format!("{first}{}{}{}\n", number(0), number(1), number(2));
    for start in (3..count).step_by(4) {
        let numbers: String = (start..(start + 4).min(count)).map(number).collect();
        out += &format!("    {numbers}\n");
    }
    out
}

#[test]
fn navigation_messages_of_version_4() {
    let kepler = |k: usize| match k {
        10 => 5_153.6,
        8 => 0.01,
        11 | 27 => 561_600.0,
        15 => 0.95,
        21 => 2445.0,
        0 => 1e-4,
        _ => 0.0,
    };
    // Position, velocity and acceleration in km; the frequency channel.
    let glonass = |k: usize| match k {
        3 => 18_000.0,
        7 => -15_000.0,
        11 => 10_000.0,
        10 => -4.0,
        2 => 561_600.0,
        _ => 0.0,
    };
    let mut text = line(
        "     4.02           NAVIGATION DATA     M",
        "RINEX VERSION / TYPE",
    );
    text += &line("    18    18  1929     7", "LEAP SECONDS");
    text += &line("", "END OF HEADER");
    text += "> EPH G05 LNAV\n";
    text += &record("G05 2026 11 21 12 00 00", 31, kepler);
    text += "> EPH G05 CNAV\n";
    text += &record("G05 2026 11 21 12 00 00", 35, kepler);
    text += "> EPH E11 INAV\n";
    text += &record("E11 2026 11 21 12 00 00", 31, kepler);
    text += "> EPH C23 CNV1\n";
    text += &record("C23 2026 11 21 12 00 00", 39, kepler);
    // Version 4 (and 3.05) adds a fifth line to GLONASS records.
    text += "> EPH R07 FDMA\n";
    text += &record("R07 2026 11 21 11 45 00", 19, glonass);
    text += "> EPH I06 L1NV\n";
    text += &record("I06 2026 11 21 12 00 00", 35, kepler);
    text += "> STO G05 LNAV\n    2026 11 21 12 00 00 GPUT\n     0.0\n";
    text += "> EOP G05 CNVX\n    2026 11 21 12 00 00 1.0D-01\n     0.0\n     0.0\n";
    text += "> ION C23 CNVX\n    2026 11 21 12 00 00 1.0D-01\n     0.0\n     0.0\n";
    let file = read(&text);
    let navigation = file.navigation.unwrap();
    let names: Vec<String> = navigation
        .ephemerides
        .iter()
        .map(|e| e.satellite().to_string())
        .collect();
    assert_eq!(names.len(), 3, "{names:?}");
    for name in ["G05", "E11", "R07"] {
        assert!(names.iter().any(|n| n == name), "{names:?}");
    }
    let glonass = navigation.ephemerides.iter().find_map(|e| match e {
        Ephemeris::Glonass(e) => Some(*e),
        _ => None,
    });
    assert_eq!(glonass.unwrap().channel, -4);
    assert_eq!(glonass.unwrap().position_ecef_m, [18e6, -15e6, 10e6]);
    // What is not used is counted by its name, and nothing else is lost.
    let unused = |name: &str| DropReason::UnusedNavigationMessage(name.to_owned());
    for name in [
        "EPH CNAV", "EPH CNV1", "EPH L1NV", "STO LNAV", "EOP CNVX", "ION CNVX",
    ] {
        assert_eq!(
            file.report.count(&unused(name)),
            1,
            "{name}: {}",
            file.report
        );
    }
    assert_eq!(file.report.dropped.len(), 6, "{}", file.report);
}
