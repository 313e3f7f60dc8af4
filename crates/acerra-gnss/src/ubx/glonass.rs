//! GLONASS navigation strings (GLONASS ICD, edition 5.1).

use acerra_geo::time::GpsTime;

use super::decoded::Decoded;
use crate::observations::satellite::SatelliteId;
use crate::orbits::bits::Bits;
use crate::orbits::navigation::GlonassEphemeris;
use crate::rinex::moscow_time;

/// Bits of a string, of which the last eight are check bits.
const STRING_BITS: usize = 85;

/// The strings collected from one satellite.
#[derive(Debug, Clone, Default)]
pub(super) struct GlonassCollector {
    superframe: u32,
    strings: [Option<Bits>; 4],
}

impl GlonassCollector {
    /// Processes the four words of a string in the layout of RXM-SFRBX. `near` is any time within half a day
    /// of the string.
    pub(super) fn take(
        &mut self,
        satellite: SatelliteId,
        channel: i8,
        words: &[u32; 4],
        near: GpsTime,
    ) -> Decoded {
        let mut bits = Bits::default();
        for &word in words {
            bits.push(word, 32);
        }
        if !check(&bits) {
            return Decoded::Invalid;
        }
        // The fourth word holds the superframe and frame numbers. The immediate data change at
        // the bounds of superframes only, so that strings lost in one frame may come from another.
        let superframe = words[3] >> 16;
        if self.superframe != superframe {
            self.strings = Default::default();
            self.superframe = superframe;
        }
        let number = bits.unsigned(1, 4) as usize;
        if !(1..=4).contains(&number) {
            return Decoded::Pending;
        }
        self.strings[number - 1] = Some(bits);
        self.ephemeris(satellite, channel, near)
    }

    fn ephemeris(&self, satellite: SatelliteId, channel: i8, near: GpsTime) -> Decoded {
        let [Some(one), Some(two), Some(three), Some(four)] = &self.strings else {
            return Decoded::Pending;
        };
        let slot = four.unsigned(70, 5);
        if slot != 0 && slot != u32::from(satellite.number()) {
            return Decoded::Invalid;
        }
        let frame_s =
            one.unsigned(9, 5) * 3600 + one.unsigned(14, 6) * 60 + one.unsigned(20, 1) * 30;
        let reference_s = two.unsigned(9, 7) * 900;
        if frame_s >= 86_400 || reference_s >= 86_400 {
            return Decoded::Invalid;
        }
        let (Some(toe), Some(transmission_time)) = (
            moscow_time(near, f64::from(reference_s)),
            moscow_time(near, f64::from(frame_s)),
        ) else {
            return Decoded::Invalid;
        };
        let axis = |bits: &Bits, start, width, exponent| {
            f64::from(bits.sign_magnitude(start, width)) * 2f64.powi(exponent) * 1e3
        };
        let position_ecef_m = [one, two, three].map(|s| axis(s, 50, 27, -11));
        let radius = position_ecef_m.iter().map(|x| x * x).sum::<f64>().sqrt();
        if !(2e7..3e7).contains(&radius) {
            return Decoded::Invalid;
        }
        Decoded::Glonass(Box::new(GlonassEphemeris {
            satellite,
            channel,
            health: two.unsigned(5, 3),
            age_days: four.unsigned(32, 5),
            toe,
            transmission_time,
            position_ecef_m,
            velocity_ecef_m_s: [one, two, three].map(|s| axis(s, 21, 24, -20)),
            acceleration_ecef_m_s2: [one, two, three].map(|s| axis(s, 45, 5, -30)),
            clock_offset_s: -f64::from(four.sign_magnitude(5, 22)) * 2f64.powi(-30),
            clock_rate: f64::from(three.sign_magnitude(6, 11)) * 2f64.powi(-40),
        }))
    }
}

/// The Hamming check of a string, whose bits the ICD numbers from 85 down to 1: check bit `i + 1` is at place
/// 2^i of the code, data bits 9 to 85 are at the places between, and a check sum covers every place that has
/// bit `i`.
fn check(bits: &Bits) -> bool {
    let bit = |icd: usize| bits.unsigned(STRING_BITS - icd, 1);
    let places = (1_usize..).filter(|place| !place.is_power_of_two());
    let data: Vec<(usize, u32)> = places.zip((9..=STRING_BITS).map(bit)).collect();
    let sums_hold = (0..7).all(|i| {
        let covered = data.iter().filter(|(place, _)| place >> i & 1 == 1);
        let sum: u32 = covered.map(|(_, value)| value).sum();
        (sum + bit(i + 1)).is_multiple_of(2)
    });
    let all: u32 = (1..=STRING_BITS).map(bit).sum();
    sums_hold && all.is_multiple_of(2)
}
