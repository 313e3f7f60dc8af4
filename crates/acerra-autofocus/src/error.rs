//! Errors of autofocus.

use acerra_imaging::ImagingError;
use thiserror::Error;

/// Reason for which an autofocus cannot be run.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum AutofocusError {
    /// An array whose length differs from the number of pulses.
    #[error("{what}: expected {expected} values, one a pulse, found {found}")]
    Length {
        /// Name of the array.
        what: &'static str,
        /// Number of pulses.
        expected: usize,
        /// Length found.
        found: usize,
    },
    /// A value outside its valid range.
    #[error("{what}: value {index} is {found}, expected {expected}")]
    OutOfRange {
        /// Name of the quantity.
        what: &'static str,
        /// Index of the first such value.
        index: usize,
        /// The valid range, in words.
        expected: &'static str,
        /// Value found.
        found: f64,
    },
    /// A range of pulses outside the flight.
    #[error("pulses {start}..{end}: expected a part of the flight's {pulses} pulses")]
    Pulses {
        /// First pulse.
        start: usize,
        /// First pulse after the range.
        end: usize,
        /// Number of pulses of the flight.
        pulses: usize,
    },
    /// Parts of the flight that omit pulses or overlap.
    #[error("coherent parts: expected part {part} to begin at pulse {expected}, found {found}")]
    Parts {
        /// Index of the part; the number of parts where the last one ends too early.
        part: usize,
        /// Pulse at which the part has to begin, or the last part to end.
        expected: usize,
        /// Pulse at which it begins or ends.
        found: usize,
    },
    /// Frequencies that are not evenly spaced.
    #[error("frequency_hz: expected evenly spaced, rising frequencies")]
    UnevenFrequencies,
    /// Data or pixels that the imaging operators refuse, or cancellation.
    #[error(transparent)]
    Imaging(#[from] ImagingError),
}
