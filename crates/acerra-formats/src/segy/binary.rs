//! The binary header, which is behind 3,200 bytes of text.

use super::sample::SampleFormat;
use crate::bytes::{Fields, Order};
use crate::error::{FormatError, Place};

/// Bytes of text before the binary header, and of each extended text.
pub const TEXT_BYTES: usize = 3200;
/// Bytes of the binary header.
pub const BINARY_BYTES: usize = 400;

/// Content of the binary header.
#[derive(Debug, Clone)]
pub struct BinaryHeader {
    pub order: Order,
    pub format: SampleFormat,
    /// Traces of one record, over antennas.
    pub ensemble_traces: usize,
    /// Interval between samples in the header's integer unit.
    pub interval: u16,
    /// Interval in double precision (revision 2), µs.
    pub extended_interval_us: Option<f64>,
    pub samples: usize,
    /// Whether lengths are in feet.
    pub is_feet: bool,
    pub revision: [u8; 2],
    /// Extended texts; none if their number is left open.
    pub extended_texts: Option<usize>,
    /// Further headers of 240 bytes with each trace.
    pub extra_trace_headers: usize,
    /// Byte at which the first trace begins, where stated.
    pub first_trace_byte: Option<u64>,
}

/// Order and sample format, where the bytes can be a binary header.
fn recognise(binary: &[u8]) -> Option<(Order, SampleFormat)> {
    // The constant of revision 2 gives the order; without it, the code of the sample format, which is below
    // 256.
    const ORDER: [u8; 4] = [1, 2, 3, 4];
    let code = binary.get(24..26)?;
    let [big, little] = [[code[0], code[1]], [code[1], code[0]]].map(u16::from_be_bytes);
    let marks = binary.get(96..100)?;
    let reversed: Vec<u8> = ORDER.iter().rev().copied().collect();
    if marks == ORDER {
        return Some((Order::Big, SampleFormat::of(big)?));
    }
    if marks == reversed {
        return Some((Order::Little, SampleFormat::of(little)?));
    }
    let big = SampleFormat::of(big).map(|f| (Order::Big, f));
    big.or_else(|| SampleFormat::of(little).map(|f| (Order::Little, f)))
}

/// Whether a file's first 3,600 bytes are those of SEG-Y: a text of 40 lines and a valid binary header.
#[must_use]
pub fn is_segy(head: &[u8]) -> bool {
    let Some(binary) = head.get(TEXT_BYTES..TEXT_BYTES + BINARY_BYTES) else {
        return false;
    };
    let Some((order, _)) = recognise(binary) else {
        return false;
    };
    let fields = Fields {
        bytes: binary,
        order,
    };
    let samples = fields.u16(20) > 0 || fields.i32(68) > 0;
    // Text in ASCII or EBCDIC, or blanks: no control characters but NUL and line ends.
    let text = &head[..TEXT_BYTES];
    let odd = |b: &&u8| !matches!(**b, 0 | 9 | 10 | 13 | 0x25 | 0x20..=0x7e | 0x80..=0xff);
    let odd = text.iter().filter(odd).count();
    let is_other = head.starts_with(b"PK") || head.starts_with(b"\x89HDF");
    samples && odd * 20 < TEXT_BYTES && !is_other && has_plain_revision(&fields)
}

/// Revision 0, 1 or 2 with small numbers in the counts that follow it.
fn has_plain_revision(fields: &Fields<'_>) -> bool {
    let major = fields.bytes[300];
    let texts = fields.i16(304);
    major <= 2 && (-1..=1024).contains(&texts)
}

impl BinaryHeader {
    /// # Errors
    /// A sample format that is not known or not read, no samples.
    pub fn read(bytes: &[u8]) -> Result<Self, FormatError> {
        let Some((order, format)) = recognise(bytes) else {
            return Err(FormatError::content(
                Place::Byte(3224),
                "a sample format code from 1 to 16 that is read",
                Fields {
                    bytes,
                    order: Order::Big,
                }
                .u16(24),
            ));
        };
        let fields = Fields { bytes, order };
        let revision = [bytes[300], bytes[301]];
        let is_two = revision[0] >= 2;
        let extended = fields.i32(68);
        let samples = if is_two && extended > 0 {
            extended as usize
        } else {
            usize::from(fields.u16(20))
        };
        let interval_us = fields.f64(72);
        let first = fields.u64(320);
        Ok(Self {
            order,
            format,
            ensemble_traces: usize::try_from(fields.i16(12)).unwrap_or(0),
            interval: fields.u16(16),
            extended_interval_us: (is_two && interval_us.is_finite() && interval_us > 0.0)
                .then_some(interval_us),
            samples,
            is_feet: fields.u16(54) == 2,
            revision,
            extended_texts: match (revision[0], fields.i16(304)) {
                (0, _) => Some(0),
                (_, n) => usize::try_from(n).ok(),
            },
            extra_trace_headers: if is_two {
                usize::try_from(fields.i32(306)).unwrap_or(0)
            } else {
                0
            },
            first_trace_byte: (is_two && first >= (TEXT_BYTES + BINARY_BYTES) as u64)
                .then_some(first),
        })
    }
}
