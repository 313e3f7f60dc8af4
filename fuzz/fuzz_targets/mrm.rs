//! MRM captures: no panic, every byte accounted for, and what is read can be written and read again.
#![no_main]

use acerra_radar::mrm::{Framing, MrmReader, read_mrm, write_mrm};
use acerra_radar::{Limits, RadargramOptions, Scan};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let mut limits = Limits::default();
    limits.max_samples = 1 << 20;
    let mut reader = MrmReader::new(data, limits);
    let scans: Vec<Scan> = reader.by_ref().map(|s| s.expect("memory does not fail")).collect();
    assert_eq!(reader.report().bytes, data.len() as u64);
    assert_eq!(reader.report().whole_scans, scans.len() as u64);
    let Ok(log) = read_mrm(data, &limits) else { return };
    assert_eq!(log.scans, scans);
    if let Ok(made) = log.radargram(&RadargramOptions::default()) {
        assert!(made.radargram.validate().is_ok());
    }
    let bytes = write_mrm(Vec::new(), Framing::Serial, None, &scans).expect("whole scans");
    let again = MrmReader::new(&bytes[..], Limits::default());
    let mut distinct = scans;
    distinct.dedup();
    let again: Vec<Scan> = again.map(|s| s.expect("memory does not fail")).collect();
    assert!(again.len() <= distinct.len());
});
