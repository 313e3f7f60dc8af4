//! From records in file order to a trajectory: order of time, frame, origin of time.

use super::{ReadError, ReadOptions, ReadReport, ReadWarning, SkipReason};
use crate::geodesy::{EnuFrame, Geodetic};
use crate::matrix::{Matrix3, Vector3};
use crate::time::GpsTime;
use crate::trajectory::{Fix, Frame, TimeOrigin, Trajectory};

/// When a record was taken.
#[derive(Debug, Clone, Copy)]
pub(super) enum Stamp {
    /// An instant.
    Gps(GpsTime),
    /// Seconds of the file's clock.
    Seconds(f64),
}

impl Stamp {
    fn order(&self, other: &Self) -> std::cmp::Ordering {
        match (self, other) {
            (Self::Gps(a), Self::Gps(b)) => a.cmp(b),
            (Self::Seconds(a), Self::Seconds(b)) => a.total_cmp(b),
            (Self::Gps(_), Self::Seconds(_)) => std::cmp::Ordering::Greater,
            (Self::Seconds(_), Self::Gps(_)) => std::cmp::Ordering::Less,
        }
    }
}

/// One record: the position, velocity and covariance are in the axes that [`Axes`] says.
pub(super) struct Record {
    pub line: u64,
    pub stamp: Stamp,
    pub fix: Fix,
}

/// Frame of the records' coordinates.
pub(super) enum Axes {
    /// Earth-centred, Earth-fixed; by default the frame's origin.
    Ecef { reference_m: Option<Vector3> },
    /// East, north, up about a known or unknown place.
    Local(Frame),
}

/// Memory (bytes) that the positions of any text may take.
const FREE_BYTES: u64 = 64 << 20;
/// Memory of positions per byte of text beyond that: a row with a time and three coordinates to the millimetre
/// takes less.
const MOST_TIMES: u64 = 10;

/// Whether so many positions of `bytes_each` in memory are in proportion to the text read up to `line`.
///
/// # Errors
/// [`ReadError::Limit`] where rows of a few bytes would take many times the text's length.
pub(super) fn in_proportion(
    positions: usize,
    bytes_each: usize,
    line: u64,
    read_bytes: u64,
) -> Result<(), ReadError> {
    let most = (FREE_BYTES + MOST_TIMES * read_bytes) / bytes_each as u64;
    if positions as u64 <= most {
        return Ok(());
    }
    Err(ReadError::Limit {
        line,
        what: "positions in so short a text",
        limit: usize::try_from(most).unwrap_or(usize::MAX),
    })
}

/// Steps of the last digit above this (m) err more by rounding than carrier phase does.
const COARSE_M: f64 = 0.02;

/// A covariance with the variances of rounding added; that of rounding alone where none is stated and
/// rounding is coarse.
fn rounded(covariance_m2: Option<Matrix3>, rounding_m2: Vector3) -> Option<Matrix3> {
    let coarse = rounding_m2.iter().any(|v| *v > COARSE_M * COARSE_M / 12.0);
    let mut m2 = covariance_m2.or(coarse.then_some([[0.0; 3]; 3]))?;
    for (axis, v) in rounding_m2.into_iter().enumerate() {
        m2[axis][axis] += v;
    }
    Some(m2)
}

/// Collects records and makes the trajectory.
pub(super) struct Assembler<'a> {
    options: &'a ReadOptions,
    records: Vec<Record>,
    pub report: ReadReport,
}

impl<'a> Assembler<'a> {
    pub fn new(options: &'a ReadOptions, report: ReadReport) -> Self {
        Self {
            options,
            records: Vec::new(),
            report,
        }
    }

    /// A place whose height counts from the sea, by its height above the ellipsoid; without a geoid there the height is
    /// left as it is, with a warning.
    pub fn above_ellipsoid(&mut self, place: Geodetic) -> Geodetic {
        self.options.above_ellipsoid(place).unwrap_or_else(|| {
            if !self.report.warnings.contains(&ReadWarning::GeoidHeights) {
                self.report.warnings.push(ReadWarning::GeoidHeights);
            }
            place
        })
    }

    /// Takes a record with a position, of a text of which `read_bytes` are read.
    pub fn push(&mut self, record: Record, read_bytes: u64) -> Result<(), ReadError> {
        if self.records.len() >= self.options.max_fixes {
            return Err(ReadError::Limit {
                line: record.line,
                what: "positions",
                limit: self.options.max_fixes,
            });
        }
        let count = self.records.len() + 1;
        in_proportion(count, size_of::<Record>(), record.line, read_bytes)?;
        self.report.records += 1;
        self.records.push(record);
        Ok(())
    }

