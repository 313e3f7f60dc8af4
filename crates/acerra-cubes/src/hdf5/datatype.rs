//! Datatypes as HDF5 encodes them (File Format Specification 3.0, IV.A.2.d).

/// Class and version, bit field of the class, size in bytes, properties.
fn encoded(class: u8, version: u8, bits: [u8; 3], size: u32, properties: &[u8]) -> Vec<u8> {
    let mut out = vec![version << 4 | class];
    out.extend(bits);
    out.extend(size.to_le_bytes());
    out.extend(properties);
    out
}

/// Sign, exponent and mantissa of an IEEE number, the least significant byte first.
struct Ieee {
    bytes: u32,
    exponent_at: u8,
    exponent_bits: u8,
    bias: u32,
}

impl Ieee {
    fn encoded(&self) -> Vec<u8> {
        #[expect(clippy::cast_possible_truncation, reason = "4 or 8 bytes")]
        let bits = (8 * self.bytes) as u8;
        let mut properties = vec![0, 0, bits, 0];
        properties.extend([self.exponent_at, self.exponent_bits, 0, self.exponent_at]);
        properties.extend(self.bias.to_le_bytes());
        // The mantissa's leading bit is implied; the sign is the last bit.
        encoded(1, 1, [0x20, bits - 1, 0], self.bytes, &properties)
    }
}

/// A number of single precision.
pub(super) fn real32() -> Vec<u8> {
    Ieee {
        bytes: 4,
        exponent_at: 23,
        exponent_bits: 8,
        bias: 127,
    }
    .encoded()
}

/// A number of double precision.
pub(super) fn real64() -> Vec<u8> {
    Ieee {
        bytes: 8,
        exponent_at: 52,
        exponent_bits: 11,
        bias: 1023,
    }
    .encoded()
}

/// A whole number of 32 bits with sign.
pub(super) fn whole32() -> Vec<u8> {
    encoded(0, 1, [0x08, 0, 0], 4, &[0, 0, 32, 0])
}

/// A whole number of 8 bits without sign: the parts of a text.
fn byte() -> Vec<u8> {
    encoded(0, 1, [0, 0, 0], 1, &[0, 0, 8, 0])
}

/// ASCII of fixed length, ended by a zero, as dimension scales ask for.
pub(super) fn fixed_text(bytes: u32) -> Vec<u8> {
    encoded(3, 1, [0, 0, 0], bytes, &[])
}

/// UTF-8 of any length, in the global heap.
pub(super) fn text() -> Vec<u8> {
    encoded(9, 1, [1, 1, 0], 16, &byte())
}

/// The address of an object.
fn reference() -> Vec<u8> {
    encoded(7, 1, [0, 0, 0], 8, &[])
}

/// Any number of addresses, in the global heap.
pub(super) fn references() -> Vec<u8> {
    encoded(9, 1, [0, 0, 0], 16, &reference())
}

/// Size of [`attached`] in bytes.
pub(super) const ATTACHED_BYTES: u32 = 16;

/// An array that a dimension scale is attached to, and which of its dimensions.
pub(super) fn attached() -> Vec<u8> {
    let mut members = Vec::new();
    for (name, at, datatype) in [("dataset", 0_u32, reference()), ("dimension", 8, whole32())] {
        let mut padded = name.as_bytes().to_vec();
        padded.resize((name.len() / 8 + 1) * 8, 0);
        members.extend(padded);
        members.extend(at.to_le_bytes());
        // No array: neither dimensions nor their sizes.
        members.extend([0; 28]);
        members.extend(datatype);
    }
    encoded(6, 1, [2, 0, 0], ATTACHED_BYTES, &members)
}
