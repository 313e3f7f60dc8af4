//! Why a log cannot be calibrated.

use crate::align::clock::ClockError;
use crate::clean::CleanError;
use crate::control::Cancelled;

/// Why a log cannot be calibrated.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CalibrateError {
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// No reflector is given.
    #[error("expected the place of at least one reflector")]
    NoReflector,
    /// A log of spectra, whose fast time cannot be calibrated.
    #[error("track {track}: expected a radargram, found spectra")]
    Spectra {
        /// Name of the track.
        track: String,
    },
    /// The traces cannot be placed.
    #[error("track {track}: {cause}")]
    Align {
        /// Name of the track.
        track: String,
        /// Why.
        cause: ClockError,
    },
    /// The traces cannot be cleaned.
    #[error("track {track}: {cause}")]
    Clean {
        /// Name of the track.
        track: String,
        /// Why.
        cause: CleanError,
    },
    /// A band that the samples do not hold.
    #[error(
        "track {track}: [image] band_ghz: expected a band below {limit_ghz:.3} GHz, half the \
         sampling rate, found {found_ghz:?}"
    )]
    Band {
        /// Name of the track.
        track: String,
        /// Half the sampling rate (GHz).
        limit_ghz: f64,
        /// The band (GHz).
        found_ghz: [f64; 2],
    },
    /// Nothing in the traces follows the reflectors.
    #[error(
        "no echo follows the reflectors: the best of all delays from {delay_ns:?} ns and offsets \
         within {offset_s} s stands {contrast:.1} deviations above the others, at least \
         {needed:.1} are needed; check the places of the reflectors and [trajectory] time_offset_s"
    )]
    NoEcho {
        /// Delays tried (ns).
        delay_ns: [f64; 2],
        /// Offsets tried about the campaign's (s).
        offset_s: f64,
        /// Height of the best above the median of all, in deviations.
        contrast: f64,
        /// Height needed.
        needed: f64,
    },
    /// Two delays or offsets explain the traces equally well.
    #[error(
        "two solutions remain: delay {:.2} ns with the offset {:+.3} s from the campaign's, and \
         delay {:.2} ns with {:+.3} s, whose stack reaches {share:.0} % of the best; state \
         [radar] delay_ns, or add a reflector",
        best[0] * 1e9, best[1], second[0] * 1e9, second[1]
    )]
    Ambiguous {
        /// Delay and change of offset of the best (s).
        best: [f64; 2],
        /// The same of the second-best (s).
        second: [f64; 2],
        /// Stack of the second over that of the best (percent).
        share: f64,
    },
    /// Too few echoes were found at the place predicted.
    #[error(
        "expected at least {needed} echoes at the ranges predicted, found {found}: the log does \
         not show the reflectors well enough"
    )]
    TooFewEchoes {
        /// Echoes needed.
        needed: usize,
        /// Echoes found.
        found: usize,
    },
    /// The iteration does not settle.
    #[error(
        "the adjustment does not converge: after {iterations} iterations {parameter} still changes \
         by {step:.2} of its deviation"
    )]
    NotConverged {
        /// Iterations done.
        iterations: usize,
        /// The unknown that changes most.
        parameter: String,
        /// Its last change over its standard deviation.
        step: f64,
    },
    /// Traces at rest that show no echo at the range stated.
    #[error(
        "no echo stands out at {range_m} m: the strongest is {contrast_db:.1} dB above the median \
         of the trace, at least {needed_db:.1} dB are needed"
    )]
    NothingAtRange {
        /// The range (m).
        range_m: f64,
        /// Contrast found (dB).
        contrast_db: f64,
        /// Contrast needed (dB).
        needed_db: f64,
    },
}
