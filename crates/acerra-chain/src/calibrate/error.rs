//! Reasons why a log cannot be calibrated.

use crate::align::clock::ClockError;
use crate::clean::CleanError;
use crate::control::Cancelled;

/// Reason why a log cannot be calibrated.
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
        /// Cause.
        cause: ClockError,
    },
    /// The traces cannot be cleaned.
    #[error("track {track}: {cause}")]
    Clean {
        /// Name of the track.
        track: String,
        /// Cause.
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
    /// Nothing is in focus at the reflectors.
    #[error(
        "no echo follows the reflectors: of all delays within {delay_ns:?} ns and offsets within {offset_s:?} s \
         the best focus is {contrast_db:.1} dB above the median, at least {needed_db:.1} dB are \
         needed; check the places of the reflectors and [trajectory] time_offset_s"
    )]
    NoEcho {
        /// Delays tried (ns).
        delay_ns: [f64; 2],
        /// Least and greatest clock offset tried (s).
        offset_s: [f64; 2],
        /// Level of the best above the median of all (dB).
        contrast_db: f64,
        /// Level needed (dB).
        needed_db: f64,
    },
    /// Several delays or offsets focus the reflectors equally well.
    #[error(
        "{} solutions remain, each of which explains the echoes:{}\nstate [radar] delay_ns or [trajectory] \
         time_offset_s, or add a reflector",
        solutions.len(),
        solutions.iter().map(ToString::to_string).collect::<String>()
    )]
    Ambiguous {
        /// The solutions, best first.
        solutions: Vec<Solution>,
    },
    /// The reflectors are in focus, as well or better, at a delay at which range zero cannot be.
    #[error(
        "the reflectors are in focus as well or better where range zero cannot be: the direct coupling and the \
         radio's time zero allow delays from {:.2} to {:.2} ns:{}\nanother echo is as strong as the reflectors'; \
         check the places of the reflectors and [trajectory] time_offset_s, or add a reflector",
        possible_ns[0],
        possible_ns[1],
        solutions.iter().map(ToString::to_string).collect::<String>()
    )]
    Impossible {
        /// The solutions, best first; those at possible delays as well.
        solutions: Vec<Solution>,
        /// First and last possible delay (ns).
        possible_ns: [f64; 2],
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
        /// Last change of an unknown over its standard deviation.
        step: f64,
    },
    /// Traces at rest that show no echo at the range stated.
    #[error(
        "no clear echo at {range_m} m: the strongest is {contrast_db:.1} dB above the median of the trace, \
         at least {needed_db:.1} dB are needed"
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

/// A setting, one of several that explain the echoes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution {
    /// Fast time at which range is zero (ns).
    pub delay_ns: f64,
    /// Clock offset (s).
    pub offset_s: f64,
    /// Level of this solution below the best (dB).
    pub below_db: f64,
}

impl std::fmt::Display for Solution {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "\n  delay {:.2} ns with the offset {:.3} s, {:.1} dB below the best",
            self.delay_ns, self.offset_s, self.below_db
        )
    }
}
