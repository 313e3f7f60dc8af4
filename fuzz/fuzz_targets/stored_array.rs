//! Any archive as a run's `image.npz`: no panic, parts read where they lie are those of the whole array, and
//! none is read beyond its end.
#![no_main]

use std::io::Cursor;

use acerra_npz::NpzReader;
use libfuzzer_sys::fuzz_target;

/// Values read of an array.
const MOST_VALUES: usize = 1 << 12;

fuzz_target!(|data: &[u8]| {
    // The first bytes tell which parts are read.
    let Some((places, archive)) = data.split_at_checked(8) else { return };
    let Ok(mut npz) = NpzReader::new(Cursor::new(archive)) else { return };
    for name in ["image", "z_m"] {
        let whole = npz.values(name, MOST_VALUES).ok();
        let Ok(mut array) = npz.stored(name) else { continue };
        let count: u64 = array.header().shape.iter().product();
        for pair in places.chunks(2) {
            let (first, wanted) = (u64::from(pair[0]), u64::from(pair[1] % 32));
            let mut part = Vec::new();
            let read = array.values(first, wanted, |re, im| part.push((re, im)));
            if read.is_err() {
                continue;
            }
            assert!(first + wanted <= count && part.len() as u64 == wanted);
            if let Some((_, values)) = &whole {
                let expected = &values[first as usize..][..part.len()];
                let same = |(a, b): (&(f64, f64), &(f64, f64))| {
                    a.0.to_bits() == b.0.to_bits() && a.1.to_bits() == b.1.to_bits()
                };
                assert!(part.iter().zip(expected).all(same));
            }
        }
        let beyond = array.values(u64::MAX - 3, 4, |_, _| ());
        assert!(beyond.is_err());
    }
});
