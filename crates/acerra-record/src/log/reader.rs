//! Reading a session log, including one that ends within a record or is damaged.

use std::io::{self, Read};

use thiserror::Error;

use super::frame::{
    HEAD_BYTES, LOG_SIGNATURE, MARK, MAX_PAYLOAD_BYTES, Record, checked_bytes, read_more,
};

/// Bytes read at once; a whole record fits.
const CHUNK_BYTES: usize = 2 * MAX_PAYLOAD_BYTES;

/// Bytes that are checked in vain before a log is given up: thousands of damaged records claim no more together, while
/// a file made of marks would be checked a megabyte a mark.
const MOST_VAIN_BYTES: u64 = 4 << 30;

/// Reason why a log cannot be read at all.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LogReadError {
    /// The input fails.
    #[error("reading failed: {0}")]
    Io(#[from] io::Error),
    /// The file is of another kind.
    #[error("expected a session log of version 1, which begins {LOG_SIGNATURE:?}; found {found:?}")]
    Signature {
        /// The first bytes.
        found: Vec<u8>,
    },
}

/// Bytes of a log outside records.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LogDamage {
    /// Bytes inside the log that belong to no sound record.
    pub damaged_bytes: u64,
    /// Places with such bytes.
    pub damaged_places: u64,
    /// Bytes behind the last sound record: a record torn by a power cut.
    pub torn_bytes: u64,
}

/// Streams the records of a log, holding one chunk at most.
pub struct LogReader<R> {
    reader: R,
    buffer: Vec<u8>,
    at: usize,
    ended: bool,
    /// End of the last sound record, as an offset in the log.
    sound_until: u64,
    offset: u64,
    damage: LogDamage,
    /// Bytes of checksums that did not fit.
    vain_bytes: u64,
}

impl<R: Read> LogReader<R> {
    /// A reader of a log.
    ///
    /// # Errors
    /// If the input fails or is no session log. A log cut off inside its signature is empty.
    pub fn new(mut reader: R) -> Result<Self, LogReadError> {
        let mut found = Vec::new();
        read_more(&mut reader, &mut found, LOG_SIGNATURE.len())?;
        if !LOG_SIGNATURE.starts_with(&found) {
            return Err(LogReadError::Signature { found });
        }
        Ok(Self {
            reader,
            buffer: Vec::new(),
            at: 0,
            ended: false,
            sound_until: found.len() as u64,
            offset: found.len() as u64,
            damage: LogDamage::default(),
            vain_bytes: 0,
        })
    }

    /// Bytes of checksums that did not fit: the cost of damage, at most 4 GiB.
    #[must_use]
    pub fn vain_bytes(&self) -> u64 {
        self.vain_bytes
    }

    /// Bytes outside records so far; complete once all records are read.
    #[must_use]
    pub fn damage(&self) -> LogDamage {
        self.damage
    }

    /// Offset of the first byte behind the last sound record.
    #[must_use]
    pub fn sound_until(&self) -> u64 {
        self.sound_until
    }

    /// The next sound record; `None` at the end.
    ///
    /// # Errors
    /// If the input fails, or is made of marks of records that are none.
    pub fn next_record(&mut self) -> io::Result<Option<Record>> {
        let mut skipped = 0_u64;
        loop {
            self.fill()?;
            let rest = &self.buffer[self.at..];
            if let Some((record, bytes)) = Record::decode(rest) {
                self.advance(bytes);
                self.sound_until = self.offset;
                if skipped > 0 {
                    self.damage.damaged_bytes += skipped;
                    self.damage.damaged_places += 1;
                }
                return Ok(Some(record));
            }
            if rest.is_empty() {
                self.damage.torn_bytes = skipped;
                return Ok(None);
            }
            self.vain_bytes += checked_bytes(rest) as u64;
            if self.vain_bytes > MOST_VAIN_BYTES {
                return Err(io::Error::new(
                    io::ErrorKind::InvalidData,
                    format!(
                        "byte {}: expected records, found marks of records whose checksums do not fit",
                        self.offset
                    ),
                ));
            }
            // Damage: on to the next mark.
            let next = rest[1..].windows(MARK.len()).position(|w| w == MARK);
            let step = next.map_or(rest.len(), |i| i + 1);
            // A mark may straddle the end of the buffer.
            let step = if next.is_none() && !self.ended {
                step.saturating_sub(HEAD_BYTES).max(1)
            } else {
                step
            };
            self.advance(step);
            skipped += step as u64;
        }
    }

    fn advance(&mut self, bytes: usize) {
        self.at += bytes;
        self.offset += bytes as u64;
    }

    /// Holds a whole record's bytes, or all there are.
    fn fill(&mut self) -> io::Result<()> {
        let largest = HEAD_BYTES + MAX_PAYLOAD_BYTES + 4;
        if self.ended || self.buffer.len() - self.at >= largest {
            return Ok(());
        }
        self.buffer.drain(..self.at);
        self.at = 0;
        let read = read_more(&mut self.reader, &mut self.buffer, CHUNK_BYTES)?;
        self.ended = read < CHUNK_BYTES;
        Ok(())
    }
}
