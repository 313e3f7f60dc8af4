//! GPS and QZSS legacy navigation message (LNAV; IS-GPS-200).

use acerra_geo::time::GpsTime;

use super::decoded::Decoded;
use crate::observations::satellite::SatelliteId;
use crate::orbits::bits::{Bits, SEMICIRCLE_RAD};
use crate::orbits::navigation::{KeplerEphemeris, Klobuchar};
use crate::rinex::{accuracy_of_index_m, nearest_week};

/// Words of a subframe.
pub(super) const WORDS: usize = 10;
const DATA_BITS: usize = 24;

/// The subframes collected from one satellite.
#[derive(Debug, Clone, Default)]
pub(super) struct LnavCollector {
    subframes: [Option<Bits>; 3],
}

impl LnavCollector {
    /// Processes one subframe of ten 24-bit words (parity removed). `near` is any time within half a week of
    /// the subframe.
    pub(super) fn take(
        &mut self,
        satellite: SatelliteId,
        words: &[u32; WORDS],
        near: GpsTime,
    ) -> Decoded {
        let mut bits = Bits::default();
        for &word in words {
            bits.push(word, DATA_BITS);
        }
        if bits.unsigned(0, 8) != 0x8B {
            return Decoded::Invalid;
        }
        match bits.unsigned(43, 3) {
            id @ 1..=3 => {
                self.subframes[id as usize - 1] = Some(bits);
                self.ephemeris(satellite, near)
            }
            4 | 5 if bits.unsigned(50, 6) == 56 => Decoded::Ionosphere(ionosphere(&bits)),
            4 | 5 => Decoded::Pending,
            _ => Decoded::Invalid,
        }
    }

    fn ephemeris(&self, satellite: SatelliteId, near: GpsTime) -> Decoded {
        let [Some(one), Some(two), Some(three)] = &self.subframes else {
            return Decoded::Pending;
        };
        let iodc = one.unsigned(70, 2) << 8 | one.unsigned(168, 8);
        let iode = two.unsigned(48, 8);
        if iode != three.unsigned(216, 8) || iode != iodc & 0xFF {
            return Decoded::Pending;
        }
        // The count in subframe 1 gives the start of the next subframe.
        let sent = nearest_week(near, f64::from(one.unsigned(24, 17)) * 6.0 - 6.0);
        // Ten bits of the week: the full number is the one nearest to the receiver's.
        let week = i64::from(one.unsigned(48, 10));
        if (sent.week() - week).rem_euclid(1024) > 1 && (week - sent.week()).rem_euclid(1024) > 1 {
            return Decoded::Invalid;
        }
        let angle = |bits: &Bits, start, width, exponent| {
            bits.scaled(start, width, exponent) * SEMICIRCLE_RAD
        };
        let toe_s = f64::from(two.unsigned(216, 16)) * 16.0;
        let toc_s = f64::from(one.unsigned(176, 16)) * 16.0;
        let eccentricity = two.scaled_unsigned(136, 32, -33);
        let sqrt_semi_major_axis = two.scaled_unsigned(184, 32, -19);
        if !KeplerEphemeris::can_be([toe_s, toc_s], sqrt_semi_major_axis, eccentricity) {
            return Decoded::Invalid;
        }
        let group_delay = match one.signed(160, 8) {
            -128 => 0.0,
            n => f64::from(n) * 2f64.powi(-31),
        };
        Decoded::Kepler(Box::new(KeplerEphemeris {
            satellite,
            iode,
            iodc,
            health: one.unsigned(64, 6),
            data_source: one.unsigned(58, 2),
            accuracy_m: accuracy_of_index_m(one.unsigned(60, 4)),
            toc: nearest_week(sent, toc_s),
            toe: nearest_week(sent, toe_s),
            transmission_time: sent,
            toe_seconds_of_week: toe_s,
            sqrt_semi_major_axis,
            eccentricity,
            inclination_rad: angle(three, 112, 32, -31),
            ascending_node_rad: angle(three, 64, 32, -31),
            perigee_rad: angle(three, 160, 32, -31),
            mean_anomaly_rad: angle(two, 88, 32, -31),
            mean_motion_correction_rad_s: angle(two, 72, 16, -43),
            ascending_node_rate_rad_s: angle(three, 192, 24, -43),
            inclination_rate_rad_s: angle(three, 224, 14, -43),
            latitude_correction_rad: [two.scaled(120, 16, -29), two.scaled(168, 16, -29)],
            radius_correction_m: [three.scaled(144, 16, -5), two.scaled(56, 16, -5)],
            inclination_correction_rad: [three.scaled(48, 16, -29), three.scaled(96, 16, -29)],
            clock: [
                one.scaled(216, 22, -31),
                one.scaled(200, 16, -43),
                one.scaled(192, 8, -55),
            ],
            group_delay_s: [group_delay, 0.0],
        }))
    }
}

fn ionosphere(bits: &Bits) -> Klobuchar {
    let alpha = [(56, -30), (64, -27), (72, -24), (80, -24)];
    let beta = [(88, 11), (96, 14), (104, 16), (112, 16)];
    Klobuchar {
        alpha: alpha.map(|(start, exponent)| bits.scaled(start, 8, exponent)),
        beta: beta.map(|(start, exponent)| bits.scaled(start, 8, exponent)),
    }
}
