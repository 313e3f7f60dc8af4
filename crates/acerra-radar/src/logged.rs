//! The clock of a recording: radar time on GPS time, in a file next to the radar log.

use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::runs::LogRadargram;

/// Longest file read.
const MAX_BYTES: u64 = 1 << 16;

/// Last GPS week of a recording: the year 2171.
const LAST_WEEK: i64 = 9999;

/// Radar time on GPS time: what `time_offset_s = "logged"` reads.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct LoggedClock {
    /// Version of the file format.
    pub version: u32,
    /// The radio's number of the first trace.
    pub first_message_id: u16,
    /// The radio's stamp of the first trace (ms).
    pub first_timestamp_ms: u32,
    /// GPS week of the first trace.
    pub gps_week: i64,
    /// Seconds of that week at the first trace: trajectory time less radar time.
    pub time_offset_s: f64,
    /// Seconds of GPS time in a second of the radio's clock.
    pub rate: f64,
    /// Standard deviation of a trace's time in the middle of the recording (s), by the stamps alone.
    pub sigma_stamps_s: f64,
    /// Standard deviation with the uncertainty of the latencies (s).
    pub sigma_s: f64,
    /// Median delay of the radio's messages beyond the shortest (s).
    pub radio_jitter_s: f64,
    /// Median delay of the receiver's epochs beyond the shortest (s).
    pub gnss_jitter_s: f64,
    /// Latency of the radio that was subtracted (s).
    pub radio_latency_s: f64,
    /// Latency of the receiver (s): as stated, or as measured by the pulses.
    pub gnss_latency_s: f64,
    /// Number of hardware time marks used; 0 where the clock is by times of arrival alone.
    #[serde(default)]
    pub marks: usize,
    /// Number of pulses per second of the receiver used; 0 where GPS time comes from the receiver's messages
    /// alone.
    #[serde(default)]
    pub pulses: usize,
}

/// Reason why a clock is unusable.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LoggedClockError {
    /// The file cannot be read.
    #[error("{}: {cause}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        cause: io::Error,
    },
    /// The file is no clock.
    #[error("{}: expected the clock of a recording, version {}; {cause}", path.display(), LoggedClock::VERSION)]
    Content {
        /// The file.
        path: PathBuf,
        /// Fault.
        cause: String,
    },
    /// The clock is of another log, or of another part of the log.
    #[error(
        "{}: the clock belongs to a recording that begins with scan {expected:?} (number, ms); the radar \
         log's traces begin with {found:?}",
        path.display()
    )]
    OtherLog {
        /// The file.
        path: PathBuf,
        /// Number and stamp of the clock's first trace.
        expected: (u16, u32),
        /// Number and stamp of the log's first trace.
        found: (u16, u32),
    },
}

impl LoggedClock {
    /// Version of the file format.
    pub const VERSION: u32 = 1;

    /// Path of the clock of a radar log: `flight.clock.json` next to `flight.mrm`.
    ///
    /// ```
    /// use acerra_radar::LoggedClock;
    /// use std::path::Path;
    /// let path = LoggedClock::path_beside(Path::new("session/radar.mrm"));
    /// assert_eq!(path, Path::new("session/radar.clock.json"));
    /// ```
    #[must_use]
    pub fn path_beside(log: &Path) -> PathBuf {
        log.with_extension("clock.json")
    }

    /// The clock as written in its file.
    #[must_use]
    pub fn to_json(&self) -> String {
        // Numbers and strings alone, which JSON can hold; a number that is not finite is written as null and
        // refused when read.
        let text = serde_json::to_string_pretty(self).unwrap_or_default();
        format!("{text}\n")
    }

