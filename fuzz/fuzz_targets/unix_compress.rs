//! Any bytes as a compress (.Z) stream: decoded or refused, in bounded memory.
#![no_main]

use std::io::Read;

use acerra_gnss::input::UnixCompressed;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    decode(bytes);
    // A right header before the same bytes, so that the fuzzer need not guess it.
    let mut stream = vec![0x1F, 0x9D];
    stream.extend_from_slice(bytes);
    decode(&stream);
});

fn decode(stream: &[u8]) {
    let mut out = Vec::new();
    let _ = UnixCompressed::new(stream).take(1 << 24).read_to_end(&mut out);
    // A string is at most one byte longer than any before it.
    assert!(out.len() <= (stream.len() + 1).pow(2));
}
