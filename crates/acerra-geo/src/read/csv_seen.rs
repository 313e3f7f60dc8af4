//! Properties of all rows of a table together: units, rounding, and assumptions that are reported.

use super::assemble::Assembler;
use super::csv_columns::{Columns, Role};
use super::csv_time::zero_of_finer;
use super::digits::{Digits, degrees_in_m};
use super::{HeightDatum, ReadError, ReadWarning};
use crate::matrix::Vector3;
use crate::time::GpsTime;

/// Properties of all rows together.
#[derive(Default)]
pub(super) struct Seen {
    pub(super) header_line: u64,
    /// A column of times whose name has no unit.
    pub(super) time_column: Option<String>,
    /// Times that such a column counts, as long as all are whole.
    pub(super) whole_times: Option<Vec<f64>>,
    /// Dates and times of day with a finer clock in the same row.
    pub(super) pairs: Vec<(GpsTime, f64)>,
    /// Dates without an offset from UTC.
    pub(super) without_zone: u64,
    pub(super) digits: [Digits; 3],
    pub(super) latitude_deg: Option<f64>,
    /// Heights above the sea that were taken as above the ellipsoid.
    pub(super) not_raised: u64,
}

/// Median step of whole numbers from which on the numbers cannot be seconds of a flight's positions.
const STEP_OF_NO_SECONDS: f64 = 5.0;

impl Seen {
    /// Checks properties of all rows, and lists assumptions.
    pub(super) fn assess(
        &mut self,
        columns: Option<&Columns>,
        all: &mut Assembler<'_>,
    ) -> Result<(), ReadError> {
        if let (Some(column), Some(times)) = (&self.time_column, &self.whole_times) {
            let mut steps: Vec<f64> = times.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
            if let Some(middle) = steps.len().checked_sub(1).map(|n| n / 2) {
                let step = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
                if step >= STEP_OF_NO_SECONDS {
                    return Err(ReadError::UnitOpen {
                        line: self.header_line,
                        column: column.clone(),
                        step,
                    });
                }
            }
        }
        if self.pairs.len() == all.positions()
            && let Some((zero, within_s)) = zero_of_finer(&self.pairs)
        {
            all.restamp(self.pairs.iter().map(|(_, fine_s)| zero + *fine_s));
            all.report
                .warnings
                .push(ReadWarning::WholeSeconds { within_s });
        }
        if self.without_zone > 0 {
            all.report.warnings.push(ReadWarning::TakenAsUtc);
        }
        if self.not_raised > 0 {
            all.report.warnings.push(ReadWarning::GeoidHeights);
        }
        let Some(columns) = columns else {
            return Ok(());
        };
        if columns
            .height
            .is_some_and(|(_, d)| d == HeightDatum::TakeOff)
        {
            all.report.warnings.push(ReadWarning::HeightsAboveTakeOff);
        }
        all.report.resolution_m = self.steps_m(columns);
        Ok(())
    }

    /// A time of a column without a unit, as long as all are whole.
    pub(super) fn note_whole(&mut self, time: f64) {
        let times = self.whole_times.get_or_insert_default();
        if time.fract() != 0.0 {
            self.time_column = None;
        } else if self.time_column.is_some() {
            times.push(time);
        }
    }

    /// Steps of the last digit (m); in a local frame a coordinate may be exactly constant.
    fn steps_m(&self, columns: &Columns) -> Option<Vector3> {
        let scale = |role| {
            let column = columns.columns.iter().find(|c| c.role == role);
            column.map_or(1.0, |c| c.scale)
        };
        if let (Some(latitude_deg), Some((height, _))) = (self.latitude_deg, columns.height) {
            // A few rows made by hand do not show rounding.
            let moves = |axis: usize| self.digits[axis].step_of_many().is_some();
            if !moves(0) && !moves(1) {
                return None;
            }
            let [latitude, longitude, up] = self.digits.each_ref().map(Digits::step);
            let [longitude_m, latitude_m] = degrees_in_m(latitude_deg);
            return Some([
                longitude? * scale(Role::Longitude) * longitude_m,
                latitude? * scale(Role::Latitude) * latitude_m,
                up.unwrap_or(0.0) * scale(height),
            ]);
        }
        let steps = self.digits.each_ref().map(Digits::step_of_many);
        if columns.has(Role::Local(0)) {
            let m = [0, 1, 2].map(|i| steps[i].unwrap_or(0.0) * scale(Role::Local(i)));
            return steps.iter().any(Option::is_some).then_some(m);
        }
        let most = (0..3).filter_map(|i| Some(steps[i]? * scale(Role::Ecef(i))));
        most.reduce(f64::max).map(|m| [m; 3])
    }
}
