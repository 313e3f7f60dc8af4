//! Files that the test writes byte by byte, and real ones where they are at hand.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "tests")]

use std::fs;
use std::path::{Path, PathBuf};

use acerra_formats::{
    Axis, Channel, Format, Limits, Positions, Recording, Values, open, recognise,
};

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

fn read(path: &Path) -> Recording {
    open(path, &Limits::default()).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn failure(path: &Path) -> String {
    open(path, &Limits::default()).unwrap_err().to_string()
}

fn real(channel: &Channel) -> &[f32] {
    let Values::Real(v) = &channel.values else {
        panic!("complex")
    };
    v
}

fn step_s(channel: &Channel) -> f64 {
    let Axis::FastTime { step_s, .. } = channel.axis else {
        panic!("spectra")
    };
    step_s
}

/// A real file, or none where the data are not at hand.
fn sample(name: &str) -> Option<PathBuf> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let path = data.join(name);
    if !path.is_file() {
        println!("skipped: {} is not at hand", path.display());
        return None;
    }
    Some(path)
}

fn dzt(bits: u16, channels: usize, traces: usize, samples: usize) -> Vec<u8> {
    let mut head = vec![0u8; 1024 * channels];
    let mut put = |at: usize, bytes: &[u8]| head[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &[0xff, 0x00]);
    put(2, &(channels as u16).to_le_bytes());
    put(4, &(samples as u16).to_le_bytes());
    put(6, &bits.to_le_bytes());
    put(8, &3u16.to_le_bytes());
    put(10, &20.0f32.to_le_bytes());
    put(26, &8.0f32.to_le_bytes());
    put(52, &(channels as u16).to_le_bytes());
    put(98, b"400MHz");
    for trace in 0..traces {
        for channel in 0..channels {
            for sample in 0..samples {
                let value = (trace * 7 + channel * 3 + sample) as i32;
                match bits {
                    8 => head.push(128 + value as u8),
                    16 => head.extend((32_768 + value as u16).to_le_bytes()),
                    _ => head.extend((value * 70_000).to_le_bytes()),
                }
            }
        }
    }
    head
}

#[test]
fn dzt_of_all_widths_and_channels() {
    let folder = folder();
    for (bits, unit) in [(8, 1.0), (16, 1.0), (32, 70_000.0)] {
        for channels in [1, 2, 4] {
            let path = folder.path().join("line.bin");
            let mut bytes = dzt(bits, channels, 5, 16);
            bytes.push(1);
            fs::write(&path, bytes).unwrap();
            let read = read(&path);
            assert_eq!(read.format, Format::Dzt);
            assert_eq!((read.channels.len(), read.skipped_bytes), (channels, 1));
            let last = &read.channels[channels - 1];
            assert_eq!(last.traces, 5);
            let row = &real(last)[4 * 16..];
            for (k, value) in row.iter().enumerate().skip(2) {
                assert_eq!(*value, unit * (28 + 3 * (channels - 1) + k) as f32);
            }
            assert!((step_s(last) - 0.5e-9).abs() < 1e-20);
            assert!(
                matches!(last.axis, Axis::FastTime { start_s, .. } if (start_s + 1.5e-9).abs() < 1e-18)
            );
            assert_eq!(last.time_s.as_ref().unwrap()[4], 0.2);
        }
    }
}

#[test]
fn dzt_with_positions_and_marks() {
    let folder = folder();
    let path = folder.path().join("line.DZT");
    fs::write(&path, dzt(16, 1, 11, 16)).unwrap();
    let dzg = "$GSSIS,0,-1\n$GPGGA,120000.00,4130.0000,N,01415.0000,E,4,12,0.7,50.0,M,45.0,M,,\n\
               $GSSIS,10,-1\n$GPGGA,120001.00,4130.0060,N,01415.0000,E,4,12,0.7,51.0,M,45.0,M,,\n";
    fs::write(folder.path().join("line.DZG"), dzg).unwrap();
    let dzx = "<DZX xmlns=\"www.geophysical.com/DZX/1.02\"><File><Profile><WayPt><scan>7</scan>\
               <mark>User</mark></WayPt></Profile></File></DZX>";
    fs::write(folder.path().join("line.DZX"), dzx).unwrap();
    let read = read(&path);
    assert_eq!(read.marks, [7]);
    let Some(Positions::Geodetic(places)) = &read.channels[0].positions else {
        panic!("no positions")
    };
    assert!((places[5][0] - (41.5 + 0.003 / 60.0)).abs() < 1e-10);
    assert!((places[5][2] - 95.5).abs() < 1e-9);
    assert!((read.channels[0].time_s.as_ref().unwrap()[5] - 0.5).abs() < 1e-9);
}

