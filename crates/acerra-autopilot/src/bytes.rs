//! A log's bytes, front to back, with the place in the file.

use std::io::{self, Read};

use crate::error::LogError;

/// Bytes read from the system at a time.
const BLOCK: usize = 1 << 16;

/// A reader with look-ahead that knows its offset.
///
/// Memory is the longest look-ahead, and one block.
#[derive(Debug)]
pub struct LogBytes<R> {
    reader: R,
    buffer: Vec<u8>,
    start: usize,
    offset: u64,
    is_ended: bool,
}

impl<R: Read> LogBytes<R> {
    /// The bytes of `reader`, whose first is byte 0.
    pub const fn new(reader: R) -> Self {
        Self {
            reader,
            buffer: Vec::new(),
            start: 0,
            offset: 0,
            is_ended: false,
        }
    }

    /// Bytes before the next one.
    pub const fn offset(&self) -> u64 {
        self.offset
    }

    /// The next `count` bytes, or all that are left where there are fewer.
    pub fn peek(&mut self, count: usize) -> io::Result<&[u8]> {
        while self.buffer.len() - self.start < count && !self.is_ended {
            self.buffer.drain(..self.start);
            self.start = 0;
            let missing = count - self.buffer.len();
            let mut block = (&mut self.reader).take(missing.max(BLOCK) as u64);
            self.is_ended = block.read_to_end(&mut self.buffer)? == 0;
        }
        let end = self.buffer.len().min(self.start.saturating_add(count));
        Ok(&self.buffer[self.start..end])
    }

    /// The next `count` bytes of a `what`.
    ///
    /// # Errors
    /// [`LogError::CutOff`] where fewer are left.
    pub fn whole(&mut self, count: usize, what: &str) -> Result<&[u8], LogError> {
        let offset = self.offset;
        let found = self.peek(count)?.len();
        if found < count {
            return Err(LogError::CutOff {
                offset,
                what: what.to_owned(),
                expected: count as u64,
                found: found as u64,
            });
        }
        Ok(&self.buffer[self.start..self.start + count])
    }

    /// Skips bytes of the look-ahead.
    pub fn advance(&mut self, count: usize) {
        let count = count.min(self.buffer.len() - self.start);
        self.start += count;
        self.offset += count as u64;
    }

    /// Goes past `count` bytes of a `what`, of any number.
    ///
    /// # Errors
    /// [`LogError::CutOff`] where fewer are left.
    pub fn skip(&mut self, count: u64, what: &str) -> Result<(), LogError> {
        let begin = self.offset;
        let mut left = count;
        while left > 0 {
            let block = usize::try_from(left).map_or(BLOCK, |left| left.min(BLOCK));
            let found = self.peek(block)?.len();
            if found == 0 {
                return Err(LogError::CutOff {
                    offset: begin,
                    what: what.to_owned(),
                    expected: count,
                    found: count - left,
                });
            }
            self.advance(found);
            left -= found as u64;
        }
        Ok(())
    }

    /// Whether nothing is left.
    pub fn is_at_end(&mut self) -> io::Result<bool> {
        Ok(self.peek(1)?.is_empty())
    }

    /// Skips to the next place, past the current byte, at which `begins` holds for the next `shown` bytes, or
    /// for all remaining bytes where there are fewer; to the end where there is none. Returns the number of
    /// skipped bytes, and whether all of them were the same byte 0 or 255, as of flash memory that was never
    /// written.
    pub fn seek(
        &mut self,
        shown: usize,
        begins: impl Fn(&[u8]) -> bool,
    ) -> io::Result<(u64, bool)> {
        let from = self.offset;
        let mut is_blank = true;
        let first = self.peek(1)?.first().copied().unwrap_or_default();
        while let Some(&byte) = self.peek(1)?.first() {
            if self.offset > from && begins(self.peek(shown)?) {
                break;
            }
            is_blank &= byte == first && matches!(byte, 0 | 255);
            self.advance(1);
        }
        Ok((self.offset - from, is_blank))
    }
}

/// The `N` bytes at `at`.
pub fn array<const N: usize>(bytes: &[u8], at: usize) -> Option<[u8; N]> {
    bytes.get(at..at.checked_add(N)?)?.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_come_in_order_across_blocks_and_the_end_is_told() {
        let all: Vec<u8> = (0..3 * BLOCK).map(|i| (i % 251) as u8).collect();
        let mut bytes = LogBytes::new(all.as_slice());
        let mut back = Vec::new();
        for step in [1, 7, 100, 5000, 40_000].into_iter().cycle() {
            let seen = bytes.peek(step).unwrap().to_vec();
            if seen.is_empty() {
                break;
            }
            bytes.advance(seen.len());
            back.extend(seen);
        }
        assert_eq!(back, all);
        assert!(bytes.is_at_end().unwrap());
        let error = bytes.whole(4, "record").unwrap_err();
        assert!(
            matches!(error, LogError::CutOff { offset, found: 0, .. } if offset == all.len() as u64)
        );
    }

    #[test]
    fn the_next_mark_is_found_and_blank_memory_is_told_from_damage() {
        let mut bytes = LogBytes::new(&b"x\xa3\x95abc\xa3\x95"[..]);
        let mark = |b: &[u8]| b.starts_with(b"\xa3\x95");
        assert_eq!(bytes.seek(2, mark).unwrap(), (1, false));
        assert_eq!(bytes.seek(2, mark).unwrap(), (5, false));
        assert_eq!(bytes.offset(), 6);
        let blank = [255; 100];
        let mut bytes = LogBytes::new(&blank[..]);
        assert_eq!(bytes.seek(2, mark).unwrap(), (100, true));
    }
}
