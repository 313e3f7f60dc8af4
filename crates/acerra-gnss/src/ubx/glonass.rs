//! GLONASS navigation strings (GLONASS ICD, edition 5.1).

use acerra_geo::time::GpsTime;

use crate::observations::satellite::SatelliteId;
use crate::orbits::bits::Bits;
use crate::orbits::navigation::GlonassEphemeris;
use crate::rinex::moscow_time;

/// Bits of a string, of which the last eight are check bits.
const STRING_BITS: usize = 85;

/// What a string completed.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum GlonassFrame {
    /// Nothing yet.
    Pending,
    /// Strings 1 to 4 of one superframe are there.
    Ephemeris(Box<GlonassEphemeris>),
    /// The check bits are wrong.
    Invalid,
}

/// The strings collected from one satellite.
#[derive(Debug, Clone, Default)]
pub(super) struct GlonassCollector {
    superframe: u32,
    strings: [Option<Bits>; 4],
}

impl GlonassCollector {
    /// Takes the four words of a string as RXM-SFRBX gives them. `near` is any time within half a
    /// day of it.
    pub(super) fn take(
        &mut self,
        satellite: SatelliteId,
        channel: i8,
        words: &[u32; 4],
        near: GpsTime,
    ) -> GlonassFrame {
        let mut bits = Bits::default();
        for &word in words {
            bits.push(word, 32);
        }
        if !check(&bits) {
            return GlonassFrame::Invalid;
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
            return GlonassFrame::Pending;
        }
        self.strings[number - 1] = Some(bits);
        self.ephemeris(satellite, channel, near)
    }

    fn ephemeris(&self, satellite: SatelliteId, channel: i8, near: GpsTime) -> GlonassFrame {
        let [Some(one), Some(two), Some(three), Some(four)] = &self.strings else {
            return GlonassFrame::Pending;
        };
        let slot = four.unsigned(70, 5);
        if slot != 0 && slot != u32::from(satellite.number()) {
            return GlonassFrame::Invalid;
        }
        let frame_s =
            one.unsigned(9, 5) * 3600 + one.unsigned(14, 6) * 60 + one.unsigned(20, 1) * 30;
        let reference_s = two.unsigned(9, 7) * 900;
        if frame_s >= 86_400 || reference_s >= 86_400 {
            return GlonassFrame::Invalid;
        }
        let (Some(toe), Some(transmission_time)) = (
            moscow_time(near, f64::from(reference_s)),
            moscow_time(near, f64::from(frame_s)),
        ) else {
            return GlonassFrame::Invalid;
        };
        let axis = |bits: &Bits, start, width, exponent| {
            f64::from(bits.sign_magnitude(start, width)) * 2f64.powi(exponent) * 1e3
        };
        let position_ecef_m = [one, two, three].map(|s| axis(s, 50, 27, -11));
        let radius = position_ecef_m.iter().map(|x| x * x).sum::<f64>().sqrt();
        if !(2e7..3e7).contains(&radius) {
            return GlonassFrame::Invalid;
        }
        GlonassFrame::Ephemeris(Box::new(GlonassEphemeris {
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

/// The Hamming check of a string: data bits (numbered as the ICD does, 85 first) that each of the
/// seven check sums covers, as inclusive ranges, besides its own check bit 1 to 7.
const CHECKS: [&[(usize, usize)]; 7] = [
    &[
        (9, 10),
        (12, 13),
        (15, 15),
        (17, 17),
        (19, 20),
        (22, 22),
        (24, 24),
        (26, 26),
        (28, 28),
        (30, 30),
        (32, 32),
        (34, 35),
        (37, 37),
        (39, 39),
        (41, 41),
        (43, 43),
        (45, 45),
        (47, 47),
        (49, 49),
        (51, 51),
        (53, 53),
        (55, 55),
        (57, 57),
        (59, 59),
        (61, 61),
        (63, 63),
        (65, 66),
        (68, 68),
        (70, 70),
        (72, 72),
        (74, 74),
        (76, 76),
        (78, 78),
        (80, 80),
        (82, 82),
        (84, 84),
    ],
    &[
        (9, 9),
        (11, 12),
        (14, 15),
        (18, 19),
        (21, 22),
        (25, 26),
        (29, 30),
        (33, 34),
        (36, 37),
        (40, 41),
        (44, 45),
        (48, 49),
        (52, 53),
        (56, 57),
        (60, 61),
        (64, 65),
        (67, 68),
        (71, 72),
        (75, 76),
        (79, 80),
        (83, 84),
    ],
    &[
        (10, 12),
        (16, 19),
        (23, 26),
        (31, 34),
        (38, 41),
        (46, 49),
        (54, 57),
        (62, 65),
        (69, 72),
        (77, 80),
        (85, 85),
    ],
    &[(13, 19), (27, 34), (42, 49), (58, 65), (73, 80)],
    &[(20, 34), (50, 65), (81, 85)],
    &[(35, 65)],
    &[(66, 85)],
];

fn check(bits: &Bits) -> bool {
    let bit = |icd: usize| bits.unsigned(STRING_BITS - icd, 1);
    let sums_hold = CHECKS.iter().enumerate().all(|(i, ranges)| {
        let covered: u32 = ranges.iter().flat_map(|&(a, b)| a..=b).map(bit).sum();
        (covered + bit(i + 1)).is_multiple_of(2)
    });
    let all: u32 = (1..=STRING_BITS).map(bit).sum();
    sums_hold && all.is_multiple_of(2)
}
