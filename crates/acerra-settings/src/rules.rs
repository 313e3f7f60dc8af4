//! Tables of rules for values.

use std::ops::RangeInclusive;

use thiserror::Error;

/// A value outside its possible range.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("[{table}] {key}: expected {expected}, found {found}")]
pub struct ValueError {
    /// Table of the key.
    pub table: &'static str,
    /// The key.
    pub key: &'static str,
    /// Possible values.
    pub expected: &'static str,
    /// Statement of the file.
    pub found: String,
}

/// One rule of a table: whether the value of a key is possible, and the possible values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rule {
    /// The key.
    pub key: &'static str,
    /// Whether its value is possible.
    pub holds: bool,
    /// The possible values, in words.
    pub expected: &'static str,
    /// Statement of the file.
    pub found: String,
}

impl Rule {
    /// A rule that `holds` or not for the value `found` of `key`.
    #[must_use]
    pub fn new(
        key: &'static str,
        holds: bool,
        expected: &'static str,
        found: impl ToString,
    ) -> Self {
        Self {
            key,
            holds,
            expected,
            found: found.to_string(),
        }
    }

    /// The rule that `value` lies in `range`, which `expected` describes. NaN lies in no range.
    #[must_use]
    pub fn range(
        key: &'static str,
        value: f64,
        range: RangeInclusive<f64>,
        expected: &'static str,
    ) -> Self {
        Self::new(key, range.contains(&value), expected, value)
    }
}

/// The rules of a table, one for each key: the predicate that its value satisfies, and the possible values in
/// words. Values are shown by the format that follows the table.
///
/// ```
/// use acerra_settings::{given, rules, within};
///
/// struct Radar {
///     interval_s: f64,
///     delay_ns: Option<f64>,
/// }
///
/// let radar = Radar { interval_s: 0.07, delay_ns: Some(-2.0) };
/// let rules = rules!(radar as "{:?}" {
///     interval_s: within(1e-3..=100.0) => "0.001 to 100",
///     delay_ns: given(|ns: &f64| *ns >= 0.0) => "0 or more",
/// });
/// assert!(rules[0].holds && !rules[1].holds);
/// assert_eq!(rules[1].found, "Some(-2.0)");
/// ```
#[macro_export]
macro_rules! rules {
    ($table:ident as $shown:literal { $($key:ident: $holds:expr => $expected:expr),+ $(,)? }) => {
        [$($crate::Rule::new(
            stringify!($key),
            $crate::holds(&$table.$key, $holds),
            $expected,
            format!($shown, $table.$key),
        )),+]
    };
}

/// Whether a value satisfies a predicate; what [`rules!`] evaluates.
pub fn holds<T>(value: &T, predicate: impl Fn(&T) -> bool) -> bool {
    predicate(value)
}

/// The predicate that a value lies in `range`. NaN lies in no range.
pub fn within<T: PartialOrd>(range: RangeInclusive<T>) -> impl Fn(&T) -> bool {
    move |value| range.contains(value)
}

/// The predicate of a key that may be absent.
pub fn given<T>(predicate: impl Fn(&T) -> bool) -> impl Fn(&Option<T>) -> bool {
    move |value| value.as_ref().is_none_or(&predicate)
}

/// The predicate of each number of a list.
pub fn each<T, const N: usize>(predicate: impl Fn(&T) -> bool) -> impl Fn(&[T; N]) -> bool {
    move |values| values.iter().all(&predicate)
}

/// Refuses the first rule of `table` that does not hold.
///
/// # Errors
/// [`ValueError`] with the expected and the found value.
pub fn check(table: &'static str, rules: &[Rule]) -> Result<(), ValueError> {
    match rules.iter().find(|rule| !rule.holds) {
        None => Ok(()),
        Some(rule) => Err(ValueError {
            table,
            key: rule.key,
            expected: rule.expected,
            found: rule.found.clone(),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_broken_rule_is_said_with_table_and_key() {
        let rules = [
            Rule::range("delay_ns", 3.0, 0.0..=10.0, "0 to 10"),
            Rule::range("taper", f64::NAN, 0.0..=1.0, "0 to 1"),
            Rule::new("samples", false, "a multiple of 96", 7),
        ];
        let error = check("radar", &rules).unwrap_err();
        assert_eq!(
            error.to_string(),
            "[radar] taper: expected 0 to 1, found NaN"
        );
        assert_eq!(check("radar", &rules[..1]), Ok(()));
    }
}
