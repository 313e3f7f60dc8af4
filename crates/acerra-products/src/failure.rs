//! The message of a failure with its causes.

use crate::plain::plain_text;

/// The message of `error` and of its causes, outer first, separated by colons; a cause that already ends the
/// message before it is left out. Names from files and campaigns are shown as text, by [`plain_text`].
///
/// ```
/// use anyhow::Context;
/// let number = "x".parse::<f64>().context("line 3").unwrap_err();
/// assert_eq!(acerra_products::failure_text(&number), "line 3: invalid float literal");
/// ```
#[must_use]
pub fn failure_text(error: &anyhow::Error) -> String {
    let mut text = String::new();
    for cause in error.chain().map(ToString::to_string) {
        if text.ends_with(&cause) {
            continue;
        }
        if !text.is_empty() {
            text.push_str(": ");
        }
        text.push_str(&cause);
    }
    plain_text(&text).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, thiserror::Error)]
    #[error("[trajectory] time_offset_s: {0}")]
    struct Told(#[from] std::fmt::Error);

    #[derive(Debug, thiserror::Error)]
    #[error("flight.mrm")]
    struct Named(#[from] std::fmt::Error);

    #[test]
    fn a_cause_is_said_once() {
        let cause = std::fmt::Error.to_string();
        let error = anyhow::Error::from(Told(std::fmt::Error)).context("flight.toml");
        let text = failure_text(&error);
        assert_eq!(
            text,
            format!("flight.toml: [trajectory] time_offset_s: {cause}")
        );
        let named = anyhow::Error::from(Named(std::fmt::Error));
        assert_eq!(failure_text(&named), format!("flight.mrm: {cause}"));
        let hostile = anyhow::anyhow!("no such file").context("a\u{1b}[31m.mrm");
        assert_eq!(failure_text(&hostile), "a\\u{1b}[31m.mrm: no such file");
    }
}