fn mala(folder: &Path, rad: &str, data: &[u8], extension: &str) -> PathBuf {
    fs::write(folder.join("line.rad"), rad).unwrap();
    let path = folder.join(format!("line.{extension}"));
    fs::write(&path, data).unwrap();
    path
}

const RAD: &str = "SAMPLES:4\nFREQUENCY:2000.0\nSIGNAL POSITION:0\nDISTANCE FLAG:1\nTIME FLAG:0\n\
                   TIME INTERVAL:0.1\nDISTANCE INTERVAL:0.05\nANTENNA SEPARATION:0.18\nTIMEWINDOW:2.0\n\
                   LAST TRACE:3\nSTOP POSITION:0.100\nSTART POSITION:0.0\n";

#[test]
fn mala_of_both_widths_from_either_file() {
    let short: Vec<u8> = (-6i16..6).flat_map(i16::to_le_bytes).collect();
    let long: Vec<u8> = (-6i32..6)
        .flat_map(|v| (v * 100_000).to_le_bytes())
        .collect();
    for (data, extension, unit) in [(short, "rd3", 1.0), (long, "rd7", 100_000.0)] {
        let folder = folder();
        let path = mala(folder.path(), RAD, &data, extension);
        let cor = "1\t2024-05-01\t10:00:00\t41.5\tN\t14.25\tE\t60.0\tM\t1.0\n\
                   3\t2024-05-01\t10:00:02\t41.6\tN\t14.25\tE\t62.0\tM\t1.0\n";
        fs::write(folder.path().join("line.cor"), cor).unwrap();
        for named in [path, folder.path().join("line.rad")] {
            let read = read(&named);
            assert_eq!(read.format, Format::Mala);
            let channel = &read.channels[0];
            assert_eq!(channel.traces, 3);
            assert_eq!(real(channel)[0], -6.0 * unit);
            assert!((step_s(channel) - 0.5e-9).abs() < 1e-18);
            assert_eq!(channel.antenna_separation_m, Some(0.18));
            assert!((channel.along_m.as_ref().unwrap()[2] - 0.1).abs() < 1e-12);
            let Some(Positions::Geodetic(places)) = &channel.positions else {
                panic!()
            };
            assert!((places[1][0] - 41.55).abs() < 1e-12);
            assert!(read.contradictions.is_empty(), "{:?}", read.contradictions);
        }
    }
}

#[test]
fn headers_that_contradict_are_noted() {
    let folder = folder();
    let data: Vec<u8> = (0i16..12).flat_map(i16::to_le_bytes).collect();
    let rad = RAD
        .replace("TIMEWINDOW:2.0", "TIMEWINDOW:2000.0")
        .replace("STOP POSITION:0.100", "STOP POSITION:0.04");
    let path = mala(folder.path(), &rad, &data, "rd3");
    let found = read(&path).contradictions;
    let about: Vec<&str> = found.iter().map(|c| c.about.as_str()).collect();
    assert_eq!(found.len(), 2, "{about:?}");
    assert!(about[0].starts_with("time window") && about[1].starts_with("distance between"));
    assert!((found[0].used - 2.0).abs() < 1e-9);
    assert_eq!(found[0].other, 2000.0);
}

