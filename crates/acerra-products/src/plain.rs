//! Text from outside, made harmless to a terminal.

use std::borrow::Cow;
use std::io::{self, Write};

/// The text with every character that a terminal would act on instead of showing it as an escape such as `\u{1b}`:
/// control characters other than tabs and ends of lines, and those that turn the direction of writing.
///
/// ```
/// use acerra_products::plain_text;
/// assert_eq!(plain_text("flight \u{1b}[31m.mrm"), "flight \\u{1b}[31m.mrm");
/// assert_eq!(plain_text("gap\tof 3 s\r\nétoile"), "gap\tof 3 s\r\nétoile");
/// ```
#[must_use]
pub fn plain_text(text: &str) -> Cow<'_, str> {
    let mut plain = String::new();
    let mut taken = 0;
    let mut characters = text.char_indices().peekable();
    while let Some((at, character)) = characters.next() {
        let ends_line =
            character == '\r' && characters.peek().is_some_and(|(_, next)| *next == '\n');
        if ends_line || !is_acted_on(character) {
            continue;
        }
        plain.push_str(&text[taken..at]);
        plain.extend(character.escape_unicode());
        taken = at + character.len_utf8();
    }
    if taken == 0 {
        return Cow::Borrowed(text);
    }
    plain.push_str(&text[taken..]);
    Cow::Owned(plain)
}

/// Whether a terminal acts on a character.
fn is_acted_on(character: char) -> bool {
    let turns = matches!(
        character,
        '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
    );
    turns || (character.is_control() && !matches!(character, '\n' | '\t'))
}

/// Writes texts on as [`plain_text`] makes them. Bytes that are no text pass unchanged.
#[derive(Debug)]
pub struct PlainWriter<W> {
    inner: W,
    /// The last byte was a carriage return, which is held until it is known whether it ends a line.
    holds_return: bool,
}

impl<W: Write> PlainWriter<W> {
    /// Writes to `inner`.
    pub const fn new(inner: W) -> Self {
        Self {
            inner,
            holds_return: false,
        }
    }
}

impl<W: Write> Write for PlainWriter<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if let Some(first) = bytes.first()
            && std::mem::take(&mut self.holds_return)
        {
            let held = if *first == b'\n' { "\r" } else { "\\u{d}" };
            self.inner.write_all(held.as_bytes())?;
        }
        self.holds_return = bytes.ends_with(b"\r");
        let now = bytes.len() - usize::from(self.holds_return);
        for chunk in bytes[..now].utf8_chunks() {
            self.inner.write_all(plain_text(chunk.valid()).as_bytes())?;
            self.inner.write_all(chunk.invalid())?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_terminal_acts_on_is_shown_and_all_else_is_unchanged() {
        for (text, shown) in [
            ("a\u{1b}]0;x\u{7}b", "a\\u{1b}]0;x\\u{7}b"),
            ("line\rover", "line\\u{d}over"),
            ("\u{9b}31m\u{202e}gpj", "\\u{9b}31m\\u{202e}gpj"),
            ("\u{7f}", "\\u{7f}"),
        ] {
            assert_eq!(plain_text(text), shown);
            assert_eq!(plain_text(shown), shown);
            let mut out = PlainWriter::new(Vec::new());
            write!(out, "{text}").unwrap();
            assert_eq!(out.inner, shown.as_bytes());
        }
        let names = "Ständchen № 5\t日本 \u{1f681}\r\n";
        assert!(matches!(plain_text(names), Cow::Borrowed(_)));
        // However a text is cut into pieces.
        let text = format!("{names}a\u{1b}\r{names}");
        let mut out = PlainWriter::new(Vec::new());
        for byte in text.as_bytes() {
            out.write_all(&[*byte]).unwrap();
        }
        assert_eq!(out.inner, plain_text(&text).as_bytes());
    }
}
