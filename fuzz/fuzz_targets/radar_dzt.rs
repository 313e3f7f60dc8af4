//! Any bytes as DZT with a DZG and a DZX: a recording or an error, in bounded memory.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut limits = acerra_formats::Limits::default();
    limits.max_samples = 1 << 18;
    limits.max_trace_samples = 1 << 14;
    limits.max_file_bytes = 1 << 24;
    let text = String::from_utf8_lossy(bytes);
    let _ = acerra_formats::dzt::read_dzt(bytes, bytes.len() as u64, [Some(&text), Some(&text)], &limits);
});
