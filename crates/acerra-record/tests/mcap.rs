//! A session as an MCAP file: everything of the log is in it, in what order tools expect it, and damage is told.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use acerra_gnss::ubx::frame::encode;
use acerra_radar::Filtering;
use acerra_radar::mrm::{SAMPLES_PER_MESSAGE, ScanHeader};
use acerra_record::log::{LogWriter, Record, RecordKind};
use acerra_record::mcap::{McapError, McapReader, acerra_topics};
use acerra_record::message::{Message, Packet, ScanMessage};
use acerra_record::session::{LOG_NAME, MCAP_NAME, write_mcap};

/// When the session begins (s since 1970).
const BEGUN_S: f64 = 1_571_133_000.25;

fn scan_messages(id: u16) -> Vec<Vec<u8>> {
    let samples: Vec<i32> = (0..700).map(|k| k * i32::from(id) - 5000).collect();
    let parts = samples.chunks(SAMPLES_PER_MESSAGE);
    let messages_total = parts.len() as u16;
    (0_u16..)
        .zip(parts)
        .map(|(message_index, part)| {
            let mut slots = [0; SAMPLES_PER_MESSAGE];
            slots[..part.len()].copy_from_slice(part);
            let header = ScanHeader {
                message_id: id,
                source_id: 100,
                timestamp_ms: 1000 + 50 * u32::from(id),
                reserved: [0; 4],
                scan_start_ps: 5000,
                scan_stop_ps: 47_700,
                scan_step_bins: 32,
                filtering: Filtering::Raw,
                reserved_byte: 0,
                antenna_id: 0,
                operation_mode: 1,
                samples_in_message: part.len() as u16,
                samples_total: samples.len() as u32,
                message_index,
                messages_total,
            };
            let message = Message::ScanInfo(Box::new(ScanMessage { header, slots }));
            Packet { id, message }.encode()
        })
        .collect()
}

/// RXM-RAWX without satellites at a time of week 2075.
fn epoch(tow_s: f64) -> Vec<u8> {
    let mut payload = [0; 16];
    payload[..8].copy_from_slice(&tow_s.to_le_bytes());
    payload[8..10].copy_from_slice(&2075_u16.to_le_bytes());
    payload[13] = 1;
    encode(2, 0x15, &payload).unwrap()
}

/// A session of 300 scans with a repeated and a lost message.
fn records() -> Vec<Record> {
    let mut records = Vec::new();
    let mut put = |kind, at_ns, payload: Vec<u8>| {
        records.push(Record {
            kind,
            at_ns,
            payload,
        });
    };
    let settings =
        format!("# begun at {BEGUN_S:.3} s since 1970\n[radio]\naddress = \"127.0.0.1:1\"\n");
    put(RecordKind::Settings, 1000, settings.into_bytes());
    put(RecordKind::RadioConfig, 2000, vec![7; 32]);
    for id in 0..300_u16 {
        let at_ns = 20_000_000 * (u64::from(id) + 1);
        for (k, message) in scan_messages(id).into_iter().enumerate() {
            if (id, k) == (50, 1) {
                continue;
            }
            if id == 60 {
                put(RecordKind::Radio, at_ns + k as u64, message.clone());
            }
            put(RecordKind::Radio, at_ns + k as u64, message);
        }
        if id % 5 == 0 {
            put(
                RecordKind::Gnss,
                at_ns + 10,
                epoch(207_000.0 + 0.02 * f64::from(id)),
            );
        }
    }
    put(
        RecordKind::Note,
        7_000_000_000,
        b"the radio scans again".to_vec(),
    );
    let pulse = b"1571133005.000000042#7".to_vec();
    put(RecordKind::Pulse, 4_750_000_000, pulse);
    put(RecordKind::Other(99), 7_000_000_001, vec![1]);
    put(RecordKind::End, 7_100_000_000, b"{}".to_vec());
    records
}

