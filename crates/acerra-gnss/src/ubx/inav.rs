//! Galileo I/NAV pages (Galileo OS SIS ICD 2.1).

use acerra_geo::time::GpsTime;

use super::decoded::Decoded;
use crate::observations::satellite::SatelliteId;
use crate::orbits::bits::{Bits, SEMICIRCLE_RAD, crc24q};
use crate::orbits::navigation::KeplerEphemeris;
use crate::rinex::{galileo_accuracy_of_index_m, nearest_week};

/// RINEX's data source word for I/NAV: E1-B and E5b pages, clock for E5b and E1.
const DATA_SOURCE: u32 = 1 | 1 << 2 | 1 << 9;

/// The words collected from one satellite.
#[derive(Debug, Clone, Default)]
pub(super) struct InavCollector {
    words: [Option<Bits>; 5],
}

impl InavCollector {
    /// Processes an even and an odd page part of four 32-bit words each. `near` is any time within half a
    /// week of the page.
    pub(super) fn take(
        &mut self,
        satellite: SatelliteId,
        words: &[u32; 8],
        near: GpsTime,
    ) -> Decoded {
        let mut parts = [Bits::default(), Bits::default()];
        for (part, words) in parts.iter_mut().zip(words.chunks(4)) {
            for &word in words {
                part.push(word, 32);
            }
        }
        let [even, odd] = &parts;
        if even.unsigned(1, 1) == 1 || odd.unsigned(1, 1) == 1 {
            return Decoded::Pending;
        }
        if even.unsigned(0, 1) != 0 || odd.unsigned(0, 1) != 1 {
            return Decoded::Invalid;
        }
        // The checksum covers 114 bits of the even part and 82 of the odd one.
        let mut covered = Bits::default();
        covered.push(0, 4);
        copy(even, 0, 114, &mut covered);
        copy(odd, 0, 82, &mut covered);
        let bytes: Vec<u8> = (0..covered.len() / 8)
            .map(|i| covered.unsigned(8 * i, 8) as u8)
            .collect();
        if crc24q(&bytes) != odd.unsigned(82, 24) {
            return Decoded::Invalid;
        }
        let mut word = Bits::default();
        copy(even, 2, 112, &mut word);
        copy(odd, 2, 16, &mut word);
        let kind = word.unsigned(0, 6) as usize;
        if !(1..=5).contains(&kind) {
            return Decoded::Pending;
        }
        self.words[kind - 1] = Some(word);
        self.ephemeris(satellite, near)
    }

