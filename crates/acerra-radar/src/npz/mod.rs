//! The neutral radar file: NPZ, for data of any radar.
//!
//! | array | shape | meaning |
//! | --- | --- | --- |
//! | `data` | `[traces, samples]` | radargram, real or complex, any float or integer type |
//! | `fast_time_s` | `[samples]` | its fast time, evenly spaced |
//! | `spectrum` | `[traces, N]` | instead of `data`: complex spectra, e^{jωt} convention |
//! | `frequency_hz` | `[N]` | its frequencies |
//! | `time_s` | `[traces]` | slow time; may be left out where `position_m` is given |
//! | `position_m` | `[traces, 3]` | optional antenna positions, x east, y north, z up |
//! | `transmitter_m`, `receiver_m` | `[traces, 3]` | optional, both or neither: antennas apart; their middle is the position where none is given |

mod read;
mod write;

pub use read::{FAST_TIME_TOLERANCE, NpzError, read_npz};
pub use write::{NpzWriteError, write_npz};

use crate::{radargram::Radargram, spectrum::Spectrum};

/// Content of a neutral file: a radargram to be cleaned, or spectra ready for the adjoint.
#[derive(Debug, Clone, PartialEq)]
pub enum NeutralContent {
    /// From `data` and `fast_time_s`.
    Radargram(Radargram),
    /// From `spectrum` and `frequency_hz`.
    Spectrum(Spectrum),
}

impl NeutralContent {
    /// Slow time of each trace, s.
    #[must_use]
    pub fn time_s(&self) -> &[f64] {
        match self {
            Self::Radargram(r) => &r.time_s,
            Self::Spectrum(s) => &s.time_s,
        }
    }
}

/// A neutral file as read.
#[derive(Debug, Clone, PartialEq)]
pub struct NeutralFile {
    /// Radargram or spectra.
    pub content: NeutralContent,
    /// Antenna position of each trace (x east, y north, z up), m.
    pub position_m: Option<Vec<[f64; 3]>>,
    /// Transmitter and receiver of each trace where they are apart, m.
    pub antennas_m: Option<[Vec<[f64; 3]>; 2]>,
    /// Whether `time_s` was absent, so that traces are numbered 0, 1, … instead.
    pub time_missing: bool,
    /// Members of the archive that were not used.
    pub ignored: Vec<String>,
}