fn written(directory: &Path) -> Vec<u8> {
    let mut log = LogWriter::create(&directory.join(LOG_NAME)).unwrap();
    records()
        .iter()
        .for_each(|record| log.write(record).unwrap());
    log.sync().unwrap();
    fs::write(directory.join("radar.clock.json"), "{\"rate\": 1.0}").unwrap();
    let messages = write_mcap(directory).unwrap();
    let bytes = fs::read(directory.join(MCAP_NAME)).unwrap();
    let read = McapReader::new(&bytes[..]).unwrap();
    assert_eq!(all(read).unwrap().1.len() as u64, messages);
    bytes
}

type Messages = Vec<(String, u64, Vec<u8>)>;

fn all(mut reader: McapReader<&[u8]>) -> Result<(McapReader<&[u8]>, Messages), McapError> {
    let mut messages = Vec::new();
    while let Some(message) = reader.next_message()? {
        messages.push((message.topic, message.log_ns, message.data));
    }
    Ok((reader, messages))
}

/// A little-endian number in a message.
fn number<const N: usize>(data: &[u8], at: usize) -> [u8; N] {
    data[at..at + N].try_into().unwrap()
}

#[test]
fn a_session_is_in_its_mcap_file_byte_for_byte() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = written(folder.path());
    let (reader, messages) = all(McapReader::new(&bytes[..]).unwrap()).unwrap();
    assert!(reader.is_whole() && reader.library().starts_with("acerra "));
    let of = |topic: &str| -> Vec<&(String, u64, Vec<u8>)> {
        messages.iter().filter(|(name, ..)| name == topic).collect()
    };
    // Header of the representation, the host's clock, the number of bytes.
    let unwrapped = |data: &[u8]| {
        let length = u32::from_le_bytes(number(data, 12)) as usize;
        assert_eq!(data.len(), 16 + length);
        (u64::from_le_bytes(number(data, 4)), data[16..].to_vec())
    };
    let began_ns = 1_571_133_000_250_000_000;
    for (kind, topic) in [
        (RecordKind::Radio, "/radar/message"),
        (RecordKind::RadioConfig, "/radar/configuration"),
        (RecordKind::Gnss, "/gnss/bytes"),
    ] {
        let records = records();
        let logged: Vec<&Record> = records.iter().filter(|r| r.kind == kind).collect();
        let found = of(topic);
        assert_eq!(found.len(), logged.len(), "{topic}");
        for ((_, log_ns, data), record) in found.into_iter().zip(logged) {
            assert_eq!(unwrapped(data), (record.at_ns, record.payload.clone()));
            assert_eq!(*log_ns, began_ns + record.at_ns);
        }
    }
    let scans = of("/radar/scan");
    assert_eq!(scans.len(), 299, "one lost a message, none comes twice");
    let (_, _, scan) = scans[3];
    assert_eq!(u16::from_le_bytes(number(scan, 12)), 3);
    assert_eq!(u32::from_le_bytes(number(scan, 16)), 1150);
    assert_eq!(i32::from_le_bytes(number(scan, 20)), 5000);
    assert_eq!(u16::from_le_bytes(number(scan, 28)), 32);
    assert_eq!(u32::from_le_bytes(number(scan, 32)), 700);
    assert_eq!(
        i32::from_le_bytes(number(scan, 36 + 4 * 699)),
        699 * 3 - 5000
    );
    let (_, _, epoch) = of("/clock/epoch")[1];
    assert_eq!(i64::from_le_bytes(number(epoch, 12)), 2075);
    assert!((f64::from_le_bytes(number(epoch, 20)) - 207_000.1).abs() < 1e-6);
    let (_, _, pulse) = of("/clock/pulse")[0];
    assert_eq!(u64::from_le_bytes(number(pulse, 4)), 4_750_000_000);
    assert_eq!(u64::from_le_bytes(number(pulse, 12)), 1_571_133_005);
    assert_eq!(u32::from_le_bytes(number(pulse, 20)), 42);
    assert_eq!(u32::from_le_bytes(number(pulse, 24)), 7);
    let told = |topic: &str| {
        let (_, text) = unwrapped(&of(topic)[0].2);
        String::from_utf8(text).unwrap()
    };
    assert_eq!(told("/session/note"), "the radio scans again\0");
    assert!(told("/session/settings").contains("127.0.0.1:1"));
    assert_eq!(told("/clock/fit"), "{\"rate\": 1.0}\0");
    assert_eq!(of("/session/end").len(), 1);
    assert_eq!(messages.len(), 601 + 299 + 60 + 60 + 6, "nothing else");
}

