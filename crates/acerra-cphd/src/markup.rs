//! XML text, written element by element.

use std::fmt::{Display, Write as _};

/// XML being written; elements are closed by the function that opened them.
#[derive(Debug, Default)]
pub(crate) struct Markup {
    text: String,
}

impl Markup {
    /// An element with whatever `content` writes into it.
    pub fn within(&mut self, name: &str, content: impl FnOnce(&mut Self)) {
        self.within_with(name, &[], content);
    }

    /// The element with attributes.
    pub fn within_with(
        &mut self,
        name: &str,
        attributes: &[(&str, String)],
        content: impl FnOnce(&mut Self),
    ) {
        self.open(name, attributes);
        self.text.push('\n');
        content(self);
        let _ = writeln!(self.text, "</{name}>");
    }

    /// An element that holds a value.
    pub fn value(&mut self, name: &str, value: impl Display) {
        self.value_with(name, &[], value);
    }

    /// The element with attributes.
    pub fn value_with(&mut self, name: &str, attributes: &[(&str, String)], value: impl Display) {
        self.open(name, attributes);
        self.text.push_str(&escaped(&value.to_string()));
        let _ = writeln!(self.text, "</{name}>");
    }

    /// An element with the coordinates X, Y and Z.
    pub fn xyz(&mut self, name: &str, xyz: [f64; 3]) {
        self.within(name, |xml| {
            for (axis, value) in ["X", "Y", "Z"].iter().zip(xyz) {
                xml.value(axis, value);
            }
        });
    }

    /// The whole text.
    pub fn into_text(self) -> String {
        self.text
    }

    fn open(&mut self, name: &str, attributes: &[(&str, String)]) {
        let _ = write!(self.text, "<{name}");
        for (attribute, value) in attributes {
            let _ = write!(self.text, " {attribute}=\"{}\"", escaped(value));
        }
        self.text.push('>');
    }
}

/// Text as XML takes it; control characters, which XML cannot hold, become spaces.
fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\n' | '\t' => safe.push(c),
            '\u{fffe}' | '\u{ffff}' => safe.push(' '),
            c if c.is_control() => safe.push(' '),
            c => safe.push(c),
        }
    }
    safe
}