fn dt1(folder: &Path, hd: &str, traces: usize) -> PathBuf {
    fs::write(folder.join("LINE00.HD"), hd).unwrap();
    let mut bytes = Vec::new();
    for trace in 0..traces {
        let mut head = [0.0f32; 32];
        head[0] = trace as f32 + 1.0;
        head[1] = trace as f32 * 2.0;
        head[2] = 6.0;
        head[5] = 2.0;
        head[23] = 86_399.5 + trace as f32 * 0.5;
        if head[23] >= 86_400.0 {
            head[23] -= 86_400.0;
        }
        bytes.extend(head.iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend((0i16..6).flat_map(|k| (k - trace as i16).to_le_bytes()));
    }
    let path = folder.join("LINE00.DT1");
    fs::write(&path, bytes).unwrap();
    path
}

const HD: &str = "1234\nGPR\nNUMBER OF TRACES   = 4\nNUMBER OF PTS/TRC  = 6\nTIMEZERO AT POINT  = 2\n\
                  TOTAL TIME WINDOW  = 4.8\nSTEP SIZE USED     = 2.0\nPOSITION UNITS     = ft\n\
                  ANTENNA SEPARATION = 1.0\n";

#[test]
fn dt1_in_feet() {
    let folder = folder();
    let path = dt1(folder.path(), HD, 4);
    for named in [path, folder.path().join("LINE00.HD")] {
        let read = read(&named);
        let channel = &read.channels[0];
        assert_eq!((read.format, channel.traces), (Format::Dt1, 4));
        assert_eq!(channel.antenna_separation_m, Some(0.3048));
        assert!((channel.along_m.as_ref().unwrap()[3] - 6.0 * 0.3048).abs() < 1e-9);
        assert!(
            matches!(channel.axis, Axis::FastTime { start_s, step_s, samples: 6 }
            if (step_s - 0.8e-9).abs() < 1e-18 && (start_s + 1.6e-9).abs() < 1e-18)
        );
        assert_eq!(real(channel)[6 + 5], 4.0);
        assert!((channel.time_s.as_ref().unwrap()[3] - 1.5).abs() < 1e-2);
        assert!(read.contradictions.is_empty());
    }
    let alone = folder.path().join("other.DT1");
    fs::copy(folder.path().join("LINE00.DT1"), &alone).unwrap();
    assert!(failure(&alone).contains("HD"), "{}", failure(&alone));
}

/// An output of gprMax in the plane, three runs of two samples, merged by version 3 or 4; single without runs.
fn gprmax(runs: usize, is_listed: bool) -> Vec<u8> {
    use hdf5_pure::AttrValue::{F64, F64Array, I64Array};
    let mut file = hdf5_pure::FileBuilder::new();
    file.set_attr("dt", F64(5e-12));
    file.set_attr("dx_dy_dz", F64Array(vec![0.002, 0.002, 0.002]));
    file.set_attr("nx_ny_nz", I64Array(vec![500, 350, 1]));
    // Cells, not metres.
    file.set_attr("srcsteps", I64Array(vec![5, 0, 0]));
    file.set_attr("rxsteps", I64Array(vec![5, 0, 0]));
    let mut receivers = file.create_group("rxs");
    let mut receiver = receivers.create_group("rx1");
    let values: Vec<f32> = (0..2 * runs).map(|k| k as f32).collect();
    receiver
        .create_dataset("Ez")
        .with_f32_data(&values)
        .with_shape(&[2, runs as u64]);
    if is_listed || runs == 1 {
        receiver.set_attr("Position", F64Array(vec![0.23, 0.5, 0.0]));
    }
    receivers.add_group(receiver.finish());
    file.add_group(receivers.finish());
    if runs == 1 {
        let mut sources = file.create_group("srcs");
        let mut source = sources.create_group("src1");
        source.set_attr("Position", F64Array(vec![0.17, 0.5, 0.0]));
        sources.add_group(source.finish());
        file.add_group(sources.finish());
    }
    if is_listed {
        let mut table = file.create_group("trace_metadata");
        for (kind, name, from_m) in [("srcs", "src1", 0.17), ("rxs", "rx1", 0.23)] {
            let places: Vec<f64> = (0..runs)
                .flat_map(|k| [from_m + 0.02 * k as f64, 0.5, 0.0])
                .collect();
            let mut group = table.create_group(kind);
            let mut antenna = group.create_group(name);
            antenna
                .create_dataset("Position")
                .with_f64_data(&places)
                .with_shape(&[runs as u64, 3]);
            group.add_group(antenna.finish());
            table.add_group(group.finish());
        }
        file.add_group(table.finish());
    }
    file.finish().unwrap()
}

#[test]
fn gprmax_places_by_table_by_source_or_by_steps_alone() {
    let folder = folder();
    let path = folder.path().join("model_merged.h5");
    let of = |runs, is_listed| {
        fs::write(&path, gprmax(runs, is_listed)).unwrap();
        read(&path)
    };
    let near = |a: [f64; 3], b: [f64; 3]| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-12);
    // The table of version 4 holds; y of a flat model is up.
    let listed = of(3, true);
    assert_eq!(listed.format, Format::GprMax);
    let channel = &listed.channels[0];
    assert_eq!(channel.traces, 3);
    assert_eq!(real(channel), [0.0, 3.0, 1.0, 4.0, 2.0, 5.0]);
    let [sources, receivers] = channel.antennas_m.as_ref().unwrap();
    assert!(near(sources[2], [0.21, 0.0, 0.5]) && near(receivers[2], [0.27, 0.0, 0.5]));
    assert!((channel.antenna_separation_m.unwrap() - 0.06).abs() < 1e-12);
    // A single output has its own places.
    let single = of(1, false);
    let Some(Positions::Local(places)) = &single.channels[0].positions else {
        panic!("no positions")
    };
    assert!(near(places[0], [0.2, 0.0, 0.5]));
    // Version 3 merges without places: steps of five cells remain.
    let stepped = of(3, false);
    let channel = &stepped.channels[0];
    assert!(channel.positions.is_none());
    assert!((channel.along_m.as_ref().unwrap()[2] - 0.02).abs() < 1e-12);
    assert_eq!(stepped.remarks.len(), 2);
}