    /// Records with a position so far.
    pub fn positions(&self) -> usize {
        self.records.len()
    }

    /// Gives the records other instants, in their order.
    pub fn restamp(&mut self, times: impl Iterator<Item = GpsTime>) {
        for (record, time) in self.records.iter_mut().zip(times) {
            record.stamp = Stamp::Gps(time);
        }
    }

    /// Counts a record without a usable position.
    pub fn skip(&mut self, reason: SkipReason, line: u64) {
        self.report.records += 1;
        self.report.skip(reason, line);
    }

    /// The trajectory. `clock` is the meaning of second zero where stamps are plain seconds.
    pub fn finish(
        mut self,
        axes: &Axes,
        clock: TimeOrigin,
        lines: u64,
    ) -> Result<(Trajectory, ReadReport), ReadError> {
        self.report.lines = lines;
        self.report.is_local = matches!(axes, Axes::Local(_));
        if self.records.is_empty() {
            let why = match self.report.skipped.first() {
                Some(s) => {
                    format!(
                        ": {} records, all skipped, first {} on line {}",
                        self.report.records, s.reason, s.first_line
                    )
                }
                None => String::new(),
            };
            return Err(ReadError::NoPositions {
                format: self.report.format,
                why,
            });
        }
        self.order_by_time()?;
        let rounding_m2 = self.rounding_m2();

        let (origin, frame) = match (axes, self.options.origin) {
            (Axes::Ecef { .. }, Some(origin)) => (None, Frame::Enu(EnuFrame::new(origin))),
            (
                Axes::Ecef {
                    reference_m: Some(m),
                },
                None,
            ) => (None, Frame::Enu(EnuFrame::from_ecef(*m))),
            (Axes::Ecef { reference_m: None }, None) => {
                let first = self.records.iter().find(|r| r.fix.status.is_fixed());
                let first = first.unwrap_or(&self.records[0]);
                (None, Frame::Enu(EnuFrame::from_ecef(first.fix.position_m)))
            }
            (Axes::Local(Frame::Local), Some(origin)) => (None, Frame::Enu(EnuFrame::new(origin))),
            (Axes::Local(frame), origin) => (origin, *frame),
        };
        let (time_origin, week_start) = match self.records[0].stamp {
            Stamp::Gps(t) => {
                let start = GpsTime::from_week_tow(t.week(), 0.0);
                (TimeOrigin::Gps(start), start)
            }
            Stamp::Seconds(_) => (clock, GpsTime::EPOCH),
        };
        let from_ecef = matches!(axes, Axes::Ecef { .. });
        let fixes = self
            .records
            .into_iter()
            .map(|Record { stamp, mut fix, .. }| {
                fix.time_s = match stamp {
                    Stamp::Gps(t) => t - week_start,
                    Stamp::Seconds(s) => s,
                };
                if let (true, Frame::Enu(enu)) = (from_ecef, &frame) {
                    fix.position_m = enu.enu_from_ecef(fix.position_m);
                    fix.velocity_m_s = fix.velocity_m_s.map(|v| enu.enu_vector_from_ecef(v));
                    fix.covariance_m2 = fix.covariance_m2.map(|c| enu.enu_covariance_from_ecef(&c));
                }
                fix.covariance_m2 = rounded(fix.covariance_m2, rounding_m2);
                fix
            })
            .collect();
        let mut trajectory = Trajectory::new(frame, time_origin, fixes)?;
        if let Some(origin) = origin {
            trajectory = trajectory.in_frame(EnuFrame::new(origin))?;
        }
        Ok((trajectory, self.report))
    }

    /// Variances of rounding to the last digit (m²), given where it is coarse.
    fn rounding_m2(&mut self) -> Vector3 {
        let step_m = self.report.resolution_m.unwrap_or_default();
        if step_m.iter().any(|s| *s > COARSE_M) {
            self.report.warnings.push(ReadWarning::Coarse { step_m });
        }
        step_m.map(|s| s * s / 12.0)
    }

