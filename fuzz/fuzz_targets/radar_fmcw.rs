//! Any bytes as FMCW settings with raw samples, and NPZ: a recording or an error, in bounded memory.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut limits = acerra_formats::Limits::default();
    limits.max_samples = 1 << 18;
    limits.max_trace_samples = 1 << 14;
    limits.max_file_bytes = 1 << 24;
    use acerra_formats::fmcw::{FmcwSettings, read_beat_npz, read_dca1000};
    let _ = read_beat_npz(std::io::Cursor::new(bytes), &limits);
    if let Ok(settings) = FmcwSettings::parse(&String::from_utf8_lossy(bytes)) {
        let _ = read_dca1000(bytes, bytes.len() as u64, &settings, &limits);
    }
});
