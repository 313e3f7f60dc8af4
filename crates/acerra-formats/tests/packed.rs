//! Packed files that unpack to far more than they hold are refused before memory is taken.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use std::io::Write;

use acerra_formats::{Limits, hdf5, matlab5};
use flate2::Compression;
use flate2::write::ZlibEncoder;

/// Samples that a small file may hold.
const MOST: usize = 1 << 23;

fn element(kind: u32, data: &[u8]) -> Vec<u8> {
    let length = u32::try_from(data.len()).unwrap();
    let mut out = [kind.to_le_bytes(), length.to_le_bytes()].concat();
    out.extend(data);
    out.resize(out.len().next_multiple_of(8), 0);
    out
}

/// A MATLAB file with packed arrays of zeros, one byte each, of a name and a number of columns of 1024.
fn matlab(arrays: &[(&str, usize)]) -> Vec<u8> {
    let mut file = b"MATLAB 5.0 MAT-file".to_vec();
    file.resize(124, b' ');
    file.extend([0x00, 0x01]);
    file.extend(b"IM");
    for (name, columns) in arrays {
        let sides = [1024, i32::try_from(*columns).unwrap()].map(i32::to_le_bytes);
        let matrix = [
            element(6, &[6, 0, 0, 0, 0, 0, 0, 0]),
            element(5, &sides.concat()),
            element(1, name.as_bytes()),
            element(2, &vec![0; 1024 * columns]),
        ];
        let mut packed = ZlibEncoder::new(Vec::new(), Compression::fast());
        packed.write_all(&element(14, &matrix.concat())).unwrap();
        // Packed elements are not filled up to eight bytes.
        let packed = packed.finish().unwrap();
        let length = u32::try_from(packed.len()).unwrap();
        file.extend([15_u32, length].map(u32::to_le_bytes).concat());
        file.extend(packed);
    }
    file
}

#[test]
fn matlab_arrays_are_bounded_one_by_one_and_together() {
    let limits = Limits::default();
    let columns = MOST / 1024;
    let file = matlab(&[("data", columns - 2)]);
    assert!(file.len() < 1 << 17, "{}", file.len());
    // It is read, and lacks an axis of time at most.
    let said = matlab5::read_matlab5(&file, &limits)
        .err()
        .map(|e| e.to_string());
    assert!(
        !said.as_deref().unwrap_or("").contains("at most"),
        "{said:?}"
    );
    for arrays in [
        vec![("data", columns + 1)],
        vec![("data", columns - 2), ("other", columns - 2)],
        vec![("data", 64 * columns)],
    ] {
        let refused = matlab5::read_matlab5(&matlab(&arrays), &limits).unwrap_err();
        assert!(
            refused.to_string().contains("expected at most"),
            "{refused}"
        );
    }
}

#[test]
fn hdf5_shapes_and_chunks_are_bounded() {
    let limits = Limits::default();
    let file = |values: usize, chunk: usize| {
        let mut file = hdf5_pure::FileBuilder::new();
        file.create_dataset("data")
            .with_u8_data(&vec![0; values])
            .with_shape(&[1024, values as u64 / 1024])
            .with_chunks(&[1024, chunk as u64])
            .with_deflate(1);
        file.finish().unwrap()
    };
    let said = |values, chunk| {
        let read = hdf5::read_hdf5(file(values, chunk), &limits);
        read.err().map(|e| e.to_string()).unwrap_or_default()
    };
    assert!(
        !said(MOST - 1024, 64).contains("at most"),
        "{}",
        said(MOST - 1024, 64)
    );
    let large = said(MOST + 1024, 64);
    assert!(
        large.contains("data: expected at most 8388608 samples"),
        "{large}"
    );
}
