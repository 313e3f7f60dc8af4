//! Files as services and editors hand them on: archives, other ends of lines, odd numbers.

use std::io::{Cursor, Write};

use acerra_gnss::input::{Limits, ReadError};
use acerra_gnss::{GnssFile, read_gnss};
use zip::write::SimpleFileOptions;

const OBSERVATIONS: &str = "     2.11           OBSERVATION DATA    G (GPS)             RINEX VERSION / TYPE\n\
    \x20    1    C1                                                # / TYPES OF OBSERV\n\
    \x20                                                           END OF HEADER\n\
    \x2026 11 21 12  0  0.0000000  0  1G07\n\
    \x20 20311445.258\n";

/// An ephemeris with what Fortran makes of numbers below 1e-99 in its spare fields.
fn navigation(kind: &str, satellite: &str, blanks: &str, spare: &str) -> String {
    let mut text = format!(
        "{:<20}{kind:<40}{:<20}\n{:60}END OF HEADER\n",
        "     2.12", "RINEX VERSION / TYPE", ""
    );
    let rows = [
        [
            " 0.160000000000D+02",
            "-0.343750000000D+02",
            " 0.477555606394D-08",
            "-0.712852183121D+00",
        ],
        [
            "-0.175461173058D-05",
            " 0.135910103563D-02",
            " 0.710599124432D-05",
            " 0.515370994186D+04",
        ],
        [
            " 0.259200000000D+06",
            " 0.204890966415D-07",
            " 0.229351786584D+01",
            " 0.149011611938D-07",
        ],
        [
            " 0.960012929923D+00",
            " 0.242218750000D+03",
            " 0.504015801138D+00",
            "-0.808212236712D-08",
        ],
        [
            "-0.432160858377D-09",
            " 0.000000000000D+00",
            " 0.171200000000D+04",
            " 0.000000000000D+00",
        ],
        [
            " 0.200000000000D+01",
            " 0.000000000000D+00",
            " 0.838190317154D-08",
            " 0.160000000000D+02",
        ],
        [
            " 0.252000000000D+06",
            " 0.400000000000D+01",
            spare,
            " 0.664593648549-315",
        ],
    ];
    text += &format!(
        "{satellite} 12 10 31  0  0  0.0 0.280183739960D-03 0.170530256582D-11 0.000000000000D+00\n"
    );
    for row in rows {
        text += &format!("{blanks}{}\n", row.concat());
    }
    text
}

fn read(bytes: &[u8]) -> Result<GnssFile, ReadError> {
    read_gnss(bytes, Limits::default())
}

fn archive(members: &[(&str, &[u8])]) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in members {
        zip.start_file(*name, SimpleFileOptions::default()).unwrap();
        zip.write_all(content).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

#[test]
fn archives_hold_one_log_and_its_navigation_data() {
    let gps = navigation("NAVIGATION DATA", " 1", "   ", " 0.000000000000D+00");
    let picture: &[u8] = b"\x89PNG\r\n\x1a\n\0";
    let whole = archive(&[
        ("log/rover.26o", OBSERVATIONS.as_bytes()),
        ("log/rover.26n", gps.as_bytes()),
        ("log/notes.png", picture),
    ]);
    let file = read(&whole).unwrap();
    assert_eq!(file.observations.unwrap().epochs.len(), 1);
    assert_eq!(file.navigation.unwrap().ephemerides.len(), 1);
    assert!(
        file.report.format.contains("rover.26o"),
        "{}",
        file.report.format
    );
    for (members, part) in [
        (
            vec![
                ("a.26o", OBSERVATIONS.as_bytes()),
                ("b.26o", OBSERVATIONS.as_bytes()),
            ],
            "several",
        ),
        (vec![("a.png", picture)], "no GNSS data"),
    ] {
        let error = read(&archive(&members)).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
    assert!(read(&whole[..whole.len() / 2]).is_err());
}

/// A small file that unpacks without end is given up by the number of its bytes.
#[test]
fn what_unpacks_without_end_is_refused() {
    let endless: Vec<u8> = [0xD3, 0x03, 0xFF]
        .into_iter()
        .cycle()
        .take(32 << 20)
        .collect();
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    gzip.write_all(&endless).unwrap();
    for packed in [gzip.finish().unwrap(), archive(&[("a.rtcm3", &endless)])] {
        assert!(packed.len() < 200_000);
        let error = read(&packed).unwrap_err().to_string();
        assert!(error.contains("unpack to more than 16 times"), "{error}");
    }
}

#[test]
fn marks_and_old_ends_of_lines() {
    let plain = read(OBSERVATIONS.as_bytes()).unwrap().observations.unwrap();
    for text in [
        format!("\u{feff}{OBSERVATIONS}"),
        OBSERVATIONS.replace('\n', "\r"),
        format!("\u{feff}{}", OBSERVATIONS.replace('\n', "\r\n")),
    ] {
        let found = read(text.as_bytes()).unwrap().observations.unwrap();
        assert_eq!(found.epochs, plain.epochs, "{text:?}");
    }
}

#[test]
fn exponents_of_three_digits_and_satellites_with_a_letter() {
    for spare in [" 0.499063314480-269", "*******************"] {
        let gps = navigation("NAVIGATION DATA", " 1", "   ", spare);
        let found = read(gps.as_bytes()).unwrap();
        let ephemerides = found.navigation.unwrap().ephemerides;
        assert_eq!(
            (ephemerides.len(), found.report.dropped.len()),
            (1, 0),
            "{spare}"
        );
    }
    // Version 2.12 of QZSS: the letter, and a column more.
    let qzss = navigation("J: GNSS NAV DATA", "J01", "    ", " 0.000000000000D+00");
    let found = read(qzss.as_bytes()).unwrap().navigation.unwrap();
    assert_eq!(found.ephemerides[0].satellite().to_string(), "J01");
}
