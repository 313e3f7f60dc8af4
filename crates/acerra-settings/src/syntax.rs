//! Parsing, with the place of an error.

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
    /// Fault.
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
            message: with_suggestion(error.message()),
        }
    })
}

/// The message with the known name that is nearest to an unknown one, where one is near: a slip of the fingers, or a
/// name cut short.
fn with_suggestion(message: &str) -> String {
    let mut names = message.split('`').skip(1).step_by(2);
    let is_unknown =
        message.starts_with("unknown field ") || message.starts_with("unknown variant ");
    let Some(unknown) = names.next().filter(|_| is_unknown) else {
        return message.to_owned();
    };
    let likeness = |name: &str| strsim::jaro_winkler(&unknown.to_lowercase(), name);
    let nearest = names.max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
    match nearest.filter(|name| likeness(name) >= LEAST_LIKENESS) {
        Some(name) => format!("{message}; did you mean `{name}`?"),
        None => message.to_owned(),
    }
}

/// Similarity of two names (Jaro and Winkler, 0 to 1) from which one counts as a misspelling of the other:
/// that of the command line's options.
const LEAST_LIKENESS: f64 = 0.8;

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

    #[derive(Debug, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    #[expect(dead_code, reason = "only parsed")]
    struct Image {
        pixel_m: Option<f64>,
        accuracy: Option<f64>,
        weight: Option<Weight>,
    }

    #[derive(Debug, serde::Deserialize)]
    #[serde(rename_all = "kebab-case")]
    enum Weight {
        Trace,
        Path,
    }

    #[test]
    fn a_slip_is_answered_by_the_name_that_was_meant() {
        let message = |text: &str| parse::<Image>(text).unwrap_err().message;
        for (text, meant) in [
            ("pixle_m = 1", "pixel_m"),
            ("Pixel_M = 1", "pixel_m"),
            ("accurcy = 1", "accuracy"),
            ("weight = 'traces'", "trace"),
        ] {
            let end = format!("; did you mean `{meant}`?");
            assert!(message(text).ends_with(&end), "{}", message(text));
        }
        for text in ["units = 1", "weight = 'equal'", "pixel_m = 'x'"] {
            assert!(!message(text).contains("did you mean"), "{}", message(text));
        }
    }
}
