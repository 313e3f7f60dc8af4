//! Neutral NPZ files: no panic, and what is read is valid and can be written and read again.
#![no_main]

use std::io::Cursor;

use acerra_radar::npz::{read_npz, write_npz};
use acerra_radar::{Limits, NeutralContent};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let mut limits = Limits::default();
    limits.max_samples = 1 << 16;
    let Ok(file) = read_npz(Cursor::new(data), &limits) else { return };
    match &file.content {
        NeutralContent::Radargram(r) => assert!(r.validate().is_ok()),
        NeutralContent::Spectrum(s) => assert!(s.validate().is_ok()),
    }
    let mut bytes = Cursor::new(Vec::new());
    write_npz(&mut bytes, &file.content, file.position_m.as_deref()).expect("valid content");
    let again = read_npz(bytes, &limits).expect("what was written can be read");
    assert_eq!(again.position_m, file.position_m);
    assert_eq!(again.content.time_s(), file.content.time_s());
});
