//! The frequency that an antenna is named after.

/// Frequency of an antenna as a header states it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AntennaFrequency {
    /// Frequency, Hz.
    pub hz: f64,
    /// The field of the header.
    pub field: &'static str,
}

impl AntennaFrequency {
    /// The first number with the unit MHz or GHz in a text, such as `400MHz` or `1.5 GHz antenna`.
    pub(crate) fn in_text(text: &str, field: &'static str) -> Option<Self> {
        let text = text.to_ascii_lowercase();
        let is_number = |c: char| c.is_ascii_digit() || c == '.';
        let units = [("mhz", 1e6), ("ghz", 1e9)];
        let of_unit = |(unit, hz): (&str, f64)| {
            let before = text[..text.find(unit)?].trim_end();
            let digits = before.len() - before.trim_end_matches(is_number).len();
            let number: f64 = before[before.len() - digits..].parse().ok()?;
            Some(number * hz).filter(|hz| hz.is_finite() && *hz > 0.0)
        };
        let hz = units.into_iter().find_map(of_unit)?;
        Some(Self { hz, field })
    }

    /// The same where a number without a unit counts megahertz.
    pub(crate) fn in_megahertz(text: &str, field: &'static str) -> Option<Self> {
        let bare = || {
            text.trim()
                .parse::<f64>()
                .ok()
                .filter(|mhz| *mhz > 0.0 && mhz.is_finite())
        };
        Self::in_text(text, field).or_else(|| {
            bare().map(|mhz| Self {
                hz: mhz * 1e6,
                field,
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frequencies_are_found_by_their_unit() {
        let hz = |text: &str| AntennaFrequency::in_text(text, "A").map(|found| found.hz);
        assert_eq!(hz("400MHz"), Some(400e6));
        assert_eq!(hz("1.5GHz antenna"), Some(1.5e9));
        assert_eq!(hz("shielded 250 MHz (S/N 12)"), Some(250e6));
        for none in ["", "3101A", "MHz", "x MHz", "0 MHz", "1..5GHz", "50400S"] {
            assert_eq!(hz(none), None, "{none}");
        }
        let bare = |text: &str| AntennaFrequency::in_megahertz(text, "A").map(|found| found.hz);
        assert_eq!(bare(" 100.00 "), Some(100e6));
        assert_eq!(bare("1 GHz"), Some(1e9));
        assert_eq!(bare("-3"), None);
    }
}
