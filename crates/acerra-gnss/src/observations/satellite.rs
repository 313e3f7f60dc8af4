//! Satellite systems and satellite identities.

use std::fmt;
use std::str::FromStr;

/// A satellite navigation system.
///
/// The order of the variants is the processing order everywhere in this crate; it decides which
/// satellite becomes the reference of an ambiguity pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum System {
    /// GPS (United States), RINEX letter `G`.
    Gps,
    /// GLONASS (Russia), RINEX letter `R`.
    Glonass,
    /// Galileo (European Union), RINEX letter `E`.
    Galileo,
    /// QZSS (Japan), RINEX letter `J`.
    Qzss,
    /// BeiDou (China), RINEX letter `C`.
    Beidou,
    /// NavIC, formerly IRNSS (India), RINEX letter `I`.
    Navic,
    /// Satellite-based augmentation (WAAS, EGNOS, …), RINEX letter `S`.
    Sbas,
}

impl System {
    /// Every system, in processing order.
    pub const ALL: [Self; 7] = [
        Self::Gps,
        Self::Glonass,
        Self::Galileo,
        Self::Qzss,
        Self::Beidou,
        Self::Navic,
        Self::Sbas,
    ];

    /// The RINEX system letter.
    #[must_use]
    pub const fn letter(self) -> char {
        match self {
            Self::Gps => 'G',
            Self::Glonass => 'R',
            Self::Galileo => 'E',
            Self::Qzss => 'J',
            Self::Beidou => 'C',
            Self::Navic => 'I',
            Self::Sbas => 'S',
        }
    }

    /// The system with this RINEX letter, if any.
    #[must_use]
    pub const fn from_letter(letter: char) -> Option<Self> {
        Some(match letter {
            'G' => Self::Gps,
            'R' => Self::Glonass,
            'E' => Self::Galileo,
            'J' => Self::Qzss,
            'C' => Self::Beidou,
            'I' => Self::Navic,
            'S' => Self::Sbas,
            _ => return None,
        })
    }

    /// Name for messages.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Gps => "GPS",
            Self::Glonass => "GLONASS",
            Self::Galileo => "Galileo",
            Self::Qzss => "QZSS",
            Self::Beidou => "BeiDou",
            Self::Navic => "NavIC",
            Self::Sbas => "SBAS",
        }
    }

    /// Smallest and largest satellite number in use, as RINEX prints it.
    #[must_use]
    pub const fn number_range(self) -> (u8, u8) {
        match self {
            Self::Gps => (1, 32),
            Self::Glonass => (1, 27),
            Self::Galileo => (1, 36),
            Self::Qzss => (1, 10),
            Self::Beidou => (1, 63),
            Self::Navic => (1, 14),
            Self::Sbas => (20, 58),
        }
    }
}

impl fmt::Display for System {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A set of systems.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct SystemSet(u8);

impl SystemSet {
    /// No system.
    pub const NONE: Self = Self(0);
    /// Every system.
    pub const ALL: Self = Self(0x7f);
    /// GPS alone.
    pub const GPS: Self = Self(1);

    /// This set with `system` added.
    #[must_use]
    pub const fn with(self, system: System) -> Self {
        Self(self.0 | 1 << system as u8)
    }

    /// This set with `system` removed.
    #[must_use]
    pub const fn without(self, system: System) -> Self {
        Self(self.0 & !(1 << system as u8))
    }

    /// Whether `system` is in the set.
    #[must_use]
    pub const fn contains(self, system: System) -> bool {
        self.0 & (1 << system as u8) != 0
    }

    /// Whether the set is empty.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The systems in the set, in processing order.
    pub fn iter(self) -> impl Iterator<Item = System> {
        System::ALL.into_iter().filter(move |&s| self.contains(s))
    }
}

impl FromIterator<System> for SystemSet {
    fn from_iter<I: IntoIterator<Item = System>>(systems: I) -> Self {
        systems.into_iter().fold(Self::NONE, Self::with)
    }
}

impl fmt::Debug for SystemSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set().entries(self.iter()).finish()
    }
}

