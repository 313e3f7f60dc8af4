//! Any text as surveyed points: finite places or an error that names a line.
#![no_main]

use acerra_chain::calibrate::read_points;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let Ok(points) = read_points(text) else {
        return;
    };
    assert!(!points.is_empty() && points.len() <= 10_000);
    assert!(
        points
            .iter()
            .flat_map(|point| point.position_m)
            .all(f64::is_finite)
    );
});
