//! The values of settings.

use super::error::ConfError;
use super::setting::Setting;

impl Setting {
    pub(super) fn wrong(&self, expected: &str) -> ConfError {
        ConfError::Value {
            line: self.line,
            key: self.key.clone(),
            expected: expected.to_owned(),
            found: self.value.clone(),
        }
    }

    pub(super) fn unsupported(&self) -> ConfError {
        ConfError::Unsupported {
            line: self.line,
            key: self.key.clone(),
            value: self.value.clone(),
        }
    }

    /// The index of a value given by name or by number.
    pub(super) fn choice(&self, names: &[&str]) -> Option<usize> {
        names
            .iter()
            .position(|name| *name == self.value)
            .or_else(|| self.value.parse().ok().filter(|&i: &usize| i < names.len()))
    }

    /// A value given by name, or by number in RTKLIB's order.
    pub(super) fn named<T: Copy + std::str::FromStr>(&self, values: &[T]) -> Option<T> {
        let by_number = || values.get(self.value.parse::<usize>().ok()?).copied();
        self.value.parse().ok().or_else(by_number)
    }

    pub(super) fn switch(&self) -> Result<bool, ConfError> {
        match self.choice(&["off", "on"]) {
            Some(i) => Ok(i == 1),
            None if self.value.is_empty() => Ok(false),
            None => Err(self.wrong("on or off")),
        }
    }

    pub(super) fn number(&self) -> Result<f64, ConfError> {
        self.value
            .parse()
            .ok()
            .filter(|v: &f64| v.is_finite())
            .ok_or_else(|| self.wrong("a number"))
    }

    pub(super) fn degrees(&self) -> Result<f64, ConfError> {
        let degrees = self.number()?;
        if (0.0..90.0).contains(&degrees) {
            Ok(degrees.to_radians())
        } else {
            Err(self.wrong("degrees from 0 to below 90"))
        }
    }

    pub(super) fn unsigned(&self) -> Result<u32, ConfError> {
        self.value.parse().map_err(|_| self.wrong("a whole number"))
    }

    pub(super) fn signed(&self) -> Result<i32, ConfError> {
        self.value.parse().map_err(|_| self.wrong("a whole number"))
    }

    pub(super) fn count(&self) -> Result<usize, ConfError> {
        self.value.parse().map_err(|_| self.wrong("a whole number"))
    }

    pub(super) fn nine(&self) -> Result<[f64; 9], ConfError> {
        let mut out = [0.0; 9];
        let mut parts = self.value.split(',');
        for value in &mut out {
            let part = parts.next().unwrap_or("0").trim();
            *value = part
                .parse()
                .ok()
                .filter(|v: &f64| v.is_finite())
                .ok_or_else(|| self.wrong("nine numbers with commas"))?;
        }
        Ok(out)
    }
}
