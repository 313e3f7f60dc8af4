//! The step of the last digit in which a text gives its coordinates.

use crate::geodesy::WGS84_SEMI_MAJOR_AXIS_M;

/// Changes of a number after which its trailing zeros are no longer chance.
const ENOUGH_CHANGES: usize = 8;

/// Digits seen of one coordinate.
#[derive(Debug, Clone, Default)]
pub(super) struct Digits {
    last: String,
    changes: usize,
    /// Most decimals written, with and without trailing zeros.
    written: Option<i32>,
    significant: Option<i32>,
}

impl Digits {
    /// Takes one number as it is written.
    pub fn take(&mut self, text: &str) {
        if text == self.last {
            return;
        }
        self.last.clear();
        self.last.push_str(text);
        self.changes += 1;
        let (mantissa, exponent) = match text.split_once(['e', 'E']) {
            Some((mantissa, exponent)) => (mantissa, exponent.parse().unwrap_or(0)),
            None => (text, 0),
        };
        let decimals = |digits: &str| digits.len().min(40) as i32 - exponent;
        let (written, significant) = match mantissa.split_once(['.', ',']) {
            Some((_, digits)) => (decimals(digits), decimals(digits.trim_end_matches('0'))),
            None => (-exponent, -exponent),
        };
        self.written = self.written.max(Some(written));
        self.significant = self.significant.max(Some(significant));
    }

    /// The step (in the text's unit); none where the numbers do not show one: too few that differ, without
    /// decimals.
    pub fn step(&self) -> Option<f64> {
        let decimals = if self.changes >= ENOUGH_CHANGES {
            self.significant?
        } else {
            self.written.filter(|d| *d > 0)?
        };
        Some(10f64.powi(-decimals))
    }

    /// The step of numbers of which many differ: a constant column may be exact.
    pub fn step_of_many(&self) -> Option<f64> {
        (self.changes >= ENOUGH_CHANGES)
            .then(|| self.step())
            .flatten()
    }
}

/// Length of a degree of longitude and of latitude (m), to a percent.
pub(super) fn degrees_in_m(latitude_deg: f64) -> [f64; 2] {
    let degree_m = WGS84_SEMI_MAJOR_AXIS_M.to_radians();
    [degree_m * latitude_deg.to_radians().cos(), degree_m]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_of_numbers_as_they_are_written() {
        let of = |texts: &[&str]| {
            let mut digits = Digits::default();
            texts.iter().for_each(|t| digits.take(t));
            digits
        };
        // Many numbers: trailing zeros carry no information.
        let padded: Vec<String> = (0..20)
            .map(|k| format!("{:.1}00", 0.1 * f64::from(k)))
            .collect();
        let padded: Vec<&str> = padded.iter().map(String::as_str).collect();
        assert!((of(&padded).step().unwrap() - 0.1).abs() < 1e-15);
        assert!((of(&padded).step_of_many().unwrap() - 0.1).abs() < 1e-15);
        // Few: as written.
        assert!((of(&["4807.0380"]).step().unwrap() - 1e-4).abs() < 1e-18);
        assert_eq!(of(&["4807.0380"]).step_of_many(), None);
        assert_eq!(of(&["75"]).step(), None);
        assert_eq!(of(&[]).step(), None);
        // Whole numbers, exponents.
        let whole: Vec<String> = (0..20).map(|k| k.to_string()).collect();
        let whole: Vec<&str> = whole.iter().map(String::as_str).collect();
        assert_eq!(of(&whole).step(), Some(1.0));
        assert!((of(&["1.25e-3"]).step().unwrap() - 1e-5).abs() < 1e-18);
    }
}
