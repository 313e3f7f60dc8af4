//! RINEX text made here, column by column: what belongs where, and what a blemish costs.

use acerra_gnss::input::{DropReason, Limits, ReadError, ReadReport};
use acerra_gnss::{Ephemeris, ObservationData, SignalCode, read_navigation, read_observations};

/// A header line: content padded to 60 columns, then the label.
fn h(content: &str, label: &str) -> String {
    format!("{content:<60}{label}\n")
}

fn v3_header(types: &[&str], extra: &str) -> String {
    let mut text = h(
        "     3.04           OBSERVATION DATA    M",
        "RINEX VERSION / TYPE",
    );
    for line in types {
        text += &h(line, "SYS / # / OBS TYPES");
    }
    text + extra + &h("", "END OF HEADER")
}

fn v2_header(version: &str, types: &str) -> String {
    h(
        &format!("     {version}           OBSERVATION DATA    M"),
        "RINEX VERSION / TYPE",
    ) + &h(types, "# / TYPES OF OBSERV")
        + &h("", "END OF HEADER")
}

fn read(text: &str) -> (ObservationData, ReadReport) {
    read_observations(text.as_bytes(), Limits::default()).unwrap()
}

fn first(data: &ObservationData, satellite: &str, slot: usize) -> acerra_gnss::SignalObservation {
    let found = data.epochs[0]
        .satellites
        .iter()
        .find(|s| s.satellite.to_string() == satellite);
    found.unwrap().signals[slot].unwrap()
}

#[test]
fn scale_factors_divide() {
    let text = v3_header(
        &["G    4 C1C L1C D1C S1C", "E    2 C1C L1C"],
        &(h("G  100   2 L1C D1C", "SYS / SCALE FACTOR") + &h("E   10", "SYS / SCALE FACTOR")),
    ) + "> 2026 11 21 12 00  0.0000000  0  2\n\
         G07  20311445.258     1234567.800         100.000          45.000\n\
         E11 203114452.580     1234567.800\n";
    let (data, _) = read(&text);
    let g = first(&data, "G07", 0);
    assert_eq!(g.pseudorange_m, Some(20_311_445.258));
    assert_eq!(g.phase_cycles, Some(12_345.678));
    assert_eq!((g.doppler_hz, g.cn0_db_hz), (Some(1.0), Some(45.0)));
    assert_eq!(first(&data, "E11", 0).pseudorange_m, Some(20_311_445.258));
}

#[test]
fn loss_of_lock_is_kept_on_a_blank_phase_and_cut_to_two_bits() {
    let text = v3_header(&["G    3 C1C L1C S1C"], "")
        + "> 2026 11 21 12 00  0.0000000  0  3\n\
           G07  20311445.258                1          45.000\n\
           G08  20311445.258     1234567.8007         45.000\n\
           G09  20311445.258     1234567.800 6        45.000\n";
    let (data, _) = read(&text);
    let g07 = first(&data, "G07", 0);
    assert_eq!((g07.phase_cycles, g07.loss_of_lock.0), (None, 1));
    assert_eq!(first(&data, "G08", 0).loss_of_lock.0, 3);
    assert_eq!(
        first(&data, "G09", 0).loss_of_lock.0,
        0,
        "strength is not loss of lock"
    );
}

