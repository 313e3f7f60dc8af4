//! Any bytes as the text of a kernel's pulse stamp: what is read is written as the same time and number, and
//! nothing longer than a stamp is read.
#![no_main]

use acerra_record::pps::{MAX_STAMP_BYTES, PulseStamp};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    if let Ok(stamp) = PulseStamp::parse(data) {
        assert!(data.len() <= MAX_STAMP_BYTES);
        assert_eq!(PulseStamp::parse(stamp.to_string().as_bytes()), Ok(stamp));
    }
});
