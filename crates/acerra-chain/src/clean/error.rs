//! Why traces cannot be cleaned.

use acerra_radar::RadargramError;
use acerra_radar::clean::CleanError as Refused;

/// Why traces cannot be cleaned.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CleanError {
    /// A trace number beyond the log.
    #[error(transparent)]
    Traces(#[from] RadargramError),
    /// Zero-timing fails.
    #[error(
        "[preprocess] zero_timing (state [radar] delay_ns, or zero_timing = \"none\", where the \
         surface echo cannot be seen): {0}"
    )]
    ZeroTiming(Refused),
    /// The background cannot be removed.
    #[error("[preprocess] background: {0}")]
    Background(Refused),
    /// A trace stands below the ground, where the gate has no meaning.
    #[error(
        "[preprocess] gate_ns: trace {trace} stands {depth_m:.3} m below the ground, where 2h/c has \
         no meaning; expected [image] z_m or terrain below the flight, or gate_ns = \"none\""
    )]
    BelowGround {
        /// Number of the trace in the log.
        trace: usize,
        /// How far below (m).
        depth_m: f64,
    },
    /// The gate cannot be applied.
    #[error("[preprocess] gate_ns: {0}")]
    Gate(Refused),
    /// The spectra cannot be had at these frequencies.
    #[error("[image] band_ghz: {0}")]
    Band(Refused),
}