/// A satellite: its system and its number as RINEX prints it (QZSS `J01` is PRN 193, SBAS `S20`
/// is PRN 120). Ordered by system, then number.
///
/// ```
/// use acerra_gnss::{SatelliteId, System};
/// let satellite: SatelliteId = "G07".parse()?;
/// assert_eq!(satellite.system(), System::Gps);
/// assert_eq!(satellite.number(), 7);
/// assert!(satellite < "R01".parse()?);
/// assert_eq!(satellite.to_string(), "G07");
/// # Ok::<(), acerra_gnss::SatelliteIdError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SatelliteId {
    system: System,
    number: u8,
}

impl SatelliteId {
    /// A satellite, if the system uses the number.
    #[must_use]
    pub const fn new(system: System, number: u8) -> Option<Self> {
        let (first, last) = system.number_range();
        if number < first || number > last {
            return None;
        }
        Some(Self { system, number })
    }

    /// The satellite's system.
    #[must_use]
    pub const fn system(self) -> System {
        self.system
    }

    /// The number within the system, as RINEX prints it.
    #[must_use]
    pub const fn number(self) -> u8 {
        self.number
    }

    /// The broadcast PRN: 193–202 for QZSS, 120–158 for SBAS, else [`number`](Self::number).
    #[must_use]
    pub const fn prn(self) -> u8 {
        match self.system {
            System::Qzss => self.number + 192,
            System::Sbas => self.number + 100,
            _ => self.number,
        }
    }
}

impl fmt::Display for SatelliteId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{:02}", self.system.letter(), self.number)
    }
}

/// A text that names no satellite.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("expected a satellite such as G07, found {found:?}")]
pub struct SatelliteIdError {
    /// The text found.
    pub found: String,
}

impl FromStr for SatelliteId {
    type Err = SatelliteIdError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let error = || SatelliteIdError {
            found: text.to_owned(),
        };
        let mut chars = text.chars();
        let system = chars
            .next()
            .and_then(System::from_letter)
            .ok_or_else(error)?;
        let digits = chars.as_str().trim_start();
        if digits.is_empty() || digits.len() > 2 || !digits.bytes().all(|b| b.is_ascii_digit()) {
            return Err(error());
        }
        let number = digits.parse().map_err(|_| error())?;
        Self::new(system, number).ok_or_else(error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn satellites_are_ordered_as_the_model_wants() {
        let names = ["G01", "G32", "R01", "E36", "J01", "C63", "I01", "S20"];
        let ids: Vec<SatelliteId> = names.iter().map(|n| n.parse().unwrap()).collect();
        assert!(ids.windows(2).all(|w| w[0] < w[1]));
        assert_eq!(
            ids.iter().map(ToString::to_string).collect::<Vec<_>>(),
            names
        );
        assert_eq!(ids[4].prn(), 193);
        assert_eq!(ids[7].prn(), 120);
    }

    #[test]
    fn impossible_satellites_are_refused() {
        for text in [
            "", "G", "G00", "G33", "R28", "X01", "G123", "G-1", "S19", "é01",
        ] {
            assert!(text.parse::<SatelliteId>().is_err(), "{text}");
        }
        assert_eq!("R 3".parse::<SatelliteId>().unwrap().number(), 3);
    }

    #[test]
    fn sets_hold_what_was_put_in() {
        let set = SystemSet::GPS.with(System::Glonass);
        assert_eq!(
            set.iter().collect::<Vec<_>>(),
            [System::Gps, System::Glonass]
        );
        assert!(!set.without(System::Gps).contains(System::Gps));
        assert_eq!(
            System::ALL.into_iter().collect::<SystemSet>(),
            SystemSet::ALL
        );
    }
}
