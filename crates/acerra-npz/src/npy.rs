//! One NPY array from an untrusted stream.
//!
//! The header is parsed here rather than by a general Python-literal parser, whose recursion a
//! hostile header can drive into the stack's end.

use std::io::{self, Read};

use thiserror::Error;

/// Longest header accepted; NumPy itself writes 118 bytes for plain arrays.
const MAX_HEADER_BYTES: usize = 1 << 16;
const CHUNK_BYTES: usize = 1 << 16;

/// Memory for the values of any archive, as numbers of double precision, and multiple of the archive's length
/// beyond that: bytes become numbers of eight bytes, and measured values hardly compress.
const FREE_BYTES: u64 = 128 << 20;
const MOST_TIMES: u64 = 12;

/// Reason why an array could not be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum NpyError {
    /// The stream ended or failed.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// The bytes are not an NPY array.
    #[error("not an NPY array: {expected} expected at byte {offset}")]
    Format {
        /// Expected content.
        expected: &'static str,
        /// Byte offset in the array's stream.
        offset: usize,
    },
    /// The element type is not a number this reader knows.
    #[error("element type {found}: expected a float, integer or complex type")]
    ElementType {
        /// NumPy's name of the type.
        found: String,
    },
    /// The array's shape differs from the requested one.
    #[error("shape {found:?}: expected {expected}")]
    Shape {
        /// Wanted shape, in words.
        expected: String,
        /// Shape in the header.
        found: Vec<u64>,
    },
    /// The header claims more than the limit.
    #[error("header claims {claimed} values; at most {limit} are read")]
    Limit {
        /// Values the shape asks for.
        claimed: u128,
        /// The limit.
        limit: usize,
    },
    /// The header claims more than an archive of this length can hold, unless it compresses to almost
    /// nothing.
    #[error(
        "header claims {claimed} values, which an archive of {archive_bytes} bytes holds only where they \
         compress to almost nothing; at most {limit} are read: store the arrays uncompressed (numpy.savez)"
    )]
    Unjustified {
        /// Values the shape asks for.
        claimed: usize,
        /// Length of the archive.
        archive_bytes: u64,
        /// The limit.
        limit: usize,
    },
    /// The header claims more values than there are.
    #[error("header claims {claimed} values, only {found} are there")]
    CutOff {
        /// Values the shape asks for.
        claimed: usize,
        /// Whole values found.
        found: usize,
    },
    /// A part that is not within the array.
    #[error("expected values within 0 to {total}, found {count} from {first}")]
    Part {
        /// The first requested value.
        first: u64,
        /// Values asked for.
        count: u64,
        /// Values of the array.
        total: u64,
    },
    /// Bytes follow the last value.
    #[error("more bytes follow the {claimed} values that the header claims")]
    Trailing {
        /// Values the shape asks for.
        claimed: usize,
    },
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Float,
    Signed,
    Unsigned,
    Complex,
}

/// What an NPY header says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NpyHeader {
    kind: Kind,
    item_bytes: usize,
    big_endian: bool,
    /// Whether the first index varies fastest.
    pub fortran_order: bool,
    /// Length along each dimension; empty for a single value.
    pub shape: Vec<u64>,
}

impl NpyHeader {
    /// Whether the values are complex.
    #[must_use]
    pub fn is_complex(&self) -> bool {
        self.kind == Kind::Complex
    }

    /// Bytes of a value.
    pub(crate) fn item_bytes(&self) -> usize {
        self.item_bytes
    }

    /// Checks that an archive of this length justifies memory for the values.
    pub(crate) fn check_archive(&self, archive_bytes: u64) -> Result<(), NpyError> {
        let claimed = self.value_count(usize::MAX)?;
        let value_bytes = if self.is_complex() { 16 } else { 8 };
        let held = FREE_BYTES.max(MOST_TIMES.saturating_mul(archive_bytes));
        let limit = usize::try_from(held / value_bytes).unwrap_or(usize::MAX);
        if claimed > limit {
            return Err(NpyError::Unjustified {
                claimed,
                archive_bytes,
                limit,
            });
        }
        Ok(())
    }

    /// Checks that this number of bytes is that of the header's values.
    pub(crate) fn check_bytes(&self, bytes: u64) -> Result<(), NpyError> {
        let claimed = self.value_count(usize::MAX)?;
        let found = usize::try_from(bytes).unwrap_or(usize::MAX) / self.item_bytes;
        match claimed.cmp(&found) {
            std::cmp::Ordering::Greater => Err(NpyError::CutOff { claimed, found }),
            std::cmp::Ordering::Less => Err(NpyError::Trailing { claimed }),
            std::cmp::Ordering::Equal => Ok(()),
        }
    }

