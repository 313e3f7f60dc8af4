//! The fuzzers' seeds, replayed without a fuzzer; `-- --ignored` writes them again.

use std::fs;
use std::io::Cursor;
use std::path::PathBuf;

use crate::common::{scan, scans};
use acerra_radar::mrm::{Framing, MrmReader, MrmWriter, RadarConfig, write_mrm};
use acerra_radar::ret::RetWriter;
use acerra_radar::{Limits, RadarFile, RadargramOptions, read};

fn folder(target: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../../fuzz/seeds")
        .join(target)
}

fn seeds(target: &str) -> Vec<(String, Vec<u8>)> {
    let mut found: Vec<(String, Vec<u8>)> = fs::read_dir(folder(target))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .map(|path| (path.display().to_string(), fs::read(&path).unwrap()))
        .collect();
    found.sort();
    found
}

#[test]
fn every_seed_is_read_or_refused_and_cuts_of_it_too() {
    let mut readable = 0;
    for target in ["mrm", "mrm_ret", "npz"] {
        let seeds = seeds(target);
        assert!(seeds.len() >= 3, "{target} has seeds");
        for (name, bytes) in seeds {
            for end in (0..=bytes.len()).rev().step_by(1 + bytes.len() / 64) {
                let whole = end == bytes.len();
                let Ok(file) = read(Cursor::new(&bytes[..end]), &Limits::default()) else {
                    continue;
                };
                readable += usize::from(whole);
                if let RadarFile::Log(log) = &file {
                    let made = log.radargram(&RadargramOptions::default());
                    assert!(made.is_ok_and(|m| m.radargram.validate().is_ok()), "{name}");
                }
            }
            let mut reader = MrmReader::new(&bytes[..], Limits::default());
            let count = reader.by_ref().filter(Result::is_ok).count() as u64;
            assert_eq!(reader.report().whole_scans, count);
            assert_eq!(reader.report().bytes, bytes.len() as u64, "{name}");
        }
    }
    assert!(readable >= 6, "seeds lead into the readers: {readable}");
}

#[test]
#[ignore = "writes fuzz/seeds again"]
fn write_seeds() {
    let save = |target: &str, name: &str, bytes: &[u8]| {
        fs::create_dir_all(folder(target)).unwrap();
        fs::write(folder(target).join(name), bytes).unwrap();
    };
    let config = RadarConfig::default();
    let mrm = |framing, config, scans: &[_]| write_mrm(Vec::new(), framing, config, scans).unwrap();
    save(
        "mrm",
        "capture.mrm",
        &mrm(Framing::Bare, Some(&config), &scans(1, 96)),
    );
    save(
        "mrm",
        "serial.mrm",
        &mrm(Framing::Serial, None, &scans(2, 2)),
    );
    let two = mrm(Framing::Bare, None, &scans(2, 384));
    let messages: Vec<&[u8]> = two.chunks(1452).collect();
    let mixed: Vec<u8> = [0, 0, 1, 3]
        .iter()
        .flat_map(|&i| messages[i])
        .copied()
        .collect();
    save("mrm", "repeated-and-missing.mrm", &mixed);
    save("mrm", "cut-off.mrm", &two[..1452 + 600]);
    let mut damaged = two[..2904].to_vec();
    damaged.drain(900..1000);
    save("mrm", "damaged.mrm", &damaged);
    let mut foreign = mrm(Framing::Bare, None, &scans(3, 96));
    let bytes: Vec<u8> = (0..600u32)
        .map(|i| (i * i * 7 + 13 * i) as u8 | 0x40)
        .collect();
    foreign.splice(1452 + 800..1452 + 800, bytes);
    save("mrm", "foreign-bytes.mrm", &foreign);
    save(
        "mrm",
        "pickle.pkl",
        b"\x80\x04\x95\x1c\0\0\0\0\0\0\0}\x94\x8c\x04scan\xf2\x01\0\x07.",
    );
    save(
        "mrm",
        "picture.png",
        b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x01\xf2\x01",
    );
    let mut writer = MrmWriter::new(Vec::new(), Framing::Serial, None).unwrap();
    writer
        .message(&[&[0x10, 0x01, 0, 1][..], &config.to_bytes()].concat())
        .unwrap();
    writer.message(&[0x11, 0x03, 0, 9, 0, 0, 0, 0]).unwrap();
    writer.scan(&scan(7, 3)).unwrap();
    save("mrm", "other-messages.mrm", &writer.finish().unwrap());

    let mut writer = RetWriter::new(Vec::new()).unwrap();
    writer.config(1.5, &config).unwrap();
    writer.control(1.6, 2, 65_535, 0).unwrap();
    for i in 0..2 {
        writer.scan(&scan(i, 4)).unwrap();
    }
    let text = writer.finish().unwrap();
    save("mrm_ret", "log.csv", &text);
    let cr = String::from_utf8(text.clone()).unwrap().replace('\n', "\r");
    save("mrm_ret", "cr.csv", cr.as_bytes());
    save("mrm_ret", "cut-off.csv", &text[..text.len() - 12]);
    let crlf = String::from_utf8(text)
        .unwrap()
        .replace('\n', "\r\n")
        .replace("0, 0, 0, 0", "-1,,,");
    save("mrm_ret", "crlf-reserved.csv", crlf.as_bytes());
    let event = b"3.25, MrmFullScanInfo, 7, 1, 90,,,,, -5, 9, 32, 2, 2, 1, 2, -5, 9\n\
        3.5, MrmDetectionListInfo, 7, 1, 4, 90\n";
    save("mrm_ret", "scan-only.csv", event);

    let fixtures = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures");
    for name in [
        "complex64_position.npz",
        "fortran_int16.npz",
        "spectrum.npz",
    ] {
        save("npz", name, &fs::read(fixtures.join(name)).unwrap());
    }
}
