//! Lines of text with their numbers, and numbers of text with their lines.

use std::borrow::Cow;
use std::io::BufRead;

use super::ReadError;
use super::error::quoted;
use crate::line_end::LineEnd;

/// Reads one line at a time into a buffer that is used again.
pub(super) struct Lines<R> {
    reader: R,
    buffer: Vec<u8>,
    number: u64,
    read_bytes: u64,
    max_line_bytes: usize,
    ended: bool,
    end: LineEnd,
}

/// One line without its end.
pub(super) struct Line<'a> {
    /// Number, from 1.
    pub number: u64,
    /// Bytes of the text up to the end of this line.
    pub read_bytes: u64,
    /// Text; bytes that are not UTF-8 are replaced.
    pub text: Cow<'a, str>,
    /// Whether it had an end of line: without one it is the last, and may be cut off.
    pub ended: bool,
}

impl<R: BufRead> Lines<R> {
    pub fn new(reader: R, max_line_bytes: usize) -> Self {
        Self {
            reader,
            buffer: Vec::new(),
            number: 0,
            read_bytes: 0,
            max_line_bytes,
            ended: false,
            end: LineEnd::default(),
        }
    }

    /// Lines handed out so far.
    pub fn count(&self) -> u64 {
        self.number
    }

    /// The next line, its end (LF, CR LF or CR) and a byte-order mark taken off; none at the end.
    pub fn next(&mut self) -> Result<Option<Line<'_>>, ReadError> {
        self.buffer.clear();
        self.ended = false;
        while !self.ended {
            let chunk = self.reader.fill_buf()?;
            if chunk.is_empty() {
                break;
            }
            let piece = self.end.next_piece(chunk);
            if self.buffer.len() + piece.content.len() > self.max_line_bytes {
                return Err(ReadError::Limit {
                    line: self.number + 1,
                    what: "bytes in a line",
                    limit: self.max_line_bytes,
                });
            }
            self.buffer.extend_from_slice(&chunk[piece.content]);
            self.ended = piece.ended;
            self.read_bytes += piece.consumed as u64;
            self.reader.consume(piece.consumed);
        }
        if self.buffer.is_empty() && !self.ended {
            return Ok(None);
        }
        self.number += 1;
        let mut bytes = self.buffer.as_slice();
        if self.number == 1 {
            bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        }
        Ok(Some(Line {
            number: self.number,
            read_bytes: self.read_bytes,
            text: String::from_utf8_lossy(bytes),
            ended: self.ended,
        }))
    }
}

impl Line<'_> {
    /// The error for a line that lacks something: cut off when it is the last and has no end.
    pub fn malformed(&self, expected: impl Into<String>, found: impl Into<String>) -> ReadError {
        let (line, expected, found) = (self.number, expected.into(), found.into());
        if self.ended {
            ReadError::Malformed {
                line,
                expected,
                found,
            }
        } else {
            ReadError::CutOff {
                line,
                expected,
                found,
            }
        }
    }

    /// A finite number out of a field of this line.
    pub fn number(&self, field: &str, text: &str) -> Result<f64, ReadError> {
        let value: f64 = text
            .trim()
            .parse()
            .map_err(|_| self.malformed(format!("a number for {field}"), quoted(text)))?;
        if value.is_finite() {
            Ok(value)
        } else {
            Err(ReadError::NotFinite {
                line: self.number,
                field: field.to_owned(),
                value,
            })
        }
    }

    /// A finite number within bounds out of a field of this line.
    pub fn number_in(
        &self,
        field: &str,
        text: &str,
        range: std::ops::RangeInclusive<f64>,
        expected: &'static str,
    ) -> Result<f64, ReadError> {
        let value = self.number(field, text)?;
        if range.contains(&value) {
            Ok(value)
        } else {
            Err(ReadError::OutOfRange {
                line: self.number,
                field: field.to_owned(),
                value,
                expected,
            })
        }
    }

    /// A local coordinate or height (m): nearer than the Moon.
    pub fn metres(&self, field: &str, text: &str) -> Result<f64, ReadError> {
        self.number_in(field, text, -4e8..=4e8, "within 4e8 m")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_of_line_and_marks() -> Result<(), ReadError> {
        let mut lines = Lines::new(&b"\xef\xbb\xbfa\r\nb\n\n\xffc"[..], 100);
        let mut seen = Vec::new();
        while let Some(line) = lines.next()? {
            seen.push((line.number, line.text.into_owned(), line.ended));
        }
        let want = [
            (1, "a", true),
            (2, "b", true),
            (3, "", true),
            (4, "\u{fffd}c", false),
        ];
        assert_eq!(seen, want.map(|(n, t, e)| (n, t.to_owned(), e)));
        Ok(())
    }

    #[test]
    fn carriage_returns_alone_end_lines_in_any_portions() -> Result<(), ReadError> {
        let text = b"a\rb\r\nc\r\rd\ne\r";
        for portion in 1..=text.len() {
            let reader = std::io::BufReader::with_capacity(portion, &text[..]);
            let mut lines = Lines::new(reader, 100);
            let mut seen = Vec::new();
            while let Some(line) = lines.next()? {
                assert!(line.ended, "{portion}");
                seen.push(line.text.into_owned());
            }
            assert_eq!(seen, ["a", "b", "c", "", "d", "e"], "{portion}");
        }
        Ok(())
    }

    #[test]
    fn a_line_without_end_is_not_hoarded() {
        let endless = vec![b'x'; 5_000];
        let mut lines = Lines::new(&endless[..], 4_096);
        assert!(matches!(
            lines.next(),
            Err(ReadError::Limit {
                line: 1,
                limit: 4_096,
                ..
            })
        ));
    }
}
