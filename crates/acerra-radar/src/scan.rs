//! One scan of the radio, exactly as recorded.

use std::fmt;

use crate::constants::FAST_TIME_BIN_S;

/// Filtering of a scan by the radio before sending.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Filtering {
    /// Raw samples (code 1).
    Raw,
    /// Band-passed along fast time (code 2).
    BandPass,
    /// Motion filter between scans (code 4).
    Motion,
    /// Any other code.
    Other(u8),
}

impl Filtering {
    /// From the code of SCAN_INFO's `filtering` field.
    #[must_use]
    pub fn from_code(code: u8) -> Self {
        match code {
            1 => Self::Raw,
            2 => Self::BandPass,
            4 => Self::Motion,
            other => Self::Other(other),
        }
    }

    /// The code of SCAN_INFO's `filtering` field.
    #[must_use]
    pub fn code(self) -> u8 {
        match self {
            Self::Raw => 1,
            Self::BandPass => 2,
            Self::Motion => 4,
            Self::Other(code) => code,
        }
    }
}

impl fmt::Display for Filtering {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Raw => f.write_str("raw"),
            Self::BandPass => f.write_str("band-passed"),
            Self::Motion => f.write_str("motion-filtered"),
            Self::Other(code) => write!(f, "filtering {code}"),
        }
    }
}

/// The fast-time window of a scan, in the radio's own integers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ScanWindow {
    /// Fast time of the first sample, ps.
    pub start_ps: i32,
    /// End of the window as the radio states it, ps.
    pub stop_ps: i32,
    /// Spacing of samples, in bins of [`FAST_TIME_BIN_S`].
    pub step_bins: u16,
    /// Number of samples.
    pub samples: usize,
}

impl ScanWindow {
    /// Fast time of the first sample, s.
    #[must_use]
    pub fn start_s(&self) -> f64 {
        f64::from(self.start_ps) * 1e-12
    }

    /// Spacing of samples, s.
    #[must_use]
    pub fn step_s(&self) -> f64 {
        f64::from(self.step_bins) * FAST_TIME_BIN_S
    }
}

impl fmt::Display for ScanWindow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} samples over {}–{} ps, step {} bins",
            self.samples, self.start_ps, self.stop_ps, self.step_bins
        )
    }
}

/// One whole scan: every sample the radio declared, exact to the integer.
#[derive(Debug, Clone, PartialEq)]
pub struct Scan {
    /// Identity of the radio.
    pub source_id: u32,
    /// The radio's running number of the scan (wraps at 65 536).
    pub message_id: u16,
    /// Radio clock at the end of the scan, whole milliseconds since boot (wraps at 2³²).
    pub timestamp_ms: u32,
    /// Clock of the logging computer, s, where the log keeps it.
    pub host_time_s: Option<f64>,
    /// Fast-time window.
    pub window: ScanWindow,
    /// Filtering by the radio.
    pub filtering: Filtering,
    /// Antenna the scan was received on, as the radio codes it.
    pub antenna_id: u8,
    /// Operation mode (1 = MRM).
    pub operation_mode: u8,
    /// The samples, `window.samples` of them.
    pub samples: Vec<i32>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn p440_step_is_16_384_ghz() {
        let window = ScanWindow {
            start_ps: 16_670,
            stop_ps: 86_982,
            step_bins: 32,
            samples: 1152,
        };
        assert!((1.0 / window.step_s() / 16.384e9 - 1.0).abs() < 1e-14);
        assert!((window.step_s() - 61.035_156_25e-12).abs() < 1e-24);
        assert!((window.start_s() - 16.67e-9).abs() < 1e-22);
    }

    #[test]
    fn filtering_codes_round_trip() {
        for code in 0..=255 {
            assert_eq!(Filtering::from_code(code).code(), code);
        }
    }
}