    fn ephemeris(&self, satellite: SatelliteId, near: GpsTime) -> Decoded {
        let [Some(one), Some(two), Some(three), Some(four), Some(five)] = &self.words else {
            return Decoded::Pending;
        };
        let issue = one.unsigned(6, 10);
        if [two, three, four]
            .iter()
            .any(|w| w.unsigned(6, 10) != issue)
        {
            return Decoded::Pending;
        }
        if four.unsigned(16, 6) != u32::from(satellite.number()) {
            return Decoded::Invalid;
        }
        let angle = |bits: &Bits, start, width, exponent| {
            bits.scaled(start, width, exponent) * SEMICIRCLE_RAD
        };
        let toe_s = f64::from(one.unsigned(16, 14)) * 60.0;
        let toc_s = f64::from(four.unsigned(54, 14)) * 60.0;
        let sqrt_semi_major_axis = one.scaled_unsigned(94, 32, -19);
        let eccentricity = one.scaled_unsigned(62, 32, -33);
        if !KeplerEphemeris::can_be([toe_s, toc_s], sqrt_semi_major_axis, eccentricity) {
            return Decoded::Invalid;
        }
        let sent = nearest_week(near, f64::from(five.unsigned(85, 20)));
        let health = |start, width| five.unsigned(start, width);
        Decoded::Kepler(Box::new(KeplerEphemeris {
            satellite,
            iode: issue,
            iodc: 0,
            // RINEX: E1-B validity and status in bits 0–2, E5b in bits 6–8.
            health: health(72, 1) | health(69, 2) << 1 | health(71, 1) << 6 | health(67, 2) << 7,
            data_source: DATA_SOURCE,
            accuracy_m: galileo_accuracy_of_index_m(three.unsigned(120, 8)),
            toc: nearest_week(sent, toc_s),
            toe: nearest_week(sent, toe_s),
            transmission_time: sent,
            toe_seconds_of_week: toe_s,
            sqrt_semi_major_axis,
            eccentricity,
            inclination_rad: angle(two, 48, 32, -31),
            ascending_node_rad: angle(two, 16, 32, -31),
            perigee_rad: angle(two, 80, 32, -31),
            mean_anomaly_rad: angle(one, 30, 32, -31),
            mean_motion_correction_rad_s: angle(three, 40, 16, -43),
            ascending_node_rate_rad_s: angle(three, 16, 24, -43),
            inclination_rate_rad_s: angle(two, 112, 14, -43),
            latitude_correction_rad: [three.scaled(56, 16, -29), three.scaled(72, 16, -29)],
            radius_correction_m: [three.scaled(88, 16, -5), three.scaled(104, 16, -5)],
            inclination_correction_rad: [four.scaled(22, 16, -29), four.scaled(38, 16, -29)],
            clock: [
                four.scaled(68, 31, -34),
                four.scaled(99, 21, -46),
                four.scaled(120, 6, -59),
            ],
            group_delay_s: [five.scaled(47, 10, -32), five.scaled(57, 10, -32)],
        }))
    }
}