#[test]
fn flags_tell_epochs_from_events() {
    let text = v3_header(&["G    2 C1C L1C"], "")
        + "> 2026 11 21 12 00  0.0000000  0  1\n\
           G07  20311445.258     1234567.800\n\
           > 2026 11 21 12 00  0.3456789  5  0\n\
           > 2026 11 21 12 00  0.5000000  5  1\n\
           camera                                                      COMMENT\n\
           > 2026 11 21 12 00  1.0000000  1  1\n\
           G07  20311446.258     1234568.800\n\
           >                              4  2\n"
        + &h("G    3 C1C D1C L1C", "SYS / # / OBS TYPES")
        + &h("  1 R05  1", "GLONASS SLOT / FRQ #")
        + "> 2026 11 21 12 00  2.0000000  0  1\n\
           G07  20311447.258         100.000     1234569.800\n\
           > 2026 11 21 12 00  2.0000000  6  1\n\
           G07                               1.000\n\
           > 2026 11 21 12 00  3.0000000  2  1\n\
           G07  20311448.258         100.000     1234570.800\n";
    let (data, report) = read(&text);
    assert_eq!(data.epochs.len(), 4, "{report}");
    assert_eq!(data.events.len(), 2);
    assert_eq!(
        data.events[0].time.format_calendar(7),
        "2026/11/21 12:00:00.3456789"
    );
    let phases: Vec<_> = data
        .epochs
        .iter()
        .map(|e| e.satellites[0].signals[0].unwrap().phase_cycles.unwrap())
        .collect();
    assert_eq!(phases, [1_234_567.8, 1_234_568.8, 1_234_569.8, 1_234_570.8]);
    assert_eq!(data.glonass_channels[&5], 1);
    assert_eq!(report.count(&DropReason::CycleSlipRecord), 1);
    assert_eq!(report.dropped.len(), 1, "{report}");
}

#[test]
fn version_2_with_many_satellites_types_and_blanks() {
    let names: Vec<String> = (1..=9)
        .map(|n| format!(" {n:2}"))
        .chain((10..=17).map(|n| format!("G{n}")))
        .collect();
    let mut text = v2_header("2.11", "     7    C1    L1    P1    L2    P2    D1    S1");
    text += &format!(" 26 11 21 12  0 30.0000000  0 17{}", names[..12].concat());
    text += "       -0.000000123\n";
    text += &format!("{:32}{}\n", "", names[12..].concat());
    for n in 1..=17 {
        // G02 has no C1: its P1 must serve. G03 has no values at all.
        let c1 = if n == 2 {
            String::new()
        } else {
            format!("{:.3}", 2e7 + f64::from(n))
        };
        if n == 3 {
            text += "\n\n";
            continue;
        }
        let line = format!(
            "{c1:>14}  {:>14.3}1 {:>14.3}  {:>14.3} 5{:>14.3}  ",
            1e8 + f64::from(n),
            2.1e7 + f64::from(n),
            0.8e8 + f64::from(n),
            2.2e7 + f64::from(n)
        );
        text += &format!("{}\n{:>14.3}  {:>14.3}\n", line.trim_end(), -1234.5, 47.0);
    }
    let (data, report) = read(&text);
    assert!(report.dropped.is_empty(), "{report}");
    assert_eq!(data.epochs[0].satellites.len(), 16);
    let g17 = first(&data, "G17", 0);
    assert_eq!(g17.code, SignalCode::new(1, 'C'));
    assert_eq!(g17.pseudorange_m, Some(20_000_017.0));
    assert_eq!(g17.phase_cycles, Some(100_000_017.0));
    assert!(g17.loss_of_lock.slipped());
    assert_eq!((g17.doppler_hz, g17.cn0_db_hz), (Some(-1234.5), Some(47.0)));
    let l2 = first(&data, "G17", 1);
    assert_eq!(
        (l2.code, l2.pseudorange_m),
        (SignalCode::new(2, 'W'), Some(22_000_017.0))
    );
    let g02 = first(&data, "G02", 0);
    assert_eq!(
        (g02.code, g02.pseudorange_m),
        (SignalCode::new(1, 'W'), Some(21_000_002.0))
    );
    assert_eq!(g02.phase_cycles, Some(100_000_002.0));
}

