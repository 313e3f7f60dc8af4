//! One setting of a configuration file: `key = value`.

use super::error::ConfError;

/// A key with its value.
#[derive(Debug, Clone)]
pub(super) struct Setting {
    /// Line number, from 1.
    pub line: u64,
    pub key: String,
    pub value: String,
}

/// The setting of a line; `None` for an empty line or a comment.
pub(super) fn parse(bytes: &[u8], line: u64) -> Result<Option<Setting>, ConfError> {
    let text = String::from_utf8_lossy(bytes);
    let content = text.split('#').next().unwrap_or("").trim();
    if content.is_empty() || content.starts_with('%') {
        return Ok(None);
    }
    let Some((key, value)) = content.split_once('=') else {
        let found = content.chars().take(60).collect();
        return Err(ConfError::Line { line, found });
    };
    Ok(Some(Setting {
        line,
        key: key.trim().to_owned(),
        value: value.trim().to_owned(),
    }))
}