    /// Turns a backward file round, then drops the fewest records that leave time strictly
    /// increasing, so that one wild time tag costs itself and not all that follow it.
    fn order_by_time(&mut self) -> Result<(), ReadError> {
        let mut rising = 0usize;
        let mut falling = 0usize;
        for pair in self.records.windows(2) {
            match pair[1].stamp.order(&pair[0].stamp) {
                std::cmp::Ordering::Greater => rising += 1,
                std::cmp::Ordering::Less => falling += 1,
                std::cmp::Ordering::Equal => {}
            }
        }
        if falling > rising {
            self.records.reverse();
            self.report.reversed = true;
            std::mem::swap(&mut rising, &mut falling);
        }
        if rising + 1 == self.records.len() {
            return Ok(());
        }
        let keep = longest_rising(&self.records);
        let total = self.records.len() as u64;
        let kept = keep.iter().filter(|&&k| k).count() as u64;
        let mut first_bad = u64::MAX;
        for (record, _) in self.records.iter().zip(&keep).filter(|(_, keep)| !**keep) {
            self.report.skip(SkipReason::TimeNotAdvancing, record.line);
            first_bad = first_bad.min(record.line);
        }
        if 2 * kept < total {
            return Err(ReadError::MostlyBad {
                bad: total - kept,
                total,
                line: first_bad,
                reason: "their times do not advance".to_owned(),
            });
        }
        let mut keep = keep.into_iter();
        self.records.retain(|_| keep.next().unwrap_or(false));
        Ok(())
    }
}

/// Which records belong to the longest strictly rising run of times, skipping others.
fn longest_rising(records: &[Record]) -> Vec<bool> {
    // tails[k]: the record that ends a rising choice of k + 1 records at the earliest time.
    let mut tails: Vec<usize> = Vec::new();
    let mut before: Vec<Option<usize>> = vec![None; records.len()];
    for (i, record) in records.iter().enumerate() {
        let k = tails.partition_point(|&t| records[t].stamp.order(&record.stamp).is_lt());
        before[i] = k.checked_sub(1).map(|k| tails[k]);
        if k == tails.len() {
            tails.push(i);
        } else if records[tails[k]].stamp.order(&record.stamp).is_gt() {
            // Of equal times the first stays.
            tails[k] = i;
        }
    }
    let mut keep = vec![false; records.len()];
    let mut at = tails.last().copied();
    while let Some(i) = at {
        keep[i] = true;
        at = before[i];
    }
    keep
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::TrajectoryFormat;

    fn assembled(times: &[f64]) -> Result<(Trajectory, ReadReport), ReadError> {
        let options = ReadOptions::default();
        let mut a = Assembler::new(&options, ReadReport::new(TrajectoryFormat::Csv));
        for (i, &t) in times.iter().enumerate() {
            let fix = Fix::new(0.0, [i as f64, 0.0, 0.0]);
            let record = Record {
                line: i as u64 + 2,
                stamp: Stamp::Seconds(t),
                fix,
            };
            a.push(record, 0)?;
        }
        a.finish(
            &Axes::Local(Frame::Local),
            TimeOrigin::Relative,
            times.len() as u64 + 1,
        )
    }

    #[test]
    fn one_wild_tag_costs_only_itself() -> Result<(), ReadError> {
        let (track, report) = assembled(&[0.0, 1.0, 900.0, 2.0, 3.0, 3.0, 4.0])?;
        let times: Vec<f64> = track.fixes().iter().map(|f| f.time_s).collect();
        assert_eq!(times, [0.0, 1.0, 2.0, 3.0, 4.0]);
        assert_eq!(report.skipped_for(SkipReason::TimeNotAdvancing), 2);
        assert_eq!(report.skipped[0].first_line, 4);
        // Of the two at 3 s the first stays.
        assert_eq!(track.fixes()[3].position_m[0], 4.0);
        Ok(())
    }

    #[test]
    fn a_backward_pass_is_turned_round() -> Result<(), ReadError> {
        let (track, report) = assembled(&[4.0, 3.0, 2.0, 1.0])?;
        assert!(report.reversed && report.skipped.is_empty());
        assert_eq!(track.fixes()[0].position_m[0], 3.0);
        Ok(())
    }

    /// Rows of eight bytes would take forty times the text.
    #[test]
    fn positions_are_in_proportion_to_the_text() {
        let mut text = String::from("t,x,y,z\n");
        for k in 0..400_000 {
            text.push_str(&format!("{},1,1,1\n", k % 10));
        }
        let read = |text: &str| {
            crate::read::read_trajectory(text.as_bytes(), &ReadOptions::default()).expect_err("bad")
        };
        assert!(
            matches!(
                read(&text),
                ReadError::Limit {
                    limit: 200_000..400_000,
                    ..
                }
            ),
            "{}",
            read(&text)
        );
        // Rows as loggers write them are refused for their times alone.
        let text = text.replace(",1,1,1", ".000,1.000,1.000,1.000");
        assert!(
            matches!(read(&text), ReadError::MostlyBad { .. }),
            "{}",
            read(&text)
        );
    }

    #[test]
    fn times_that_stand_still_are_an_error() {
        let error = assembled(&[1.0; 9]).expect_err("no advance");
        assert!(
            matches!(
                error,
                ReadError::MostlyBad {
                    bad: 8,
                    total: 9,
                    line: 3,
                    ..
                }
            ),
            "{error}"
        );
    }
}
