//! The neutral NPZ file: round trips, files written by NumPy, and hostile archives.

use std::io::Cursor;

use acerra_npz::{NpyError, NpzWriter};
use acerra_radar::npz::{NpzError, read_npz, write_npz};
use acerra_radar::{
    Limits, NeutralContent, Radargram, RadargramError, SPEED_OF_LIGHT_M_S, Samples, Spectrum,
};
use num_complex::{Complex32, Complex64};
use proptest::prelude::*;

fn fixture(name: &str) -> Cursor<Vec<u8>> {
    let path = format!("{}/tests/fixtures/{name}", env!("CARGO_MANIFEST_DIR"));
    Cursor::new(std::fs::read(path).unwrap())
}

/// An archive of float64 arrays.
fn archive(arrays: &[(&str, &[u64], &[f64])]) -> Cursor<Vec<u8>> {
    let mut npz = NpzWriter::deflated(Cursor::new(Vec::new()));
    for (name, shape, values) in arrays {
        npz.array(name, shape, values.iter().copied()).unwrap();
    }
    let mut bytes = npz.finish().unwrap();
    bytes.set_position(0);
    bytes
}

fn read(bytes: Cursor<Vec<u8>>) -> Result<acerra_radar::NeutralFile, NpzError> {
    read_npz(bytes, &Limits::default())
}

#[test]
fn numpy_column_major_integers() {
    let file = read(fixture("fortran_int16.npz")).unwrap();
    let NeutralContent::Radargram(r) = file.content else {
        panic!("a radargram")
    };
    assert_eq!(
        r.samples,
        Samples::Real((0..15).map(|i| i as f32).collect())
    );
    assert_eq!((r.traces, r.samples_per_trace), (3, 5));
    assert!((r.fast_time_step_s / 61.035_156_25e-12 - 1.0).abs() < 1e-9);
    assert!((r.fast_time_start_s - 10e-9).abs() < 1e-20);
    assert_eq!(r.time_s, [0.0, 0.07, 0.14]);
    assert!(file.position_m.is_none() && file.ignored.is_empty());
}

#[test]
fn numpy_complex_with_positions_and_no_time() {
    let file = read(fixture("complex64_position.npz")).unwrap();
    assert!(file.time_missing);
    assert_eq!(file.ignored, ["note.npy"]);
    assert_eq!(file.position_m.unwrap()[1], [0.1, 0.0, 4.1]);
    let NeutralContent::Radargram(r) = file.content else {
        panic!("a radargram")
    };
    assert_eq!(r.at(2, 4), Complex64::new(14.0, 28.0));
    assert_eq!(r.time_s, [0.0, 1.0, 2.0]);
}

#[test]
fn numpy_spectrum_keeps_phase_in_double_precision() {
    let NeutralContent::Spectrum(s) = read(fixture("spectrum.npz")).unwrap().content else {
        panic!("a spectrum")
    };
    assert_eq!(s.time_s, [1.0, 2.0]);
    for (m, range_m) in [4.0, 5.0].into_iter().enumerate() {
        for (f, z) in s.frequency_hz.iter().zip(s.trace(m)) {
            let phase = -4.0 * std::f64::consts::PI * f * range_m / SPEED_OF_LIGHT_M_S;
            assert!((z - Complex64::from_polar(1.0, phase)).norm() < 1e-12);
        }
    }
}

#[test]
fn missing_and_ambiguous_arrays() {
    let t: (&str, &[u64], &[f64]) = ("time_s", &[1], &[0.0]);
    let data: (&str, &[u64], &[f64]) = ("data", &[1, 2], &[1.0, 2.0]);
    let axis: (&str, &[u64], &[f64]) = ("fast_time_s", &[2], &[0.0, 1.0]);
    for (arrays, gone) in [
        (vec![t, axis], "data"),
        (vec![data, t], "fast_time_s"),
        (vec![data, axis], "time_s"),
        (
            vec![("spectrum", &[1u64, 2][..], &[1.0, 2.0][..]), t],
            "frequency_hz",
        ),
    ] {
        match read(archive(&arrays)) {
            Err(NpzError::Missing { array, .. }) => assert_eq!(array, gone),
            other => panic!("{gone}: {other:?}"),
        }
    }
    let both = archive(&[data, axis, t, ("spectrum", &[1, 2], &[1.0, 2.0])]);
    assert!(matches!(read(both), Err(NpzError::Ambiguous)));
}

