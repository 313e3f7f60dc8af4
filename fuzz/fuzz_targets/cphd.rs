//! Any bytes as phase history data: no panic, and what is read is finite and can be written again.
#![no_main]

use std::io::Cursor;

use acerra_cphd::{ReadOptions, Scene, read_cphd, write_cphd};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let options = ReadOptions::default().with_max_samples(1 << 16);
    let Ok(file) = read_cphd(Cursor::new(data), &options) else {
        return;
    };
    let channel = &file.history.channels[0];
    let pulses = channel.time_s.len();
    assert_eq!(channel.position_m.len(), pulses);
    assert_eq!(channel.spectrum.len(), pulses * channel.frequency.count);
    assert!(channel.spectrum.iter().all(|z| z.re.is_finite() && z.im.is_finite()));
    assert!(channel.position_m.as_flattened().iter().all(|v| v.is_finite()));
    assert!(channel.time_s.windows(2).all(|w| w[0] < w[1]));
    let scene = Scene { middle_m: [0.0; 3], pixel_m: 0.1, nx: 10, ny: 10 };
    // A platform at rest has no geometry; whatever is written is a file.
    let mut bytes = Cursor::new(Vec::new());
    if write_cphd(&mut bytes, &file.history, &scene).is_ok() {
        bytes.set_position(0);
        let _ = read_cphd(bytes, &options);
    }
});
