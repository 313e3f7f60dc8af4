//! Any bytes as SEG-Y: a recording or an error, in bounded memory.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut limits = acerra_formats::Limits::default();
    limits.max_samples = 1 << 18;
    limits.max_trace_samples = 1 << 14;
    limits.max_file_bytes = 1 << 24;
    let _ = acerra_formats::segy::read_segy(bytes, bytes.len() as u64, &limits);
});