#[test]
fn uneven_axis_and_stray_nan_are_named() {
    let data: (&str, &[u64], &[f64]) = ("data", &[1, 4], &[1.0; 4]);
    let time: (&str, &[u64], &[f64]) = ("time_s", &[1], &[0.0]);
    let uneven = archive(&[data, ("fast_time_s", &[4], &[0.0, 1.0, 2.1, 3.0]), time]);
    match read(uneven) {
        Err(NpzError::UnevenFastTime { index: 2, .. }) => {}
        other => panic!("{other:?}"),
    }
    let falling = archive(&[data, ("fast_time_s", &[4], &[3.0, 2.0, 1.0, 0.0]), time]);
    assert!(matches!(
        read(falling),
        Err(NpzError::Radargram(RadargramError::Step { .. }))
    ));
    let nan = archive(&[
        ("data", &[2, 2], &[1.0, 2.0, f64::NAN, 3.0]),
        ("fast_time_s", &[2], &[0.0, 1.0]),
        ("time_s", &[2], &[0.0, 1.0]),
    ]);
    match read(nan) {
        Err(e @ NpzError::NotFinite { .. }) => {
            assert_eq!(
                e.to_string(),
                "array `data`: value at [1, 0] is not a finite number"
            );
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn wrong_shapes_are_named() {
    let axis: (&str, &[u64], &[f64]) = ("fast_time_s", &[2], &[0.0, 1.0]);
    let shape_error = |bytes, name: &str| match read(bytes) {
        Err(NpzError::Array {
            array,
            source: NpyError::Shape { .. },
        }) => assert_eq!(array, name),
        other => panic!("{name}: {other:?}"),
    };
    shape_error(
        archive(&[("data", &[4], &[1.0; 4]), axis, ("time_s", &[1], &[0.0])]),
        "data",
    );
    shape_error(
        archive(&[
            ("data", &[1, 2], &[1.0; 2]),
            axis,
            ("time_s", &[3], &[0.0; 3]),
        ]),
        "time_s",
    );
    shape_error(
        archive(&[
            ("data", &[1, 2], &[1.0; 2]),
            axis,
            ("time_s", &[1], &[0.0]),
            ("position_m", &[3], &[0.0; 3]),
        ]),
        "position_m",
    );
}

#[test]
fn a_zip_bomb_stops_at_the_limit() {
    // 800 thousand zeros deflate to a few kilobytes.
    let zeros = vec![0.0; 800_000];
    let bytes = archive(&[
        ("data", &[2, 400_000], &zeros),
        ("fast_time_s", &[1], &[0.0]),
        ("time_s", &[2], &[0.0; 2]),
    ]);
    let limits = Limits::default().with_max_samples(100_000);
    match read_npz(bytes, &limits) {
        Err(NpzError::Array {
            array: "data",
            source: NpyError::Limit { claimed, limit },
        }) => {
            assert_eq!((claimed, limit), (800_000, 100_000));
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn every_cut_and_every_flipped_byte_is_an_error_or_the_same_data() {
    let whole = fixture("spectrum.npz").into_inner();
    let good = read(Cursor::new(whole.clone())).unwrap();
    for end in 0..whole.len() {
        assert!(
            read(Cursor::new(whole[..end].to_vec())).is_err(),
            "cut at {end}"
        );
    }
    for at in 0..whole.len() {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x41;
        if let Ok(file) = read(Cursor::new(bytes)) {
            assert_eq!(file.content, good.content, "byte {at}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn real_and_complex_round_trip(
        traces in 1usize..6,
        samples in 2usize..9,
        start in -1e-6..1e-6f64,
        step in 1e-12..1e-9f64,
        seed in any::<u32>(),
        complex in any::<bool>(),
    ) {
        let value = |i: usize| (i as f32 + 1.0) * (seed as f32 + 0.5);
        let n = traces * samples;
        let samples = if complex {
            Samples::Complex((0..n).map(|i| Complex32::new(value(i), -value(n - i))).collect())
        } else {
            Samples::Real((0..n).map(value).collect())
        };
        let radargram =
            Radargram::new((0..traces).map(|i| i as f64 * 0.07).collect(), start, step, samples)
                .unwrap();
        let position: Vec<[f64; 3]> = (0..traces).map(|i| [i as f64, -0.5, 4.0]).collect();
        let mut bytes = Cursor::new(Vec::new());
        let content = NeutralContent::Radargram(radargram.clone());
        write_npz(&mut bytes, &content, Some(&position)).unwrap();
        let file = read(bytes).unwrap();
        let NeutralContent::Radargram(back) = file.content else { panic!() };
        prop_assert_eq!(back.samples, radargram.samples);
        prop_assert_eq!(back.time_s, radargram.time_s);
        prop_assert_eq!(file.position_m.unwrap(), position);
        prop_assert!((back.fast_time_start_s - start).abs() < 1e-20);
        prop_assert!((back.fast_time_step_s / step - 1.0).abs() < 1e-6);
    }

    #[test]
    fn spectra_round_trip_exactly(traces in 1usize..5, n in 1usize..7, seed in any::<u64>()) {
        let spectrum = Spectrum::new(
            (0..n).map(|i| 3.1e9 + i as f64 * 5e6).collect(),
            (0..traces * n).map(|i| Complex64::new(i as f64 / 3.0, seed as f64)).collect(),
            vec![0.25; traces],
        )
        .unwrap();
        let mut bytes = Cursor::new(Vec::new());
        let content = NeutralContent::Spectrum(spectrum);
        write_npz(&mut bytes, &content, None).unwrap();
        prop_assert_eq!(read(bytes).unwrap().content, content);
    }
}
