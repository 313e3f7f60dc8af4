//! Epoch lines of observation files.

use super::fields::{calendar, column, integer, real};
use acerra_geo::time::Calendar;

/// Content of an epoch line.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct EpochLine {
    pub flag: u8,
    pub count: usize,
    /// The time tag, where there is one (events of flag 2–5 may go without).
    pub time: Option<Calendar>,
    /// Receiver clock offset applied or not, as given (s).
    pub receiver_clock_s: Option<f64>,
}

impl EpochLine {
    /// Reads an epoch line of version 3 or 4; `None` for any other line.
    pub(super) fn parse_v3(line: &[u8]) -> Option<Self> {
        if line.first() != Some(&b'>') {
            return None;
        }
        Self::parse(line, 1..29, 31, 41, 15)
    }

    /// Reads an epoch line of version 2; `None` for any other line.
    pub(super) fn parse_v2(line: &[u8]) -> Option<Self> {
        Self::parse(line, 0..26, 28, 68, 12)
    }

    fn parse(
        line: &[u8],
        time: std::ops::Range<usize>,
        flag_at: usize,
        clock_at: usize,
        clock_width: usize,
    ) -> Option<Self> {
        let flag = match column(line, flag_at, 1) {
            b" " | b"" => 0,
            &[digit @ b'0'..=b'6'] => digit - b'0',
            _ => return None,
        };
        let count_field = column(line, flag_at + 1, 3);
        let count = match (integer(count_field), flag) {
            (Some(count), _) => count,
            (None, 2..=5) if count_field.trim_ascii().is_empty() => 0,
            _ => return None,
        };
        let time = calendar(column(line, time.start, time.len()));
        if time.is_none() && !matches!(flag, 2..=5) {
            return None;
        }
        let receiver_clock_s = real(column(line, clock_at, clock_width)).ok().flatten();
        Some(Self {
            flag,
            count,
            time,
            receiver_clock_s,
        })
    }

    /// Whether a line inside a version 2 record is really the next epoch line: the seconds'
    /// decimal point is where no value has one, and the rest reads as an epoch.
    pub(super) fn interrupts_v2(line: &[u8]) -> bool {
        column(line, 18, 1) == b"."
            && column(line, 10, 1) != b"."
            && column(line, 0, 1) == b" "
            && Self::parse_v2(line).is_some_and(|e| e.time.is_some())
    }
}
