//! A receiver's messages while it has no fix.

use acerra_gnss::ubx::frame::{Piece, encode, pieces};

/// The same bytes as a receiver without reception sends them: epochs without satellites, solutions without a
/// fix, neither subframes nor time marks.
pub(super) fn without_fix(bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    for piece in pieces(bytes) {
        match piece {
            Piece::Frame(frame) => {
                let payload = match (frame.class, frame.id) {
                    (0x02, 0x15) => emptied(frame.payload, 16, 11),
                    (0x02, 0x10) => emptied(frame.payload, 8, 6),
                    (0x01, 0x07) => Some(unsolved(frame.payload)),
                    (0x01, 0x14) => Some(invalid(frame.payload)),
                    (0x02, 0x11 | 0x13) | (0x0D, 0x03) => None,
                    _ => Some(frame.payload.to_vec()),
                };
                let message = payload.and_then(|p| encode(frame.class, frame.id, &p));
                out.extend(message.unwrap_or_default());
            }
            Piece::Outside { offset, bytes: n } => {
                out.extend_from_slice(&bytes[offset..offset + n])
            }
            Piece::BadChecksum { .. } | Piece::CutOff { .. } => {}
        }
    }
    out
}

/// Measurements reduced to their head, with a count of none.
fn emptied(payload: &[u8], head_bytes: usize, count_at: usize) -> Option<Vec<u8>> {
    let mut head = payload.get(..head_bytes)?.to_vec();
    head[count_at] = 0;
    Some(head)
}

/// NAV-PVT without a fix.
fn unsolved(payload: &[u8]) -> Vec<u8> {
    let mut payload = payload.to_vec();
    for at in [20, 21, 23] {
        if let Some(byte) = payload.get_mut(at) {
            *byte = 0;
        }
    }
    payload
}

/// NAV-HPPOSLLH that calls itself invalid.
fn invalid(payload: &[u8]) -> Vec<u8> {
    let mut payload = payload.to_vec();
    if let Some(flags) = payload.get_mut(3) {
        *flags |= 1;
    }
    payload
}