fn copy(from: &Bits, start: usize, count: usize, to: &mut Bits) {
    for i in start..start + count {
        to.push(from.unsigned(i, 1), 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The five words, field by field in the order of the ICD's tables.
    fn words_of(satellite: u32, issue: u32) -> [Vec<(i64, usize)>; 5] {
        let issue = i64::from(issue);
        let toe = 475_200 / 60;
        [
            vec![
                (1, 6),
                (issue, 10),
                (toe, 14),
                (-1_000_000, 32),
                (3_000_000, 32),
                (2_852_450_000, 32),
                (0, 2),
            ],
            vec![
                (2, 6),
                (issue, 10),
                (700_000_000, 32),
                (680_000_000, 32),
                (-900_000_000, 32),
                (-500, 14),
                (0, 2),
            ],
            vec![
                (3, 6),
                (issue, 10),
                (-17_000, 24),
                (8_000, 16),
                (-3000, 16),
                (4000, 16),
                (5000, 16),
                (-6000, 16),
                (107, 8),
            ],
            vec![
                (4, 6),
                (issue, 10),
                (i64::from(satellite), 6),
                (70, 16),
                (-80, 16),
                (toe, 14),
                (-12_345_678, 31),
                (-345, 21),
                (-1, 6),
                (0, 2),
            ],
            vec![
                (5, 6),
                (0, 11),
                (0, 11),
                (0, 14),
                (0, 5),
                (-9, 10),
                (11, 10),
                (2, 2),
                (1, 2),
                (1, 1),
                (0, 1),
                (1421, 12),
                (475_260, 20),
                (0, 23),
            ],
        ]
    }

    /// A page of both parts with the right checksum, as eight words.
    fn page(fields: &[(i64, usize)]) -> [u32; 8] {
        let mut word = Bits::default();
        for &(value, width) in fields {
            word.push(value as u32, width);
        }
        assert_eq!(word.len(), 128);
        let mut even = Bits::default();
        even.push(0, 2);
        copy(&word, 0, 112, &mut even);
        let mut odd = Bits::default();
        odd.push(0b10, 2);
        copy(&word, 112, 16, &mut odd);
        odd.push(0, 32);
        odd.push(0, 32);
        let mut covered = Bits::default();
        covered.push(0, 4);
        copy(&even, 0, 114, &mut covered);
        copy(&odd, 0, 82, &mut covered);
        let bytes: Vec<u8> = (0..25).map(|i| covered.unsigned(8 * i, 8) as u8).collect();
        odd.push(crc24q(&bytes), 24);
        let mut out = [0; 8];
        for i in 0..4 {
            out[i] = even.unsigned(32 * i, 32);
            out[4 + i] = odd.unsigned(32 * i, 32);
        }
        out
    }

    #[test]
    fn five_words_make_an_ephemeris() {
        let satellite: SatelliteId = "E11".parse().unwrap();
        let near = GpsTime::from_week_tow(2445, 475_300.0);
        let mut collector = InavCollector::default();
        let mut last = Decoded::Pending;
        for fields in words_of(11, 77) {
            assert_eq!(last, Decoded::Pending);
            last = collector.take(satellite, &page(&fields), near);
        }
        let Decoded::Kepler(e) = last else {
            panic!("{last:?}")
        };
        assert_eq!(e.toe, GpsTime::from_week_tow(2445, 475_200.0));
        assert_eq!(e.toc, e.toe);
        assert_eq!(e.transmission_time, GpsTime::from_week_tow(2445, 475_260.0));
        assert_eq!((e.iode, e.data_source), (77, 517));
        assert_eq!(e.sqrt_semi_major_axis, 2_852_450_000.0 * 2f64.powi(-19));
        assert_eq!(e.mean_anomaly_rad, -1e6 * 2f64.powi(-31) * SEMICIRCLE_RAD);
        assert_eq!(e.inclination_rad, 6.8e8 * 2f64.powi(-31) * SEMICIRCLE_RAD);
        assert_eq!(
            e.inclination_rate_rad_s,
            -500.0 * 2f64.powi(-43) * SEMICIRCLE_RAD
        );
        assert_eq!(
            e.ascending_node_rate_rad_s,
            -17_000.0 * 2f64.powi(-43) * SEMICIRCLE_RAD
        );
        assert_eq!(e.latitude_correction_rad[1], 4000.0 * 2f64.powi(-29));
        assert_eq!(e.radius_correction_m, [156.25, -187.5]);
        assert_eq!(e.inclination_correction_rad[0], 70.0 * 2f64.powi(-29));
        assert_eq!(e.clock[0], -12_345_678.0 * 2f64.powi(-34));
        assert_eq!(e.clock[1], -345.0 * 2f64.powi(-46));
        assert_eq!(e.clock[2], -(2f64.powi(-59)));
        assert_eq!(
            e.group_delay_s,
            [-9.0 * 2f64.powi(-32), 11.0 * 2f64.powi(-32)]
        );
        assert!((e.accuracy_m - 3.12).abs() < 1e-12);
        // E5b status 2, E1-B status 1, E5b data valid flag 1.
        assert_eq!(e.health, 2 << 7 | 1 << 6 | 1 << 1);
    }

    #[test]
    fn wrong_checksums_and_mixed_issues_give_nothing() {
        let satellite: SatelliteId = "E11".parse().unwrap();
        let near = GpsTime::from_week_tow(2445, 475_300.0);
        let mut collector = InavCollector::default();
        let mut damaged = page(&words_of(11, 77)[0]);
        damaged[1] ^= 4;
        assert_eq!(collector.take(satellite, &damaged, near), Decoded::Invalid);
        for (i, fields) in words_of(11, 77).iter().enumerate() {
            let issue = if i < 2 { 77 } else { 78 };
            let fields = if i < 2 {
                fields.clone()
            } else {
                words_of(11, issue)[i].clone()
            };
            assert_eq!(
                collector.take(satellite, &page(&fields), near),
                Decoded::Pending
            );
        }
        // Words of another satellite under this satellite's number.
        let mut collector = InavCollector::default();
        for fields in words_of(12, 77) {
            let got = collector.take(satellite, &page(&fields), near);
            assert!(matches!(got, Decoded::Pending | Decoded::Invalid));
        }
    }
}
