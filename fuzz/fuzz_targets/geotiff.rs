//! Any bytes as a terrain raster: an answer or an error, in bounded memory.
#![no_main]

use std::io::Cursor;

use acerra_geo::geodesy::{EnuFrame, Geodetic};
use acerra_geo::terrain::{TerrainFile, TerrainOptions};
use acerra_geo::trajectory::Frame;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    // What does not begin as a TIFF belongs to the target `xyz`.
    let mut file = bytes.to_vec();
    if !(file.starts_with(b"II") || file.starts_with(b"MM")) {
        file.splice(0..0, *b"II*\0");
    }
    let mut options = TerrainOptions::default();
    options.max_cells = 1 << 20;
    let Ok(file) = TerrainFile::open(Cursor::new(file), &options) else {
        return;
    };
    let enu = EnuFrame::new(Geodetic::from_degrees(41.0, 14.2, 60.0));
    if let Ok(terrain) = file.in_frame(&Frame::Enu(enu), [-12.0, 16.0], [-13.0, 9.0]) {
        if let Ok(height_m) = terrain.height_m(0.3, -0.2) {
            assert!(height_m.is_finite());
        }
    }
});
