//! Phase history data, written and read: by this crate, by its structure, and by `sarkit` where
//! `ACERRA_PYTHON` names a Python that has it.
#![allow(clippy::unwrap_used, clippy::print_stderr)] // a test that cannot go on has failed

use std::io::Cursor;
use std::path::Path;
use std::process::Command;

use acerra_cphd::{
    Channel, Description, EvenFrequencies, PhaseHistory, ReadError, ReadOptions,
    SPEED_OF_LIGHT_M_S, Scene, WriteError, read_cphd, write_cphd,
};
use acerra_geo::geodesy::{EnuFrame, Geodetic};
use acerra_geo::time::GpsTime;
use num_complex::Complex64;

const SCENE: Scene = Scene {
    middle_m: [12.0, 3.0, -1.5],
    pixel_m: 0.05,
    nx: 161,
    ny: 120,
};
const TARGET_M: [f64; 3] = [13.0, 2.5, -1.5];
const BAND: EvenFrequencies = EvenFrequencies {
    first_hz: 3.1e9,
    step_hz: 5e6,
    count: 341,
};

/// A flight to the north past a target in the east, of Eq. (1).
fn channel(name: &str, start_s: f64) -> Channel<'static> {
    let time_s: Vec<f64> = (0..60).map(|k| start_s + 0.0216 * f64::from(k)).collect();
    let place = |t: &f64| [0.3 * (t - start_s).sin(), 2.0 * (t - start_s), 8.0];
    let position_m: Vec<[f64; 3]> = time_s.iter().map(place).collect();
    let spectrum: Vec<Complex64> = position_m.iter().flat_map(echo).collect();
    Channel {
        name: name.to_owned(),
        time_s,
        position_m,
        frequency: BAND,
        spectrum: spectrum.into(),
        fast_time_s: Some([10e-9, 150e-9]),
    }
}

fn echo(position_m: &[f64; 3]) -> Vec<Complex64> {
    let range_m: f64 = (0..3).map(|i| (TARGET_M[i] - position_m[i]).powi(2)).sum();
    let delay_s = 2.0 * range_m.sqrt() / SPEED_OF_LIGHT_M_S;
    let phase = |n| -std::f64::consts::TAU * BAND.hz(n) * delay_s;
    (0..BAND.count)
        .map(|n| Complex64::from_polar(3.0, phase(n)))
        .collect()
}

fn history(names: &[(&str, f64)]) -> PhaseHistory<'static> {
    PhaseHistory {
        frame: EnuFrame::new(Geodetic::from_degrees(40.9596, 14.3696, 75.0)),
        start: Some(GpsTime::from_week_tow(2400, 302_400.25)),
        channels: names
            .iter()
            .map(|(name, start_s)| channel(name, *start_s))
            .collect(),
        description: Description {
            name: "a <flight> & \"its\" echoes".to_owned(),
            collector: "PulsON P440".to_owned(),
            items: vec![("EVIDENCE".to_owned(), "consistent: 3 < 4".to_owned())],
        },
    }
}

fn written(history: &PhaseHistory<'_>) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    write_cphd(&mut file, history, &SCENE).unwrap();
    file.into_inner()
}

fn assert_same(found: &Channel<'_>, expected: &Channel<'_>, tolerance: f64) {
    assert_eq!(found.name, expected.name);
    assert_eq!(found.position_m.len(), expected.position_m.len());
    for (a, b) in found.position_m.iter().zip(&expected.position_m) {
        let off = (0..3).map(|i| (a[i] - b[i]).abs()).fold(0.0, f64::max);
        assert!(off < 5e-9, "{a:?} {b:?}");
    }
    assert_eq!(found.spectrum.len(), expected.spectrum.len());
    for (a, b) in found.spectrum.iter().zip(&*expected.spectrum) {
        assert!((a - b).norm() < tolerance, "{a} {b}");
    }
}

