//! Errors of autofocus.

use acerra_imaging::ImagingError;
use thiserror::Error;

/// Why an autofocus cannot be run on data.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum AutofocusError {
    /// An array has another length than there are pulses.
    #[error("{what}: expected {expected} values, one a pulse, found {found}")]
    Length {
        /// Which array.
        what: &'static str,
        /// Number of pulses.
        expected: usize,
        /// Length found.
        found: usize,
    },
    /// A value that has no meaning.
    #[error("{what}: value {index} is {found}, expected {expected}")]
    OutOfRange {
        /// Which quantity.
        what: &'static str,
        /// Index of the first such value.
        index: usize,
        /// The valid range, in words.
        expected: &'static str,
        /// Value found.
        found: f64,
    },
    /// Pulses that are none of the flight's.
    #[error("pulses {start}..{end}: expected a part of the flight's {pulses} pulses")]
    Pulses {
        /// First pulse.
        start: usize,
        /// First pulse after them.
        end: usize,
        /// Number of pulses of the flight.
        pulses: usize,
    },
    /// Parts of the flight that leave pulses out, or have some twice.
    #[error("coherent parts: expected part {part} to begin at pulse {expected}, found {found}")]
    Parts {
        /// Which part; their number where the last ends too early.
        part: usize,
        /// Where it has to begin, or the last to end.
        expected: usize,
        /// Where it does.
        found: usize,
    },
    /// Frequencies that are not evenly spaced.
    #[error("frequency_hz: expected evenly spaced, rising frequencies")]
    UnevenFrequencies,
    /// Data or pixels that the imaging operators refuse, or cancellation.
    #[error(transparent)]
    Imaging(#[from] ImagingError),
}
