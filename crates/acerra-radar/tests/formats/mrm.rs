//! MRM captures: real ones to the sample, and streams with every blemish.

use std::io::{Cursor, Read};

use crate::common::{scan, scans, shared};
use acerra_radar::mrm::{Framing, HeaderFault, MrmReader, RadarConfig, read_mrm, write_mrm};
use acerra_radar::{
    BlemishKind, ClockBasis, Filtering, Limits, OpenError, Place, RadarFile, RadarLog,
    RadargramOptions, ReadError, RunChoice, Samples, Scan, read,
};
use proptest::prelude::*;

const MESSAGE: usize = 1452;

fn bare(scans: &[Scan]) -> Vec<u8> {
    write_mrm(Vec::new(), Framing::Bare, None, scans).unwrap()
}

fn log(bytes: &[u8]) -> RadarLog {
    read_mrm(bytes, &Limits::default()).unwrap()
}

fn kinds(log: &RadarLog) -> Vec<BlemishKind> {
    log.report
        .blemishes
        .iter()
        .map(|b| b.kind.clone())
        .collect()
}

#[test]
fn the_flight_has_799_whole_scans_and_a_cut_off_one() {
    let Some(bytes) = shared("uav-flight-2019/flight.mrm") else {
        return;
    };
    let RadarFile::Log(log) = read(Cursor::new(&bytes), &Limits::default()).unwrap() else {
        panic!("a log")
    };
    assert_eq!(log.scans.len(), 799);
    assert_eq!(log.report.scan_messages, 799 * 4 + 1);
    assert_eq!(
        kinds(&log),
        [BlemishKind::IncompleteScan {
            message_id: 799,
            found: 1,
            expected: 4,
            at_end: true
        }]
    );
    assert_eq!(log.report.bytes, 4_642_076);
    assert_eq!(log.configs.len(), 1);
    let config = log.configs[0].config;
    assert_eq!(
        (
            config.integration_index,
            config.transmit_gain,
            config.antenna_mode
        ),
        (11, 63, 2)
    );
    assert_eq!(
        (config.scan_start_ps, config.scan_stop_ps),
        (16_670, 86_982)
    );
    // Every sample against the bytes it came from.
    for (i, scan) in log.scans.iter().enumerate() {
        for (j, &sample) in scan.samples.iter().enumerate() {
            let at = 32 + (4 * i + j / 350) * MESSAGE + 52 + 4 * (j % 350);
            assert_eq!(
                sample,
                i32::from_be_bytes(bytes[at..at + 4].try_into().unwrap())
            );
        }
    }
    let made = log.radargram(&RadargramOptions::default()).unwrap();
    assert_eq!(
        (made.radargram.traces, made.radargram.samples_per_trace),
        (799, 1152)
    );
    assert!((made.radargram.fast_time_start_s - 16.67e-9).abs() < 1e-20);
    assert_eq!(made.clock.basis, ClockBasis::EvenRadioClock);
    assert!(
        (made.clock.interval_s - 21.5728e-3).abs() < 1e-7,
        "{}",
        made.clock.interval_s
    );
    assert_eq!((made.clock.stretches.len(), made.clock.lost_scans), (1, 0));
    assert!(made.clock.residual_max_s < 0.51e-3 && made.clock.residual_rms_s < 0.3e-3);
}

#[test]
fn writing_the_real_captures_again_gives_their_bytes() {
    for path in [
        "uav-flight-2019/flight.mrm",
        "corner-reflector-captures/July19-CornerReflector-scan01.out",
        "corner-reflector-captures/July19-CornerReflector-scan07.out",
    ] {
        let Some(bytes) = shared(path) else { return };
        let log = log(&bytes);
        let config = log.configs[0].config;
        let again = write_mrm(Vec::new(), Framing::Bare, Some(&config), &log.scans).unwrap();
        let whole = bytes.len().min(32 + log.scans.len() * 4 * MESSAGE);
        assert!(again == bytes[..whole], "{path}");
        if path.ends_with(".out") {
            assert_eq!(log.scans.len(), 200);
            assert!(log.report.is_clean());
            let made = log.radargram(&RadargramOptions::default()).unwrap();
            assert!((made.clock.interval_s - 21.5726e-3).abs() < 1e-6);
        }
    }
}