#[test]
fn what_is_written_is_read() {
    let history = history(&[("first", 0.0), ("second", 40.0)]);
    let bytes = written(&history);
    let file = read_cphd(Cursor::new(&bytes), &ReadOptions::default()).unwrap();
    assert_eq!(file.other_channels, ["second"]);
    assert_eq!(file.left_out, 0);
    let found = &file.history.channels[0];
    assert_same(found, &history.channels[0], 2e-6);
    assert_eq!(found.frequency.count, BAND.count);
    assert_eq!(found.frequency.first_hz, BAND.first_hz);
    assert_eq!(found.frequency.step_hz, BAND.step_hz);
    // The window of fast time comes back, as do the instants of the pulses and the frame.
    let [from, to] = found.fast_time_s.unwrap();
    assert!((from - 10e-9).abs() < 1e-15 && (to - 150e-9).abs() < 1e-15);
    let at = |history: &PhaseHistory<'_>, k: usize| {
        history.start.unwrap() + history.channels[0].time_s[k]
    };
    for k in [0, 59] {
        assert!(at(&file.history, k).seconds_since(at(&history, k)).abs() < 1e-9);
    }
    let origin = file.history.frame.origin();
    assert!((origin.height_m - 75.0).abs() < 1e-9);
    assert_eq!(file.history.description.name, history.description.name);
    assert!(
        file.history
            .description
            .items
            .contains(&history.description.items[0])
    );

    // Written again about another origin, the data stand in the same place.
    let mut moved = file.history.clone();
    moved.frame = EnuFrame::new(Geodetic::from_degrees(40.96, 14.37, 70.0));
    let again = read_cphd(Cursor::new(written(&moved)), &ReadOptions::default()).unwrap();
    assert!((again.history.frame.origin().height_m - 70.0).abs() < 1e-9);

    let second = ReadOptions::default().with_channel("second");
    let file = read_cphd(Cursor::new(&bytes), &second).unwrap();
    assert_same(&file.history.channels[0], &history.channels[1], 2e-6);
    assert_eq!(
        bytes,
        written(&history),
        "the same bytes for the same input"
    );
}

#[test]
fn the_file_is_laid_out_as_the_standard_says() {
    let bytes = written(&history(&[("flight", 0.0)]));
    let end = bytes.windows(2).position(|w| w == b"\x0c\n").unwrap();
    let header = std::str::from_utf8(&bytes[..end]).unwrap();
    let field = |name: &str| -> usize {
        let line = header
            .lines()
            .find(|l| l.starts_with(&format!("{name} := ")));
        line.unwrap().rsplit(' ').next().unwrap().parse().unwrap()
    };
    assert!(header.starts_with("CPHD/1.1.0\n"));
    assert_eq!(field("XML_BLOCK_BYTE_OFFSET"), end + 2);
    let xml_end = end + 2 + field("XML_BLOCK_SIZE");
    assert_eq!(&bytes[xml_end..xml_end + 2], b"\x0c\n");
    assert_eq!(field("PVP_BLOCK_SIZE"), 60 * 28 * 8);
    let (vectors, signal) = (
        field("PVP_BLOCK_BYTE_OFFSET"),
        field("SIGNAL_BLOCK_BYTE_OFFSET"),
    );
    assert_eq!(vectors % 8, 0);
    assert_eq!(signal, vectors + field("PVP_BLOCK_SIZE"));
    assert_eq!(bytes.len(), signal + 60 * 341 * 8);
    // The first sample: the echo relative to that of the middle of the scene.
    let word = |at: usize| f32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
    let range =
        |p: [f64; 3]| -> f64 { (p[0].powi(2) + p[1].powi(2) + (p[2] - 8.0).powi(2)).sqrt() };
    let toa_s = 2.0 * (range(TARGET_M) - range(SCENE.middle_m)) / SPEED_OF_LIGHT_M_S;
    let expected = Complex64::from_polar(3.0, -std::f64::consts::TAU * 3.1e9 * toa_s);
    let found = Complex64::new(word(signal).into(), word(signal + 4).into());
    assert!((found - expected).norm() < 1e-5, "{found} {expected}");
}

