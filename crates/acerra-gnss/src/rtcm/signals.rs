//! Signals of the bits of an MSM signal mask (RTCM 10403.3, tables 3.5-91 ff.).

use crate::observations::satellite::System;
use crate::observations::signal::SignalCode;

/// The signals of a system: mask bit (1 to 32), then band and attribute as RINEX names them.
const fn table(system: System) -> &'static str {
    match system {
        System::Gps => {
            "2:1C 3:1P 4:1W 8:2C 9:2P 10:2W 15:2S 16:2L 17:2X 22:5I 23:5Q 24:5X 30:1S 31:1L 32:1X"
        }
        System::Glonass => "2:1C 3:1P 8:2C 9:2P",
        System::Galileo => {
            "2:1C 3:1A 4:1B 5:1X 6:1Z 8:6C 9:6A 10:6B 11:6X 12:6Z 14:7I 15:7Q 16:7X 18:8I 19:8Q \
             20:8X 22:5I 23:5Q 24:5X"
        }
        System::Sbas => "2:1C 22:5I 23:5Q 24:5X",
        System::Qzss => {
            "2:1C 9:6S 10:6L 11:6X 15:2S 16:2L 17:2X 22:5I 23:5Q 24:5X 30:1S 31:1L 32:1X"
        }
        System::Beidou => {
            "2:2I 3:2Q 4:2X 8:6I 9:6Q 10:6X 14:7I 15:7Q 16:7X 22:5D 23:5P 24:5X 25:7D 30:1D 31:1P \
             32:1X"
        }
        System::Navic => "8:9A 22:5A",
    }
}

/// The signal of mask bit 1 to 32; `None` for reserved bits.
pub(super) fn signal(system: System, bit: u8) -> Option<SignalCode> {
    let mut rows = table(system)
        .split(' ')
        .filter_map(|row| row.split_once(':'));
    let (_, code) = rows.find(|(number, _)| number.parse() == Ok(bit))?;
    let (band, attribute) = code.split_at(1);
    Some(SignalCode::new(
        band.parse().ok()?,
        attribute.chars().next()?,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_is_a_signal_with_a_carrier() {
        for system in System::ALL {
            let codes: Vec<SignalCode> = (0..=33).filter_map(|bit| signal(system, bit)).collect();
            assert_eq!(codes.len(), table(system).split(' ').count(), "{system}");
            for code in codes {
                let carrier = code.carrier_frequency_hz(system, Some(0));
                assert!(carrier.is_some(), "{system} {code}");
            }
        }
        assert_eq!(signal(System::Gps, 1), None);
        assert_eq!(signal(System::Gps, 24), Some(SignalCode::new(5, 'X')));
    }
}