/// Header words of a trace and its samples.
fn segy(
    order_is_big: bool,
    code: u16,
    samples: usize,
    traces: usize,
    sample: impl Fn(usize) -> Vec<u8>,
) -> Vec<u8> {
    let two = |v: u16| {
        if order_is_big {
            v.to_be_bytes()
        } else {
            v.to_le_bytes()
        }
    };
    let four = |v: i32| {
        if order_is_big {
            v.to_be_bytes()
        } else {
            v.to_le_bytes()
        }
    };
    let mut head = vec![b' '; 3200];
    head.extend([0; 400]);
    let put =
        |to: &mut [u8], at: usize, bytes: &[u8]| to[at..at + bytes.len()].copy_from_slice(bytes);
    put(&mut head, 3216, &two(100));
    put(&mut head, 3220, &two(samples as u16));
    put(&mut head, 3224, &two(code));
    for trace in 0..traces {
        let mut h = [0; 240];
        put(&mut h, 8, &four(trace as i32 / 2 + 1));
        put(&mut h, 12, &four(trace as i32 % 2 + 1));
        put(&mut h, 72, &four(51_300_000 + 10 * trace as i32));
        put(&mut h, 76, &four(149_400_000));
        put(&mut h, 70, &two((-1000i16) as u16));
        put(&mut h, 88, &two(2));
        put(&mut h, 114, &two(samples as u16));
        head.extend(h);
        for k in 0..samples {
            let mut word = sample(trace * samples + k);
            if !order_is_big {
                word.reverse();
            }
            head.extend(word);
        }
    }
    head
}

#[test]
fn sample_intervals_of_segy_that_contradict_each_other_are_noted_with_both_values() {
    let folder = folder();
    let path = folder.path().join("x");
    // 100 ps in the binary header.
    let plain = segy(true, 3, 5, 6, |_| vec![0, 1]);
    let noted = |change: &dyn Fn(&mut [u8])| {
        let mut bytes = plain.clone();
        change(&mut bytes);
        fs::write(&path, &bytes).unwrap();
        let found = read(&path).contradictions.into_iter();
        let values = found.map(|c| (c.about, c.used.round(), c.other.round()));
        values.collect::<Vec<_>>()
    };
    assert_eq!(noted(&|_| ()), []);
    // The third trace header counts nanoseconds.
    let trace_bytes = 240 + 5 * 2;
    let in_trace = |bytes: &mut [u8]| {
        let at = 3600 + 2 * trace_bytes + 116;
        bytes[at..at + 2].copy_from_slice(&1000_u16.to_be_bytes());
    };
    let about = "sample interval: binary header, trace headers".to_owned();
    assert_eq!(noted(&in_trace), [(about, 100.0, 1000.0)]);
    // Revision 2 states 0.1 µs: a thousand times the integer.
    let in_double = |bytes: &mut [u8]| {
        bytes[3500] = 2;
        bytes[3272..3280].copy_from_slice(&0.1_f64.to_be_bytes());
    };
    let about = "sample interval: double precision, integer of the binary header".to_owned();
    assert_eq!(noted(&in_double), [(about, 1e5, 100.0)]);
    // The same interval in both, with a fraction that the integer lacks.
    let in_both = |bytes: &mut [u8]| {
        bytes[3500] = 2;
        bytes[3272..3280].copy_from_slice(&100.4e-6_f64.to_be_bytes());
    };
    assert_eq!(noted(&in_both), []);
    let in_text = |bytes: &mut [u8]| {
        bytes[400..426].copy_from_slice(b"C 6 SAMPLE INTERVAL: 10 ns");
    };
    let about = "sample interval: binary header, text".to_owned();
    assert_eq!(noted(&in_text), [(about, 100.0, 1e4)]);
}

