//! Reasons why traces cannot be cleaned.

use acerra_radar::RadargramError;
use acerra_radar::clean::CleanError as Refused;

/// Reason why traces cannot be cleaned.
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
    /// The direct wave is requested for antennas that are not known to be apart.
    #[error(
        "[preprocess] zero_timing = \"direct-wave\": expected transmitter and receiver apart ([radar] \
         antenna_offset_m, ANTENNA SEPARATION in the file's header of a line), found one place for both; state [radar] delay_ns"
    )]
    OneAntenna,
    /// The record shows no direct wave.
    #[error(
        "[preprocess] zero_timing = \"direct-wave\": expected the direct wave within the record, found none from \
         {:.2} ns on; state [radar] delay_ns", 1e9 * start_s
    )]
    NoDirectWave {
        /// Fast time at which the record begins (s).
        start_s: f64,
    },
    /// The running mean cannot be had.
    #[error("[preprocess] dewow_ns: {0}")]
    Dewow(Refused),
    /// The band cannot be had.
    #[error("[preprocess] band_pass_ghz: {0}")]
    BandPass(Refused),
    /// The background cannot be removed.
    #[error("[preprocess] background: {0}")]
    Background(Refused),
    /// A trace is below the ground, where the gate has no meaning.
    #[error(
        "[preprocess] gate_ns: trace {trace} is {depth_m:.3} m below the ground, where 2h/c has no meaning; \
         expected [image] z_m or terrain below the flight, or gate_ns = \"none\""
    )]
    BelowGround {
        /// Number of the trace in the log.
        trace: usize,
        /// Depth of the trace below the ground (m).
        depth_m: f64,
    },
    /// The gate cannot be applied.
    #[error("[preprocess] gate_ns: {0}")]
    Gate(Refused),
    /// The spectra cannot be had at these frequencies.
    #[error("[image] band_ghz: {0}")]
    Band(Refused),
}
