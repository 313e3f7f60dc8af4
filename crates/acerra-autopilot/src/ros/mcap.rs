//! Records of an MCAP file (mcap.dev, "MCAP Format Specification"): a byte for the kind, eight for the
//! length, the content, all little-endian.

use std::io::Read;

use crate::bytes::array;

/// First and last bytes of a file.
pub const MAGIC: [u8; 8] = [0x89, b'M', b'C', b'A', b'P', b'0', b'\r', b'\n'];
/// Kind and length of a record (bytes).
pub const RECORD_HEADER: usize = 9;
/// Most bytes of a chunk's records.
pub const LARGEST_CHUNK: u64 = 1 << 28;

/// Kinds of record.
pub mod kind {
    /// The last record of a file that was closed.
    pub const FOOTER: u8 = 0x02;
    /// The type of a topic's messages.
    pub const SCHEMA: u8 = 0x03;
    /// A topic.
    pub const CHANNEL: u8 = 0x04;
    /// A message.
    pub const MESSAGE: u8 = 0x05;
    /// Records, often compressed.
    pub const CHUNK: u8 = 0x06;
    /// The end of the data: an index and statistics follow.
    pub const DATA_END: u8 = 0x0f;
}

/// Reads a record's fields one behind the other.
#[derive(Debug, Clone)]
pub struct Fields<'a> {
    rest: &'a [u8],
}

impl<'a> Fields<'a> {
    /// The fields of a record's content.
    pub const fn new(content: &'a [u8]) -> Self {
        Self { rest: content }
    }

    fn next<const N: usize>(&mut self) -> Option<[u8; N]> {
        let bytes = array(self.rest, 0)?;
        self.rest = &self.rest[N..];
        Some(bytes)
    }

    /// A whole number of 16 bits.
    pub fn u16(&mut self) -> Option<u16> {
        self.next().map(u16::from_le_bytes)
    }

    /// A whole number of 32 bits.
    pub fn u32(&mut self) -> Option<u32> {
        self.next().map(u32::from_le_bytes)
    }

    /// A whole number of 64 bits.
    pub fn u64(&mut self) -> Option<u64> {
        self.next().map(u64::from_le_bytes)
    }

    fn bytes(&mut self, length: u64) -> Option<&'a [u8]> {
        let length = usize::try_from(length).ok()?;
        let bytes = self.rest.get(..length)?;
        self.rest = &self.rest[length..];
        Some(bytes)
    }

    /// A text behind its length.
    pub fn text(&mut self) -> Option<&'a str> {
        let length = self.u32()?;
        std::str::from_utf8(self.bytes(length.into())?).ok()
    }

    /// What is left.
    pub const fn rest(self) -> &'a [u8] {
        self.rest
    }
}

/// The records of a chunk, unpacked. The error describes its fault.
pub fn unpacked(content: &[u8]) -> Result<Vec<u8>, String> {
    let short = || "a chunk shorter than its fields".to_owned();
    let mut fields = Fields::new(content);
    fields.u64().and_then(|_| fields.u64()).ok_or_else(short)?;
    let size = fields.u64().ok_or_else(short)?;
    let crc = fields.u32().ok_or_else(short)?;
    let compression = fields.text().ok_or_else(short)?;
    let packed_size = fields.u64().ok_or_else(short)?;
    let packed = fields.bytes(packed_size).ok_or_else(short)?;
    if size > LARGEST_CHUNK {
        return Err(format!(
            "a chunk of {size} bytes, more than {LARGEST_CHUNK}"
        ));
    }
    let mut records = Vec::new();
    // One byte more reveals a chunk that is larger than it says.
    let read = match compression {
        "" => packed.take(size + 1).read_to_end(&mut records),
        "lz4" => lz4_flex::frame::FrameDecoder::new(packed)
            .take(size + 1)
            .read_to_end(&mut records),
        "zstd" => {
            let decoder = ruzstd::decoding::StreamingDecoder::new(packed);
            let decoder = decoder.map_err(|error| format!("a chunk that is not zstd: {error}"))?;
            decoder.take(size + 1).read_to_end(&mut records)
        }
        other => return Err(format!("a chunk packed by '{}'", other.escape_debug())),
    };
    read.map_err(|error| format!("a chunk that cannot be unpacked: {error}"))?;
    if records.len() as u64 != size {
        return Err(format!(
            "a chunk of {} bytes that states {size}",
            records.len()
        ));
    }
    if crc != 0 && crc32fast::hash(&records) != crc {
        return Err("a chunk with a wrong checksum".to_owned());
    }
    Ok(records)
}
