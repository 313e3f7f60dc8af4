//! Session logs: torn anywhere, damaged anywhere, killed at any moment.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use std::fs;

use acerra_record::log::{LOG_SIGNATURE, LogReader, LogWriteError, LogWriter, Record, RecordKind};
use proptest::prelude::*;

fn record(number: u64) -> Record {
    let kinds = [RecordKind::Radio, RecordKind::Gnss, RecordKind::Note];
    Record {
        kind: kinds[(number % 3) as usize],
        at_ns: 1_000_000 * number,
        payload: (0..number * 37 % 500).map(|i| (i * number) as u8).collect(),
    }
}

fn log(records: &[Record]) -> Vec<u8> {
    let mut bytes = LOG_SIGNATURE.to_vec();
    for record in records {
        bytes.extend(record.encode().unwrap());
    }
    bytes
}

fn read(bytes: &[u8]) -> (Vec<Record>, acerra_record::log::LogDamage) {
    let mut reader = LogReader::new(bytes).unwrap();
    let mut records = Vec::new();
    while let Some(record) = reader.next_record().unwrap() {
        records.push(record);
    }
    (records, reader.damage())
}

#[test]
fn a_log_cut_anywhere_holds_every_whole_record() {
    let records: Vec<Record> = (0..12).map(record).collect();
    let whole = log(&records);
    for cut in 0..=whole.len() {
        let fitting = (0..=12).rev().find(|n| log(&records[..*n]).len() <= cut);
        let (found, damage) = read(&whole[..cut]);
        assert_eq!(found, records[..fitting.unwrap_or(0)], "cut at {cut}");
        let sound = fitting.map_or(cut, |n| log(&records[..n]).len());
        assert_eq!(damage.torn_bytes, (cut - sound) as u64);
        assert_eq!(damage.damaged_places, 0);
    }
}

#[test]
fn damage_costs_the_records_that_it_touches() {
    let records: Vec<Record> = (0..12).map(record).collect();
    let whole = log(&records);
    for at in LOG_SIGNATURE.len()..whole.len() {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x40;
        let (found, damage) = read(&bytes);
        assert_eq!(found.len(), 11, "byte {at}");
        assert!(found.iter().all(|record| records.contains(record)));
        assert_eq!(damage.damaged_places + u64::from(damage.torn_bytes > 0), 1);
    }
}

#[test]
fn another_file_is_refused() {
    let error = LogReader::new(&b"PK\x03\x04 and more"[..]).err().unwrap();
    assert!(
        error.to_string().starts_with("expected a session log"),
        "{error}"
    );
}

#[test]
fn an_existing_log_is_not_overwritten_and_a_torn_end_is_cut() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("session.log");
    let mut writer = LogWriter::create(&path).unwrap();
    for number in 0..5 {
        writer.write(&record(number)).unwrap();
    }
    drop(writer);
    assert!(matches!(
        LogWriter::create(&path),
        Err(LogWriteError::Io { .. })
    ));
    let mut bytes = fs::read(&path).unwrap();
    bytes.extend_from_slice(&record(5).encode().unwrap()[..30]);
    fs::write(&path, &bytes).unwrap();
    let (mut writer, damage) = LogWriter::resume(&path).unwrap();
    assert_eq!(damage.torn_bytes, 30);
    writer.write(&record(6)).unwrap();
    drop(writer);
    let (found, damage) = read(&fs::read(&path).unwrap());
    let expected: Vec<Record> = [0, 1, 2, 3, 4, 6].map(record).into();
    assert_eq!(found, expected);
    assert_eq!(damage.torn_bytes, 0);
}

/// A file of nothing but marks, each of which claims a megabyte, is given up before the work grows with its square.
#[test]
fn marks_without_records_are_given_up() {
    let mut mark = b"AcRf\x02\0\0\0".to_vec();
    mark.extend(1_000_000_u32.to_le_bytes());
    mark.extend([0; 8]);
    let mut bytes = log(&[record(0)]);
    bytes.extend(mark.repeat(10_000_000 / mark.len()));
    let mut reader = LogReader::new(&bytes[..]).unwrap();
    assert_eq!(reader.next_record().unwrap(), Some(record(0)));
    let error = reader.next_record().unwrap_err().to_string();
    assert!(error.contains("checksums do not fit"), "{error}");
    assert!(reader.vain_bytes() < (4 << 30) + (2 << 20));
    // Damage in every record costs their lengths, and what damaged lengths claim.
    let records: Vec<Record> = (0..1000).map(record).collect();
    let mut bytes = log(&records);
    let length = bytes.len() as u64;
    for at in (100..bytes.len()).step_by(90) {
        bytes[at] ^= 1;
    }
    let mut reader = LogReader::new(&bytes[..]).unwrap();
    while reader.next_record().unwrap().is_some() {}
    assert!(
        reader.vain_bytes() < 200 * length,
        "{}",
        reader.vain_bytes()
    );
}

#[test]
fn a_log_has_one_writer_at_a_time() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("session.log");
    let mut first = LogWriter::create(&path).unwrap();
    first.write(&record(0)).unwrap();
    let second = LogWriter::resume(&path).err().unwrap();
    assert!(matches!(second, LogWriteError::InUse { .. }), "{second}");
    first.write(&record(1)).unwrap();
    drop(first);
    let (mut third, damage) = LogWriter::resume(&path).unwrap();
    assert_eq!(damage.torn_bytes, 0);
    third.write(&record(2)).unwrap();
    drop(third);
    let (found, damage) = read(&fs::read(&path).unwrap());
    assert_eq!(found, [0, 1, 2].map(record));
    assert_eq!(damage.damaged_places, 0);
}

/// A file system without space: `/dev/full` refuses every byte.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_named() {
    let path = std::path::Path::new("/dev/full");
    let full = fs::OpenOptions::new().write(true).open(path).unwrap();
    let error = LogWriter::over_empty(path, full).err().unwrap();
    assert_eq!(
        error.to_string(),
        "/dev/full: the disk is full; the data written before are kept"
    );
}

proptest! {
    #[test]
    fn any_bytes_are_read_without_a_panic(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        let mut log = LOG_SIGNATURE.to_vec();
        log.extend_from_slice(&bytes);
        let (records, damage) = read(&log);
        prop_assert!(records.is_empty());
        prop_assert_eq!(damage.torn_bytes, bytes.len() as u64);
    }
}
