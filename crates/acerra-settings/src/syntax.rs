//! Parsing, with the place of what is wrong.

use serde::de::DeserializeOwned;
use thiserror::Error;

/// Text that is not TOML, or holds an unknown key or a value of the wrong form.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("line {line}, column {column}: {message}")]
pub struct SyntaxError {
    /// Line, counted from 1.
    pub line: usize,
    /// Column, counted from 1.
    pub column: usize,
    /// What is wrong.
    pub message: String,
}

/// Reads a settings file from its text.
///
/// # Errors
/// [`SyntaxError`] with the line and column of the first offence.
pub fn parse<T: DeserializeOwned>(text: &str) -> Result<T, SyntaxError> {
    toml::from_str(text).map_err(|error| {
        let (line, column) = line_and_column(text, error.span());
        SyntaxError {
            line,
            column,
            message: error.message().to_owned(),
        }
    })
}

/// Line and column, counted from 1, of the start of `span`.
fn line_and_column(text: &str, span: Option<std::ops::Range<usize>>) -> (usize, usize) {
    let at = span.map_or(0, |span| span.start).min(text.len());
    let before = &text.as_bytes()[..at];
    let line_start = before
        .iter()
        .rposition(|b| *b == b'\n')
        .map_or(0, |i| i + 1);
    (
        1 + before.iter().filter(|b| **b == b'\n').count(),
        1 + at - line_start,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_place_of_an_error_is_counted_from_one() {
        let text = "a = 1\n[b]\n  c = x\n";
        assert_eq!(line_and_column(text, Some(16..17)), (3, 7));
        assert_eq!(line_and_column(text, None), (1, 1));
        let error = parse::<toml::Table>(text).unwrap_err();
        assert_eq!(error.line, 3);
    }
}