#[test]
fn segy_in_both_orders_with_two_antennas_and_seconds_of_arc() {
    let folder = folder();
    let path = folder.path().join("x");
    for big in [true, false] {
        let bytes = segy(big, 3, 5, 6, |i| (i as i16 - 9).to_be_bytes().to_vec());
        fs::write(&path, &bytes).unwrap();
        assert_eq!(recognise(&path).unwrap(), Some(Format::SegY));
        let read = read(&path);
        assert_eq!(read.channels.len(), 2, "{:?}", read.remarks);
        let second = read.channel(Some("2")).unwrap();
        assert_eq!(second.traces, 3);
        assert_eq!(real(second)[..5], [-4.0, -3.0, -2.0, -1.0, 0.0]);
        assert!((step_s(second) - 100e-12).abs() < 1e-20);
        let Some(Positions::Geodetic(places)) = &second.positions else {
            panic!()
        };
        assert!((places[0][0] - 41.5).abs() < 1e-12);
        assert!((places[0][1] - (51_300.01 / 3600.0)).abs() < 1e-12);
    }
    let mut cut = segy(true, 3, 5, 6, |_| vec![0, 0]);
    cut.truncate(3600 + 100);
    fs::write(&path, &cut).unwrap();
    assert_eq!(
        failure(&path),
        "trace 1: expected 250 bytes, found the end of the file after 100"
    );
}

#[test]
fn broken_files_are_refused_with_a_place() {
    let folder = folder();
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        path
    };
    assert!(failure(&write("empty", b"")).contains("it is empty"));
    assert!(failure(&write("text", b"hello world\n")).contains("found another kind"));
    let mut header = dzt(16, 1, 0, 16);
    header.extend([0; 31]);
    let message = failure(&write("cut.dzt", &header));
    assert_eq!(
        message,
        "byte 1024: expected a scan of 32 bytes, found the end of the file after 31"
    );
    let nan = segy(true, 5, 2, 1, |_| f32::NAN.to_be_bytes().to_vec());
    assert!(failure(&write("nan.sgy", &nan)).contains("trace 1, sample 1"));
}

/// The refusal gives the samples of the whole file: it comes before they are read.
#[test]
fn files_of_more_samples_than_the_limit_are_refused_by_their_length() {
    let folder = folder();
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        path
    };
    let settings = "[fmcw]\nfile = \"adc.bin\"\nstart_frequency_hz = 77e9\nslope_hz_per_s = 60e12\n\
                    sample_rate_hz = 10e6\nsamples = 4\nreceivers = 2\nchirp_interval_s = 1e-4\n";
    write("adc.bin", &[0; 3 * 32]);
    let files = [
        (write("line.sgy", &segy(true, 5, 6, 3, |_| vec![0; 4])), 18),
        (write("line.dzt", &dzt(16, 2, 3, 16)), 96),
        (dt1(folder.path(), HD, 4), 24),
        (mala(folder.path(), RAD, &[0; 24], "rd3"), 12),
        (write("fmcw.toml", settings.as_bytes()), 24),
    ];
    let mut limits = Limits::default();
    limits.max_samples = 10;
    for (path, samples) in files {
        let message = open(&path, &limits).unwrap_err().to_string();
        let expected = format!("the file: expected at most 10 samples, found {samples}");
        assert!(message.ends_with(&expected), "{message}");
    }
}

