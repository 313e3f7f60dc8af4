//! BeiDou D1 navigation message of the MEO and IGSO satellites (BDS-SIS-ICD-B1I 3.0).

use acerra_geo::time::GpsTime;

use super::decoded::Decoded;
use crate::observations::satellite::SatelliteId;
use crate::orbits::bits::{Bits, SEMICIRCLE_RAD};
use crate::orbits::navigation::KeplerEphemeris;
use crate::rinex::accuracy_of_index_m;

/// Words of a subframe, 30 bits each.
pub(super) const WORDS: usize = 10;

/// The subframes collected from one satellite.
#[derive(Debug, Clone, Default)]
pub(super) struct D1Collector {
    subframes: [Option<Bits>; 3],
}

fn second_of_week(bits: &Bits) -> u32 {
    bits.unsigned2((18, 8), (30, 12))
}

impl D1Collector {
    /// Processes one subframe of ten 30-bit words.
    pub(super) fn take(&mut self, satellite: SatelliteId, words: &[u32; WORDS]) -> Decoded {
        let mut bits = Bits::default();
        for &word in words {
            bits.push(word & 0x3FFF_FFFF, 30);
        }
        if bits.unsigned(0, 11) != 0b111_0001_0010 {
            return Decoded::Invalid;
        }
        match bits.unsigned(15, 3) {
            id @ 1..=3 => {
                self.subframes[id as usize - 1] = Some(bits);
                self.ephemeris(satellite)
            }
            4 | 5 => Decoded::Pending,
            _ => Decoded::Invalid,
        }
    }

