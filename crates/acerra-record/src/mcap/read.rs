//! Reading an MCAP file of a session: its topics, and its messages one by one.

use std::collections::BTreeMap;
use std::io::{self, Read};

use thiserror::Error;

/// First and last bytes of a file.
pub const MAGIC: [u8; 8] = [0x89, b'M', b'C', b'A', b'P', b'0', b'\r', b'\n'];
/// Longest record (bytes): a chunk of this project's is a megabyte and its last message.
const LONGEST_RECORD: u64 = 1 << 26;
/// Topics of a file at most.
const MOST_TOPICS: usize = 1024;

/// Kinds of record.
pub(super) mod kind {
    pub const HEADER: u8 = 0x01;
    pub const FOOTER: u8 = 0x02;
    pub const SCHEMA: u8 = 0x03;
    pub const CHANNEL: u8 = 0x04;
    pub const MESSAGE: u8 = 0x05;
    pub const CHUNK: u8 = 0x06;
    pub const MESSAGE_INDEX: u8 = 0x07;
    pub const CHUNK_INDEX: u8 = 0x08;
    pub const STATISTICS: u8 = 0x0b;
    pub const DATA_END: u8 = 0x0f;
}

/// Reason why a file cannot be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum McapError {
    /// The input fails.
    #[error("reading failed: {0}")]
    Io(#[from] io::Error),
    /// The file is of another kind.
    #[error("expected an MCAP file, which begins {MAGIC:?}; found {found:?}")]
    Magic {
        /// The first bytes.
        found: Vec<u8>,
    },
    /// A record that is cut off, or with an impossible length.
    #[error(
        "offset {offset}: expected a record of {} bytes at most; found {found}",
        LONGEST_RECORD
    )]
    Length {
        /// Offset of the first byte.
        offset: u64,
        /// Text found.
        found: String,
    },
    /// A record whose content does not match its kind.
    #[error("offset {offset}: expected {expected}")]
    Content {
        /// Offset at which the record begins.
        offset: u64,
        /// Value expected.
        expected: &'static str,
    },
}

/// A topic and its messages.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TopicCount {
    /// Name.
    pub name: String,
    /// The type of its messages.
    pub schema: String,
    /// Number of its messages that were read.
    pub messages: u64,
}

/// A message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct McapContent {
    /// Topic's name.
    pub topic: String,
    /// When it was logged (ns).
    pub log_ns: u64,
    /// Content.
    pub data: Vec<u8>,
}

/// Reads messages in the order of the file; holds a chunk at most.
pub struct McapReader<R> {
    input: R,
    offset: u64,
    schemas: BTreeMap<u16, String>,
    topics: BTreeMap<u16, TopicCount>,
    /// Records of the current chunk.
    chunk: Vec<u8>,
    at: usize,
    is_over: bool,
    library: String,
}

/// A record's fields, one behind the other.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn take(&mut self, bytes: usize) -> Option<&'a [u8]> {
        let (head, rest) = self.0.split_at_checked(bytes)?;
        self.0 = rest;
        Some(head)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N)?.try_into().ok()
    }

    fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    fn text(&mut self) -> Option<String> {
        let bytes = self.u32()? as usize;
        Some(String::from_utf8_lossy(self.take(bytes)?).into_owned())
    }
}

impl<R: Read> McapReader<R> {
    /// A reader of a file.
    ///
    /// # Errors
    /// If the input fails or is no MCAP file.
    pub fn new(mut input: R) -> Result<Self, McapError> {
        let mut found = Vec::new();
        input
            .by_ref()
            .take(MAGIC.len() as u64)
            .read_to_end(&mut found)?;
        if found != MAGIC {
            return Err(McapError::Magic { found });
        }
        Ok(Self {
            input,
            offset: MAGIC.len() as u64,
            schemas: BTreeMap::new(),
            topics: BTreeMap::new(),
            chunk: Vec::new(),
            at: 0,
            is_over: false,
            library: String::new(),
        })
    }

    /// The topics so far, with the number of messages read of each.
    pub fn topics(&self) -> impl Iterator<Item = &TopicCount> {
        self.topics.values()
    }

    /// The program that wrote the file.
    #[must_use]
    pub fn library(&self) -> &str {
        &self.library
    }

