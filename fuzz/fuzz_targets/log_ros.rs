//! Any bytes as a flight log, from seeds of ros.
#![no_main]

#[path = "shared/flight_log.rs"]
mod flight_log;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| flight_log::check(data));