    /// Reads the clock next to a radar log; `None` without one.
    ///
    /// # Errors
    /// A file that cannot be read, or that holds no clock.
    pub fn next_to(log: &Path) -> Result<Option<Self>, LoggedClockError> {
        let path = Self::path_beside(log);
        let failed = |cause| LoggedClockError::Io {
            path: path.clone(),
            cause,
        };
        let content = |cause: String| LoggedClockError::Content {
            path: path.clone(),
            cause,
        };
        match std::fs::metadata(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(cause) => return Err(failed(cause)),
            Ok(found) if found.len() > MAX_BYTES => {
                return Err(content(format!("found {} bytes", found.len())));
            }
            Ok(_) => {}
        }
        let text = std::fs::read_to_string(&path).map_err(failed)?;
        let clock = Self::parse(&text).map_err(content)?;
        Ok(Some(clock))
    }

    /// Reads a clock from the text of its file.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn parse(text: &str) -> Result<Self, String> {
        let clock: Self = serde_json::from_str(text).map_err(|e| format!("found: {e}"))?;
        if clock.version != Self::VERSION {
            return Err(format!("found version {}", clock.version));
        }
        let is_sound = (0.99..=1.01).contains(&clock.rate)
            && (0..=LAST_WEEK).contains(&clock.gps_week)
            && (0.0..604_800.0).contains(&clock.time_offset_s)
            && clock.sigma_s >= 0.0
            && clock.sigma_s.is_finite();
        if !is_sound {
            return Err("found an impossible rate, week, offset or deviation".to_owned());
        }
        Ok(clock)
    }

    /// Whether the clock belongs to these traces.
    ///
    /// # Errors
    /// [`LoggedClockError::OtherLog`] where the clock belongs to other traces; `log` names the radar log.
    pub fn check_traces(
        &self,
        log: &Path,
        first_message_id: u16,
        first_timestamp_ms: u32,
    ) -> Result<(), LoggedClockError> {
        let expected = (self.first_message_id, self.first_timestamp_ms);
        let found = (first_message_id, first_timestamp_ms);
        if expected == found {
            return Ok(());
        }
        Err(LoggedClockError::OtherLog {
            path: Self::path_beside(log),
            expected,
            found,
        })
    }

    /// Converts the times of a radargram from seconds of the radio's clock to seconds of GPS time.
    pub fn scale(&self, made: &mut LogRadargram) {
        for time_s in &mut made.radargram.time_s {
            *time_s *= self.rate;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_is_read_as_it_was_written_and_others_are_refused() {
        let clock = LoggedClock {
            version: 1,
            first_message_id: 3,
            first_timestamp_ms: 60_000,
            gps_week: 2345,
            time_offset_s: 1234.5,
            rate: 0.999_98,
            sigma_stamps_s: 1e-5,
            sigma_s: 0.02,
            radio_jitter_s: 1e-4,
            gnss_jitter_s: 1e-3,
            radio_latency_s: 0.0,
            gnss_latency_s: 0.05,
            marks: 0,
            pulses: 0,
        };
        let folder = tempfile::tempdir().unwrap();
        let log = folder.path().join("radar.mrm");
        assert!(LoggedClock::next_to(&log).unwrap().is_none());
        let path = LoggedClock::path_beside(&log);
        std::fs::write(&path, clock.to_json()).unwrap();
        assert_eq!(LoggedClock::next_to(&log).unwrap(), Some(clock.clone()));
        assert!(clock.check_traces(&log, 3, 60_000).is_ok());
        let other = clock.check_traces(&log, 4, 60_010).unwrap_err().to_string();
        assert!(other.contains("begins with scan (3, 60000)"), "{other}");
        for (text, why) in [
            ("{}".to_owned(), "missing field"),
            (
                clock.to_json().replace("0.99998", "1.99998"),
                "found an impossible",
            ),
            (
                clock.to_json().replace("\"version\": 1", "\"version\": 2"),
                "version 2",
            ),
            (clock.to_json().replace("0.02", "null"), "invalid type"),
        ] {
            std::fs::write(&path, text).unwrap();
            let error = LoggedClock::next_to(&log).unwrap_err().to_string();
            assert!(error.contains(why), "{error}");
        }
    }
}
