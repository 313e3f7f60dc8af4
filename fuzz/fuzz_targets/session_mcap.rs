//! Any bytes behind the mark of an MCAP file: no panic, and no more messages than the bytes hold.
#![no_main]

use acerra_record::mcap::{MAGIC, McapReader};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let file = [&MAGIC[..], data].concat();
    let mut reader = McapReader::new(&file[..]).expect("the mark is there");
    let (mut messages, mut bytes) = (0, 0);
    while let Ok(Some(message)) = reader.next_message() {
        messages += 1;
        bytes += message.data.len();
    }
    assert!(31 * messages + bytes <= data.len());
    let counted: u64 = reader.topics().map(|topic| topic.messages).sum();
    assert_eq!(counted, messages as u64);
});
