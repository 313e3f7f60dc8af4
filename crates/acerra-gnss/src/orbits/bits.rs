//! Bit fields of navigation messages, most significant bit first.

/// π truncated as the interface documents of the systems define it for semicircles.
#[expect(clippy::approx_constant, reason = "the systems' own value")]
pub(crate) const SEMICIRCLE_RAD: f64 = 3.141_592_653_589_8;

/// Bits packed from the left.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Bits {
    bytes: Vec<u8>,
    length: usize,
}

impl Bits {
    /// Appends the lowest `width` bits of `value`.
    pub(crate) fn push(&mut self, value: u32, width: usize) {
        for i in (0..width).rev() {
            if self.length.is_multiple_of(8) {
                self.bytes.push(0);
            }
            let bit = (value >> i & 1) as u8;
            self.bytes[self.length / 8] |= bit << (7 - self.length % 8);
            self.length += 1;
        }
    }

    /// Number of bits.
    pub(crate) fn len(&self) -> usize {
        self.length
    }

    /// The unsigned number in `width` (at most 32) bits from `start`; bits past the end are 0.
    pub(crate) fn unsigned(&self, start: usize, width: usize) -> u32 {
        (start..start + width).fold(0, |value, i| {
            let bit = self.bytes.get(i / 8).map_or(0, |b| b >> (7 - i % 8) & 1);
            value << 1 | u32::from(bit)
        })
    }

    /// The two's-complement number in `width` bits from `start`.
    pub(crate) fn signed(&self, start: usize, width: usize) -> i32 {
        let shift = 32 - width;
        (self.unsigned(start, width) << shift).cast_signed() >> shift
    }

    /// The sign-and-magnitude number in `width` bits from `start`.
    pub(crate) fn sign_magnitude(&self, start: usize, width: usize) -> i32 {
        let magnitude = self.unsigned(start + 1, width - 1).cast_signed();
        if self.unsigned(start, 1) == 1 {
            -magnitude
        } else {
            magnitude
        }
    }

    /// An unsigned number with separate high and low parts.
    pub(crate) fn unsigned2(&self, high: (usize, usize), low: (usize, usize)) -> u32 {
        self.unsigned(high.0, high.1) << low.1 | self.unsigned(low.0, low.1)
    }

    /// A two's-complement number with separate high and low parts.
    pub(crate) fn signed2(&self, high: (usize, usize), low: (usize, usize)) -> i32 {
        let shift = 32 - high.1 - low.1;
        (self.unsigned2(high, low) << shift).cast_signed() >> shift
    }

    /// `signed` · 2^`exponent`.
    pub(crate) fn scaled(&self, start: usize, width: usize, exponent: i32) -> f64 {
        f64::from(self.signed(start, width)) * 2f64.powi(exponent)
    }

    /// `unsigned` · 2^`exponent`.
    pub(crate) fn scaled_unsigned(&self, start: usize, width: usize, exponent: i32) -> f64 {
        f64::from(self.unsigned(start, width)) * 2f64.powi(exponent)
    }
}

/// CRC-24Q of every byte value, in the upper 24 bits' place.
const CRC24Q: [u32; 256] = {
    let mut table = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        let mut crc = (byte as u32) << 16;
        let mut bit = 0;
        while bit < 8 {
            crc <<= 1;
            if crc & 0x100_0000 != 0 {
                crc ^= 0x186_4CFB;
            }
            bit += 1;
        }
        table[byte] = crc;
        byte += 1;
    }
    table
};

/// CRC-24Q (polynomial 0x1864CFB) of whole bytes.
pub(crate) fn crc24q(bytes: &[u8]) -> u32 {
    bytes.iter().fold(0, |crc, &byte| crc24q_step(crc, byte))
}

/// The CRC after one more byte.
pub(crate) fn crc24q_step(crc: u32, byte: u8) -> u32 {
    let index = (crc >> 16) as u8 ^ byte;
    crc << 8 & 0xFF_FFFF ^ CRC24Q[usize::from(index)]
}

