//! Any bytes as a message of the radio and as a serial stream: what is decoded encodes to the same
//! bytes, and a stream cut anywhere yields the same messages.
#![no_main]

use acerra_record::link::Deframer;
use acerra_record::message::Packet;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    if let Ok(packet) = Packet::decode(data) {
        assert_eq!(packet.encode(), data);
    }
    let bodies = |chunk: usize| {
        let mut deframer = Deframer::default();
        let mut found = Vec::new();
        for bytes in data.chunks(chunk) {
            deframer.push(bytes);
            found.extend(std::iter::from_fn(|| deframer.next_body()));
        }
        found
    };
    assert_eq!(bodies(data.len().max(1)), bodies(7));
});
