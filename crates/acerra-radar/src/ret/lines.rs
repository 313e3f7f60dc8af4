//! Lines of bounded length out of a stream.

use std::io::{self, BufRead};

/// One line of a text log.
pub(super) enum Line {
    /// A line without its end; `ended` tells whether it had one.
    Text { ended: bool },
    /// A line longer than the limit, passed over.
    TooLong,
}

/// Reads the next line into `line` (without CR and LF); `None` at the end of the file.
pub(super) fn next_line(
    reader: &mut impl BufRead,
    line: &mut Vec<u8>,
    limit: usize,
    bytes: &mut u64,
) -> io::Result<Option<Line>> {
    line.clear();
    let (mut any, mut too_long) = (false, false);
    loop {
        let available = match reader.fill_buf() {
            Ok(b) => b,
            Err(e) if e.kind() == io::ErrorKind::Interrupted => continue,
            Err(e) => return Err(e),
        };
        if available.is_empty() {
            return Ok(any.then(|| finish(line, false, too_long)));
        }
        any = true;
        let end = available.iter().position(|&b| b == b'\n');
        let content = &available[..end.unwrap_or(available.len())];
        if line.len() + content.len() > limit {
            too_long = true;
        } else if !too_long {
            line.extend_from_slice(content);
        }
        let used = end.map_or(available.len(), |e| e + 1);
        reader.consume(used);
        *bytes += used as u64;
        if end.is_some() {
            return Ok(Some(finish(line, true, too_long)));
        }
    }
}

fn finish(line: &mut Vec<u8>, ended: bool, too_long: bool) -> Line {
    if line.last() == Some(&b'\r') {
        line.pop();
    }
    if too_long {
        Line::TooLong
    } else {
        Line::Text { ended }
    }
}
