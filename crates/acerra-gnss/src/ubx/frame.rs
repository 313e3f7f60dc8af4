//! UBX frames: `B5 62`, class, identifier, length, payload, two checksum bytes.

use super::window::SumWindow;

pub use super::window::MAX_PAYLOAD_BYTES;

const OVERHEAD_BYTES: usize = 8;

/// A frame with a valid checksum.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame<'a> {
    /// Message class.
    pub class: u8,
    /// Message identifier.
    pub id: u8,
    /// The payload.
    pub payload: &'a [u8],
    /// Offset of the first synchronisation byte in the input.
    pub offset: usize,
}

/// Content of a log, piece by piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Piece<'a> {
    /// A frame.
    Frame(Frame<'a>),
    /// Bytes that belong to no frame (NMEA, RTCM, noise).
    Outside {
        /// Offset of the first byte.
        offset: usize,
        /// Number of bytes.
        bytes: usize,
    },
    /// A frame whose checksum is wrong; the search continues behind the frame's synchronisation bytes.
    BadChecksum {
        /// Offset of the first synchronisation byte.
        offset: usize,
    },
    /// The input ends inside a frame.
    CutOff {
        /// Offset of the first synchronisation byte.
        offset: usize,
    },
}

/// The pieces of a log.
///
/// ```
/// use acerra_gnss::ubx::frame::{Piece, pieces};
/// let log = [0xB5, 0x62, 0x05, 0x01, 2, 0, 0x06, 0x01, 0x0F, 0x38, b'$'];
/// let found: Vec<_> = pieces(&log).collect();
/// assert!(matches!(found[0], Piece::Frame(f) if f.class == 5 && f.payload == [6, 1]));
/// assert_eq!(found[1], Piece::Outside { offset: 10, bytes: 1 });
/// ```
pub fn pieces(log: &[u8]) -> Pieces<'_> {
    Pieces {
        log,
        at: 0,
        resumed: false,
        window: SumWindow::default(),
    }
}

/// Iterator of [`pieces`].
#[derive(Debug, Clone)]
pub struct Pieces<'a> {
    log: &'a [u8],
    at: usize,
    /// Whether the two bytes at `at` begin a frame already reported as bad, and are skipped.
    resumed: bool,
    window: SumWindow,
}

/// The 8-bit Fletcher checksum over class, identifier, length and payload.
pub fn checksum(covered: &[u8]) -> [u8; 2] {
    let (mut a, mut b) = (0_u8, 0_u8);
    for &byte in covered {
        a = a.wrapping_add(byte);
        b = b.wrapping_add(a);
    }
    [a, b]
}

/// A frame with its header and checksum, as a receiver would send it. `None` for a payload too
/// long for one.
pub fn encode(class: u8, id: u8, payload: &[u8]) -> Option<Vec<u8>> {
    if payload.len() > MAX_PAYLOAD_BYTES {
        return None;
    }
    let length = u16::try_from(payload.len()).ok()?.to_le_bytes();
    let mut out = vec![0xB5, 0x62, class, id, length[0], length[1]];
    out.extend_from_slice(payload);
    let check = checksum(&out[2..]);
    out.extend_from_slice(&check);
    Some(out)
}

impl<'a> Iterator for Pieces<'a> {
    type Item = Piece<'a>;

