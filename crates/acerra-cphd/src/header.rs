//! The header of a file: its version, and where its blocks lie.

use std::collections::BTreeMap;
use std::io::{Read, Seek, SeekFrom};

use crate::error::ReadError;
use crate::write::SECTION_END;

/// Longest header that is read (bytes).
const MAX_HEADER: u64 = 1 << 16;
/// Beginning of the first line.
pub(crate) const SIGNATURE: &[u8] = b"CPHD/1.";

/// A part of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Block {
    pub offset: u64,
    pub size: u64,
}

impl Block {
    /// The part of this block from `offset` on, of `size` bytes.
    pub fn part(&self, what: &str, offset: u64, size: Option<u64>) -> Result<Self, ReadError> {
        let outside = || ReadError::Outside {
            what: what.to_owned(),
            offset,
            size: size.unwrap_or(u64::MAX),
            file: self.size,
        };
        let size = size.ok_or_else(outside)?;
        match offset.checked_add(size) {
            Some(end) if end <= self.size => Ok(Self {
                offset: self.offset + offset,
                size,
            }),
            _ => Err(outside()),
        }
    }
}

/// Offsets of the blocks of a file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Header {
    pub xml: Block,
    pub vectors: Block,
    pub signals: Block,
}

impl Header {
    /// Reads the header from the beginning of the file. All blocks that it names lie in the file.
    ///
    /// # Errors
    /// Another kind of file, a header that is broken or names bytes that are not there.
    pub fn read(reader: &mut (impl Read + Seek)) -> Result<Self, ReadError> {
        let file = reader.seek(SeekFrom::End(0))?;
        reader.seek(SeekFrom::Start(0))?;
        let mut bytes = Vec::new();
        reader.take(MAX_HEADER).read_to_end(&mut bytes)?;
        let first = bytes.split(|b| *b == b'\n').next().unwrap_or_default();
        if !first.starts_with(SIGNATURE) {
            return Err(ReadError::Version { found: text(first) });
        }
        let fields = Fields::of(&bytes)?;
        let whole = Block {
            offset: 0,
            size: file,
        };
        let block = |name: &str| {
            let size = fields.number(&format!("{name}_BLOCK_SIZE"))?;
            let offset = fields.number(&format!("{name}_BLOCK_BYTE_OFFSET"))?;
            whole.part(&format!("{name} block"), offset, Some(size))
        };
        Ok(Self {
            xml: block("XML")?,
            vectors: block("PVP")?,
            signals: block("SIGNAL")?,
        })
    }
}

/// The lines `NAME := value` of a header.
struct Fields {
    /// Names, offsets of their lines, values.
    lines: BTreeMap<String, (u64, String)>,
    end: u64,
}

impl Fields {
    fn of(bytes: &[u8]) -> Result<Self, ReadError> {
        let mut lines = BTreeMap::new();
        let mut at = 0;
        for (k, line) in bytes.split(|b| *b == b'\n').enumerate() {
            let byte = at as u64;
            at += line.len() + 1;
            if line == &SECTION_END[..1] {
                return Ok(Self { lines, end: byte });
            }
            if k == 0 {
                continue;
            }
            let line = text(line);
            let Some((name, value)) = line.split_once(":=") else {
                return Err(ReadError::Header {
                    byte,
                    expected: "NAME := value".to_owned(),
                    found: line,
                });
            };
            let value = value.trim().to_owned();
            lines.insert(name.trim().to_owned(), (byte, value));
        }
        Err(ReadError::Header {
            byte: bytes.len() as u64,
            expected: "a form feed at the end of the header".to_owned(),
            found: "the end of the part that is read".to_owned(),
        })
    }

    fn number(&self, name: &str) -> Result<u64, ReadError> {
        let (byte, value) = self.lines.get(name).ok_or_else(|| ReadError::Header {
            byte: self.end,
            expected: format!("{name} := number"),
            found: "the end of the header".to_owned(),
        })?;
        value.parse().map_err(|_| ReadError::Header {
            byte: *byte,
            expected: format!("{name} := number"),
            found: value.clone(),
        })
    }
}

/// The beginning of a line, for messages.
fn text(line: &[u8]) -> String {
    String::from_utf8_lossy(&line[..line.len().min(80)]).into_owned()
}
