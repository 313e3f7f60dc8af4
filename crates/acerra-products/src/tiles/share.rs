//! Share of the tiles of an image that one of several processes computes.

use std::str::FromStr;

/// The share `number` of `of`, counted from 1: every tile whose index leaves `number − 1` on division.
///
/// ```
/// use acerra_products::Share;
///
/// let share: Share = "2/3".parse().unwrap();
/// assert_eq!(share.of(8).collect::<Vec<_>>(), [1, 4, 7]);
/// assert!("0/3".parse::<Share>().unwrap_err().to_string().contains("found 0/3"));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    number: usize,
    of: usize,
}

/// A text that is no share.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected K/N with K from 1 to N, found {found}")]
pub struct ShareError {
    /// The text.
    pub found: String,
}

impl Share {
    /// The indices of this share among `count`.
    pub fn of(self, count: usize) -> impl Iterator<Item = usize> {
        (self.number - 1..count).step_by(self.of)
    }
}

impl FromStr for Share {
    type Err = ShareError;

    fn from_str(text: &str) -> Result<Self, ShareError> {
        let share = text.split_once('/').and_then(|(number, of)| {
            let (number, of) = (number.parse().ok()?, of.parse().ok()?);
            (1..=of).contains(&number).then_some(Self { number, of })
        });
        share.ok_or_else(|| ShareError {
            found: text.to_owned(),
        })
    }
}
