//! Hatanaka compression: the original tool's output, expanded, and damaged.

use std::io::Write;

use acerra_gnss::crinex::CrinexLines;
use acerra_gnss::input::{DropReason, FileKind, Limits, LineSource, Lines, ReadError, sniff};
use acerra_gnss::{read_gnss, read_observations};

const PAIRS: [(&[u8], &[u8]); 2] = [
    (
        include_bytes!("fixtures/observations-2.11.crx"),
        include_bytes!("fixtures/observations-2.11.rnx"),
    ),
    (
        include_bytes!("fixtures/observations-3.04.crx"),
        include_bytes!("fixtures/observations-3.04.rnx"),
    ),
];

#[test]
fn expansion_is_that_of_the_original_tool() {
    for (compressed, plain) in PAIRS {
        let mut lines = CrinexLines::new(Lines::new(compressed, Limits::default())).unwrap();
        let mut got = Vec::new();
        while lines.advance().unwrap() {
            got.extend_from_slice(lines.line().trim_ascii_end());
            got.push(b'\n');
        }
        let expected: Vec<u8> = plain
            .split_inclusive(|&b| b == b'\n')
            .flat_map(|l| [l.trim_ascii_end(), b"\n"].concat())
            .collect();
        assert_eq!(
            String::from_utf8_lossy(&got).lines().collect::<Vec<_>>(),
            String::from_utf8_lossy(&expected)
                .lines()
                .collect::<Vec<_>>()
        );
        assert!(lines.take_report().dropped.is_empty());
    }
}

#[test]
fn compressed_and_plain_read_alike_also_inside_gzip() {
    for (compressed, plain) in PAIRS {
        let (from_plain, _) = read_observations(plain, Limits::default()).unwrap();
        assert_eq!(from_plain.epochs.len(), 12);
        assert_eq!(from_plain.events.len(), 1);
        let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        gzip.write_all(compressed).unwrap();
        let gzip = gzip.finish().unwrap();
        assert_eq!(sniff(&gzip), FileKind::Gzip);
        for bytes in [compressed, &gzip] {
            let file = read_gnss(bytes, Limits::default()).unwrap();
            assert_eq!(file.kind, FileKind::Crinex);
            assert_eq!(file.observations.as_ref(), Some(&from_plain));
            assert!(file.report.dropped.is_empty(), "{}", file.report);
        }
        // A gzip stream that ends early: what came whole is kept, and said so.
        let file = read_gnss(&gzip[..gzip.len() / 2], Limits::default()).unwrap();
        let epochs = file.observations.unwrap().epochs;
        assert!(!epochs.is_empty() && epochs.len() < 12);
        assert_eq!(epochs[..], from_plain.epochs[..epochs.len()]);
        assert!(file.report.remarks.iter().any(|r| r.contains("cut off")));
    }
}

#[test]
fn a_cut_at_any_byte_keeps_whole_epochs_only() {
    for (compressed, plain) in PAIRS {
        let (whole, _) = read_observations(plain, Limits::default()).unwrap();
        for cut in (600..compressed.len()).step_by(7) {
            let data = read_observations(&compressed[..cut], Limits::default())
                .unwrap()
                .0;
            assert_eq!(
                data.epochs[..],
                whole.epochs[..data.epochs.len()],
                "cut at {cut}"
            );
        }
    }
}

/// One damaged difference costs that value until its arc begins anew, and nothing else.
#[test]
fn damage_is_contained() {
    let (compressed, plain) = PAIRS[1];
    let text = String::from_utf8(compressed.to_vec()).unwrap();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    // The first satellite's line of the second epoch; its first field is the pseudorange.
    let epochs: Vec<usize> = (0..lines.len())
        .filter(|&i| lines[i].ends_with('1') && lines[i].starts_with("  "))
        .collect();
    let at = epochs[0] + 2;
    lines[at] = format!("x{}", lines[at]);
    let damaged = lines.join("\n") + "\n";
    let (data, report) = read_observations(damaged.as_bytes(), Limits::default()).unwrap();
    let (whole, _) = read_observations(plain, Limits::default()).unwrap();
    assert!(report.count(&DropReason::BrokenDifference) > 1, "{report}");
    let mut lost = 0;
    for (d, w) in data.epochs.iter().zip(&whole.epochs) {
        for (ds, ws) in d.satellites.iter().zip(&w.satellites) {
            let (d, w) = (ds.signals[0].unwrap(), ws.signals[0].unwrap());
            assert!(d.pseudorange_m == w.pseudorange_m || d.pseudorange_m.is_none());
            assert_eq!(d.phase_cycles, w.phase_cycles);
            lost += usize::from(d.pseudorange_m.is_none());
        }
    }
    assert_eq!(lost as u64, report.count(&DropReason::BrokenDifference));
}

#[test]
fn other_versions_are_refused_by_name() {
    let line = format!(
        "{:<20}{:<40}CRINEX VERS   / TYPE\n",
        "2.0", "COMPACT RINEX FORMAT"
    );
    let error = read_observations(line.as_bytes(), Limits::default()).unwrap_err();
    assert!(matches!(error, ReadError::Unsupported { .. }), "{error}");
}
