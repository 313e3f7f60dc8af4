//! `acerra convert` of radar logs: every sample comes back.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "tests")]

use std::fs;
use std::path::Path;

use acerra_formats::{Axis, Channel, Limits, Positions, Values, open};
use assert_cmd::Command;

fn acerra(folder: &Path, args: &[&str]) -> (bool, String) {
    let output = Command::cargo_bin("acerra")
        .unwrap()
        .current_dir(folder)
        .args(args)
        .output()
        .unwrap();
    let all = [output.stdout, output.stderr].concat();
    (
        output.status.success(),
        String::from_utf8_lossy(&all).into_owned(),
    )
}

fn channel(path: &Path) -> Channel {
    let read = open(path, &Limits::default()).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    read.channels[0].clone()
}

/// A line of 7 traces of 40 samples, 3.8517 ps apart.
fn write_rd3(folder: &Path) {
    let samples = (0..7 * 40_i16).flat_map(|i| (i.wrapping_mul(4099)).to_le_bytes());
    fs::write(folder.join("line.rd3"), samples.collect::<Vec<u8>>()).unwrap();
    let step_s: f64 = 3.8517e-12;
    let header = format!(
        "SAMPLES:40\r\nFREQUENCY:{:.8}\r\nLAST TRACE:7\r\nDISTANCE FLAG:1\r\nDISTANCE INTERVAL:0.0100\r\n\
         TIMEWINDOW:{:.8}\r\nANTENNA SEPARATION:0.0590\r\nCHANNELS:1\r\n",
        1e-6 / step_s,
        40.0 * step_s * 1e9
    );
    fs::write(folder.join("line.rad"), header).unwrap();
}

fn axis(channel: &Channel) -> [f64; 2] {
    match channel.axis {
        Axis::FastTime {
            start_s, step_s, ..
        } => [start_s, step_s],
        Axis::Frequency(_) => panic!("spectra"),
    }
}

#[test]
fn a_foreign_log_becomes_segy_and_hdf5_with_every_sample() {
    let folder = tempfile::tempdir().unwrap();
    write_rd3(folder.path());
    let (done, said) = acerra(
        folder.path(),
        &["convert", "line.rd3", "--formats", "segy,hdf5"],
    );
    assert!(done, "{said}");
    assert!(said.contains("line.sgy: 7 traces of 40 samples"), "{said}");
    let original = channel(&folder.path().join("line.rd3"));
    for name in ["line.sgy", "line.h5"] {
        let back = channel(&folder.path().join(name));
        assert_eq!(back.values, original.values, "{name}");
        for (found, expected) in axis(&back).into_iter().zip(axis(&original)) {
            assert!((found - expected).abs() <= 1e-14 * expected.abs(), "{name}");
        }
    }
    let back = channel(&folder.path().join("line.h5"));
    assert_eq!(back.along_m, original.along_m);
    assert_eq!(back.antenna_separation_m, Some(0.059));
    // What is there already is kept.
    let before = fs::read(folder.path().join("line.sgy")).unwrap();
    let (done, said) = acerra(folder.path(), &["convert", "line.rd3", "--formats", "segy"]);
    assert!(
        !done && said.contains("line.sgy: is there already"),
        "{said}"
    );
    assert_eq!(fs::read(folder.path().join("line.sgy")).unwrap(), before);
    // Nothing lies beside the files.
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 4);
    let (done, said) = acerra(folder.path(), &["convert", "line.rd3", "--formats", "vtk"]);
    assert!(!done && said.contains("segy or hdf5"), "{said}");
}

#[test]
fn a_campaign_becomes_its_cleaned_traces_at_their_places() {
    let folder = tempfile::tempdir().unwrap();
    write_rd3(folder.path());
    let campaign = "[radar]\nfile = 'line.rd3'\nline_start_m = [1, 2, 0.5]\nline_end_m = [1.06, 2, 0.5]\ndelay_ns = 0\n\
                    [preprocess]\ngate_ns = 'none'\n[image]\nx_m = [1, 1.1]\ny_m = [2, 2.1]\nz_m = 0\npixel_m = 0.05\n\
                    band_ghz = [5, 20]\nfrequencies = 3\n";
    fs::write(folder.path().join("line.toml"), campaign).unwrap();
    let (done, said) = acerra(
        folder.path(),
        &["convert", "line.toml", "--formats", "segy,hdf5"],
    );
    assert!(done, "{said}");
    let Values::Real(raw) = channel(&folder.path().join("line.rd3")).values else {
        panic!("complex")
    };
    let mean = |sample: usize| (0..7).map(|t| raw[40 * t + sample]).sum::<f32>() / 7.0;
    for name in ["line-cleaned.sgy", "line-cleaned.h5"] {
        let back = channel(&folder.path().join(name));
        let Values::Real(values) = &back.values else {
            panic!("complex")
        };
        for (i, value) in values.iter().enumerate() {
            assert!((value - (raw[i] - mean(i % 40))).abs() < 0.02, "{name} {i}");
        }
        let Some(Positions::Local(places)) = &back.positions else {
            panic!("{name}: {:?}", back.positions)
        };
        // SEG-Y keeps each antenna to a millimetre.
        assert!((places[2][0] - 1.02).abs() < 1.1e-3 && (places[2][2] - 0.5).abs() < 1e-6);
        let antennas_m = back.antennas_m.as_ref().unwrap();
        assert!((antennas_m[0][2][0] - antennas_m[1][2][0] - 0.059).abs() < 1.1e-3);
    }
}

#[test]
fn spectra_become_hdf5_and_no_segy() {
    let folder = tempfile::tempdir().unwrap();
    let text = "# Hz S RI R 50\n1000000000 0.5 -0.25\n1100000000 0.25 0.125\n1200000000 -1 0\n";
    fs::write(folder.path().join("sweep.s1p"), text).unwrap();
    let (done, said) = acerra(
        folder.path(),
        &["convert", "sweep.s1p", "--formats", "hdf5"],
    );
    assert!(done, "{said}");
    let [original, back] = ["sweep.s1p", "sweep.h5"].map(|n| channel(&folder.path().join(n)));
    assert_eq!(back.values, original.values);
    assert_eq!(back.axis, original.axis);
    let (done, said) = acerra(
        folder.path(),
        &["convert", "sweep.s1p", "--formats", "segy", "-o", "other"],
    );
    assert!(!done && said.contains("SEG-Y holds real samples"), "{said}");
}

/// Real logs, where they are at hand.
#[test]
fn real_logs_come_back_sample_by_sample() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    for name in [
        "gpr-samples/grid-line-001.dzt",
        "gpr-samples/warr.dt1",
        "gpr-iwagpr2017/buried_objects_xdir_bscan_1.rd3",
    ] {
        let path = data.join(name);
        if !path.is_file() {
            println!("skipped: {} is not at hand", path.display());
            continue;
        }
        let folder = tempfile::tempdir().unwrap();
        let file = path.display().to_string();
        let (done, said) = acerra(
            folder.path(),
            &["convert", &file, "--formats", "segy,hdf5", "-o", "."],
        );
        assert!(done, "{said}");
        let original = channel(&path);
        for end in ["sgy", "h5"] {
            let name = path.with_extension(end);
            let back = channel(&folder.path().join(name.file_name().unwrap()));
            assert!(back.values == original.values, "{name:?}");
            let [found, expected] = [axis(&back)[1], axis(&original)[1]];
            assert!((found - expected).abs() <= 1e-14 * expected, "{name:?}");
        }
    }
}
