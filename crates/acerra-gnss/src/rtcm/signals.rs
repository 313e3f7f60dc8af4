//! Which signal each bit of an MSM signal mask stands for (RTCM 10403.3, tables 3.5-91 ff.).

use crate::observations::satellite::System;
use crate::observations::signal::SignalCode;

/// The signals of a system by mask bit (1 to 32).
const fn table(system: System) -> &'static [(u8, u8, char)] {
    match system {
        System::Gps => &[
            (2, 1, 'C'),
            (3, 1, 'P'),
            (4, 1, 'W'),
            (8, 2, 'C'),
            (9, 2, 'P'),
            (10, 2, 'W'),
            (15, 2, 'S'),
            (16, 2, 'L'),
            (17, 2, 'X'),
            (22, 5, 'I'),
            (23, 5, 'Q'),
            (24, 5, 'X'),
            (30, 1, 'S'),
            (31, 1, 'L'),
            (32, 1, 'X'),
        ],
        System::Glonass => &[(2, 1, 'C'), (3, 1, 'P'), (8, 2, 'C'), (9, 2, 'P')],
        System::Galileo => &[
            (2, 1, 'C'),
            (3, 1, 'A'),
            (4, 1, 'B'),
            (5, 1, 'X'),
            (6, 1, 'Z'),
            (8, 6, 'C'),
            (9, 6, 'A'),
            (10, 6, 'B'),
            (11, 6, 'X'),
            (12, 6, 'Z'),
            (14, 7, 'I'),
            (15, 7, 'Q'),
            (16, 7, 'X'),
            (18, 8, 'I'),
            (19, 8, 'Q'),
            (20, 8, 'X'),
            (22, 5, 'I'),
            (23, 5, 'Q'),
            (24, 5, 'X'),
        ],
        System::Sbas => &[(2, 1, 'C'), (22, 5, 'I'), (23, 5, 'Q'), (24, 5, 'X')],
        System::Qzss => &[
            (2, 1, 'C'),
            (9, 6, 'S'),
            (10, 6, 'L'),
            (11, 6, 'X'),
            (15, 2, 'S'),
            (16, 2, 'L'),
            (17, 2, 'X'),
            (22, 5, 'I'),
            (23, 5, 'Q'),
            (24, 5, 'X'),
            (30, 1, 'S'),
            (31, 1, 'L'),
            (32, 1, 'X'),
        ],
        System::Beidou => &[
            (2, 2, 'I'),
            (3, 2, 'Q'),
            (4, 2, 'X'),
            (8, 6, 'I'),
            (9, 6, 'Q'),
            (10, 6, 'X'),
            (14, 7, 'I'),
            (15, 7, 'Q'),
            (16, 7, 'X'),
            (22, 5, 'D'),
            (23, 5, 'P'),
            (24, 5, 'X'),
            (25, 7, 'D'),
            (30, 1, 'D'),
            (31, 1, 'P'),
            (32, 1, 'X'),
        ],
        System::Navic => &[(8, 9, 'A'), (22, 5, 'A')],
    }
}

/// The signal of mask bit 1 to 32; `None` for reserved bits.
pub(super) fn signal(system: System, bit: u8) -> Option<SignalCode> {
    table(system)
        .iter()
        .find(|row| row.0 == bit)
        .map(|&(_, band, attribute)| SignalCode::new(band, attribute))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_signal_has_a_carrier_and_one_bit() {
        for system in System::ALL {
            let rows = table(system);
            assert!(rows.windows(2).all(|w| w[0].0 < w[1].0), "{system}");
            for &(bit, band, attribute) in rows {
                let code = SignalCode::new(band, attribute);
                assert_eq!(signal(system, bit), Some(code));
                assert!(
                    code.carrier_frequency_hz(system, Some(0)).is_some(),
                    "{system} {code}"
                );
            }
        }
        assert_eq!(signal(System::Gps, 1), None);
    }
}
