//! Any bytes as rd3 and rd7 with a rad and a cor, apart at the first NUL: a recording or an error, in bounded memory.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut limits = acerra_formats::Limits::default();
    limits.max_samples = 1 << 18;
    limits.max_trace_samples = 1 << 14;
    limits.max_file_bytes = 1 << 24;
    use acerra_formats::mala::{NamedAs, read_mala};
    let cut = bytes.iter().position(|b| *b == 0).unwrap_or(bytes.len());
    let (text, data) = bytes.split_at(cut);
    let text = String::from_utf8_lossy(text);
    for named in [NamedAs::Short, NamedAs::Long] {
        let _ = read_mala(data, data.len() as u64, named, &text, Some(&text), &limits);
    }
});
