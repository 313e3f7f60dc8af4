//! Sample formats.

use crate::bytes::Order;

/// How a sample is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SampleFormat {
    Ibm,
    I32,
    I16,
    F32,
    F64,
    I24,
    I8,
    U32,
    U16,
    U24,
    U8,
}

impl SampleFormat {
    /// The format of a code; none if it is unknown or not read (4, fixed point with gain; 9 and 12, integers of 64
    /// bits).
    pub const fn of(code: u16) -> Option<Self> {
        Some(match code {
            1 => Self::Ibm,
            2 => Self::I32,
            3 => Self::I16,
            5 => Self::F32,
            6 => Self::F64,
            7 => Self::I24,
            8 => Self::I8,
            10 => Self::U32,
            11 => Self::U16,
            15 => Self::U24,
            16 => Self::U8,
            _ => return None,
        })
    }

    pub const fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I24 | Self::U24 => 3,
            Self::Ibm | Self::I32 | Self::F32 | Self::U32 => 4,
            Self::F64 => 8,
        }
    }

    pub const fn name(self) -> &'static str {
        match self {
            Self::Ibm => "IBM float, 32 bit",
            Self::I32 => "integer, 32 bit",
            Self::I16 => "integer, 16 bit",
            Self::F32 => "IEEE float, 32 bit",
            Self::F64 => "IEEE float, 64 bit",
            Self::I24 => "integer, 24 bit",
            Self::I8 => "integer, 8 bit",
            Self::U32 => "unsigned, 32 bit",
            Self::U16 => "unsigned, 16 bit",
            Self::U24 => "unsigned, 24 bit",
            Self::U8 => "unsigned, 8 bit",
        }
    }

    /// Appends the samples of whole words. Unsigned numbers are unchanged.
    pub fn decode(self, order: Order, bytes: &[u8], to: &mut Vec<f32>) {
        /// The words of a slice in a byte order, through a conversion.
        fn words<const N: usize>(
            order: Order,
            bytes: &[u8],
            to: &mut Vec<f32>,
            value: impl Fn([u8; N]) -> f32,
        ) {
            let words = bytes.as_chunks::<N>().0.iter();
            match order {
                Order::Big => to.extend(words.map(|w| value(*w))),
                Order::Little => to.extend(words.map(|w| {
                    let mut w = *w;
                    w.reverse();
                    value(w)
                })),
            }
        }
        match self {
            Self::Ibm => words(order, bytes, to, |w| ibm(u32::from_be_bytes(w))),
            Self::I32 => words(order, bytes, to, |w| i32::from_be_bytes(w) as f32),
            Self::I16 => words(order, bytes, to, |w| f32::from(i16::from_be_bytes(w))),
            Self::F32 => words(order, bytes, to, f32::from_be_bytes),
            Self::F64 => words(order, bytes, to, |w| f64::from_be_bytes(w) as f32),
            Self::I24 => words(order, bytes, to, |[a, b, c]: [u8; 3]| {
                (i32::from_be_bytes([a, b, c, 0]) >> 8) as f32
            }),
            Self::I8 => to.extend(bytes.iter().map(|b| f32::from(*b as i8))),
            Self::U32 => words(order, bytes, to, |w| u32::from_be_bytes(w) as f32),
            Self::U16 => words(order, bytes, to, |w| f32::from(u16::from_be_bytes(w))),
            Self::U24 => words(order, bytes, to, |[a, b, c]: [u8; 3]| {
                u32::from_be_bytes([0, a, b, c]) as f32
            }),
            Self::U8 => to.extend(bytes.iter().map(|b| f32::from(*b))),
        }
    }
}

/// An IBM System/360 number: sign, exponent of 16 (excess 64), 24 bits of fraction.
pub fn ibm(word: u32) -> f32 {
    let fraction = f64::from(word & 0x00ff_ffff) / f64::from(1 << 24);
    let exponent = ((word >> 24) & 0x7f) as i32 - 64;
    let magnitude = (fraction * 16f64.powi(exponent)) as f32;
    if word >> 31 == 1 {
        -magnitude
    } else {
        magnitude
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ibm_numbers_are_those_of_the_manual() {
        // −118.625 is the example of the System/360's principles of operation.
        assert_eq!(ibm(0xc276_a000), -118.625);
        assert_eq!(ibm(0x4110_0000), 1.0);
        assert_eq!(ibm(0), 0.0);
        assert_eq!(ibm(0x4019_999a), 0.100_000_024);
        assert!(ibm(0x7fff_ffff).is_infinite());
    }

    #[test]
    fn every_format_in_both_orders() {
        let cases: [(u16, &[u8], f32); 9] = [
            (2, &[0xff, 0xff, 0xff, 0xfe], -2.0),
            (3, &[0x80, 0x00], -32_768.0),
            (5, &[0x3f, 0xc0, 0, 0], 1.5),
            (6, &[0xbf, 0xf8, 0, 0, 0, 0, 0, 0], -1.5),
            (7, &[0xff, 0xff, 0xff], -1.0),
            (8, &[0x80], -128.0),
            (11, &[0x80, 0x01], 32_769.0),
            (15, &[0x80, 0x00, 0x01], 8_388_609.0),
            (16, &[0x80], 128.0),
        ];
        for (code, bytes, expected) in cases {
            let format = SampleFormat::of(code).unwrap();
            let mut out = Vec::new();
            format.decode(Order::Big, bytes, &mut out);
            let reversed: Vec<u8> = bytes.iter().rev().copied().collect();
            format.decode(Order::Little, &reversed, &mut out);
            assert_eq!(out, [expected; 2], "code {code}");
        }
    }
}
