//! Messages of ROS 2 in their Common Data Representation, little-endian.

/// Writes the fields of a message, each at a multiple of its length.
pub(super) struct Cdr(Vec<u8>);

/// The representation's header: little-endian, no options.
const HEAD: [u8; 4] = [0, 1, 0, 0];

impl Cdr {
    /// A message that begins with the host's clock (ns).
    pub fn at(host_ns: u64) -> Self {
        let mut cdr = Self(HEAD.to_vec());
        cdr.put(host_ns.to_le_bytes());
        cdr
    }

    /// A number.
    pub fn put<const N: usize>(&mut self, value: [u8; N]) -> &mut Self {
        while !(self.0.len() - HEAD.len()).is_multiple_of(N) {
            self.0.push(0);
        }
        self.0.extend(value);
        self
    }

    /// Bytes behind their number.
    pub fn bytes(&mut self, value: &[u8]) -> &mut Self {
        self.put((value.len() as u32).to_le_bytes());
        self.0.extend(value);
        self
    }

    /// A text, which ends with a zero.
    pub fn text(&mut self, value: &str) -> &mut Self {
        self.put((value.len() as u32 + 1).to_le_bytes());
        self.0.extend(value.as_bytes());
        self.0.push(0);
        self
    }

    /// Numbers behind their number.
    pub fn i32s(&mut self, values: impl ExactSizeIterator<Item = i32>) -> &mut Self {
        self.put((values.len() as u32).to_le_bytes());
        for value in values {
            self.put(value.to_le_bytes());
        }
        self
    }

    /// The message.
    pub fn end(self) -> Vec<u8> {
        self.0
    }
}
