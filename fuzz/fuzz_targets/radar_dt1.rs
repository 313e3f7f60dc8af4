//! Any bytes as DT1 with an HD and a GPS, apart at the first NUL: a recording or an error, in bounded memory.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut limits = acerra_formats::Limits::default();
    limits.max_samples = 1 << 18;
    limits.max_trace_samples = 1 << 14;
    limits.max_file_bytes = 1 << 24;
    let cut = bytes.iter().position(|b| *b == 0).unwrap_or(bytes.len());
    let (text, data) = bytes.split_at(cut);
    let text = String::from_utf8_lossy(text);
    let _ = acerra_formats::dt1::read_dt1(data, data.len() as u64, &text, Some(&text), &limits);
});
