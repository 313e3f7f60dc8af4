//! MRM-RET logs: no panic, and what is read can be written and read again.
#![no_main]

use acerra_radar::ret::{RetWriter, read_ret};
use acerra_radar::{Limits, RadargramOptions};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let mut limits = Limits::default();
    limits.max_samples = 1 << 20;
    limits.max_line_bytes = 1 << 12;
    let Ok(log) = read_ret(data, &limits) else { return };
    if let Ok(made) = log.radargram(&RadargramOptions::default()) {
        assert!(made.radargram.validate().is_ok());
    }
    let mut writer = RetWriter::new(Vec::new()).expect("memory does not fail");
    for scan in &log.scans {
        writer.scan(scan).expect("memory does not fail");
    }
    let text = writer.finish().expect("memory does not fail");
    let again = read_ret(&text[..], &Limits::default()).expect("what was written can be read");
    assert_eq!(again.scans, log.scans);
});
