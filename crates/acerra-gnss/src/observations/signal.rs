//! Signal codes (band and tracking attribute) and their carrier frequencies.

use super::satellite::System;
use std::fmt;

/// Speed of light in vacuum (m/s).
pub const SPEED_OF_LIGHT_M_S: f64 = 299_792_458.0;

/// Number of frequency slots kept per satellite: L1, L2 (E5b, B2I) and L5 (E5a, B2a).
pub const FREQUENCY_SLOTS: usize = 3;

/// GPS L1 carrier (Hz), to which the ionospheric model refers.
pub const FREQUENCY_L1_HZ: f64 = 1_575.42e6;

const FREQUENCY_L2_HZ: f64 = 1_227.60e6;
const FREQUENCY_L5_HZ: f64 = 1_176.45e6;
const FREQUENCY_E5B_HZ: f64 = 1_207.14e6;
const FREQUENCY_E5_HZ: f64 = 1_191.795e6;
const FREQUENCY_E6_HZ: f64 = 1_278.75e6;
const FREQUENCY_B1I_HZ: f64 = 1_561.098e6;
const FREQUENCY_B3_HZ: f64 = 1_268.52e6;
const FREQUENCY_S_HZ: f64 = 2_492.028e6;
const FREQUENCY_G3_HZ: f64 = 1_202.025e6;
const FREQUENCY_G1A_HZ: f64 = 1_600.995e6;
const FREQUENCY_G2A_HZ: f64 = 1_248.06e6;

/// A RINEX 3 signal: band digit and tracking attribute, e.g. `1C`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SignalCode {
    /// Band digit, 1–9.
    pub band: u8,
    /// Tracking attribute letter, `A`–`Z`.
    pub attribute: char,
}

impl SignalCode {
    /// The signal with this band digit and attribute letter.
    #[must_use]
    pub const fn new(band: u8, attribute: char) -> Self {
        Self { band, attribute }
    }

    /// The frequency slot (0 = L1, 1 = L2, 2 = L5) that this signal fills in `system`.
    ///
    /// Slot 0 is L1, G1, E1, B1 (B1I or B1C) and NavIC L5; slot 1 is L2, G2, E5b and B2I; slot 2
    /// is L5, E5a, G3 and B3 or B2a. Other bands fill no slot.
    #[must_use]
    pub const fn slot(self, system: System) -> Option<usize> {
        Some(match (system, self.band) {
            (System::Gps | System::Glonass | System::Galileo | System::Qzss | System::Sbas, 1)
            | (System::Glonass, 4)
            | (System::Beidou, 1 | 2)
            | (System::Navic, 5) => 0,
            (System::Gps | System::Glonass | System::Qzss, 2)
            | (System::Glonass, 6)
            | (System::Galileo | System::Beidou, 7)
            | (System::Navic, 9) => 1,
            (System::Gps | System::Galileo | System::Qzss | System::Sbas, 5)
            | (System::Glonass, 3)
            | (System::Beidou, 5 | 6) => 2,
            _ => return None,
        })
    }

    /// Carrier frequency in Hz. `glonass_channel` is the satellite's FDMA channel (−7…6), needed
    /// for GLONASS bands 1 and 2 only; `None` when it is missing or the band does not exist.
    #[must_use]
    pub fn carrier_frequency_hz(self, system: System, glonass_channel: Option<i8>) -> Option<f64> {
        Some(match (system, self.band) {
            (System::Glonass, 1) => 1_602.0e6 + 0.562_5e6 * f64::from(glonass_channel?),
            (System::Glonass, 2) => 1_246.0e6 + 0.437_5e6 * f64::from(glonass_channel?),
            (System::Glonass, 3) => FREQUENCY_G3_HZ,
            (System::Glonass, 4) => FREQUENCY_G1A_HZ,
            (System::Glonass, 6) => FREQUENCY_G2A_HZ,
            (System::Beidou, 2) => FREQUENCY_B1I_HZ,
            (System::Beidou, 6) => FREQUENCY_B3_HZ,
            (System::Navic, 9) => FREQUENCY_S_HZ,
            (System::Navic, 1) | (_, 1) => FREQUENCY_L1_HZ,
            (System::Gps | System::Qzss, 2) => FREQUENCY_L2_HZ,
            (_, 5) => FREQUENCY_L5_HZ,
            (System::Galileo | System::Qzss, 6) => FREQUENCY_E6_HZ,
            (System::Galileo | System::Beidou, 7) => FREQUENCY_E5B_HZ,
            (System::Galileo | System::Beidou, 8) => FREQUENCY_E5_HZ,
            _ => return None,
        })
    }
}

impl fmt::Display for SignalCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.band, self.attribute)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn carriers_follow_the_band_and_the_channel() {
        let l1 = SignalCode::new(1, 'C');
        assert_eq!(l1.carrier_frequency_hz(System::Gps, None), Some(1_575.42e6));
        assert_eq!(l1.carrier_frequency_hz(System::Glonass, None), None);
        assert_eq!(
            l1.carrier_frequency_hz(System::Glonass, Some(-7)),
            Some(1_598.062_5e6)
        );
        let b1i = SignalCode::new(2, 'I');
        assert_eq!(
            b1i.carrier_frequency_hz(System::Beidou, None),
            Some(1_561.098e6)
        );
        assert_eq!(b1i.slot(System::Beidou), Some(0));
        assert_eq!(b1i.slot(System::Gps), Some(1));
        assert_eq!(SignalCode::new(6, 'C').slot(System::Galileo), None);
        assert_eq!(
            SignalCode::new(9, 'A').carrier_frequency_hz(System::Gps, None),
            None
        );
    }
}