#[test]
fn damaged_values_cost_themselves_only() {
    let text = v3_header(&["G    3 C1C L1C S1C"], "")
        + "> 2026 11 21 12 00  0.0000000  0  5\n\
           G07  2031x445.258     1234567.800          45.000\n\
           G08  20311445.258       nan                45.000\n\
           X09  20311445.258     1234567.800          45.000\n\
           G08  99999999.000     1234567.800          45.000\n\
           C08  20311445.258     1234567.800          45.000\n\
           > 2026 11 21 12 99  0.0000000  0  1\n\
           G07  20311445.258     1234567.800          45.000\n\
           > 2026 11 21 12 00  2.0000000  0  1\n\
           G07  20311445.258     1234567.800          45.000\n";
    let (data, report) = read(&text);
    assert_eq!(data.epochs.len(), 2);
    assert_eq!(first(&data, "G07", 0).pseudorange_m, None);
    assert_eq!(first(&data, "G07", 0).phase_cycles, Some(1_234_567.8));
    assert_eq!(first(&data, "G08", 0).pseudorange_m, Some(20_311_445.258));
    assert_eq!(report.count(&DropReason::UnreadableNumber), 2);
    assert_eq!(
        report.count(&DropReason::UnknownSatellite("X09".to_owned())),
        1
    );
    assert_eq!(report.count(&DropReason::DuplicateSatellite), 1);
    assert_eq!(report.count(&DropReason::UndeclaredSystem('C')), 1);
    assert_eq!(report.count(&DropReason::UnreadableEpoch), 1);
}

/// A log cut at any byte gives its whole epochs, each with the values of the uncut file.
#[test]
fn every_cut_keeps_whole_epochs_only() {
    let v3 = v3_header(&["G    2 C1C L1C"], "")
        + "> 2026 11 21 12 00  0.0000000  0  2\n\
           G07  20311445.258     1234567.80011\n\
           G08  20311446.258     1234568.80011\n\
           > 2026 11 21 12 00  1.0000000  0  2\n\
           G07  20311447.258     1234569.80011\n\
           G08  20311448.258     1234570.80011\n";
    let v2 = v2_header("2.10", "     2    C1    L1")
        + " 26 11 21 12  0  0.0000000  0  2G07G08\n\
           \x20 20311445.258     1234567.80011\n\
           \x20 20311446.258     1234568.80011\n\
           \x2026 11 21 12  0  1.0000000  0  2G07G08\n\
           \x20 20311447.258     1234569.80011\n\
           \x20 20311448.258     1234570.80011\n";
    for text in [v3, v2] {
        let whole = read(&text).0;
        assert_eq!(whole.epochs.len(), 2);
        let body = text.find("END OF HEADER").unwrap() + 14;
        for cut in body..text.len() {
            let (data, _) = read(&text[..cut]);
            for (got, full) in data.epochs.iter().zip(&whole.epochs) {
                assert_eq!(got.time, full.time);
                assert_eq!(got.satellites.len(), 2, "cut at {cut}");
                for (g, f) in got.satellites.iter().zip(&full.satellites) {
                    let (g, f) = (g.signals[0].unwrap(), f.signals[0].unwrap());
                    assert_eq!(g.pseudorange_m, f.pseudorange_m, "cut at {cut}");
                    assert!(g.phase_cycles.is_none() || g.phase_cycles == f.phase_cycles);
                }
            }
        }
        assert_eq!(
            read(&text[..text.len() - 40]).1.count(&DropReason::CutOff),
            1
        );
    }
}

/// A count that promises more satellites than follow costs that epoch, not the next.
#[test]
fn an_epoch_with_missing_lines_does_not_eat_the_next() {
    let v3 = v3_header(&["G    2 C1C L1C"], "")
        + "> 2026 11 21 12 00  0.0000000  0  2\n\
           G07  20311445.258     1234567.800\n\
           > 2026 11 21 12 00  1.0000000  0  1\n\
           G07  20311447.258     1234569.800\n";
    let v2 = v2_header("2.10", "     2    C1    L1")
        + " 26 11 21 12  0  0.0000000  0  2G07G08\n\
           \x20 20311445.258     1234567.800\n\
           \x2026 11 21 12  0  1.0000000  0  1G07\n\
           \x20 20311447.258     1234569.800\n";
    for text in [v3, v2] {
        let (data, report) = read(&text);
        assert_eq!(data.epochs.len(), 1);
        assert_eq!(first(&data, "G07", 0).pseudorange_m, Some(20_311_447.258));
        assert_eq!(report.count(&DropReason::CutOff), 1);
    }
}