    /// Checks that `count` values from `first` on are within the array.
    pub(crate) fn check_part(&self, first: u64, count: u64) -> Result<(), NpyError> {
        let total = self.value_count(usize::MAX)? as u64;
        match first.checked_add(count) {
            Some(end) if end <= total => Ok(()),
            _ => Err(NpyError::Part {
                first,
                count,
                total,
            }),
        }
    }

    /// Number of values, checked against `limit`.
    ///
    /// # Errors
    /// [`NpyError::Limit`] if the shape asks for more.
    pub fn value_count(&self, limit: usize) -> Result<usize, NpyError> {
        let claimed = self
            .shape
            .iter()
            .try_fold(1u128, |n, &d| n.checked_mul(u128::from(d)))
            .unwrap_or(u128::MAX);
        match usize::try_from(claimed) {
            Ok(n) if n <= limit => Ok(n),
            _ => Err(NpyError::Limit { claimed, limit }),
        }
    }

    /// Reads magic, version and header.
    ///
    /// # Errors
    /// Bytes that are not an NPY header, or an element type that is no number.
    pub fn read(reader: &mut impl Read) -> Result<Self, NpyError> {
        let mut preamble = [0u8; 8];
        reader.read_exact(&mut preamble)?;
        if &preamble[..6] != b"\x93NUMPY" {
            return Err(NpyError::Format {
                expected: "the magic bytes \\x93NUMPY",
                offset: 0,
            });
        }
        let (length, start) = match preamble[6] {
            1 => {
                let mut b = [0u8; 2];
                reader.read_exact(&mut b)?;
                (usize::from(u16::from_le_bytes(b)), 10)
            }
            2 | 3 => {
                let mut b = [0u8; 4];
                reader.read_exact(&mut b)?;
                (u32::from_le_bytes(b) as usize, 12)
            }
            _ => {
                return Err(NpyError::Format {
                    expected: "format version 1, 2 or 3",
                    offset: 6,
                });
            }
        };
        if length > MAX_HEADER_BYTES {
            return Err(NpyError::Format {
                expected: "a header below 64 KiB",
                offset: 8,
            });
        }
        let mut text = vec![0u8; length];
        reader.read_exact(&mut text)?;
        HeaderText {
            text: &text,
            at: 0,
            start,
        }
        .parse()
    }

    /// Reads the values, handing `(re, im)` of each to `sink` in file order.
    ///
    /// # Errors
    /// More values than `limit`, fewer or more bytes than the shape asks for.
    pub fn read_values(
        &self,
        reader: &mut impl Read,
        limit: usize,
        mut sink: impl FnMut(f64, f64),
    ) -> Result<(), NpyError> {
        let claimed = self.value_count(limit)?;
        let mut buffer = vec![0u8; CHUNK_BYTES / self.item_bytes * self.item_bytes];
        let mut found = 0usize;
        while found < claimed {
            let want = (claimed - found).min(buffer.len() / self.item_bytes) * self.item_bytes;
            let got = read_up_to(reader, &mut buffer[..want])?;
            for item in buffer[..got].chunks_exact(self.item_bytes) {
                let (re, im) = self.decode(item);
                sink(re, im);
            }
            found += got / self.item_bytes;
            if got < want {
                return Err(NpyError::CutOff { claimed, found });
            }
        }
        // Reading on to the end also makes the archive verify its checksum.
        if read_up_to(reader, &mut buffer[..1])? > 0 {
            return Err(NpyError::Trailing { claimed });
        }
        Ok(())
    }

    pub(crate) fn decode(&self, item: &[u8]) -> (f64, f64) {
        if self.kind == Kind::Complex {
            let (re, im) = item.split_at(self.item_bytes / 2);
            return (
                self.decode_one(Kind::Float, re),
                self.decode_one(Kind::Float, im),
            );
        }
        (self.decode_one(self.kind, item), 0.0)
    }

    fn decode_one(&self, kind: Kind, item: &[u8]) -> f64 {
        let mut bits = [0u8; 8];
        let n = item.len();
        for (i, &byte) in item.iter().enumerate() {
            bits[if self.big_endian { n - 1 - i } else { i }] = byte;
        }
        let raw = u64::from_le_bytes(bits);
        match (kind, n) {
            (Kind::Float, 2) => f64_from_half(raw as u16),
            (Kind::Float, 4) => f64::from(f32::from_bits(raw as u32)),
            (Kind::Float | Kind::Complex, _) => f64::from_bits(raw),
            (Kind::Unsigned, _) => raw as f64,
            (Kind::Signed, _) => {
                let unused = 64 - 8 * n as u32;
                ((raw << unused) as i64 >> unused) as f64
            }
        }
    }
}

