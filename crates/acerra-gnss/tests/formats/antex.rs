//! Antenna calibrations from ANTEX text made here.

use std::f64::consts::FRAC_PI_2;

use acerra_gnss::antex::{AntexFile, read_antex};
use acerra_gnss::input::{DropReason, FileKind, Limits, Lines, ReadError, ReadReport, sniff};
use acerra_gnss::{SignalCode, System};

fn line(content: &str, label: &str) -> String {
    format!("{content:<60}{label}\n")
}

/// One antenna: offset of L1 (north, east, up; mm), variations that grow by 1 mm every 30° of
/// zenith angle and by 0.1 mm every 90° of azimuth.
fn antenna(name: &str, serial: &str) -> String {
    let mut out = line("", "START OF ANTENNA");
    out += &line(&format!("{name:<20}{serial:<40}"), "TYPE / SERIAL NO");
    out += &line("    90.0", "DAZI");
    out += &line("     0.0  90.0  30.0", "ZEN1 / ZEN2 / DZEN");
    out += &line("     2", "# OF FREQUENCIES");
    for (frequency, up) in [("G01", 60.0), ("G02", 65.0)] {
        out += &line(&format!("   {frequency}"), "START OF FREQUENCY");
        out += &line(
            &format!("{:10.2}{:10.2}{up:10.2}", 1.5, -0.5),
            "NORTH / EAST / UP",
        );
        out += "   NOAZI    0.00    1.00    2.00    3.00\n";
        for (azimuth, more) in [
            (0.0, 0.0),
            (90.0, 0.1),
            (180.0, 0.2),
            (270.0, 0.3),
            (360.0, 0.0),
        ] {
            let values: String = (0..4)
                .map(|k| format!("{:8.2}", f64::from(k) + more))
                .collect();
            out += &format!("{azimuth:8.1}{values}\n");
        }
        out += &line(&format!("   {frequency}"), "END OF FREQUENCY");
        out += &line(&format!("   {frequency}"), "START OF FREQ RMS");
        out += &line("      0.10      0.10      0.10", "NORTH / EAST / UP");
        out += "   NOAZI    0.10    0.10    0.10    0.10\n";
        out += &line(&format!("   {frequency}"), "END OF FREQ RMS");
    }
    out + &line("", "END OF ANTENNA")
}

fn file(antennas: &[String]) -> String {
    let mut out = line("     1.4            M", "ANTEX VERSION / SYST");
    out += &line("A", "PCV TYPE / REFANT");
    out += &line("", "END OF HEADER");
    out + &antennas.concat()
}

fn read(text: &str) -> Result<(AntexFile, ReadReport), ReadError> {
    read_antex(&mut Lines::new(text.as_bytes(), Limits::default()))
}

fn sample() -> String {
    file(&[
        antenna("BLOCK IIF", "G05                 G050"),
        antenna("TRM57971.00     NONE", ""),
        antenna("TRM57971.00     TZGD", ""),
    ])
}

#[test]
fn ranges_follow_offset_and_variation() {
    assert_eq!(sniff(sample().as_bytes()), FileKind::Antex);
    let (antex, report) = read(&sample()).unwrap();
    assert_eq!(report.dropped, []);
    assert_eq!(antex.antennas.len(), 2, "satellites are passed over");
    let antenna = antex.find("TRM57971.00     TZGD").unwrap();
    let l1 = antenna
        .of_signal(System::Gps, SignalCode::new(1, 'C'))
        .unwrap();
    assert_eq!(
        l1.offset_enu_m.map(|m| (m * 1e4).round()),
        [-5.0, 15.0, 600.0]
    );
    let close = |found: f64, mm: f64| assert!((found * 1e3 - mm).abs() < 1e-9, "{found} {mm}");
    // In the zenith only the height counts.
    close(l1.range_m(0.0, FRAC_PI_2), -60.0);
    // At the horizon in the north: the north offset, and the variation for 90° of zenith angle.
    close(l1.range_m(0.0, 0.0), -1.5 + 3.0);
    close(l1.range_m(FRAC_PI_2, 0.0), 0.5 + 3.1);
    // Half way between directions; 315° lies between 270° and 360°, which repeats 0°.
    close(
        l1.range_m(315f64.to_radians(), 0.0),
        -(1.5 + 0.5) * 0.5f64.sqrt() + 3.15,
    );
    close(
        l1.range_m(-45f64.to_radians(), 0.0),
        -(1.5 + 0.5) * 0.5f64.sqrt() + 3.15,
    );
    let zenith_45 = 45f64.to_radians();
    close(
        l1.range_m(0.0, zenith_45),
        -(1.5 + 60.0) * 0.5f64.sqrt() + 1.5,
    );
}

