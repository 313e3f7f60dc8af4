//! Records of equal length: the whole ones, and the number of remaining bytes.

use std::io::Read;

use crate::bytes::fill;
use crate::error::{FormatError, Place};
use crate::limits::Limits;

/// Numbers in which samples are stored, least significant byte first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Word {
    /// Unsigned, silence at 128.
    U8,
    /// Signed.
    I16,
    /// Unsigned, silence at 32,768.
    U16,
    /// Signed.
    I32,
}

impl Word {
    pub const fn bytes(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 => 4,
        }
    }

    /// Appends the numbers of whole words.
    pub fn decode(self, bytes: &[u8], to: &mut Vec<f32>) {
        match self {
            Self::U8 => to.extend(bytes.iter().map(|b| f32::from(*b) - 128.0)),
            Self::I16 => {
                let words = bytes.as_chunks::<2>().0.iter();
                to.extend(words.map(|b| f32::from(i16::from_le_bytes(*b))));
            }
            Self::U16 => {
                let words = bytes.as_chunks::<2>().0.iter();
                to.extend(words.map(|b| f32::from(u16::from_le_bytes(*b)) - 32_768.0));
            }
            Self::I32 => {
                let words = bytes.as_chunks::<4>().0.iter();
                to.extend(words.map(|b| i32::from_le_bytes(*b) as f32));
            }
        }
    }
}

/// Hands each whole record of `record_bytes` of a stream of `length_bytes` to `take`; returns their number and the bytes
/// that are left.
///
/// # Errors
/// More samples than the limit, before any is read where the length shows it; errors of the stream and of `take`.
pub fn records(
    reader: &mut impl Read,
    length_bytes: u64,
    [record_bytes, record_samples]: [usize; 2],
    limits: &Limits,
    mut take: impl FnMut(usize, &[u8]) -> Result<(), FormatError>,
) -> Result<(usize, u64), FormatError> {
    let expected = length_bytes / record_bytes.max(1) as u64;
    limits.check_samples(Place::Whole, expected.saturating_mul(record_samples as u64))?;
    let mut buffer = vec![0; record_bytes];
    let mut count = 0;
    loop {
        let found = fill(reader, &mut buffer)?;
        if found < record_bytes {
            return Ok((count, found as u64));
        }
        let held = (count as u64 + 1).saturating_mul(record_samples as u64);
        limits.check_samples(Place::Trace(count as u64 + 1), held)?;
        take(count, &buffer)?;
        count += 1;
    }
}
