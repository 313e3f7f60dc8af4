//! The transport layer: preamble, ten bits of length, payload, CRC-24Q (RTCM 10403.3, section 4).

use super::window::CrcWindow;
use crate::orbits::bits::{BitCursor, crc24q};

const PREAMBLE: u8 = 0xD3;
const HEADER_BYTES: usize = 3;
const OVERHEAD_BYTES: usize = HEADER_BYTES + 3;
/// Ten bits of length.
const MAX_PAYLOAD_BYTES: usize = 1023;

/// A message with a valid checksum.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame<'a> {
    /// Message number (DF002); 0 for a payload too short to hold one.
    pub number: u16,
    /// Payload, message number included.
    pub payload: &'a [u8],
    /// Byte offset of the preamble in the log.
    pub offset: usize,
}

/// A piece of a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Piece<'a> {
    /// A whole message.
    Frame(Frame<'a>),
    /// Bytes outside any message.
    Outside {
        /// Offset of the first byte.
        offset: usize,
        /// Number of bytes.
        bytes: usize,
    },
    /// The place of an expected message: a preamble with a wrong checksum, and the bytes up to the next whole
    /// message.
    Damaged {
        /// Offset of the first byte.
        offset: usize,
        /// Number of bytes.
        bytes: usize,
    },
    /// A message that the end of the log cuts off.
    CutOff {
        /// Offset of the first byte.
        offset: usize,
    },
}

/// The pieces of a log, in order and without gaps.
///
/// ```
/// use acerra_gnss::rtcm::frame::{Piece, encode, pieces};
/// let mut log = b"noise".to_vec();
/// log.extend(encode(&[0x3E, 0xD0, 0, 3]).unwrap());
/// let found: Vec<Piece<'_>> = pieces(&log).collect();
/// assert_eq!(found[0], Piece::Outside { offset: 0, bytes: 5 });
/// assert!(matches!(found[1], Piece::Frame(f) if f.number == 1005 && f.offset == 5));
/// ```
pub fn pieces(log: &[u8]) -> Pieces<'_> {
    Pieces {
        log,
        at: 0,
        window: CrcWindow::default(),
    }
}

/// Iterator over the pieces of a log; see [`pieces`].
#[derive(Debug, Clone)]
pub struct Pieces<'a> {
    log: &'a [u8],
    at: usize,
    window: CrcWindow,
}

impl<'a> Pieces<'a> {
    /// The whole message that begins at `offset`.
    fn whole_frame(&mut self, offset: usize) -> Option<Frame<'a>> {
        let length = payload_length(self.log.get(offset..)?)?;
        let end = offset + HEADER_BYTES + length;
        let check = self.log.get(end..end + 3)?;
        if self.window.crc(self.log, offset, end)?
            != u32::from_be_bytes([0, check[0], check[1], check[2]])
        {
            return None;
        }
        let payload = &self.log[offset + HEADER_BYTES..end];
        let number = BitCursor::new(payload).unsigned(12).unwrap_or(0);
        Some(Frame {
            number: u16::try_from(number).unwrap_or(0),
            payload,
            offset,
        })
    }

    /// Offset of the first whole message from `at` on.
    fn first_valid_at(&mut self, mut at: usize) -> Option<usize> {
        while let Some(found) = self.log.get(at..)?.iter().position(|&b| b == PREAMBLE) {
            at += found;
            if self.whole_frame(at).is_some() {
                return Some(at);
            }
            at += 1;
        }
        None
    }
}

impl<'a> Iterator for Pieces<'a> {
    type Item = Piece<'a>;

    fn next(&mut self) -> Option<Piece<'a>> {
        let from = self.at;
        let rest = self.log.get(from..).filter(|rest| !rest.is_empty())?;
        if let Some(frame) = self.whole_frame(from) {
            self.at = from + frame.payload.len() + OVERHEAD_BYTES;
            return Some(Piece::Frame(frame));
        }
        self.at = self.first_valid_at(from + 1).unwrap_or(self.log.len());
        let next = self.at - from;
        let ends_the_log = self.at == self.log.len();
        Some(match payload_length(rest) {
            Some(length) if ends_the_log && length + OVERHEAD_BYTES > rest.len() => {
                Piece::CutOff { offset: from }
            }
            Some(_) => Piece::Damaged {
                offset: from,
                bytes: next,
            },
            None => Piece::Outside {
                offset: from,
                bytes: next,
            },
        })
    }
}

/// The length that a preamble at the beginning of `bytes` announces.
fn payload_length(bytes: &[u8]) -> Option<usize> {
    match bytes {
        [PREAMBLE, high, low, ..] if high >> 2 == 0 => {
            Some(usize::from(u16::from_be_bytes([*high, *low])))
        }
        _ => None,
    }
}

/// Whether any whole message with a number that RTCM 3 uses is in `bytes`.
pub(crate) fn first_valid(bytes: &[u8]) -> bool {
    pieces(bytes).any(|p| matches!(p, Piece::Frame(f) if (1001..=4095).contains(&f.number)))
}

/// A message around `payload`; `None` where it is longer than ten bits of length can express.
#[must_use]
pub fn encode(payload: &[u8]) -> Option<Vec<u8>> {
    if payload.len() > MAX_PAYLOAD_BYTES {
        return None;
    }
    let [_, _, high, low] = u32::try_from(payload.len()).ok()?.to_be_bytes();
    let mut out = vec![PREAMBLE, high, low];
    out.extend_from_slice(payload);
    let check = crc24q(&out).to_be_bytes();
    out.extend_from_slice(&check[1..]);
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kinds(log: &[u8]) -> String {
        pieces(log)
            .map(|p| match p {
                Piece::Frame(_) => 'F',
                Piece::Outside { .. } => 'o',
                Piece::Damaged { .. } => 'd',
                Piece::CutOff { .. } => 'c',
            })
            .collect()
    }

    #[test]
    fn frames_among_noise_and_damage() {
        let good = encode(&[0x3E, 0xD0, 1, 2, 3, 4, 5, 6]).unwrap();
        let mut bad = good.clone();
        bad[6] ^= 0x10;
        let mut log = b"$GNGGA,1*00\r\n".to_vec();
        for part in [&good[..], &bad, &good, &good[..9]] {
            log.extend_from_slice(part);
        }
        assert_eq!(kinds(&log), "oFdFc");
    }

    /// A damaged length that reaches over the end must not swallow the messages behind it.
    #[test]
    fn a_damaged_length_costs_one_message() {
        let good = encode(&[7; 40]).unwrap();
        let mut log = good.clone();
        log[1] = 3;
        log.extend_from_slice(&good);
        assert_eq!(kinds(&log), "dF");
    }

    #[test]
    fn every_cut_is_survived_and_accounted_for() {
        let mut log = encode(&[9; 28]).unwrap();
        log.extend_from_slice(&encode(&[0xD3, 0, 0xD3]).unwrap());
        for cut in 0..log.len() {
            let frames = kinds(&log[..cut]).matches('F').count();
            assert_eq!(frames, usize::from(cut >= 34), "cut at {cut}");
        }
    }

    #[test]
    fn the_longest_message() {
        let whole = encode(&[1; 1023]).unwrap();
        assert_eq!(kinds(&whole), "F");
        assert_eq!(encode(&[1; 1024]), None);
    }
}