    /// Whether the file was closed: its data have come to their end.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.is_over
    }

    /// The next message; none behind the last one.
    ///
    /// # Errors
    /// A file that is cut off or damaged, or whose chunks are packed.
    pub fn next_message(&mut self) -> Result<Option<McapContent>, McapError> {
        while !self.is_over {
            let Some((kind, content)) = self.next_record()? else {
                return Ok(None);
            };
            if let Some(message) = self.record(kind, &content)? {
                return Ok(Some(message));
            }
        }
        Ok(None)
    }

    /// The next record, of the current chunk or of the file.
    fn next_record(&mut self) -> Result<Option<(u8, Vec<u8>)>, McapError> {
        let offset = self.offset;
        let failed = |found: String| McapError::Length { offset, found };
        if self.at < self.chunk.len() {
            let mut fields = Fields(&self.chunk[self.at..]);
            let head = fields.array::<1>().zip(fields.u64());
            let ([kind], length) = head.ok_or_else(|| failed("a cut-off one in a chunk".into()))?;
            let bytes = usize::try_from(length).ok();
            let content = bytes.and_then(|bytes| fields.take(bytes));
            let content = content
                .ok_or_else(|| failed(format!("{length} in a chunk")))?
                .to_vec();
            self.at += 9 + content.len();
            return Ok(Some((kind, content)));
        }
        let mut head = Vec::new();
        self.input.by_ref().take(9).read_to_end(&mut head)?;
        if head.is_empty() {
            return Ok(None);
        }
        let mut fields = Fields(&head);
        let both = fields.array::<1>().zip(fields.u64());
        let ([kind], length) = both.ok_or_else(|| failed("a cut-off one".into()))?;
        if length > LONGEST_RECORD {
            return Err(failed(length.to_string()));
        }
        let mut content = Vec::new();
        self.input.by_ref().take(length).read_to_end(&mut content)?;
        if (content.len() as u64) < length {
            return Err(failed(format!("{} of {length}", content.len())));
        }
        self.offset += 9 + length;
        Ok(Some((kind, content)))
    }

    fn record(&mut self, kind: u8, content: &[u8]) -> Result<Option<McapContent>, McapError> {
        let offset = self.offset;
        let expected = |expected| move || McapError::Content { offset, expected };
        let mut fields = Fields(content);
        match kind {
            kind::HEADER => {
                let names = fields.text().zip(fields.text());
                self.library = names.ok_or_else(expected("profile and library"))?.1;
            }
            kind::SCHEMA => {
                let schema = fields.u16().zip(fields.text());
                let (id, name) = schema.ok_or_else(expected("a schema's number and name"))?;
                if self.schemas.len() < MOST_TOPICS {
                    self.schemas.insert(id, name);
                }
            }
            kind::CHANNEL => {
                let ids = fields.u16().zip(fields.u16());
                let both = ids.zip(fields.text());
                let ((id, schema), name) = both.ok_or_else(expected("a channel's numbers"))?;
                if self.topics.len() < MOST_TOPICS {
                    let schema = self.schemas.get(&schema).cloned().unwrap_or_default();
                    let topic = self.topics.entry(id).or_default();
                    (topic.name, topic.schema) = (name, schema);
                }
            }
            kind::MESSAGE => {
                let id = fields.u16().zip(fields.u32());
                let times = id.zip(fields.u64()).zip(fields.u64());
                let (((id, _), log_ns), _) = times.ok_or_else(expected("a message's head"))?;
                let topic = self.topics.get_mut(&id);
                let topic = topic.ok_or_else(expected("a channel before its messages"))?;
                topic.messages += 1;
                return Ok(Some(McapContent {
                    topic: topic.name.clone(),
                    log_ns,
                    data: fields.0.to_vec(),
                }));
            }
            kind::CHUNK => self.open_chunk(content)?,
            kind::DATA_END => self.is_over = true,
            _ => {}
        }
        Ok(None)
    }

    fn open_chunk(&mut self, content: &[u8]) -> Result<(), McapError> {
        let offset = self.offset;
        let expected = |expected| McapError::Content { offset, expected };
        if self.at < self.chunk.len() {
            return Err(expected("no chunk within a chunk"));
        }
        let mut fields = Fields(content);
        let mut head = || {
            let (_, _, size, crc) = (fields.u64()?, fields.u64()?, fields.u64()?, fields.u32()?);
            let packing = fields.text()?;
            let bytes = usize::try_from(fields.u64()?).ok()?;
            Some((size, crc, packing, fields.take(bytes)?))
        };
        let (size, crc, packing, records) = head().ok_or_else(|| expected("a chunk's fields"))?;
        if !packing.is_empty() || records.len() as u64 != size {
            return Err(expected("a chunk without packing"));
        }
        if crc != 0 && crc != crc32fast::hash(records) {
            return Err(expected("a chunk with the checksum that it states"));
        }
        (self.chunk, self.at) = (records.to_vec(), 0);
        Ok(())
    }
}
