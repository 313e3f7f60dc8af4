//! Reading a choice that is a word or a value.

use serde::de::{Deserialize, Deserializer, Error};
use toml::Value;

/// Farthest place (m) from the origin of the frame, more than the Earth's radius.
pub(crate) const FARTHEST_M: f64 = 1e7;
/// Longest time (s) between radar and trajectory clock: a tenth of GPS time.
pub(crate) const LONGEST_S: f64 = 1e10;
/// Longest delay (ns): light goes 300 km.
pub(crate) const LONGEST_NS: f64 = 1e6;

/// One of `words`, or what `other` reads from the value; `expected` lists both.
pub(super) fn word_or<'de, D: Deserializer<'de>, T: Copy>(
    deserializer: D,
    words: &[(&str, T)],
    other: impl FnOnce(&Value) -> Option<T>,
    expected: &str,
) -> Result<T, D::Error> {
    let value = Value::deserialize(deserializer)?;
    let word = words.iter().find(|(word, _)| value.as_str() == Some(word));
    word.map(|(_, choice)| *choice)
        .or_else(|| other(&value))
        .ok_or_else(|| Error::custom(format!("expected {expected}; found {value}")))
}

/// The value of a table's only key.
pub(super) fn single<'a>(value: &'a Value, key: &str) -> Option<&'a Value> {
    let table = value.as_table()?;
    if table.len() == 1 {
        table.get(key)
    } else {
        None
    }
}

/// A number, whole or not, whose magnitude is `most` or less.
pub(super) fn within(value: &Value, most: f64) -> Option<f64> {
    let number = match value {
        Value::Float(x) => *x,
        #[expect(
            clippy::cast_precision_loss,
            reason = "campaign numbers are far below 2^53"
        )]
        Value::Integer(x) => *x as f64,
        _ => return None,
    };
    (number.abs() <= most).then_some(number)
}

/// Two numbers whose magnitudes are `most` or less.
pub(super) fn pair_within(value: &Value, most: f64) -> Option<[f64; 2]> {
    match value.as_array()?.as_slice() {
        [from, to] => Some([within(from, most)?, within(to, most)?]),
        _ => None,
    }
}