#[test]
fn what_makes_no_phase_history_is_refused() {
    let refused = |change: fn(&mut Channel<'static>)| {
        let mut history = history(&[("flight", 0.0)]);
        change(&mut history.channels[0]);
        write_cphd(Vec::new(), &history, &SCENE).unwrap_err()
    };
    let error = refused(|c| c.time_s[7] = c.time_s[6]);
    assert!(
        matches!(error, WriteError::Time { pulse: 7, .. }),
        "{error}"
    );
    let error = refused(|c| c.spectrum.to_mut().truncate(5));
    assert!(
        matches!(error, WriteError::Length { found: 5, .. }),
        "{error}"
    );
    let error = refused(|c| c.spectrum.to_mut()[3].im = f64::NAN);
    assert!(
        matches!(error, WriteError::NotFinite { index: 3, .. }),
        "{error}"
    );
    let error = refused(|c| c.position_m.iter_mut().for_each(|p| *p = [0.0, 0.0, 8.0]));
    assert!(matches!(error, WriteError::AtRest { .. }), "{error}");
    let twice = history(&[("a", 0.0), ("a", 5.0)]);
    let error = write_cphd(Vec::new(), &twice, &SCENE).unwrap_err();
    assert!(matches!(error, WriteError::SameName { .. }), "{error}");
    let scene = Scene { nx: 0, ..SCENE };
    let error = write_cphd(Vec::new(), &history(&[("a", 0.0)]), &scene).unwrap_err();
    assert!(matches!(error, WriteError::Scene { .. }), "{error}");
}

fn read(bytes: &[u8]) -> Result<(), ReadError> {
    read_cphd(Cursor::new(bytes), &ReadOptions::default()).map(drop)
}

/// The file with one text in its header or XML replaced by another of the same length.
fn replaced(bytes: &[u8], from: &str, to: &str) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    let at = bytes
        .windows(from.len())
        .position(|w| w == from.as_bytes())
        .unwrap();
    let mut bytes = bytes.to_vec();
    bytes[at..at + to.len()].copy_from_slice(to.as_bytes());
    bytes
}

#[test]
fn broken_files_are_refused_with_the_place() {
    let bytes = written(&history(&[("flight", 0.0)]));
    assert!(read(&bytes).is_ok());
    for (from, to, words) in [
        ("CPHD/1.1.0", "CPHD/2.1.0", "CPHD/1.x"),
        ("XML_BLOCK_SIZE := ", "XML_BLOCK_SIZE := 9", "header"),
        (
            "SIGNAL_BLOCK_SIZE",
            "SIGNAL_BLOCK_SIZF",
            "SIGNAL_BLOCK_SIZE",
        ),
        ("<DomainType>FX<", "<DomainType>XF<", "DomainType"),
        ("<SGN>-1<", "<SGN>-2<", "SGN"),
        (
            "<CollectType>MONOSTATIC<",
            "<CollectType>BISTATIC  <",
            "MONOSTATIC",
        ),
        (
            "<SignalArrayFormat>CF8<",
            "<SignalArrayFormat>CF9<",
            "CI2, CI4 or CF8",
        ),
        (
            "<NumVectors>60<",
            "<NumVectors>61<",
            "parameters of channel",
        ),
        (
            "<NumVectors>60<",
            "<NumVectors>00<",
            "vectors with a signal",
        ),
        ("<NumSamples>341<", "<NumSamples>342<", "signal of channel"),
        (
            "<NumBytesPVP>224<",
            "<NumBytesPVP>223<",
            "223 bytes of a vector",
        ),
        ("<RefChId>flight<", "<RefChId>flighT<", "flighT"),
        ("</Channel>", "</Chaxnel>", "XML block"),
        (
            "<CollectionStart>20",
            "<CollectionStart>x0",
            "CollectionStart",
        ),
    ] {
        let (from, to) = match from.len() == to.len() {
            true => (from.to_owned(), to.to_owned()),
            // One digit more: the header line takes one from its end.
            false => (format!("{from}1"), to.to_owned()),
        };
        let at = bytes.windows(from.len()).any(|w| w == from.as_bytes());
        let (from, to) = if at {
            (from, to)
        } else {
            let digit = |d: char| from[..from.len() - 1].to_owned() + &d.to_string();
            let found = ('2'..='9').map(digit);
            let found = found
                .into_iter()
                .find(|f| bytes.windows(f.len()).any(|w| w == f.as_bytes()));
            (found.unwrap(), to)
        };
        let error = read(&replaced(&bytes, &from, &to)).unwrap_err().to_string();
        let is_told = error.contains(words) || words == "header";
        assert!(is_told, "{from} → {to}: {error}");
    }
    // Cut off anywhere.
    for cut in (0..bytes.len()).step_by(997) {
        assert!(read(&bytes[..cut]).is_err(), "cut at {cut}");
    }
    // A value that is no number.
    let mut spoilt = bytes.clone();
    let last = spoilt.len() - 8;
    spoilt[last..].copy_from_slice(&[0x7f, 0xc0, 0, 0, 0, 0, 0, 0]);
    let error = read(&spoilt).unwrap_err();
    let place = matches!(
        error,
        ReadError::Sample {
            vector: 59,
            sample: 340,
            ..
        }
    );
    assert!(place, "{error}");
    let few = ReadOptions::default().with_max_samples(1000);
    let error = read_cphd(Cursor::new(&bytes), &few).unwrap_err();
    assert!(
        matches!(error, ReadError::TooLarge { found: 20460, .. }),
        "{error}"
    );
}