/// IEEE 754 binary16.
fn f64_from_half(bits: u16) -> f64 {
    let sign = if bits & 0x8000 == 0 { 1.0 } else { -1.0 };
    let exponent = i32::from(bits >> 10 & 0x1f);
    let fraction = f64::from(bits & 0x3ff) / 1024.0;
    sign * match exponent {
        0 => fraction * 2f64.powi(-14),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1.0 + fraction) * 2f64.powi(exponent - 15),
    }
}

fn read_up_to(reader: &mut impl Read, buffer: &mut [u8]) -> io::Result<usize> {
    let mut filled = 0;
    while filled < buffer.len() {
        match reader.read(&mut buffer[filled..]) {
            Ok(0) => break,
            Ok(n) => filled += n,
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
    Ok(filled)
}

/// The header's dictionary: `{'descr': '<f4', 'fortran_order': False, 'shape': (3, 4), }`.
struct HeaderText<'a> {
    text: &'a [u8],
    at: usize,
    /// Offset of the text in the stream, for messages.
    start: usize,
}

impl HeaderText<'_> {
    fn parse(mut self) -> Result<NpyHeader, NpyError> {
        let (mut descr, mut fortran_order, mut shape) = (None, None, None);
        self.expect(b'{', "a dictionary")?;
        while !self.take(b'}') {
            let key = self.string()?;
            self.expect(b':', "a colon")?;
            match key.as_str() {
                "descr" => descr = Some(self.element_type()?),
                "fortran_order" => fortran_order = Some(self.boolean()?),
                "shape" => shape = Some(self.tuple()?),
                _ => return Err(self.wrong("the keys descr, fortran_order and shape")),
            }
            if !self.take(b',') {
                self.expect(b'}', "a comma or the dictionary's end")?;
                break;
            }
        }
        let missing = self.wrong("the keys descr, fortran_order and shape");
        let ((kind, item_bytes, big_endian), Some(fortran_order), Some(shape)) =
            (descr.ok_or(missing)?, fortran_order, shape)
        else {
            return Err(self.wrong("the keys descr, fortran_order and shape"));
        };
        Ok(NpyHeader {
            kind,
            item_bytes,
            big_endian,
            fortran_order,
            shape,
        })
    }

    fn wrong(&self, expected: &'static str) -> NpyError {
        NpyError::Format {
            expected,
            offset: self.start + self.at,
        }
    }

    fn peek(&mut self) -> Option<u8> {
        while self.text.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
        self.text.get(self.at).copied()
    }

    fn take(&mut self, byte: u8) -> bool {
        let hit = self.peek() == Some(byte);
        self.at += usize::from(hit);
        hit
    }

    fn expect(&mut self, byte: u8, expected: &'static str) -> Result<(), NpyError> {
        if self.take(byte) {
            Ok(())
        } else {
            Err(self.wrong(expected))
        }
    }

    fn string(&mut self) -> Result<String, NpyError> {
        let quote = match self.peek() {
            Some(q @ (b'\'' | b'"')) => q,
            _ => return Err(self.wrong("a quoted string")),
        };
        let rest = &self.text[self.at + 1..];
        let Some(end) = rest.iter().position(|&b| b == quote) else {
            return Err(self.wrong("a closed string"));
        };
        let value = String::from_utf8_lossy(&rest[..end]).into_owned();
        self.at += end + 2;
        Ok(value)
    }

    fn boolean(&mut self) -> Result<bool, NpyError> {
        self.peek();
        for (word, value) in [(&b"True"[..], true), (&b"False"[..], false)] {
            if self.text[self.at..].starts_with(word) {
                self.at += word.len();
                return Ok(value);
            }
        }
        Err(self.wrong("True or False"))
    }

    fn tuple(&mut self) -> Result<Vec<u64>, NpyError> {
        self.expect(b'(', "a tuple")?;
        let mut dims = Vec::new();
        while !self.take(b')') {
            self.peek();
            let digits = self.text[self.at..]
                .iter()
                .take_while(|b| b.is_ascii_digit())
                .count();
            let dim = std::str::from_utf8(&self.text[self.at..self.at + digits])
                .ok()
                .and_then(|s| s.parse().ok())
                .ok_or_else(|| self.wrong("a dimension"))?;
            self.at += digits;
            self.take(b'L'); // NumPy under Python 2
            dims.push(dim);
            if dims.len() > 32 {
                return Err(self.wrong("at most 32 dimensions"));
            }
            if !self.take(b',') {
                self.expect(b')', "a comma or the tuple's end")?;
                break;
            }
        }
        Ok(dims)
    }

    fn element_type(&mut self) -> Result<(Kind, usize, bool), NpyError> {
        if self.peek() == Some(b'[') {
            return Err(NpyError::ElementType {
                found: "a record".into(),
            });
        }
        let found = self.string()?;
        let mut chars = found.chars();
        let big_endian = match chars.next() {
            Some('<' | '|') => Some(false),
            Some('>') => Some(true),
            Some('=') => Some(cfg!(target_endian = "big")),
            _ => None,
        };
        let parsed = match (chars.next(), chars.as_str()) {
            (Some('f'), "2") => Some((Kind::Float, 2)),
            (Some('f'), "4") => Some((Kind::Float, 4)),
            (Some('f'), "8") => Some((Kind::Float, 8)),
            (Some('c'), "8") => Some((Kind::Complex, 8)),
            (Some('c'), "16") => Some((Kind::Complex, 16)),
            (Some(k @ ('i' | 'u')), n @ ("1" | "2" | "4" | "8")) => Some((
                if k == 'i' {
                    Kind::Signed
                } else {
                    Kind::Unsigned
                },
                usize::from(n.as_bytes()[0] - b'0'),
            )),
            _ => None,
        };
        match (big_endian, parsed) {
            (Some(big), Some((kind, bytes))) => Ok((kind, bytes, big)),
            _ => Err(NpyError::ElementType {
                found: format!("'{found}'"),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn npy(header: &str, body: &[u8]) -> Vec<u8> {
        let mut v = b"\x93NUMPY\x01\x00".to_vec();
        v.extend((header.len() as u16).to_le_bytes());
        v.extend(header.as_bytes());
        v.extend(body);
        v
    }

    fn values(bytes: &[u8]) -> Result<Vec<(f64, f64)>, NpyError> {
        let mut reader = bytes;
        let header = NpyHeader::read(&mut reader)?;
        let mut out = Vec::new();
        header.read_values(&mut reader, 1000, |re, im| out.push((re, im)))?;
        Ok(out)
    }

    #[test]
    fn every_element_type_decodes() {
        let one = |descr: &str, bytes: &[u8]| {
            values(&npy(
                &format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': (1,), }}  \n"),
                bytes,
            ))
            .unwrap()[0]
        };
        assert_eq!(one("<f4", &1.5f32.to_le_bytes()), (1.5, 0.0));
        assert_eq!(one(">f8", &(-2.25f64).to_be_bytes()), (-2.25, 0.0));
        assert_eq!(one("<f2", &0xC500u16.to_le_bytes()), (-5.0, 0.0));
        assert_eq!(one("<f2", &1u16.to_le_bytes()), (2f64.powi(-24), 0.0));
        assert_eq!(one("|i1", &[0xfe]), (-2.0, 0.0));
        assert_eq!(one(">i2", &(-300i16).to_be_bytes()), (-300.0, 0.0));
        assert_eq!(one("<u4", &u32::MAX.to_le_bytes()), (4_294_967_295.0, 0.0));
        assert_eq!(one("<i8", &(-7i64).to_le_bytes()), (-7.0, 0.0));
        let mut z = 1f32.to_be_bytes().to_vec();
        z.extend((-2f32).to_be_bytes());
        assert_eq!(one(">c8", &z), (1.0, -2.0));
    }

    #[test]
    fn headers_that_claim_too_much_are_refused_before_allocation() {
        let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (4294967296, 4294967296, 4294967296, 4294967296, 9), }";
        assert!(matches!(
            values(&npy(header, &[])),
            Err(NpyError::Limit { limit: 1000, .. })
        ));
        let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (900,), }";
        assert!(matches!(
            values(&npy(header, &[0; 20])),
            Err(NpyError::CutOff {
                claimed: 900,
                found: 2
            })
        ));
        let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (1,), }";
        assert!(matches!(
            values(&npy(header, &[0; 9])),
            Err(NpyError::Trailing { claimed: 1 })
        ));
        let mut long = b"\x93NUMPY\x02\x00".to_vec();
        long.extend(u32::MAX.to_le_bytes());
        assert!(matches!(
            values(&long),
            Err(NpyError::Format { offset: 8, .. })
        ));
    }

    #[test]
    fn nested_and_foreign_headers_are_refused() {
        for header in [
            "",
            "{",
            "{'descr'",
            "{'descr': (((((((((((((",
            "{'descr': '<f8', 'fortran_order': False}",
            "{'descr': '<f8', 'fortran_order': maybe, 'shape': ()}",
            "{'descr': '<f8', 'fortran_order': False, 'shape': (-1,)}",
            "{'descr': '<f8', 'fortran_order': False, 'shape': (99999999999999999999,)}",
        ] {
            assert!(
                matches!(values(&npy(header, &[])), Err(NpyError::Format { .. })),
                "{header}"
            );
        }
        for descr in ["'|O'", "'<U3'", "'<f16'", "[('a', '<f8')]", "''"] {
            let header = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': (1,)}}");
            assert!(
                matches!(
                    values(&npy(&header, &[])),
                    Err(NpyError::ElementType { .. })
                ),
                "{descr}"
            );
        }
    }
}