#[test]
fn both_framings_with_and_without_configuration_round_trip() {
    let config = RadarConfig {
        scan_start_ps: -500,
        ..RadarConfig::default()
    };
    for count in [96, 350, 351, 1152] {
        for framing in [Framing::Bare, Framing::Serial] {
            for config in [None, Some(&config)] {
                let scans = scans(3, count);
                let bytes = write_mrm(Vec::new(), framing, config, &scans).unwrap();
                let RadarFile::Log(log) = read(Cursor::new(bytes), &Limits::default()).unwrap()
                else {
                    panic!("a log")
                };
                assert_eq!(log.scans, scans);
                assert!(log.report.is_clean(), "{:?}", log.report);
                assert_eq!(log.configs.first().map(|c| c.config), config.copied());
            }
        }
    }
}

/// Hands bytes out a few at a time.
struct Trickle<'a>(&'a [u8], usize);

impl Read for Trickle<'_> {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        self.1 = self.1 % 977 + 1;
        let n = self.1.min(out.len()).min(self.0.len());
        out[..n].copy_from_slice(&self.0[..n]);
        self.0 = &self.0[n..];
        Ok(n)
    }
}

#[test]
fn streaming_in_any_portions_gives_the_same_scans() {
    let wanted = scans(20, 1152);
    let bytes = write_mrm(Vec::new(), Framing::Serial, None, &wanted).unwrap();
    let got: Vec<Scan> = MrmReader::new(Trickle(&bytes, 3), Limits::default())
        .map(Result::unwrap)
        .collect();
    assert_eq!(got, wanted);
}

#[test]
fn messages_lost_repeated_and_out_of_order() {
    let wanted = scans(5, 1152);
    let bytes = bare(&wanted);
    let messages: Vec<&[u8]> = bytes.chunks(MESSAGE).collect();
    let order = [
        0, 1, 2, 3, /* scan 1 loses 5 */ 4, 6, 7, 9, 8, 10, 11, 11, 12, 13, 14, 15, 13, 16,
        17, 18,
    ];
    let stream: Vec<u8> = order.iter().flat_map(|&i| messages[i]).copied().collect();
    let log = log(&stream);
    assert_eq!(
        log.scans,
        [wanted[0].clone(), wanted[2].clone(), wanted[3].clone()]
    );
    let found = kinds(&log);
    assert_eq!(log.report.blemish_count, 5);
    for kind in [
        BlemishKind::IncompleteScan {
            message_id: 1,
            found: 3,
            expected: 4,
            at_end: false,
        },
        BlemishKind::OutOfOrder {
            message_id: 2,
            index: 0,
        },
        BlemishKind::RepeatedMessage {
            message_id: 2,
            index: 3,
            identical: Some(true),
        },
        BlemishKind::RepeatedMessage {
            message_id: 3,
            index: 1,
            identical: Some(true),
        },
        BlemishKind::IncompleteScan {
            message_id: 4,
            found: 3,
            expected: 4,
            at_end: true,
        },
    ] {
        assert!(found.contains(&kind), "{kind:?} not in {found:?}");
    }
    let made = log.radargram(&RadargramOptions::default()).unwrap();
    assert_eq!(made.clock.lost_scans, 1);
}

#[test]
fn messages_overtaking_each_other_across_scans() {
    let wanted = scans(3, 700);
    let bytes = bare(&wanted);
    let messages: Vec<&[u8]> = bytes.chunks(MESSAGE).collect();
    let stream: Vec<u8> = [0, 2, 1, 3, 5, 4]
        .iter()
        .flat_map(|&i| messages[i])
        .copied()
        .collect();
    let log = log(&stream);
    assert_eq!(log.scans, wanted);
    assert_eq!(log.report.out_of_order_messages, 1);
}