/// Asked of sarkit: is the file consistent by its checker, with every check that reads the file; what
/// are its first signal and geometry. It writes the file anew as 16-bit integers with amplitude
/// factors, opposite sign of phase, a vector without a signal, and no origin of Acerra's frame.
const ASK: &str = r#"
import sys, json, numpy as np, lxml.etree
import sarkit.cphd as skcphd, sarkit.verification as skver
path, other = sys.argv[1:3]
with open(path, "rb") as f:
    check = skver.CphdConsistency.from_file(f, thorough=True)
    check.check()
failed = [d["details"] for v in check.failures().values() for d in v["details"] if not d["passed"]]
told = {"failed": failed, "passes": len(check.passes())}
with open(path, "rb") as f, skcphd.Reader(f) as r:
    tree = r.metadata.xmltree
    channel = tree.findtext("{*}Data/{*}Channel/{*}Identifier")
    signal, pvps = r.read_channel(channel)
told["signal"] = [float(signal[0, 0].real), float(signal[0, 0].imag)]
told["core"] = tree.findtext("{*}CollectionID/{*}CoreName")
told["incidence"] = float(tree.findtext("{*}ReferenceGeometry/{*}Monostatic/{*}IncidenceAngle"))
tree.find("{*}Data/{*}SignalArrayFormat").text = "CI4"
tree.find("{*}Global/{*}SGN").text = "+1"
tree.find("{*}Channel/{*}Parameters/{*}SignalNormal").text = "false"
product = tree.find("{*}ProductInfo")
for p in list(product):
    if p.get("name") == "LOCAL_FRAME_ORIGIN_DEG_M":
        product.remove(p)
pvp = tree.find("{*}PVP")
ns = pvp.tag.split("}")[0] + "}"
amp = lxml.etree.Element(ns + "AmpSF")
for name, value in [("Offset", "28"), ("Size", "1"), ("Format", "F8")]:
    lxml.etree.SubElement(amp, ns + name).text = value
pvp.insert(7, amp)
tree.find("{*}Data/{*}NumBytesPVP").text = "232"
new = np.zeros(pvps.shape, dtype=skcphd.get_pvp_dtype(tree))
for name in pvps.dtype.names:
    new[name] = pvps[name]
