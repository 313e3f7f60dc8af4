//! Reasons for the absence of a live image.

use acerra_imaging::ImagingError;
use acerra_radar::RadargramError;
use acerra_radar::clean::CleanError;
use thiserror::Error;

/// Reasons for the absence of a live image.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LiveError {
    /// A table of `[campaign]` that cannot be.
    #[error("[campaign.{table}]: {cause}")]
    Campaign {
        /// The table.
        table: &'static str,
        /// Fault.
        cause: toml::de::Error,
    },
    /// A band that is none, or no frequencies over it.
    #[error(
        "[campaign.image] band_ghz, frequencies: expected two rising frequencies above 0 and two or more over \
             them; found {band_ghz:?}, {frequencies}"
    )]
    Band {
        /// The band (GHz).
        band_ghz: [f64; 2],
        /// Number of frequencies.
        frequencies: usize,
    },
    /// A zero of range that needs antennas apart.
    #[error(
        "[campaign.preprocess] zero_timing: expected \"first-trace\", \"none\" or {{ shift_ns = NUMBER }} for one antenna, \
         found \"direct-wave\""
    )]
    DirectWave,
    /// Pixels that no image has.
    #[error("[live]: {0}")]
    Grid(ImagingError),
    /// Traces that cannot be cleaned.
    #[error(transparent)]
    Clean(#[from] CleanError),
    /// Samples that make no radargram.
    #[error(transparent)]
    Radargram(#[from] RadargramError),
    /// Pulses that cannot be imaged.
    #[error(transparent)]
    Imaging(#[from] ImagingError),
    /// The log of a session that is replayed.
    #[error("{}: {cause}", path.display())]
    Log {
        /// The log.
        path: std::path::PathBuf,
        /// Fault of the input.
        cause: String,
    },
    /// The system gives no thread.
    #[error("cannot start a thread: {0}")]
    Thread(std::io::Error),
}