#[test]
fn other_messages_are_counted_and_passed_over() {
    let wanted = scans(3, 96);
    for framing in [Framing::Bare, Framing::Serial] {
        let mut writer = acerra_radar::mrm::MrmWriter::new(Vec::new(), framing, None).unwrap();
        let control = [
            &[0x10, 0x03, 0, 9, 0xff, 0xff, 0, 0][..],
            &[0, 0, 0xc3, 0x50],
        ]
        .concat();
        let mut detections = vec![0x12, 0x01, 0, 5];
        detections.resize(1408, 0xF2);
        let mut status = vec![0xF1, 0x01, 0, 7];
        status.resize(64, 0);
        let mut confirm = [&[0x11, 0x02, 0, 3][..], &RadarConfig::default().to_bytes()].concat();
        confirm.resize(44, 0);
        writer.message(&confirm).unwrap();
        writer.message(&control).unwrap();
        writer.message(&[0x11, 0x03, 0, 9, 0, 0, 0, 0]).unwrap();
        for scan in &wanted {
            writer.scan(scan).unwrap();
            writer.message(&detections).unwrap();
        }
        writer.message(&status).unwrap();
        let bytes = writer.finish().unwrap();
        let RadarFile::Log(log) = read(Cursor::new(bytes), &Limits::default()).unwrap() else {
            panic!("a log")
        };
        assert_eq!(log.scans, wanted);
        assert!(log.report.is_clean(), "{framing:?} {:?}", log.report);
        assert_eq!(log.report.other_events["DETECTION_LIST_INFO"], 3);
        assert_eq!(log.report.other_events["GET_STATUSINFO_CONFIRM"], 1);
        assert_eq!(log.report.other_events["CONTROL_CONFIRM"], 1);
        assert_eq!(log.requested_interval_us, Some(50_000));
        assert_eq!(log.configs[0].config, RadarConfig::default());
    }
}

#[test]
fn the_way_back_after_damage() {
    let wanted = scans(4, 350);
    let bytes = bare(&wanted);
    // 100 bytes missing from scan 1.
    let mut lost = bytes.clone();
    lost.drain(MESSAGE + 500..MESSAGE + 600);
    let log1 = log(&lost);
    assert_eq!(log1.scans, [0, 2, 3].map(|i: usize| wanted[i].clone()));
    assert_eq!(
        kinds(&log1),
        [BlemishKind::CutOffMessage {
            found: MESSAGE as u64 - 100
        }]
    );
    assert_eq!(log1.report.blemishes[0].place, Place::Byte(MESSAGE as u64));
    // 37 foreign bytes between scans 1 and 2.
    let mut foreign = bytes.clone();
    foreign.splice(2 * MESSAGE..2 * MESSAGE, [0x55; 37]);
    let log2 = log(&foreign);
    assert_eq!(log2.scans, wanted);
    assert_eq!(kinds(&log2), [BlemishKind::UnreadableBytes { count: 37 }]);
    // A header overwritten: that message is lost, the next is found.
    let mut broken = bytes.clone();
    broken[MESSAGE..MESSAGE + 60].fill(0xAA);
    let log3 = log(&broken);
    assert_eq!(log3.scans, [0, 2, 3].map(|i: usize| wanted[i].clone()));
    assert_eq!(log3.report.unreadable_bytes, MESSAGE as u64);
    // The stream begins in the middle of a message.
    let log4 = log(&bytes[700..]);
    assert_eq!(log4.scans, wanted[1..]);
    assert_eq!(log4.report.unreadable_bytes, MESSAGE as u64 - 700);
}

/// Bytes as a generator with a fixed seed draws them.
fn junk(count: usize, seed: u64) -> Vec<u8> {
    let mut state = seed;
    let next = |_| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 56) as u8
    };
    (0..count).map(next).collect()
}

#[test]
fn foreign_bytes_never_become_samples() {
    let wanted = scans(6, 1152);
    let bytes = bare(&wanted);
    let per_scan = 4 * MESSAGE;
    for seed in 0..40 {
        // At any place: in a header, among samples, between messages; put in or written over.
        let at = per_scan + seed as usize * 499 % (3 * per_scan);
        let mut put_in = bytes.clone();
        put_in.splice(at..at, junk(5000, seed));
        let mut written_over = bytes.clone();
        written_over[at..at + 5000].copy_from_slice(&junk(5000, seed));
        for damaged in [put_in, written_over] {
            let log = log(&damaged);
            assert!(log.scans.len() >= 4, "{at}: {}", log.scans.len());
            for scan in &log.scans {
                assert!(wanted.contains(scan), "{at}: a scan that was not sent");
            }
            assert!(!log.report.is_clean());
        }
    }
}

