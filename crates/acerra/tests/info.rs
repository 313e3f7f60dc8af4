//! `acerra info` on files of every kind, good and bad.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use std::fs;
use std::process::{Command, Output};

fn info(folder: &std::path::Path, files: &[&str]) -> (Output, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_acerra"))
        .current_dir(folder)
        .arg("info")
        .args(files)
        .output()
        .unwrap();
    let [out, told] =
        [&output.stdout, &output.stderr].map(|b| String::from_utf8_lossy(b).into_owned());
    (output, out, told)
}

#[test]
fn a_bad_file_does_not_keep_the_others_from_being_described() {
    let folder = tempfile::tempdir().unwrap();
    let grid = "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n3 4.5\n";
    fs::write(folder.path().join("ground.asc"), grid).unwrap();
    fs::write(folder.path().join("letter.txt"), "Dear all,").unwrap();
    let conf = "pos1-posmode =kinematic\nfile-rcvantfile =igs20.atx\nant1-anttype =*\n";
    fs::write(folder.path().join("flight.conf"), conf).unwrap();
    let files = ["letter.txt", "ground.asc", "absent.mrm", "flight.conf"];
    let (output, out, told) = info(folder.path(), &files);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        out.contains("ground.asc: raster of heights (ESRI ASCII grid)"),
        "{out}"
    );
    assert!(out.contains("heights                  1 … 4.5 m"), "{out}");
    assert!(out.contains("flight.conf: RTKLIB configuration"), "{out}");
    assert!(
        out.contains("line 2: file-rcvantfile = igs20.atx: no such file"),
        "{out}"
    );
    let errors: Vec<&str> = told.lines().collect();
    assert_eq!(errors.len(), 2, "{told}");
    assert!(errors[0].starts_with("acerra: letter.txt: not a kind"));
    assert!(errors[1].starts_with("acerra: absent.mrm: "));
    let (output, _, told) = info(folder.path(), &files[1..2]);
    assert!(output.status.success() && told.is_empty(), "{told}");
}

#[test]
fn a_geoid_grid_is_known() {
    let folder = tempfile::tempdir().unwrap();
    let mut gtx = Vec::new();
    for value in [34.0_f64, 138.0, 0.5, 0.25] {
        gtx.extend(value.to_be_bytes());
    }
    gtx.extend(3_i32.to_be_bytes());
    gtx.extend(4_i32.to_be_bytes());
    for k in 0..12_u8 {
        gtx.extend((38.0 + f32::from(k)).to_be_bytes());
    }
    fs::write(folder.path().join("geoid.gtx"), gtx).unwrap();
    let (_, out, told) = info(folder.path(), &["geoid.gtx"]);
    assert!(
        out.contains("latitudes                34 … 35 °"),
        "{out}{told}"
    );
    assert!(
        out.contains("longitudes               138 … 138.75 °"),
        "{out}"
    );
    assert!(out.contains("geoid above ellipsoid    38 … 49 m"), "{out}");
}

/// Names from outside are text: nothing that a terminal acts on comes through.
#[test]
fn escapes_in_names_and_files_are_shown_and_not_acted_on() {
    let folder = tempfile::tempdir().unwrap();
    let csv = "time_s,x_m,y_m,z_m,a\u{1b}[31mb\n0,0,0,5,1\n1,1,0,5,1\n2,2,0,5,1\n";
    fs::write(folder.path().join("flight.csv"), csv).unwrap();
    let (_, out, told) = info(folder.path(), &["flight.csv", "a\u{1b}]0;x\u{7}.mrm"]);
    assert!(out.contains("a\\u{1b}[31mb"), "{out}");
    assert!(told.contains("a\\u{1b}]0;x\\u{7}.mrm"), "{told}");
    assert!(!(out + &told).contains(['\u{1b}', '\u{7}']));
}