/// Bytes changed, cut and repeated at random: an answer or an error, and no panic.
#[test]
fn broken_bytes_never_panic() {
    use acerra_formats::{
        dt1, dzt as dzt_format, fmcw, hdf5, mala as mala_format, matlab5, segy as segy_format,
    };
    let mut limits = Limits::default();
    limits.max_samples = 1 << 16;
    limits.max_trace_samples = 1 << 12;
    limits.max_file_bytes = 1 << 20;
    let mut state = 1u64;
    let mut random = move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize
    };
    let hd_and_data = {
        let folder = folder();
        let path = dt1(folder.path(), HD, 4);
        [HD.as_bytes(), &fs::read(path).unwrap()].concat()
    };
    let gps = "Trace #1 at position 0\n$GPGGA,120000.00,4130.0000,N,01415.0000,E,4,12,0.7,50.0,M,45.0,M,,\n\
               Trace #3 at position 2\n$GPGGA,120001.00,4130.0060,N,01415.0000,E,4,12,0.7,51.0,M,45.0,M,,\n";
    let seeds: [Vec<u8>; 5] = [
        dzt(16, 2, 3, 16),
        segy(true, 3, 5, 6, |_| vec![0, 1]),
        hd_and_data,
        [RAD.as_bytes(), gps.as_bytes()].concat(),
        b"[fmcw]\nfile = \"a\"\nstart_frequency_hz = 1e9\nslope_hz_per_s = 1e12\nsample_rate_hz = 1e6\n\
          samples = 4\nreceivers = 2\nchirp_interval_s = 1e-4\n# GHz S RI R 50\nfreq,re,im\n1,2,3\n"
            .to_vec(),
    ];
    for _ in 0..20_000 {
        let mut bytes = seeds[random() % seeds.len()].clone();
        for _ in 0..1 + random() % 8 {
            let at = random() % bytes.len();
            match random() % 4 {
                0 => bytes[at] = random() as u8,
                1 => bytes[at] ^= 1 << (random() % 8),
                2 => bytes.truncate(at + 1),
                _ => {
                    let end = (at + random() % 64).min(bytes.len());
                    let piece = bytes[at..end].to_vec();
                    bytes.extend(piece);
                }
            }
        }
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let cut = HD.len().min(bytes.len());
        let _ = segy_format::read_segy(bytes.as_slice(), bytes.len() as u64, &limits);
        let _ = dzt_format::read_dzt(
            bytes.as_slice(),
            bytes.len() as u64,
            [Some(&text), Some(&text)],
            &limits,
        );
        let head = String::from_utf8_lossy(&bytes[..cut]).into_owned();
        let _ = dt1::read_dt1(
            &bytes[cut..],
            (bytes.len() - cut) as u64,
            &head,
            Some(gps),
            &limits,
        );
        let long = mala_format::NamedAs::Long;
        let _ = mala_format::read_mala(
            bytes.as_slice(),
            bytes.len() as u64,
            long,
            &text,
            Some(&text),
            &limits,
        );
        let _ = matlab5::read_matlab5(&bytes, &limits);
        let _ = hdf5::read_hdf5(bytes.clone(), &limits);
        let _ = acerra_formats::touchstone::read_touchstone(&text, &limits);
        let _ = acerra_formats::analyser_csv::read_analyser_csv(&text, &limits);
        if let Ok(settings) = fmcw::FmcwSettings::parse(&text) {
            let _ = fmcw::read_dca1000(bytes.as_slice(), bytes.len() as u64, &settings, &limits);
        }
    }
}

#[test]
fn real_files_are_read() {
    if let Some(path) = sample("gpr-samples/grid-line-001.dzt") {
        let read = read(&path);
        let channel = &read.channels[0];
        assert_eq!((channel.traces, channel.axis.samples()), (451, 512));
        assert!((step_s(channel) * 512.0 - 50e-9).abs() < 1e-15);
        assert!((channel.along_m.as_ref().unwrap()[450] - 9.0).abs() < 1e-9);
        assert_eq!(channel.antenna_frequency.unwrap().hz, 400e6);
    }
    if let Some(path) = sample("gpr-samples/warr.dt1") {
        let read = read(&path);
        let channel = &read.channels[0];
        assert_eq!((channel.traces, channel.axis.samples()), (164, 1900));
        assert!((step_s(channel) - 0.4e-9).abs() < 1e-18);
        assert_eq!(channel.antenna_separation_m, Some(0.75));
        assert_eq!(channel.antenna_frequency.unwrap().hz, 100e6);
    }
    if let Some(path) = sample("gpr-iwagpr2017/buried_objects_xdir_bscan_19.rd3") {
        let read = read(&path);
        let channel = &read.channels[0];
        assert_eq!((channel.traces, channel.axis.samples()), (91, 2078));
        assert!((step_s(channel) - 3.8517e-12).abs() < 1e-15);
        assert_eq!(channel.antenna_separation_m, Some(0.059));
        assert_eq!(channel.antenna_frequency.unwrap().hz, 1.5e9);
    }
    if let Some(path) = sample("gpr-samples/gprmax-rectangle.h5") {
        let read = read(&path);
        assert_eq!(read.channels.len(), 6);
        assert!(
            read.channels[0].name.starts_with("rx1/E"),
            "{}",
            read.channels[0].name
        );
        assert_eq!(
            (read.channels[0].traces, read.channels[0].axis.samples()),
            (85, 1697)
        );
    }
}
