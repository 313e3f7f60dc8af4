//! Any bytes as Hatanaka-compressed lines: they expand to something bounded, or an error.
#![no_main]

use acerra_gnss::crinex::CrinexLines;
use acerra_gnss::input::{Limits, LineSource, Lines};
use acerra_gnss::read_observations;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = read_observations(bytes, Limits::default());
    let Ok(mut lines) = CrinexLines::new(Lines::new(bytes, Limits::default())) else { return };
    let mut last = 0;
    while let Ok(true) = lines.advance() {
        assert!(lines.number() >= last);
        last = lines.number();
    }
});