scale = np.abs(signal).max(axis=1) / 32000
new["AmpSF"] = scale
new["SIGNAL"][3] = 0
whole = np.round(signal.conj() / scale[:, None])
whole[3] = 0
ints = np.zeros(signal.shape, dtype=[("real", ">i2"), ("imag", ">i2")])
ints["real"], ints["imag"] = whole.real, whole.imag
metadata = skcphd.Metadata(xmltree=tree, file_header_part=skcphd.FileHeaderPart())
with open(other, "wb") as f, skcphd.Writer(f, metadata) as w:
    w.write_signal(channel, ints)
    w.write_pvp(channel, new)
print(json.dumps(told))
"#;

fn asked(python: &std::ffi::OsStr, path: &Path, other: &Path) -> String {
    let answer = Command::new(python)
        .args(["-c", ASK])
        .arg(path)
        .arg(other)
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&answer.stderr).into_owned();
    assert!(answer.status.success(), "{errors}");
    String::from_utf8(answer.stdout).unwrap()
}

#[test]
fn sarkit_finds_files_consistent_and_its_own_are_read() {
    let Some(python) = std::env::var_os("ACERRA_PYTHON") else {
        eprintln!("skipped: ACERRA_PYTHON names no Python with sarkit");
        return;
    };
    let history = history(&[("flight", 0.0)]);
    let folder = tempfile::tempdir().unwrap();
    let [path, other] = ["ours.cphd", "theirs.cphd"].map(|name| folder.path().join(name));
    std::fs::write(&path, written(&history)).unwrap();
    let answer = asked(&python, &path, &other);
    // The checker tells the ground range by the arc cosine of an angle of 2 µrad, of which double
    // precision leaves four digits, and asks for six.
    let none = "\"failed\": []";
    let ground_range = "\"failed\": [\"GroundRange matches defined PVP/calculation\"]";
    assert!(
        answer.contains(none) || answer.contains(ground_range),
        "{answer}"
    );
    assert!(
        answer.contains("a <flight> & \\\"its\\\" echoes"),
        "{answer}"
    );

    let file = std::fs::File::open(&other).unwrap();
    let theirs = read_cphd(std::io::BufReader::new(file), &ReadOptions::default()).unwrap();
    assert_eq!(theirs.left_out, 1);
    let found = &theirs.history.channels[0];
    let expected = &history.channels[0];
    assert_eq!(found.time_s.len(), 59);
    // Their frame stands about the middle of the scene.
    let moved = theirs.history.frame.ecef_from_enu(found.position_m[10]);
    let place = history.frame.ecef_from_enu(expected.position_m[11]);
    let off_m = (0..3)
        .map(|i| (moved[i] - place[i]).powi(2))
        .sum::<f64>()
        .sqrt();
    assert!(off_m < 1e-8, "{off_m}");
    // With the sign of phase the reflectivity is conjugate: that of the target is 3, real. Sixteen
    // bits leave 3/32000.
    let n = BAND.count;
    for (a, b) in found.spectrum[3 * n..]
        .iter()
        .zip(&expected.spectrum[4 * n..])
    {
        assert!((a - b).norm() < 1.5e-4, "{a} {b}");
    }
}

/// Writes the seed of the fuzz target `cphd`; run by name where the writer changes.
#[test]
#[ignore = "writes fuzz/seeds/cphd/flight.cphd"]
fn write_the_seed_of_the_fuzz_target() {
    let mut history = history(&[("flight", 0.0)]);
    let channel = &mut history.channels[0];
    let count = 5;
    let first = |line: &[Complex64]| line[..count].to_vec();
    channel.spectrum = channel
        .spectrum
        .chunks(341)
        .take(4)
        .flat_map(first)
        .collect();
    channel.frequency.count = count;
    channel.time_s.truncate(4);
    channel.position_m.truncate(4);
    let seeds = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds/cphd");
    std::fs::write(seeds.join("flight.cphd"), written(&history)).unwrap();
}
