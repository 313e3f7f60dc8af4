//! Bit fields of navigation messages, most significant bit first.

/// π as the interface documents of the systems define it for semicircles: cut, on purpose.
#[expect(clippy::approx_constant, reason = "the systems' own value")]
pub(super) const SEMICIRCLE_RAD: f64 = 3.141_592_653_589_8;

/// Bits packed from the left.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Bits {
    bytes: Vec<u8>,
    length: usize,
}

impl Bits {
    /// Appends the lowest `width` bits of `value`.
    pub(super) fn push(&mut self, value: u32, width: usize) {
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
    pub(super) fn len(&self) -> usize {
        self.length
    }

    /// The unsigned number in `width` (at most 32) bits from `start`; bits past the end are 0.
    pub(super) fn unsigned(&self, start: usize, width: usize) -> u32 {
        (start..start + width).fold(0, |value, i| {
            let bit = self.bytes.get(i / 8).map_or(0, |b| b >> (7 - i % 8) & 1);
            value << 1 | u32::from(bit)
        })
    }

    /// The two's-complement number in `width` bits from `start`.
    pub(super) fn signed(&self, start: usize, width: usize) -> i32 {
        let shift = 32 - width;
        (self.unsigned(start, width) << shift).cast_signed() >> shift
    }

    /// The sign-and-magnitude number in `width` bits from `start`.
    pub(super) fn sign_magnitude(&self, start: usize, width: usize) -> i32 {
        let magnitude = self.unsigned(start + 1, width - 1).cast_signed();
        if self.unsigned(start, 1) == 1 {
            -magnitude
        } else {
            magnitude
        }
    }

    /// An unsigned number whose high and low parts stand apart.
    pub(super) fn unsigned2(&self, high: (usize, usize), low: (usize, usize)) -> u32 {
        self.unsigned(high.0, high.1) << low.1 | self.unsigned(low.0, low.1)
    }

    /// A two's-complement number whose high and low parts stand apart.
    pub(super) fn signed2(&self, high: (usize, usize), low: (usize, usize)) -> i32 {
        let shift = 32 - high.1 - low.1;
        (self.unsigned2(high, low) << shift).cast_signed() >> shift
    }

    /// `signed` · 2^`exponent`.
    pub(super) fn scaled(&self, start: usize, width: usize, exponent: i32) -> f64 {
        f64::from(self.signed(start, width)) * 2f64.powi(exponent)
    }

    /// `unsigned` · 2^`exponent`.
    pub(super) fn scaled_unsigned(&self, start: usize, width: usize, exponent: i32) -> f64 {
        f64::from(self.unsigned(start, width)) * 2f64.powi(exponent)
    }
}

/// CRC-24Q (polynomial 0x1864CFB) of whole bytes.
pub(super) fn crc24q(bytes: &[u8]) -> u32 {
    bytes.iter().fold(0, |crc, &byte| {
        let mut crc = crc ^ u32::from(byte) << 16;
        for _ in 0..8 {
            crc <<= 1;
            if crc & 0x100_0000 != 0 {
                crc ^= 0x186_4CFB;
            }
        }
        crc
    })
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

    /// The published check value of CRC-24Q for "123456789".
    #[test]
    fn crc_check_value() {
        assert_eq!(crc24q(b"123456789"), 0xCD_E703);
    }
}
