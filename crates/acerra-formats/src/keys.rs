//! Headers of `KEY = value` or `KEY:value` lines.

use crate::error::{FormatError, Place};

/// Keys in capitals with their values, in the file's order.
pub struct Keys {
    pub lines: Vec<(String, String)>,
}

impl Keys {
    pub fn parse(text: &str, separator: char) -> Self {
        let lines = text.lines().filter_map(|line| {
            let (key, value) = line.split_once(separator)?;
            Some((key.trim().to_uppercase(), value.trim().to_owned()))
        });
        Self {
            lines: lines.collect(),
        }
    }

    /// The value of a key, unless it is absent or empty.
    pub fn text(&self, key: &str) -> Option<&str> {
        let found = self.lines.iter().find(|(k, _)| k == key);
        found.map(|(_, v)| v.as_str()).filter(|v| !v.is_empty())
    }

    /// A number; none where the key is absent.
    ///
    /// # Errors
    /// A value that is no finite number.
    pub fn number(&self, key: &str) -> Result<Option<f64>, FormatError> {
        let Some(text) = self.text(key) else {
            return Ok(None);
        };
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(Some(value)),
            _ => Err(FormatError::content(Place::field(key), "a number", text)),
        }
    }

    /// A number that must be there and positive.
    ///
    /// # Errors
    /// A key that is absent, or another value.
    pub fn positive(&self, key: &str) -> Result<f64, FormatError> {
        match self.number(key)? {
            Some(value) if value > 0.0 => Ok(value),
            Some(value) => Err(FormatError::content(
                Place::field(key),
                "a positive number",
                value,
            )),
            None => Err(FormatError::content(
                Place::field(key),
                "a number",
                "no such line",
            )),
        }
    }

    /// A whole number from 1.
    ///
    /// # Errors
    /// A key that is absent, or another value.
    pub fn count(&self, key: &str) -> Result<u64, FormatError> {
        let value = self.positive(key)?;
        if value.fract() == 0.0 && value < 9e15 {
            return Ok(value as u64);
        }
        Err(FormatError::content(
            Place::field(key),
            "a whole number",
            value,
        ))
    }
}