#[test]
fn pickles_pictures_and_archives_are_refused_by_name() {
    let open = |bytes: &[u8]| match read(Cursor::new(bytes.to_vec()), &Limits::default()) {
        Err(e) => e.to_string(),
        Ok(_) => panic!("read"),
    };
    // What compressed or packed data hold by chance: the two bytes of a message type.
    let mut noise = junk(40_000, 1);
    noise[1000..1002].copy_from_slice(&[0xf2, 0x01]);
    let with = |mark: &[u8]| [mark, &noise[..]].concat();
    for (mark, found) in [
        (&b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR"[..], "found a PNG image"),
        (
            b"\x80\x04\x95\xf2\x01\0\0\0\0\0\0}",
            "found a Python pickle",
        ),
        (b"\x80\x03}q\0(X\x09\0\0\0", "found a Python pickle"),
        (b"\x80\x02]q\x01(", "found a Python pickle"),
        (b"\x1f\x8b\x08\0", "found a gzip archive"),
        (b"", "found binary data"),
    ] {
        let text = open(&with(mark));
        assert!(text.contains(found), "{found}: {text}");
        assert!(text.starts_with("not a radar file"), "{text}");
    }
}

#[test]
fn several_filterings_and_windows_keep_apart() {
    let mut all = Vec::new();
    for i in 0..40 {
        for filtering in [Filtering::BandPass, Filtering::Raw, Filtering::Motion] {
            let samples = if i < 10 { 96 } else { 192 };
            all.push(Scan {
                filtering,
                ..scan(i, samples)
            });
        }
    }
    let log = log(&bare(&all));
    assert_eq!(log.scans.len(), 120);
    let made = log.radargram(&RadargramOptions::default()).unwrap();
    assert_eq!(
        (made.run.filtering, made.runs, made.run_number),
        (Filtering::Raw, 2, 1)
    );
    assert_eq!(
        (made.radargram.traces, made.radargram.samples_per_trace),
        (30, 192)
    );
    assert_eq!(made.other_scans, 90);
    let Samples::Real(values) = &made.radargram.samples else {
        panic!("real")
    };
    assert_eq!(values[0], scan(10, 192).samples[0] as f32);
    let first = RadargramOptions::default()
        .with_run(RunChoice::First)
        .with_filtering(Filtering::Motion);
    assert_eq!(log.radargram(&first).unwrap().radargram.traces, 10);
    let none = RadargramOptions::default().with_run(RunChoice::Number(2));
    assert_eq!(
        log.radargram(&none).unwrap_err().to_string(),
        "run 2 requested, but the log has 2 (raw)"
    );
    let changes = kinds(&log)
        .iter()
        .filter(|k| matches!(k, BlemishKind::WindowChanged { .. }))
        .count();
    assert_eq!(changes, 3, "one a filtering");
}

#[test]
fn hostile_and_foreign_files_are_errors_that_say_why() {
    let open = |bytes: &[u8]| read(Cursor::new(bytes.to_vec()), &Limits::default());
    assert!(matches!(open(&[]), Err(OpenError::Read(ReadError::Empty))));
    let good = bare(&scans(2, 1152));

    let swapped: Vec<u8> = good
        .chunks(MESSAGE)
        .flat_map(|m| {
            let mut m = m.to_vec();
            for field in [
                0..2,
                2..4,
                4..8,
                8..12,
                28..32,
                32..36,
                36..38,
                42..44,
                44..48,
                48..50,
                50..52,
            ] {
                m[field].reverse();
            }
            m
        })
        .collect();
    match open(&swapped) {
        Err(
            e @ OpenError::Read(ReadError::WrongEndian {
                place: Place::Byte(0),
            }),
        ) => {
            assert!(e.to_string().contains("little-endian"));
        }
        other => panic!("{other:?}"),
    }
    let with = |at: usize, value: &[u8]| {
        let mut bytes = good[..MESSAGE].to_vec();
        bytes[at..at + value.len()].copy_from_slice(value);
        bytes
    };
    for (at, value, expected) in [
        (
            42,
            &[1u8, 0x5f][..],
            HeaderFault::SamplesInMessage { found: 351 },
        ),
        (
            50,
            &[0, 0],
            HeaderFault::MessageIndex {
                index: 0,
                messages: 0,
            },
        ),
        (
            44,
            &[0xff; 4],
            HeaderFault::SamplesTotal {
                found: u32::MAX,
                messages: 4,
            },
        ),
        (36, &[0, 0], HeaderFault::Step { bins: 0 }),
        (
            32,
            &[0, 0, 0, 1],
            HeaderFault::Window {
                start_ps: 16_670,
                stop_ps: 1,
            },
        ),
    ] {
        match open(&with(at, value)) {
            Err(OpenError::Read(ReadError::BadHeader { fault, .. })) => assert_eq!(fault, expected),
            other => panic!("{expected:?}: {other:?}"),
        }
    }
    // A scan that claims 22 million samples: nothing is allocated for it, and it is reported.
    let claims = [with(44, &22_000_000u32.to_be_bytes()), vec![]].concat();
    let mut claims = claims;
    claims[50..52].copy_from_slice(&0xffffu16.to_be_bytes());
    match open(&claims) {
        Err(OpenError::Read(ReadError::NoScans { report })) => {
            assert!(matches!(
                report.blemishes[0].kind,
                BlemishKind::BadHeader(HeaderFault::Limit {
                    samples: 22_000_000,
                    ..
                })
            ));
        }
        other => panic!("{other:?}"),
    }
    // Only a configuration, only part of a message, text, noise.
    let only = RadarConfig::default().to_bytes();
    assert!(matches!(
        open(&only),
        Err(OpenError::Read(ReadError::NoScans { .. }))
    ));
    assert!(matches!(
        open(&good[..800]),
        Err(OpenError::Read(ReadError::NoScans { .. }))
    ));
    for foreign in [
        &b"%  GPST  latitude(deg)\n"[..],
        &[0; 5000],
        &[0xff, 0xd8, 0xff, 0xe0],
    ] {
        assert!(matches!(
            open(foreign),
            Err(OpenError::Read(ReadError::Unrecognised { .. }))
        ));
    }
    let limits = Limits::default().with_max_samples(2000);
    assert!(matches!(
        read_mrm(&good[..], &limits),
        Err(ReadError::Limit { limit: 2000, .. })
    ));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Cut anywhere: every scan before the cut is there, and every byte is accounted for.
    #[test]
    fn a_cut_loses_only_the_scan_it_falls_in(cut in 1usize..4 * 3 * 1456, serial in any::<bool>()) {
        let wanted = scans(4, 800);
        let framing = if serial { Framing::Serial } else { Framing::Bare };
        let bytes = write_mrm(Vec::new(), framing, None, &wanted).unwrap();
        let cut = cut.min(bytes.len());
        let per_scan = bytes.len() / 4;
        let mut reader = MrmReader::new(&bytes[..cut], Limits::default());
        let got: Vec<Scan> = reader.by_ref().map(Result::unwrap).collect();
        prop_assert_eq!(&got[..], &wanted[..cut / per_scan]);
        prop_assert_eq!(reader.report().bytes, cut as u64);
        prop_assert_eq!(reader.report().is_clean(), cut % per_scan == 0);
    }

    /// One damaged stretch costs at most the scans it touches and the one before or after.
    #[test]
    fn damage_stays_local(at in 0usize..6 * 1452, length in 1usize..2000, byte in any::<u8>()) {
        let wanted = scans(6, 350);
        let mut bytes = bare(&wanted);
        let end = (at + length).min(bytes.len());
        bytes[at..end].fill(byte);
        let got = read_mrm(&bytes[..], &Limits::default()).map(|l| l.scans).unwrap_or_default();
        for (i, scan) in wanted.iter().enumerate() {
            let touched = at < (i + 1) * MESSAGE && end > i * MESSAGE;
            prop_assert!(touched || got.contains(scan), "scan {i} lost");
        }
    }

    /// Arbitrary bytes never panic, and what is read adds up.
    #[test]
    fn noise_is_survived(bytes in proptest::collection::vec(any::<u8>(), 0..6000)) {
        let _ = read(Cursor::new(&bytes), &Limits::default());
        let mut reader = MrmReader::new(&bytes[..], Limits::default());
        for item in reader.by_ref() {
            prop_assert!(item.is_ok());
        }
        prop_assert_eq!(reader.offset(), bytes.len() as u64);
    }
}

#[test]
fn traces_and_clock_of_a_real_capture() {
    let Some(bytes) = shared("uav-flight-2019/flight.mrm") else {
        return;
    };
    let log = read_mrm(&bytes[..], &Limits::default()).unwrap();
    let made = log.radargram(&RadargramOptions::default()).unwrap();
    let (radargram, clock) = (made.radargram, made.clock);
    assert_eq!((radargram.traces, radargram.samples_per_trace), (799, 1152));
    assert!(!radargram.samples.is_complex());
    let [first, .., last] = radargram.time_s[..] else {
        panic!()
    };
    assert!((last - first - 798.0 * 21.5728e-3).abs() < 1e-3);
    assert_eq!(log.runs(Filtering::Raw).len(), 1);
    assert!(
        log.scans
            .iter()
            .all(|scan| scan.filtering == Filtering::Raw)
    );
    assert_eq!((clock.lost_scans, clock.stretches.len()), (0, 1));
    assert_eq!(log.report.incomplete_scans, 1);
}
