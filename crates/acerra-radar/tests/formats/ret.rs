//! MRM-RET text logs.

use std::io::Cursor;

use crate::common::{scan, scans};
use acerra_radar::mrm::RadarConfig;
use acerra_radar::ret::{RetWriter, read_ret};
use acerra_radar::{
    BlemishKind, Filtering, Limits, OpenError, Place, RadarFile, RadarLog, RadargramOptions,
    ReadError, Scan, read,
};
use proptest::prelude::*;

fn text(scans: &[Scan]) -> String {
    let mut writer = RetWriter::new(Vec::new()).unwrap();
    writer.config(10.0, &RadarConfig::default()).unwrap();
    writer.control(10.5, 3, 65535, 50_000).unwrap();
    for scan in scans {
        writer.scan(scan).unwrap();
    }
    String::from_utf8(writer.finish().unwrap()).unwrap()
}

fn timed(count: usize, samples: usize) -> Vec<Scan> {
    let mut scans = scans(count, samples);
    for (i, scan) in scans.iter_mut().enumerate() {
        scan.host_time_s = Some(1000.25 + 0.0216 * i as f64);
    }
    scans
}

fn log(text: &str) -> RadarLog {
    let RadarFile::Log(log) = read(Cursor::new(text.as_bytes()), &Limits::default()).unwrap()
    else {
        panic!("a log")
    };
    log
}

#[test]
fn a_written_log_reads_back_to_the_sample() {
    let wanted = timed(6, 288);
    for ends in ["\n", "\r\n"] {
        let log = log(&text(&wanted).replace('\n', ends));
        assert_eq!(log.scans, wanted);
        assert!(log.report.is_clean(), "{:?}", log.report);
        assert_eq!(log.configs[0].config, RadarConfig::default());
        assert_eq!(log.requested_interval_us, Some(50_000));
        let made = log.radargram(&RadargramOptions::default()).unwrap();
        assert_eq!(made.host_time_s.unwrap()[3], 1000.25 + 0.0216 * 3.0);
    }
}

#[test]
fn blemishes_of_real_logs() {
    let good = timed(4, 96);
    let lines: Vec<String> = text(&good).lines().map(str::to_owned).collect();
    let (head, scan_lines) = lines.split_at(5);
    let mut log_lines = head.to_vec();
    // Empty and −1 reserved fields, no blanks after commas.
    log_lines.push(
        scan_lines[0]
            .replacen("0, 0, 0, 0,", "-1,,-1,,", 1)
            .replace(", ", ","),
    );
    log_lines.push("1000.3, MrmDetectionListInfo, 9, 2, 17, 300, 40, 200".into());
    log_lines.push("1000.3, MrmControlConfirm, 3, 0".into());
    log_lines.push("garbage".into());
    log_lines.push(scan_lines[1].replace(", 32, 1,", ", x, 1,"));
    log_lines.push(String::new());
    log_lines.push(scan_lines[2].clone() + ", ");
    log_lines.push(scan_lines[2].rsplit_once(',').unwrap().0.into());
    log_lines.push(scan_lines[3][..scan_lines[3].len() / 2].into());
    let log = log(&log_lines.join("\n"));
    assert_eq!(log.scans, [good[0].clone(), good[2].clone()]);
    let found: Vec<_> = log
        .report
        .blemishes
        .iter()
        .map(|b| (b.place, b.kind.clone()))
        .collect();
    assert_eq!(
        found,
        [
            (
                Place::Line(9),
                BlemishKind::MalformedLine {
                    field: 2,
                    expected: "an event's name"
                }
            ),
            (
                Place::Line(10),
                BlemishKind::MalformedLine {
                    field: 12,
                    expected: "a scan step in bins"
                }
            ),
            (
                Place::Line(13),
                BlemishKind::LineSamples {
                    expected: 96,
                    found: 95
                }
            ),
            (Place::Line(14), BlemishKind::CutOffLine),
        ]
    );
    assert_eq!(log.report.incomplete_scans, 2);
    assert_eq!(log.report.other_events["MrmDetectionListInfo"], 1);
    assert_eq!(log.report.other_events["MrmControlConfirm"], 1);
}

#[test]
fn a_last_line_without_end_is_kept_and_said() {
    let wanted = timed(2, 96);
    let log = log(text(&wanted).trim_end());
    assert_eq!(log.scans, wanted);
    assert_eq!(log.report.blemishes[0].kind, BlemishKind::UnterminatedLine);
}

#[test]
fn raw_scans_are_preferred_and_reconfiguration_parts_runs() {
    let mut writer = RetWriter::new(Vec::new()).unwrap();
    writer.config(0.0, &RadarConfig::default()).unwrap();
    for i in 0..30 {
        if i == 10 {
            let config = RadarConfig {
                integration_index: 12,
                ..RadarConfig::default()
            };
            writer.config(0.2, &config).unwrap();
        }
        for filtering in [Filtering::Raw, Filtering::BandPass] {
            writer
                .scan(&Scan {
                    filtering,
                    ..scan(i, 96)
                })
                .unwrap();
        }
    }
    let log = log(&String::from_utf8(writer.finish().unwrap()).unwrap());
    assert_eq!(log.scans.len(), 60);
    let made = log.radargram(&RadargramOptions::default()).unwrap();
    assert_eq!(
        (made.radargram.traces, made.run_number, made.runs),
        (20, 1, 2)
    );
    assert_eq!(made.run.config.unwrap().integration_index, 12);
    assert_eq!(log.report.blemishes[0].kind, BlemishKind::Reconfigured);
}

#[test]
fn logs_without_scans_and_lines_without_end() {
    let head = text(&[]);
    match read(Cursor::new(head), &Limits::default()) {
        Err(OpenError::Read(ReadError::NoScans { .. })) => {}
        other => panic!("{other:?}"),
    }
    let limits = Limits::default().with_max_line_bytes(100);
    let long = text(&timed(1, 96));
    match read_ret(long.as_bytes(), &limits) {
        Err(ReadError::NoScans { report }) => {
            assert!(matches!(
                report.blemishes[0].kind,
                BlemishKind::LongLine { limit: 100 }
            ));
        }
        other => panic!("{other:?}"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_cut_anywhere_keeps_every_whole_line(cut in 0usize..5000) {
        let wanted = timed(5, 96);
        let whole = text(&wanted);
        let cut = cut.min(whole.len());
        let ends = whole[..cut].matches('\n').count();
        let got = read_ret(&whole.as_bytes()[..cut], &Limits::default())
            .map(|l| l.scans)
            .unwrap_or_default();
        let lines = ends.saturating_sub(5);
        prop_assert_eq!(&got[..lines.min(got.len())], &wanted[..lines]);
        // At most the unfinished line's scan comes on top.
        prop_assert!(got.len() <= lines + 1);
    }

    #[test]
    fn arbitrary_text_never_panics(noise in "[ -~,\n\r]{0,400}") {
        let _ = read_ret(noise.as_bytes(), &Limits::default());
        let event = format!("1.0, MrmFullScanInfo, {noise}");
        let _ = read_ret(event.as_bytes(), &Limits::default());
    }
}
