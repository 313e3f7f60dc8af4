//! Numbers at fixed places of a header.

/// Byte order of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// Least significant byte first.
    Little,
    /// Most significant byte first.
    Big,
}

/// A header whose fields are read; bytes beyond its end are 0.
#[derive(Clone, Copy)]
pub struct Fields<'a> {
    pub bytes: &'a [u8],
    pub order: Order,
}

macro_rules! field {
    ($name:ident, $type:ty) => {
        pub fn $name(self, at: usize) -> $type {
            let bytes = self.array(at);
            match self.order {
                Order::Little => <$type>::from_le_bytes(bytes),
                Order::Big => <$type>::from_be_bytes(bytes),
            }
        }
    };
}

impl<'a> Fields<'a> {
    pub const fn little(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            order: Order::Little,
        }
    }

    fn array<const N: usize>(self, at: usize) -> [u8; N] {
        let mut out = [0; N];
        if let Some(found) = self.bytes.get(at..at + N) {
            out.copy_from_slice(found);
        }
        out
    }

    field!(u16, u16);
    field!(i16, i16);
    field!(u32, u32);
    field!(i32, i32);
    field!(u64, u64);
    field!(f32, f32);
    field!(f64, f64);

    /// Text up to a NUL or the end of the field, without spaces at its ends.
    pub fn text(self, at: usize, length: usize) -> String {
        let end = (at + length).min(self.bytes.len());
        let bytes = self.bytes.get(at..end).unwrap_or_default();
        let bytes = bytes.split(|b| *b == 0).next().unwrap_or_default();
        String::from_utf8_lossy(bytes).trim().to_owned()
    }
}

/// Reads until `buffer` is full or the stream ends; the bytes read.
pub fn fill(reader: &mut impl std::io::Read, buffer: &mut [u8]) -> std::io::Result<usize> {
    let mut filled = 0;
    while filled < buffer.len() {
        match reader.read(&mut buffer[filled..]) {
            Ok(0) => break,
            Ok(n) => filled += n,
            Err(e) if e.kind() == std::io::ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
    Ok(filled)
}
