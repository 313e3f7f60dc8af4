//! Lines of bounded length from a stream; LF, CR LF and CR end a line.

use std::io::{self, BufRead};

/// One line of a text log.
pub(super) enum Line {
    /// A line, found in [`Lines::text`] without its end; `ended` is whether it had one.
    Text { ended: bool },
    /// A line longer than the limit, skipped.
    TooLong,
}

/// Reads one line at a time into a reused buffer.
pub(super) struct Lines<R> {
    reader: R,
    buffer: Vec<u8>,
    limit: usize,
    bytes: u64,
    after_cr: bool,
}

impl<R: BufRead> Lines<R> {
    /// Lines of at most `limit` bytes.
    pub(super) fn new(reader: R, limit: usize) -> Self {
        Self {
            reader,
            buffer: Vec::new(),
            limit,
            bytes: 0,
            after_cr: false,
        }
    }

    /// The line last read.
    pub(super) fn text(&self) -> &[u8] {
        &self.buffer
    }

    /// Bytes read from the input.
    pub(super) fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Reads the next line; `None` at the end of the file.
    pub(super) fn next(&mut self) -> io::Result<Option<Line>> {
        self.buffer.clear();
        let (mut any, mut too_long, mut ended) = (false, false, false);
        while !ended {
            let available = match self.reader.fill_buf() {
                Ok(b) => b,
                Err(e) if e.kind() == io::ErrorKind::Interrupted => continue,
                Err(e) => return Err(e),
            };
            if available.is_empty() {
                break;
            }
            // The LF of a CR LF that is split between two portions, or two calls.
            let start = usize::from(std::mem::take(&mut self.after_cr) && available[0] == b'\n');
            let rest = &available[start..];
            let end = rest.iter().position(|b| matches!(b, b'\n' | b'\r'));
            let content = &rest[..end.unwrap_or(rest.len())];
            any |= !rest.is_empty();
            if self.buffer.len() + content.len() > self.limit {
                too_long = true;
            } else if !too_long {
                self.buffer.extend_from_slice(content);
            }
            let used = start + end.map_or(rest.len(), |e| e + 1);
            self.after_cr = end.is_some_and(|e| rest[e] == b'\r');
            ended = end.is_some();
            self.reader.consume(used);
            self.bytes += used as u64;
        }
        Ok(any.then_some(if too_long {
            Line::TooLong
        } else {
            Line::Text { ended }
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_line_ends_in_any_portions() {
        let text = b"a\rb\r\n\nc\r\rlonger\nd";
        for portion in 1..=text.len() {
            let reader = io::BufReader::with_capacity(portion, &text[..]);
            let mut lines = Lines::new(reader, 5);
            let mut seen = Vec::new();
            while let Some(line) = lines.next().unwrap() {
                seen.push(match line {
                    Line::Text { ended } => {
                        (String::from_utf8_lossy(lines.text()).into_owned(), ended)
                    }
                    Line::TooLong => ("…".to_owned(), true),
                });
            }
            let want = [
                ("a", true),
                ("b", true),
                ("", true),
                ("c", true),
                ("", true),
            ];
            let want = [&want[..], &[("…", true), ("d", false)]].concat();
            let want: Vec<_> = want.iter().map(|(t, e)| ((*t).to_owned(), *e)).collect();
            assert_eq!(seen, want, "{portion}");
            assert_eq!(lines.bytes(), text.len() as u64);
        }
    }
}