#[test]
fn antennas_and_signals_that_are_not_calibrated_take_the_nearest() {
    let (antex, _) = read(&sample()).unwrap();
    let name = |wanted: &str| antex.find(wanted).map(|a| a.antenna.clone());
    assert_eq!(name("TRM57971.00").as_deref(), Some("TRM57971.00     NONE"));
    assert_eq!(
        name("TRM57971.00     SNOW").as_deref(),
        Some("TRM57971.00     NONE")
    );
    assert_eq!(
        name("TRM57971.00 TZGD").as_deref(),
        Some("TRM57971.00     TZGD")
    );
    assert_eq!((name(""), name("TRM5797")), (None, None));
    let antenna = antex.find("TRM57971.00").unwrap();
    let up = |system, band| {
        let found = antenna.of_signal(system, SignalCode::new(band, 'X'));
        found.map(|c| (c.offset_enu_m[2] * 1e3).round())
    };
    assert_eq!(up(System::Galileo, 1), Some(60.0));
    assert_eq!(up(System::Glonass, 2), Some(65.0));
    assert_eq!(up(System::Beidou, 7), Some(65.0));
    assert_eq!(up(System::Gps, 5), Some(65.0));
    assert_eq!(up(System::Navic, 9), None);
}

#[test]
fn damaged_calibrations_are_not_used() {
    let good = antenna("TRM57971.00     NONE", "");
    for (from, to) in [
        ("   270.0", "   271.0"),
        ("   NOAZI    0.00", "   NOAZI    x.00"),
        ("     0.0  90.0  30.0", "     0.0  90.0   0.0"),
        ("     0.0  90.0  30.0", "     0.0  90.0 1e-09"),
        ("    90.0", "    -1.0"),
        ("   360.0    0.00    1.00    2.00    3.00\n", ""),
        ("      1.50", "          "),
    ] {
        let bad = good.replacen(from, to, 1);
        assert_ne!(bad, good, "{from}");
        let (antex, report) = read(&file(&[bad, antenna("LEIAR25.R3      LEIT", "")])).unwrap();
        assert_eq!(antex.antennas.len(), 1, "{from} {to}");
        let reason = DropReason::UnreadableCalibration("TRM57971.00     NONE".to_owned());
        assert_eq!(report.count(&reason), 1, "{from} {to}");
    }
    let text = sample();
    for cut in (1..text.len()).step_by(11) {
        if let Ok((antex, report)) = read(&text[..cut]) {
            let all = antex.antennas.len();
            assert!(
                all == 2 || !report.dropped.is_empty() || all < 2,
                "cut at {cut}"
            );
        }
    }
}

#[test]
fn files_that_are_no_absolute_calibrations_are_refused() {
    let relative = sample().replacen("A         ", "R         ", 1);
    assert!(matches!(
        read(&relative),
        Err(ReadError::Unsupported { line: 2, .. })
    ));
    let version = sample().replacen("     1.4", "     2.0", 1);
    assert!(matches!(
        read(&version),
        Err(ReadError::Unsupported { line: 1, .. })
    ));
    assert!(matches!(
        read("x\n"),
        Err(ReadError::Format { line: 1, .. })
    ));
    assert!(matches!(read(""), Err(ReadError::Empty)));
}

/// Writes a seed of the fuzz target `products` where `ACERRA_FUZZ_SEEDS` names a folder.
#[test]
fn fuzz_seeds() {
    if let Some(folder) = std::env::var_os("ACERRA_FUZZ_SEEDS") {
        std::fs::write(std::path::Path::new(&folder).join("antennas.atx"), sample()).unwrap();
    }
}
