//! Lines of text formats, with their numbers and a bound on their length.

use std::io::{BufRead, Read};

use super::error::ReadError;
use super::limits::Limits;
use super::report::ReadReport;

/// A stream of lines, the input of the RINEX readers: a decoder (Hatanaka) can be placed between reader and
/// file.
pub trait LineSource {
    /// Moves to the next line; false at the end.
    ///
    /// # Errors
    /// [`ReadError::Io`] and [`ReadError::Limit`].
    fn advance(&mut self) -> Result<bool, ReadError>;
    /// The current line without its end-of-line characters.
    fn line(&self) -> &[u8];
    /// Number of the current line in the file, from 1.
    fn number(&self) -> u64;
    /// Whether the current line ended with a line feed. False only at the end of a file.
    fn terminated(&self) -> bool;
    /// Returns the data that the source itself dropped so far.
    fn take_report(&mut self) -> ReadReport {
        ReadReport::default()
    }
}

/// [`LineSource`] over a buffered reader. Line feeds end lines; a carriage return before one, and a Ctrl-Z at
/// the end of a file, are dropped. Carriage returns end lines where there is no line feed; a byte order mark
/// before the first line is dropped.
#[derive(Debug)]
pub struct Lines<R> {
    reader: R,
    limits: Limits,
    buffer: Vec<u8>,
    number: u64,
    terminated: bool,
    bytes: u64,
    /// The byte that ends lines, once it is known.
    end: Option<u8>,
}

/// The byte that ends lines of a text that begins like this: carriage returns, as old Macintosh programs wrote them, where
/// there is no line feed.
pub(crate) fn line_end(start: &[u8]) -> u8 {
    match start.iter().find(|b| matches!(b, b'\n' | b'\r')) {
        Some(b'\r') if !start.contains(&b'\n') => b'\r',
        _ => b'\n',
    }
}

/// The mark of UTF-8, which some editors put before a text.
pub(crate) const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

impl<R: BufRead> Lines<R> {
    /// Lines of `reader` within `limits`.
    pub fn new(reader: R, limits: Limits) -> Self {
        Self {
            reader,
            limits,
            buffer: Vec::new(),
            number: 0,
            terminated: true,
            bytes: 0,
            end: None,
        }
    }
}

impl<R: BufRead> LineSource for Lines<R> {
    fn advance(&mut self) -> Result<bool, ReadError> {
        self.buffer.clear();
        let most = self.limits.max_line_bytes as u64 + 1;
        let end = match self.end {
            Some(end) => end,
            None => {
                let end = line_end(self.reader.fill_buf()?);
                *self.end.insert(end)
            }
        };
        let taken = self
            .reader
            .by_ref()
            .take(most)
            .read_until(end, &mut self.buffer)?;
        if taken == 0 {
            return Ok(false);
        }
        self.bytes += taken as u64;
        self.terminated = self.buffer.last() == Some(&end);
        if !self.terminated && taken as u64 == most {
            return Err(ReadError::Limit {
                what: "a line",
                limit: most - 1,
            });
        }
        if self.bytes > self.limits.max_bytes {
            return Err(ReadError::Limit {
                what: "the file",
                limit: self.limits.max_bytes,
            });
        }
        if self.terminated {
            self.buffer.pop();
        }
        while matches!(self.buffer.last(), Some(b'\r' | 0x1a)) {
            self.buffer.pop();
        }
        self.number += 1;
        if self.number == 1 && self.buffer.starts_with(BYTE_ORDER_MARK) {
            self.buffer.drain(..BYTE_ORDER_MARK.len());
        }
        // A lone Ctrl-Z (CP/M's end of file) is no line.
        if !self.terminated && self.buffer.is_empty() {
            return Ok(false);
        }
        Ok(true)
    }

    fn line(&self) -> &[u8] {
        &self.buffer
    }

    fn number(&self) -> u64 {
        self.number
    }

    fn terminated(&self) -> bool {
        self.terminated
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(text: &[u8], limits: Limits) -> Result<Vec<(u64, Vec<u8>, bool)>, ReadError> {
        let mut lines = Lines::new(text, limits);
        let mut out = Vec::new();
        while lines.advance()? {
            out.push((lines.number(), lines.line().to_vec(), lines.terminated()));
        }
        Ok(out)
    }

    #[test]
    fn both_line_ends_and_an_unterminated_tail() {
        let got = all(b"a\r\n\nbc", Limits::default()).unwrap();
        assert_eq!(
            got,
            vec![
                (1, b"a".to_vec(), true),
                (2, b"".to_vec(), true),
                (3, b"bc".to_vec(), false)
            ]
        );
        assert_eq!(all(b"a\n\x1a", Limits::default()).unwrap().len(), 1);
        let old = all(b"\xef\xbb\xbfa\r\rbc\r", Limits::default()).unwrap();
        let texts: Vec<&[u8]> = old.iter().map(|(_, text, _)| text.as_slice()).collect();
        assert_eq!(texts, [&b"a"[..], b"", b"bc"]);
    }

    #[test]
    fn limits_hold() {
        let limits = Limits {
            max_bytes: 10,
            max_line_bytes: 4,
        };
        assert!(matches!(
            all(b"12345\n", limits),
            Err(ReadError::Limit { what: "a line", .. })
        ));
        assert!(all(b"1234\n", limits).is_ok());
        assert!(matches!(
            all(b"123\n123\n123\n", limits),
            Err(ReadError::Limit {
                what: "the file",
                ..
            })
        ));
    }
}
