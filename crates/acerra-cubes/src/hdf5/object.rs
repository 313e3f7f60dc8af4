//! Object headers of version 2, and the messages in them (File Format Specification 3.0, IV.A).

use super::checksum::lookup3;
use super::datatype;

/// The address of nothing.
pub(super) const NOWHERE: u64 = u64::MAX;

/// Messages of an object.
#[derive(Clone, Debug, Default)]
pub(super) struct Messages {
    bytes: Vec<u8>,
}

impl Messages {
    fn add(&mut self, kind: u8, body: &[u8]) {
        self.bytes.push(kind);
        // Texts are stored in the heap and lists are short: bodies hold some hundred bytes.
        self.bytes
            .extend(u16::try_from(body.len()).unwrap_or(u16::MAX).to_le_bytes());
        self.bytes.push(0);
        self.bytes.extend(body);
    }

    /// The header of the object.
    pub(super) fn header(&self) -> Vec<u8> {
        let mut out = b"OHDR".to_vec();
        // Version 2; the size of the messages takes four bytes.
        out.extend([2, 2]);
        out.extend(length32(self.bytes.len()).to_le_bytes());
        out.extend(&self.bytes);
        out.extend(lookup3(&out).to_le_bytes());
        out
    }

    /// The lengths of an array; empty for a single value.
    pub(super) fn dataspace(&mut self, shape: &[usize]) {
        self.add(0x01, &dataspace(shape));
    }

    /// The type of its values.
    pub(super) fn datatype(&mut self, datatype: &[u8]) {
        self.add(0x03, datatype);
    }

    /// Zeros where no value was written.
    pub(super) fn fill_with_zeros(&mut self) {
        self.add(0x05, &[3, 0x0a]);
    }

    /// Values in one piece.
    pub(super) fn contiguous(&mut self, address: u64, bytes: u64) {
        let mut body = vec![3, 1];
        body.extend(address.to_le_bytes());
        body.extend(bytes.to_le_bytes());
        self.add(0x08, &body);
    }

    /// Values in chunks, which a B-tree lists, shuffled and deflated.
    pub(super) fn chunked(&mut self, tree: u64, chunk: &[usize], value_bytes: u32, level: u32) {
        let mut body = vec![3, 2, small(chunk.len() + 1)];
        body.extend(tree.to_le_bytes());
        for n in chunk {
            body.extend(length32(*n).to_le_bytes());
        }
        body.extend(value_bytes.to_le_bytes());
        self.add(0x08, &body);
        let mut filters = vec![2, 2];
        for (filter, parameter) in [(2_u16, value_bytes), (1, level)] {
            filters.extend(filter.to_le_bytes());
            // Not optional; one parameter.
            filters.extend([0, 0, 1, 0]);
            filters.extend(parameter.to_le_bytes());
        }
        self.add(0x0b, &filters);
    }

    /// A property with its value.
    pub(super) fn attribute(&mut self, name: &str, datatype: &[u8], shape: &[usize], data: &[u8]) {
        let space = dataspace(shape);
        let mut body = vec![3, 0];
        for length in [name.len() + 1, datatype.len(), space.len()] {
            body.extend(u16::try_from(length).unwrap_or(u16::MAX).to_le_bytes());
        }
        // The name is ASCII or UTF-8.
        body.push(u8::from(!name.is_ascii()));
        body.extend(name.as_bytes());
        body.push(0);
        body.extend(datatype);
        body.extend(space);
        body.extend(data);
        self.add(0x0c, &body);
    }

    /// A fixed ASCII text.
    pub(super) fn fixed_text(&mut self, name: &str, text: &str) {
        let mut data = text.as_bytes().to_vec();
        data.push(0);
        let datatype = datatype::fixed_text(length32(data.len()));
        self.attribute(name, &datatype, &[], &data);
    }

    /// Messages of a group whose links keep their order.
    pub(super) fn group(&mut self, links: usize) {
        // The order of creation is tracked; all links are stored in the header.
        let mut body = vec![0, 1];
        body.extend((links as u64).to_le_bytes());
        body.extend(NOWHERE.to_le_bytes());
        body.extend(NOWHERE.to_le_bytes());
        self.add(0x02, &body);
        self.add(0x0a, &[0, 0]);
    }

    /// The link number `order` of a group.
    pub(super) fn link(&mut self, order: usize, name: &str, address: u64) {
        // Version 1, with the order of creation.
        let mut body = vec![1, 4];
        body.extend((order as u64).to_le_bytes());
        body.push(small(name.len()));
        body.extend(name.as_bytes());
        body.extend(address.to_le_bytes());
        self.add(0x06, &body);
    }
}

fn dataspace(shape: &[usize]) -> Vec<u8> {
    let mut body = vec![2, small(shape.len()), 0, u8::from(!shape.is_empty())];
    for n in shape {
        body.extend((*n as u64).to_le_bytes());
    }
    body
}

/// A length below 2³²: chunks, names and lists are short.
pub(super) fn length32(length: usize) -> u32 {
    u32::try_from(length).unwrap_or(u32::MAX)
}

/// A number of dimensions, or of letters of a name of 64 at most.
fn small(length: usize) -> u8 {
    u8::try_from(length).unwrap_or(u8::MAX)
}
