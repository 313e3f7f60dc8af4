//! Any bytes as a geoid grid: heights within bounds or an error.
#![no_main]

use acerra_geo::geoid::GeoidGrid;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Ok(grid) = GeoidGrid::from_reader(bytes) else {
        return;
    };
    for (latitude, longitude) in [(0.0, 0.0), (89.9, -179.9), (-45.3, 359.99), (90.0, 180.0)] {
        if let Some(height_m) = grid.height_m(latitude, longitude) {
            assert!(height_m.abs() <= 150.0);
        }
    }
});