#[test]
fn time_systems_become_gps_time() {
    for (system, expected) in [
        ("GPS", "2026/11/21 12:00:00.0"),
        ("BDT", "2026/11/21 12:00:14.0"),
        ("GLO", "2026/11/21 12:00:18.0"),
        ("GAL", "2026/11/21 12:00:00.0"),
    ] {
        let first_obs = format!("  2026    11    21    12     0    0.0000000     {system}");
        let text = v3_header(&["G    1 C1C"], &h(&first_obs, "TIME OF FIRST OBS"))
            + "> 2026 11 21 12 00  0.0000000  0  1\nG07  20311447.258\n";
        assert_eq!(
            read(&text).0.epochs[0].time.format_calendar(1),
            expected,
            "{system}"
        );
    }
}

#[test]
fn repeated_and_disordered_epochs() {
    let epoch =
        |s: f64, name: &str| format!("> 2026 11 21 12 00 {s:10.7}  0  1\n{name}  20311447.258\n");
    let text = v3_header(&["G    1 C1C"], "")
        + &epoch(2.0, "G07")
        + &epoch(0.0, "G07")
        + &epoch(0.01, "G08")
        + &epoch(2.0, "G07");
    let (data, report) = read(&text);
    assert_eq!(data.epochs.len(), 2);
    assert_eq!(data.epochs[0].satellites.len(), 2);
    assert_eq!(report.count(&DropReason::EpochOutOfOrder), 1);
    assert_eq!(report.count(&DropReason::DuplicateEpoch), 2);
}

#[test]
fn headers_that_cannot_serve() {
    let kind = |text: &str| read_observations(text.as_bytes(), Limits::default()).unwrap_err();
    let bad_version = h(
        "     5.00           OBSERVATION DATA    M",
        "RINEX VERSION / TYPE",
    );
    assert!(matches!(
        kind(&bad_version),
        ReadError::Unsupported { line: 1, .. }
    ));
    let endless = h(
        "     3.04           OBSERVATION DATA    M",
        "RINEX VERSION / TYPE",
    );
    assert!(matches!(
        kind(&endless),
        ReadError::MissingHeader {
            missing: "END OF HEADER",
            ..
        }
    ));
    assert!(matches!(
        kind(&v3_header(&[], "")),
        ReadError::MissingHeader {
            missing: "SYS / # / OBS TYPES",
            ..
        }
    ));
    assert!(matches!(kind(""), ReadError::Empty));
    assert!(matches!(kind("hello"), ReadError::WrongKind { .. }));
    let nav = h(
        "     3.04           N: GNSS NAV DATA    M",
        "RINEX VERSION / TYPE",
    ) + &h("", "END OF HEADER");
    assert!(matches!(kind(&nav), ReadError::WrongKind { .. }));
}

/// `D19.12` numbers in a row.
fn values(numbers: &[f64]) -> String {
    let one = |x: &f64| {
        let text = format!("{x:.12e}");
        let (mantissa, exponent) = text.split_once('e').unwrap();
        let exponent: i32 = exponent.parse().unwrap();
        format!("{:>19}", format!("{mantissa}D{exponent:+03}"))
    };
    numbers.iter().map(one).collect()
}

fn kepler_record(first: &str, indent: &str, toe_sow: f64, week: f64) -> String {
    let slots: Vec<f64> = (0..31)
        .map(|slot| match slot {
            0 => 1e-4,
            8 => 0.01,
            10 => 5153.0,
            11 => toe_sow,
            20 => 517.0,
            21 => week,
            23 => 3.12,
            24 | 2 => 0.0,
            27 => toe_sow - 600.0,
            s => 1e-3 * f64::from(s),
        })
        .collect();
    let mut text = format!("{first}{}\n", values(&slots[..3]));
    for row in slots[3..].chunks(4) {
        text += &format!("{indent}{}\n", values(row));
    }
    text
}