/// Reads bit fields one after another from whole bytes, most significant bit first; `None` past
/// the end.
#[derive(Debug, Clone)]
pub(crate) struct BitCursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> BitCursor<'a> {
    pub(crate) const fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// The unsigned number in the next `width` (at most 64) bits.
    pub(crate) fn unsigned(&mut self, width: usize) -> Option<u64> {
        let end = self.at.checked_add(width)?;
        if width > 64 || end > 8 * self.bytes.len() {
            return None;
        }
        let mut value = 0;
        while self.at < end {
            let bit = self.at % 8;
            let taken = (8 - bit).min(end - self.at);
            let byte = u64::from(self.bytes[self.at / 8]);
            value = value << taken | byte >> (8 - bit - taken) & ((1 << taken) - 1);
            self.at += taken;
        }
        Some(value)
    }

    /// The two's-complement number in the next `width` (1 to 64) bits.
    pub(crate) fn signed(&mut self, width: usize) -> Option<i64> {
        let shift = 64 - width;
        Some((self.unsigned(width)? << shift).cast_signed() >> shift)
    }

    /// The sign-and-magnitude number in the next `width` (2 to 64) bits.
    pub(crate) fn sign_magnitude(&mut self, width: usize) -> Option<i64> {
        let negative = self.flag()?;
        let magnitude = self.unsigned(width - 1)?.cast_signed();
        Some(if negative { -magnitude } else { magnitude })
    }

    /// The unsigned number in the next `width` (at most 32) bits.
    pub(crate) fn unsigned32(&mut self, width: usize) -> Option<u32> {
        u32::try_from(self.unsigned(width)?).ok()
    }

    /// The unsigned number in the next `width` (at most 8) bits.
    pub(crate) fn byte(&mut self, width: usize) -> Option<u8> {
        u8::try_from(self.unsigned(width)?).ok()
    }

    /// The next bit.
    pub(crate) fn flag(&mut self) -> Option<bool> {
        Some(self.unsigned(1)? == 1)
    }

    /// The next `width` (at most 53) bits as a two's-complement number times 2^`exponent`.
    pub(crate) fn scaled(&mut self, width: usize, exponent: i32) -> Option<f64> {
        Some(self.signed(width)? as f64 * 2f64.powi(exponent))
    }

    /// The next `width` (at most 53) bits as an unsigned number times 2^`exponent`.
    pub(crate) fn scaled_unsigned(&mut self, width: usize, exponent: i32) -> Option<f64> {
        Some(self.unsigned(width)? as f64 * 2f64.powi(exponent))
    }

    /// Passes over `width` bits.
    pub(crate) fn skip(&mut self, width: usize) -> Option<()> {
        let end = self.at.checked_add(width)?;
        (end <= 8 * self.bytes.len()).then(|| self.at = end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_come_back() {
        let mut bits = Bits::default();
        bits.push(0b101, 3);
        bits.push((-5_i32).cast_unsigned(), 9);
        bits.push(0x1234_5678, 32);
        bits.push(1 << 6 | 37, 7);
        assert_eq!(bits.len(), 51);
        assert_eq!(bits.unsigned(0, 3), 5);
        assert_eq!(bits.signed(3, 9), -5);
        assert_eq!(bits.unsigned(12, 32), 0x1234_5678);
        assert_eq!(bits.sign_magnitude(44, 7), -37);
        assert_eq!(bits.signed2((3, 4), (7, 5)), -5);
        assert_eq!(bits.unsigned(60, 8), 0);
    }

    #[test]
    fn a_cursor_reads_what_was_pushed() {
        let mut bits = Bits::default();
        for (value, width) in [
            (0b101, 3),
            (0x1234_5678, 32),
            (1 << 6 | 37, 7),
            (0xFFFF_FFFB, 32),
        ] {
            bits.push(value, width);
        }
        let mut cursor = BitCursor::new(&bits.bytes);
        assert_eq!(cursor.signed(3), Some(-3));
        assert_eq!(cursor.unsigned(32), Some(0x1234_5678));
        assert_eq!(cursor.sign_magnitude(7), Some(-37));
        assert_eq!(cursor.signed(32), Some(-5));
        assert_eq!(cursor.unsigned(7), None, "74 bits fill ten bytes");
        assert_eq!((cursor.unsigned(6), cursor.skip(1)), (Some(0), None));
    }

    /// The published check value of CRC-24Q for "123456789".
    #[test]
    fn crc_check_value() {
        assert_eq!(crc24q(b"123456789"), 0xCD_E703);
    }
}
