//! Any bytes as an RTCM 3 log: every byte is accounted for, and no measurement is impossible.
#![no_main]

use acerra_geo::time::GpsTime;
use acerra_gnss::rtcm::frame::{Piece, encode, pieces};
use acerra_gnss::rtcm::{RtcmHints, read_rtcm};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut at = 0;
    for piece in pieces(bytes) {
        let (offset, end) = match piece {
            Piece::Frame(f) => (f.offset, f.offset + f.payload.len() + 6),
            Piece::Outside { offset, bytes } | Piece::Damaged { offset, bytes } => {
                (offset, offset + bytes)
            }
            Piece::CutOff { offset } => (offset, bytes.len()),
        };
        assert_eq!(offset, at);
        at = end;
    }
    assert_eq!(at, bytes.len());
    read(bytes);
    // Whole messages around the same bytes, so that the fuzzer need not guess checksums.
    let [length, payload @ ..] = bytes else { return };
    let mut log = Vec::new();
    for part in payload.chunks(usize::from(*length) + 8) {
        log.extend(encode(part).expect("short"));
    }
    read(&log);
});

fn read(bytes: &[u8]) {
    let stated = RtcmHints {
        near: Some(GpsTime::from_week_tow(2262, 200_000.0)),
        not_after: Some(GpsTime::from_week_tow(2400, 0.0)),
        glonass_channels: (1..=24).map(|number| (number, 3)).collect(),
    };
    for hints in [RtcmHints::default(), stated] {
        let log = read_rtcm(bytes, &hints);
        assert!(log.date.is_some() || log.epochs.is_empty());
        for (_, epoch) in &log.epochs {
            for signal in epoch.satellites.iter().flat_map(|s| &s.signals) {
                let values = [signal.pseudorange_m, signal.phase_cycles, signal.doppler_hz];
                assert!(values.into_iter().flatten().all(f64::is_finite));
            }
        }
    }
}