#[test]
fn navigation_of_all_versions_and_a_cut_at_every_byte() {
    let v2 = h(
        "     2.11           N: GPS NAV DATA",
        "RINEX VERSION / TYPE",
    ) + &h(
        "    1.1180D-08  1.4900D-08 -5.9600D-08 -5.9600D-08",
        "ION ALPHA",
    ) + &h(
        "    8.8060D+04  1.6380D+04 -1.9660D+05 -1.3110D+05",
        "ION BETA",
    ) + &h("", "END OF HEADER")
        + &kepler_record(" 7 26 11 21 12  0  0.0", "   ", 561_600.0, 2445.0);
    let v3_head = h(
        "     3.04           N: GNSS NAV DATA    M: MIXED",
        "RINEX VERSION / TYPE",
    ) + &h("", "END OF HEADER");
    let v3 = v3_head.clone()
        + &kepler_record("E07 2026 11 21 12 00 00", "    ", 561_600.0, 2445.0)
        + &kepler_record("C07 2026 11 21 12 00 00", "    ", 561_600.0, 1089.0);
    let v4 = h(
        "     4.00           NAVIGATION DATA     M",
        "RINEX VERSION / TYPE",
    ) + &h("", "END OF HEADER")
        + "> EPH G07 LNAV\n"
        + &kepler_record("G07 2026 11 21 12 00 00", "    ", 561_600.0, 2445.0)
        + "> EPH G08 CNAV\n"
        + &kepler_record("G08 2026 11 21 12 00 00", "    ", 561_600.0, 2445.0)
        + "> STO G01 LNAV\n    2026 11 21 00 00 00 GPUT\n"
        + &format!("    {}\n", values(&[1.0, 2.0, 3.0]))
        + "> ION G01 LNAV\n"
        + &format!("    2026 11 21 00 00 00{}\n", values(&[1e-8, 2e-8, 3e-8]))
        + &format!("    {}\n", values(&[4e-8, 1e5, 2e5, 3e5]))
        + &format!("    {}\n", values(&[4e5, 0.0]))
        + "> EPH E08 FNAV\n"
        + &kepler_record("E08 2026 11 21 12 00 00", "    ", 561_600.0, 2445.0);
    let read = |text: &str| read_navigation(text.as_bytes(), Limits::default());

    let (nav, report) = read(&v2).unwrap();
    assert!(report.dropped.is_empty(), "{report}");
    let Ephemeris::Kepler(g) = nav.ephemerides[0] else {
        panic!()
    };
    assert_eq!(g.toe.format_calendar(0), "2026/11/21 12:00:00");
    assert_eq!(g.toe - g.transmission_time, 600.0);
    assert_eq!((g.accuracy_m, g.iode, g.clock[0]), (3.4, 0, 1e-4));
    assert!((g.group_delay_s[0] - 0.025).abs() < 1e-15);
    assert_eq!(nav.klobuchar.unwrap().beta[2], -196_600.0);

    let (nav, _) = read(&v3).unwrap();
    let at = |name: &str| match nav
        .ephemerides
        .iter()
        .find(|e| e.satellite().to_string() == name)
    {
        Some(Ephemeris::Kepler(e)) => *e,
        other => panic!("{other:?}"),
    };
    assert!((at("E07").accuracy_m - 2.96).abs() < 1e-12);
    assert_eq!(at("E07").data_source, 517);
    assert_eq!(at("C07").toe - at("E07").toe, 14.0);
    assert_eq!(at("C07").toe_seconds_of_week, 561_600.0);

    let (nav, report) = read(&v4).unwrap();
    let names: Vec<String> = nav
        .ephemerides
        .iter()
        .map(|e| e.satellite().to_string())
        .collect();
    assert_eq!(names, ["G07", "E08"]);
    assert_eq!(nav.klobuchar.unwrap().alpha, [1e-8, 2e-8, 3e-8, 4e-8]);
    assert_eq!(nav.klobuchar.unwrap().beta, [1e5, 2e5, 3e5, 4e5]);
    let unused = |what: &str| report.count(&DropReason::UnusedNavigationMessage(what.to_owned()));
    assert_eq!((unused("EPH CNAV"), unused("STO LNAV")), (1, 1), "{report}");

    for text in [&v2, &v3, &v4] {
        let whole = read(text).unwrap().0;
        for cut in text.find("END OF HEADER").unwrap() + 14..text.len() {
            for got in read(&text[..cut]).unwrap().0.ephemerides {
                // All slots up to the transmission time are there; the last (fit interval) is
                // not used.
                assert!(whole.ephemerides.contains(&got), "cut at {cut}: {got:?}");
            }
        }
    }
}