    fn ephemeris(&self, satellite: SatelliteId) -> Decoded {
        let [Some(one), Some(two), Some(three)] = &self.subframes else {
            return Decoded::Pending;
        };
        let start = second_of_week(one);
        if second_of_week(two) != start + 6 || second_of_week(three) != start + 12 {
            return Decoded::Pending;
        }
        let toc_s = f64::from(one.unsigned2((73, 9), (90, 8))) * 8.0;
        // Seventeen bits: two in subframe 2, fifteen in subframe 3.
        let toe = two.unsigned(290, 2) << 15 | three.unsigned2((42, 10), (60, 5));
        let toe_s = f64::from(toe) * 8.0;
        let sqrt_semi_major_axis = f64::from(two.unsigned2((250, 12), (270, 20))) * 2f64.powi(-19);
        let eccentricity = f64::from(two.unsigned2((132, 10), (150, 22))) * 2f64.powi(-33);
        // Frames in which the data change carry two issues.
        if toc_s != toe_s {
            return Decoded::Pending;
        }
        if !KeplerEphemeris::can_be([toe_s, toc_s], sqrt_semi_major_axis, eccentricity) {
            return Decoded::Invalid;
        }
        let number = |bits: &Bits, high, low, exponent| {
            f64::from(bits.signed2(high, low)) * 2f64.powi(exponent)
        };
        let angle =
            |bits: &Bits, high, low, exponent| number(bits, high, low, exponent) * SEMICIRCLE_RAD;
        let week = i64::from(one.unsigned(60, 13));
        let sent = GpsTime::from_bdt_week_sow(week, f64::from(start));
        // The reference time's week is the one nearest to the transmission.
        let near = |sow: f64| {
            let week = week + ((f64::from(start) - sow) / 604_800.0).round() as i64;
            GpsTime::from_bdt_week_sow(week, sow)
        };
        let nanoseconds = |tenths: i32| f64::from(tenths) * 1e-10;
        Decoded::Kepler(Box::new(KeplerEphemeris {
            satellite,
            iode: one.unsigned(287, 5),
            iodc: one.unsigned(43, 5),
            health: one.unsigned(42, 1),
            data_source: 0,
            accuracy_m: accuracy_of_index_m(one.unsigned(48, 4)),
            toc: near(toc_s),
            toe: near(toe_s),
            transmission_time: sent,
            toe_seconds_of_week: toe_s,
            sqrt_semi_major_axis,
            eccentricity,
            inclination_rad: angle(three, (65, 17), (90, 15), -31),
            ascending_node_rad: angle(three, (211, 21), (240, 11), -31),
            perigee_rad: angle(three, (251, 11), (270, 21), -31),
            mean_anomaly_rad: angle(two, (92, 20), (120, 12), -31),
            mean_motion_correction_rad_s: angle(two, (42, 10), (60, 6), -43),
            ascending_node_rate_rad_s: angle(three, (131, 11), (150, 13), -43),
            inclination_rate_rad_s: angle(three, (189, 13), (210, 1), -43),
            latitude_correction_rad: [
                number(two, (66, 16), (90, 2), -31),
                two.scaled(180, 18, -31),
            ],
            radius_correction_m: [
                number(two, (198, 4), (210, 14), -6),
                number(two, (224, 8), (240, 10), -6),
            ],
            inclination_correction_rad: [
                number(three, (105, 7), (120, 11), -31),
                number(three, (163, 9), (180, 9), -31),
            ],
            clock: [
                number(one, (225, 7), (240, 17), -33),
                number(one, (257, 5), (270, 17), -50),
                one.scaled(214, 11, -66),
            ],
            group_delay_s: [
                nanoseconds(one.signed(98, 10)),
                nanoseconds(one.signed2((108, 4), (120, 6))),
            ],
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A subframe of 224 information bits, laid into ten words as the ICD does: the first word
    /// carries 26 of them, the others 22, each followed by its check bits.
    fn subframe(fields: &[(i64, usize)]) -> [u32; WORDS] {
        let bits: Vec<u32> = fields
            .iter()
            .flat_map(|&(value, width)| (0..width).rev().map(move |i| (value >> i & 1) as u32))
            .collect();
        assert_eq!(bits.len(), 224);
        let mut out = [0; WORDS];
        let mut at = 0;
        for (i, word) in out.iter_mut().enumerate() {
            let take = if i == 0 { 26 } else { 22 };
            *word = bits[at..at + take].iter().fold(0, |w, b| w << 1 | b) << (30 - take);
            at += take;
        }
        out
    }

    fn head(id: i64, sow: i64) -> Vec<(i64, usize)> {
        vec![(0b111_0001_0010, 11), (0, 4), (id, 3), (sow, 20)]
    }

    fn frame(toe: i64) -> [[u32; WORDS]; 3] {
        let mut one = head(1, 345_600);
        one.extend([
            (0, 1),
            (4, 5),
            (2, 4),
            (755, 13),
            (toe, 17),
            (-71, 10),
            (33, 10),
        ]);
        one.extend([(0, 64), (-5, 11), (-3_861_000, 24), (-27_170, 22), (9, 5)]);
        let mut two = head(2, 345_606);
        two.extend([
            (7000, 16),
            (9584, 18),
            (1_906_000_000, 32),
            (15_844_000, 32),
            (5693, 18),
        ]);
        two.extend([
            (20_747, 18),
            (5830, 18),
            (2_769_605_000, 32),
            (toe >> 15, 2),
        ]);
        let mut three = head(3, 345_612);
        three.extend([
            (toe & 0x7FFF, 15),
            (676_700_000, 32),
            (6, 18),
            (-19_260, 24),
            (-15, 18),
        ]);
        three.extend([(931, 14), (1_286_000_000, 32), (-1_463_000_000, 32), (0, 1)]);
        [one, two, three].map(|f| subframe(&f))
    }

    #[test]
    fn three_subframes_make_an_ephemeris() {
        let satellite: SatelliteId = "C11".parse().unwrap();
        let mut collector = D1Collector::default();
        let [a, b, c] = frame(345_600 / 8);
        assert_eq!(collector.take(satellite, &a), Decoded::Pending);
        assert_eq!(collector.take(satellite, &b), Decoded::Pending);
        let Decoded::Kepler(e) = collector.take(satellite, &c) else {
            panic!()
        };
        assert_eq!(e.toe, GpsTime::from_bdt_week_sow(755, 345_600.0));
        assert_eq!(e.toe, e.toc);
        assert_eq!((e.iode, e.iodc, e.health), (9, 4, 0));
        let p = |x: f64, n| x * 2f64.powi(n);
        assert_eq!(
            e.clock,
            [p(-3_861_000.0, -33), p(-27_170.0, -50), p(-5.0, -66)]
        );
        assert!((e.group_delay_s[0] + 7.1e-9).abs() < 1e-20);
        assert!((e.group_delay_s[1] - 3.3e-9).abs() < 1e-20);
        assert_eq!(e.sqrt_semi_major_axis, p(2_769_605_000.0, -19));
        assert_eq!(e.eccentricity, p(15_844_000.0, -33));
        assert_eq!(e.mean_anomaly_rad, p(1_906_000_000.0, -31) * SEMICIRCLE_RAD);
        assert_eq!(
            e.mean_motion_correction_rad_s,
            p(7000.0, -43) * SEMICIRCLE_RAD
        );
        assert_eq!(e.latitude_correction_rad, [p(9584.0, -31), p(5693.0, -31)]);
        assert_eq!(e.radius_correction_m, [p(20_747.0, -6), p(5830.0, -6)]);
        assert_eq!(e.inclination_correction_rad, [p(6.0, -31), p(-15.0, -31)]);
        assert_eq!(e.inclination_rad, p(676_700_000.0, -31) * SEMICIRCLE_RAD);
        assert_eq!(
            e.ascending_node_rad,
            p(1_286_000_000.0, -31) * SEMICIRCLE_RAD
        );
        assert_eq!(e.perigee_rad, p(-1_463_000_000.0, -31) * SEMICIRCLE_RAD);
        assert_eq!(
            e.ascending_node_rate_rad_s,
            p(-19_260.0, -43) * SEMICIRCLE_RAD
        );
        assert_eq!(e.inclination_rate_rad_s, p(931.0, -43) * SEMICIRCLE_RAD);
    }

    #[test]
    fn subframes_of_different_frames_do_not_mix() {
        let satellite: SatelliteId = "C11".parse().unwrap();
        let mut collector = D1Collector::default();
        let [a, b, _] = frame(345_600 / 8);
        let [_, _, mut c] = frame(345_600 / 8);
        c[1] ^= 1 << 12;
        assert_eq!(collector.take(satellite, &a), Decoded::Pending);
        assert_eq!(collector.take(satellite, &b), Decoded::Pending);
        assert_eq!(collector.take(satellite, &c), Decoded::Pending);
        assert_eq!(collector.take(satellite, &[0; WORDS]), Decoded::Invalid);
    }
}
