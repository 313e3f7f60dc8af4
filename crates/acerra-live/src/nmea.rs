//! GGA positions in a receiver's bytes as they come.

use acerra_geo::read::{ReadOptions, TrajectoryFormat, read_trajectory};

use crate::solutions::Position;

/// Bytes of a sentence at most; NMEA allows 82, some receivers send more.
const LONGEST_SENTENCE: usize = 200;
/// Sentences kept: a position is dated by the RMC or ZDA near it, and has its deviations from GST.
const KEPT: usize = 24;

/// Finds positions in sentences.
#[derive(Debug, Default)]
pub(crate) struct NmeaFinder {
    /// The sentence that begins, from its `$` on.
    open: Option<Vec<u8>>,
    kept: Vec<String>,
    /// Positions without a date, which are of no use.
    pub undated: u64,
}

impl NmeaFinder {
    /// Takes bytes; hands each dated position to `found`.
    pub fn take(&mut self, bytes: &[u8], mut found: impl FnMut(Position)) {
        for &byte in bytes {
            match (byte, &mut self.open) {
                (b'$', _) => self.open = Some(vec![byte]),
                (b'\r' | b'\n', Some(sentence)) => {
                    let text = String::from_utf8_lossy(sentence).into_owned();
                    self.open = None;
                    self.sentence(text, &mut found);
                }
                (0x20..=0x7E, Some(sentence)) if sentence.len() < LONGEST_SENTENCE => {
                    sentence.push(byte);
                }
                _ => self.open = None,
            }
        }
    }

    fn sentence(&mut self, text: String, found: &mut impl FnMut(Position)) {
        let kind = text.get(3..6).unwrap_or_default();
        if !matches!(kind, "GGA" | "RMC" | "ZDA" | "GST") || !text.contains('*') {
            return;
        }
        // A position is complete when the next one begins: its date may follow.
        if kind == "GGA" {
            if let Some(position) = self.latest() {
                found(position);
            }
            let excess = (self.kept.len() + 1).saturating_sub(KEPT);
            self.kept.drain(..excess);
        }
        self.kept.push(text);
        // Without positions the latest sentences stay: those that date the next one.
        let excess = self.kept.len().saturating_sub(4 * KEPT);
        self.kept.drain(..excess);
    }

    /// The position of the latest GGA.
    fn latest(&mut self) -> Option<Position> {
        let is_gga = |text: &String| text.get(3..6) == Some("GGA");
        let last = self.kept.iter().rposition(is_gga)?;
        let has_fix = self.kept[last].split(',').nth(6).is_some_and(|q| q != "0");
        if !has_fix {
            return None;
        }
        let text = self.kept.join("\n") + "\n";
        let mut options = ReadOptions::default();
        options.format = Some(TrajectoryFormat::Nmea);
        let (trajectory, _) = read_trajectory(text.as_bytes(), &options).ok()?;
        let fix = trajectory.fixes().last()?;
        let Some(time) = trajectory.gps_time_at(fix.time_s) else {
            self.undated += 1;
            return None;
        };
        Some(Position {
            time,
            place: *trajectory.geodetic()?.last()?,
            sigma_m: fix.standard_deviation_m(),
            status: fix.status,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use acerra_geo::time::{Calendar, GpsTime};
    use acerra_geo::trajectory::SolutionStatus;

    fn sentence(body: &str) -> String {
        let sum = body.bytes().fold(0, |sum, b| sum ^ b);
        format!("${body}*{sum:02X}\r\n")
    }

    fn epoch(second: f64, quality: u8) -> String {
        [
            sentence(&format!(
                "GNGGA,1030{second:05.2},4054.0000,N,01412.0000,E,{quality},12,0.8,12.0,M,48.0,M,,"
            )),
            sentence(&format!(
                "GNRMC,1030{second:05.2},A,4054.0000,N,01412.0000,E,0.0,0.0,151019,,,A"
            )),
            sentence(&format!(
                "GNGST,1030{second:05.2},1.0,0.02,0.01,0,0.01,0.02,0.03"
            )),
        ]
        .concat()
    }

    #[test]
    fn sentences_cut_anywhere_give_dated_positions() {
        let text: String = (0..5).map(|k| epoch(0.2 * f64::from(k), 4)).collect();
        let noise = [b"\xB5\x62\x01$$GNG\x00".as_slice(), text.as_bytes()].concat();
        for size in [1, 7, 64, noise.len()] {
            let mut finder = NmeaFinder::default();
            let mut found = Vec::new();
            for chunk in noise.chunks(size) {
                finder.take(chunk, |position| found.push(position));
            }
            // The last one is complete with the next.
            assert_eq!(found.len(), 4, "{size}");
            let last = found[3];
            let utc = Calendar::new(2019, 10, 15, 10, 30, 0.6).unwrap();
            let expected = GpsTime::from_utc(&utc).unwrap();
            assert!(last.time.seconds_since(expected).abs() < 1e-6);
            assert_eq!(last.status, SolutionStatus::Fixed);
            assert!((last.place.height_m - 60.0).abs() < 1e-6);
            assert!((last.place.latitude_deg() - 40.9).abs() < 1e-9);
        }
    }

    #[test]
    fn the_latest_sentences_date_a_position_that_was_long_in_coming() {
        let rmc = |day: u8, second: u8| {
            sentence(&format!(
                "GNRMC,1030{second:02}.00,A,4054.0000,N,01412.0000,E,0.0,0.0,{day}1019,,,A"
            ))
        };
        let gga = |second: u8| {
            sentence(&format!(
                "GNGGA,1030{second:02}.00,4054.0000,N,01412.0000,E,4,12,0.8,12.0,M,48.0,M,,"
            ))
        };
        let before: String = (0..200).map(|k| rmc(14, k % 60)).collect();
        let text = [before, rmc(15, 10), gga(10), gga(11)].concat();
        let mut found = Vec::new();
        NmeaFinder::default().take(text.as_bytes(), |position| found.push(position));
        let utc = Calendar::new(2019, 10, 15, 10, 30, 10.0).unwrap();
        assert_eq!(found.len(), 1);
        let off_s = found[0]
            .time
            .seconds_since(GpsTime::from_utc(&utc).unwrap());
        assert!(off_s.abs() < 1e-6, "{off_s}");
    }

    #[test]
    fn wrong_checksums_and_no_fix_give_nothing() {
        let wrong = epoch(1.0, 4).replace(",12,0.8", ",13,0.8");
        let mut finder = NmeaFinder::default();
        let mut found = Vec::new();
        for text in [epoch(0.8, 0), wrong, epoch(1.2, 0), epoch(1.4, 0)] {
            finder.take(text.as_bytes(), |position| found.push(position));
        }
        assert_eq!(found, []);
        // A sentence without end is not held.
        finder.take(&[b'$'; 10], |_| {});
        finder.take(&vec![b'A'; 100_000], |_| {});
        assert!(finder.open.is_none());
    }
}
