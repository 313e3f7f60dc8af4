//! Any bytes as a text grid: an answer or an error, in bounded memory.
#![no_main]

use std::io::Cursor;

use acerra_geo::terrain::{TerrainFile, TerrainOptions};
use acerra_geo::trajectory::Frame;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if bytes.starts_with(b"II") || bytes.starts_with(b"MM") {
        return;
    }
    let mut options = TerrainOptions::default();
    options.max_cells = 1 << 20;
    let Ok(file) = TerrainFile::open(Cursor::new(bytes), &options) else {
        return;
    };
    let [columns, rows] = file.size();
    assert!(columns > 0 && rows > 0 && columns * rows <= 1 << 20);
    if let Ok(terrain) = file.in_frame(&Frame::Local, [0.0, 1.0], [0.0, 1.0]) {
        if let Ok(height_m) = terrain.height_m(0.3, 0.9) {
            assert!(height_m.is_finite());
        }
    }
});
