//! Comma-separated fields, numbered from 1 as in the log's description.

use std::str::FromStr;

use crate::report::BlemishKind;

/// The fields of one line.
pub(super) struct Fields<'a> {
    fields: Vec<&'a str>,
}

impl<'a> Fields<'a> {
    pub(super) fn new(line: &'a str) -> Self {
        Self {
            fields: line.split(',').map(str::trim).collect(),
        }
    }

    /// Field `number`, if present, without surrounding blanks.
    pub(super) fn get(&self, number: usize) -> Option<&'a str> {
        self.fields.get(number - 1).copied()
    }

    /// Fields from `number` on, without empty ones at the end.
    pub(super) fn from(&self, number: usize) -> &[&'a str] {
        let rest = self.fields.get(number - 1..).unwrap_or_default();
        let filled = rest
            .iter()
            .rposition(|f| !f.is_empty())
            .map_or(0, |i| i + 1);
        &rest[..filled]
    }

    /// Field `number` as a number.
    pub(super) fn parse<T: FromStr>(
        &self,
        number: usize,
        expected: &'static str,
    ) -> Result<T, BlemishKind> {
        self.get(number)
            .and_then(|f| f.parse().ok())
            .ok_or(BlemishKind::MalformedLine {
                field: number,
                expected,
            })
    }

    /// Field `number` as a number, or `default` where it is empty, absent or −1.
    pub(super) fn parse_or<T: FromStr>(
        &self,
        number: usize,
        expected: &'static str,
        default: T,
    ) -> Result<T, BlemishKind> {
        match self.get(number) {
            None | Some("" | "-1") => Ok(default),
            Some(_) => self.parse(number, expected),
        }
    }
}
