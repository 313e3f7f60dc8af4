//! Any bytes as an SP3, RINEX clock or ANTEX file: what comes out is finite.
#![no_main]

use acerra_gnss::antex::read_antex;
use acerra_gnss::input::{Limits, Lines};
use acerra_gnss::read_navigation;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok((navigation, _)) = read_navigation(bytes, Limits::default()) {
        let precise = navigation.precise;
        if let Some((first, last)) = precise.span() {
            let middle = first + 0.5 * last.seconds_since(first);
            for satellite in precise.satellites() {
                if let Ok(state) = precise.state_at(satellite, middle) {
                    assert!(state.position_ecef_m.iter().all(|x| x.is_finite()));
                    assert!(state.clock_s.is_finite());
                }
            }
        }
    }
    if let Ok((antex, _)) = read_antex(&mut Lines::new(bytes, Limits::default())) {
        for calibration in antex.antennas.iter().flat_map(|a| a.frequencies.values()) {
            for degrees in [0.0f64, 33.3, 90.0] {
                let range_m = calibration.range_m(4.0, degrees.to_radians());
                assert!(range_m.is_finite());
            }
        }
    }
});