#[test]
fn the_summary_leads_to_the_chunks_and_counts_the_messages() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = written(folder.path());
    let u64_at = |at: usize| u64::from_le_bytes(number(&bytes, at)) as usize;
    // Footer: kind, length, start of the summary, start of its offsets, checksum; then the mark.
    let footer = bytes.len() - 8 - 29;
    assert_eq!(bytes[footer], 0x02);
    let mut at = u64_at(footer + 9);
    let (mut counts, mut chunks, mut total) = (BTreeMap::new(), 0, 0);
    while at < footer {
        let (kind, length) = (bytes[at], u64_at(at + 1));
        let content = at + 9;
        if kind == 0x0b {
            total = u64_at(content);
            let entries = content + 46;
            for k in 0..acerra_topics().len() {
                let entry = entries + 10 * k;
                let id = u16::from_le_bytes(number(&bytes, entry));
                counts.insert(id, u64_at(entry + 2));
            }
        }
        if kind == 0x08 {
            chunks += 1;
            let [start_ns, end_ns, offset, chunk_bytes] =
                [0, 8, 16, 24].map(|k| u64_at(content + k));
            assert!(start_ns <= end_ns);
            assert_eq!((bytes[offset], u64_at(offset + 1) + 9), (0x06, chunk_bytes));
            // The messages that the chunk's indices lead to are those of their topics.
            let index = offset + chunk_bytes;
            assert_eq!(bytes[index], 0x07);
            let topic = u16::from_le_bytes(number(&bytes, index + 9));
            let (log_ns, place) = (u64_at(index + 15), u64_at(index + 23));
            let message = offset + 9 + 8 * 3 + 4 + 4 + 8 + place;
            assert_eq!(bytes[message], 0x05);
            assert_eq!(u16::from_le_bytes(number(&bytes, message + 9)), topic);
            assert_eq!(u64_at(message + 15), log_ns);
        }
        at = content + length;
    }
    assert!(chunks >= 2, "{chunks} chunks");
    assert_eq!(counts.values().sum::<usize>(), total);
    assert_eq!(counts[&2], 299);
}

#[test]
fn cut_off_and_damaged_files_are_told_and_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = written(folder.path());
    for cut in (0..bytes.len()).step_by(50_021).chain(0..40) {
        let Ok(reader) = McapReader::new(&bytes[..cut]) else {
            assert!(cut < 8);
            continue;
        };
        match all(reader) {
            Ok((reader, _)) => assert!(!reader.is_whole(), "{cut}"),
            Err(McapError::Length { .. }) => {}
            Err(other) => panic!("{cut}: {other}"),
        }
    }
    let mut damaged = bytes.clone();
    let middle = bytes.len() / 2;
    damaged[middle] ^= 0x10;
    let told = all(McapReader::new(&damaged[..]).unwrap()).err().unwrap();
    assert!(told.to_string().contains("checksum"), "{told}");
    let huge = [&bytes[..8], &[0x06], &u64::MAX.to_le_bytes()[..]].concat();
    assert!(matches!(
        all(McapReader::new(&huge[..]).unwrap()),
        Err(McapError::Length { .. })
    ));
    assert!(matches!(
        McapReader::new(&b"ACERLOG\x01"[..]),
        Err(McapError::Magic { .. })
    ));
}
