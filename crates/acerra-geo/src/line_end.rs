//! Line ends of text files: LF, CR LF, or CR alone (as spreadsheets on older systems write).

use std::ops::Range;

/// Finds line ends in a stream that arrives in portions. A CR at the end of one portion and an LF
/// at the beginning of the next are one line end.
#[derive(Debug, Default)]
pub(crate) struct LineEnd {
    after_cr: bool,
}

/// The part of a portion that belongs to the current line.
pub(crate) struct Piece {
    /// Bytes of the line's content, within the portion.
    pub content: Range<usize>,
    /// Bytes of the portion that are used up, line end included.
    pub consumed: usize,
    /// Whether the line ends here.
    pub ended: bool,
}

impl LineEnd {
    /// Looks at a portion that is not empty.
    pub fn next_piece(&mut self, portion: &[u8]) -> Piece {
        let start = usize::from(std::mem::take(&mut self.after_cr) && portion[0] == b'\n');
        let rest = &portion[start..];
        match rest.iter().position(|b| matches!(b, b'\n' | b'\r')) {
            Some(length) => {
                let end = start + length;
                self.after_cr = portion[end] == b'\r';
                Piece {
                    content: start..end,
                    consumed: end + 1,
                    ended: true,
                }
            }
            None => Piece {
                content: start..portion.len(),
                consumed: portion.len(),
                ended: false,
            },
        }
    }
}

/// The lines of a text that is held whole, whatever ends them. CR LF leaves an empty line between.
pub(crate) fn lines_of(text: &str) -> impl Iterator<Item = &str> + Clone {
    text.split(['\n', '\r'])
}
