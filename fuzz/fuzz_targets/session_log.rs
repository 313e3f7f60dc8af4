//! Any bytes behind the signature of a session log: every byte is of a record, damaged or torn, and
//! what is read can be written and read again.
#![no_main]

use acerra_record::log::{LOG_SIGNATURE, LogReader, Record};
use libfuzzer_sys::fuzz_target;

fn read(bytes: &[u8]) -> (Vec<Record>, u64) {
    let mut reader = LogReader::new(bytes).expect("the signature is there");
    let mut records = Vec::new();
    while let Some(record) = reader.next_record().expect("memory does not fail") {
        records.push(record);
    }
    let damage = reader.damage();
    (records, damage.damaged_bytes + damage.torn_bytes)
}

fuzz_target!(|data: &[u8]| {
    let log = [&LOG_SIGNATURE[..], data].concat();
    let (records, unread) = read(&log);
    let written: Vec<u8> = records
        .iter()
        .flat_map(|record| record.encode().expect("a record that was read"))
        .collect();
    let reserved = written.len() as u64 + unread == data.len() as u64;
    assert!(reserved, "every byte is accounted for");
    let again = [&LOG_SIGNATURE[..], &written].concat();
    assert_eq!(read(&again), (records, 0));
});
