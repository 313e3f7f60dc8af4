//! Any bytes as a UBX log: every byte is accounted for, and no measurement is impossible.
#![no_main]

use acerra_gnss::ubx::frame::{Piece, encode, pieces};
use acerra_gnss::ubx::{fine_position, fix_state, read_ubx, receiver_solution, rising_edge};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut at = 0;
    for piece in pieces(bytes) {
        let (offset, end) = match piece {
            Piece::Frame(f) => (f.offset, f.offset + f.payload.len() + 8),
            Piece::Outside { offset, bytes } => (offset, offset + bytes),
            Piece::BadChecksum { offset } => (offset, offset + 2),
            Piece::CutOff { offset } => (offset, bytes.len()),
        };
        assert_eq!(offset, at);
        at = end;
    }
    assert!(at == bytes.len() || bytes.is_empty());
    read(bytes);
    // Whole frames around the same bytes, so that the fuzzer need not guess checksums.
    let [kind, payload @ ..] = bytes else { return };
    let known = [
        (0x02, 0x15),
        (0x02, 0x10),
        (0x02, 0x13),
        (0x02, 0x11),
        (0x0D, 0x03),
        (0x01, 0x07),
        (0x01, 0x14),
    ];
    let (class, id) = known[usize::from(*kind) % known.len()];
    let mut log = Vec::new();
    for part in payload.chunks(usize::from(payload.first().copied().unwrap_or(0)) + 8) {
        log.extend(encode(class, id, part).expect("short"));
    }
    read(&log);
});

fn read(bytes: &[u8]) {
    for piece in pieces(bytes) {
        if let Piece::Frame(frame) = piece {
            let fix = fix_state(&frame);
            assert!(fix.is_none_or(|f| f.height_m.is_none() || f.has_fix));
            let solution = receiver_solution(&frame);
            assert!(solution.is_none_or(|s| s.place.latitude_deg().abs() <= 90.0));
            let time = solution.and_then(|s| s.time);
            assert!(time.is_none_or(|t| (0.0..604_800.0).contains(&t.tow_s())));
            let fine = fine_position(&frame);
            assert!(fine.is_none_or(|f| f.place.height_m.is_finite() && f.sigma_m[2] >= 0.0));
            let edge = rising_edge(&frame);
            assert!(edge.is_none_or(|e| e.time.tow_s().is_finite()));
        }
    }
    let log = read_ubx(bytes);
    for (_, epoch) in &log.epochs {
        for signal in epoch.satellites.iter().flat_map(|s| &s.signals) {
            let values = [signal.pseudorange_m, signal.phase_cycles, signal.doppler_hz];
            assert!(values.into_iter().flatten().all(f64::is_finite));
        }
    }
}