    fn next(&mut self) -> Option<Piece<'a>> {
        let from = self.at
            + if std::mem::take(&mut self.resumed) {
                2
            } else {
                0
            };
        let rest = self.log.get(from..).filter(|r| !r.is_empty())?;
        let sync = rest.windows(2).position(|w| w == [0xB5, 0x62]);
        let begin = from
            + sync.unwrap_or(if rest.last() == Some(&0xB5) {
                rest.len() - 1
            } else {
                rest.len()
            });
        if begin > from {
            self.at = begin;
            return Some(Piece::Outside {
                offset: from,
                bytes: begin - from,
            });
        }
        self.at = from;
        let whole = &self.log[from..];
        let length = match whole {
            [_, _, _, _, low, high, ..] => usize::from(u16::from_le_bytes([*low, *high])),
            _ => {
                self.at = self.log.len();
                return Some(Piece::CutOff { offset: from });
            }
        };
        if length > MAX_PAYLOAD_BYTES {
            self.resumed = true;
            return Some(Piece::BadChecksum { offset: from });
        }
        let Some(frame) = whole.get(..length + OVERHEAD_BYTES) else {
            // Either the log ends inside this frame, or the length is damaged and whole frames
            // follow: look for one before giving up.
            if first_valid(&whole[2..]) {
                self.resumed = true;
                return Some(Piece::BadChecksum { offset: from });
            }
            self.at = self.log.len();
            return Some(Piece::CutOff { offset: from });
        };
        let end = from + 6 + length;
        if self
            .window
            .checksum(self.log, from + 2, end)
            .as_ref()
            .map(<[u8; 2]>::as_slice)
            != self.log.get(end..end + 2)
        {
            self.resumed = true;
            return Some(Piece::BadChecksum { offset: from });
        }
        self.at = from + frame.len();
        Some(Piece::Frame(Frame {
            class: frame[2],
            id: frame[3],
            payload: &frame[6..6 + length],
            offset: from,
        }))
    }
}

/// Whether any whole frame with a right checksum is in `bytes`.
pub(crate) fn first_valid(bytes: &[u8]) -> bool {
    let mut window = SumWindow::default();
    let mut at = 0;
    while let Some(found) = bytes[at..].windows(2).position(|w| w == [0xB5, 0x62]) {
        at += found;
        if begins_frame(bytes, at, &mut window) {
            return true;
        }
        at += 2;
    }
    false
}

/// Whether a whole frame with a valid checksum begins at `at`.
fn begins_frame(bytes: &[u8], at: usize, window: &mut SumWindow) -> bool {
    let [_, _, _, _, low, high, ..] = bytes[at..] else {
        return false;
    };
    let length = usize::from(u16::from_le_bytes([low, high]));
    let end = at + 6 + length;
    length <= MAX_PAYLOAD_BYTES
        && bytes.get(end..end + 2).is_some_and(|check| {
            window
                .checksum(bytes, at + 2, end)
                .is_some_and(|found| found == check)
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_among_noise() {
        let good = encode(0x02, 0x15, &[7; 40]).unwrap();
        let mut bad = good.clone();
        bad[20] ^= 0x10;
        let mut log = b"$GNGGA,1*00\r\n".to_vec();
        log.extend_from_slice(&good);
        log.extend_from_slice(&bad);
        log.extend_from_slice(&good);
        log.extend_from_slice(&good[..30]);
        let found: Vec<Piece<'_>> = pieces(&log).collect();
        let kinds: Vec<char> = found
            .iter()
            .map(|p| match p {
                Piece::Frame(_) => 'F',
                Piece::Outside { .. } => 'o',
                Piece::BadChecksum { .. } => 'b',
                Piece::CutOff { .. } => 'c',
            })
            .collect();
        assert_eq!(kinds, ['o', 'F', 'b', 'o', 'F', 'c']);
        assert!(matches!(found[4], Piece::Frame(f) if f.offset == 13 + 48 + 48));
    }

    /// A damaged length that reaches over the end must not swallow the frames behind it.
    #[test]
    fn a_damaged_length_costs_one_frame() {
        let good = encode(0x01, 0x07, &[1; 92]).unwrap();
        let mut log = good.clone();
        log[5] = 0x20;
        log.extend_from_slice(&good);
        let frames = pieces(&log)
            .filter(|p| matches!(p, Piece::Frame(_)))
            .count();
        assert_eq!(frames, 1);
    }

    #[test]
    fn every_cut_is_survived_and_accounted_for() {
        let mut log = encode(0x0D, 0x03, &[9; 28]).unwrap();
        log.extend_from_slice(&encode(0x02, 0x13, &[0xB5, 0x62, 0xB5]).unwrap());
        for cut in 0..log.len() {
            let frames = pieces(&log[..cut])
                .filter(|p| matches!(p, Piece::Frame(_)))
                .count();
            assert_eq!(frames, usize::from(cut >= 36), "cut at {cut}");
        }
    }
}
