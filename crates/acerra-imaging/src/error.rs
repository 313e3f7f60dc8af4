//! Errors of imaging.

use thiserror::Error;

/// Reason for refusing data, a grid or an accuracy.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ImagingError {
    /// An array whose length does not match the other arrays.
    #[error("{what}: expected {expected} values, found {found}")]
    Length {
        /// Name of the array.
        what: &'static str,
        /// Length required by the other arrays.
        expected: usize,
        /// Length found.
        found: usize,
    },
    /// An empty array.
    #[error("{what} is empty")]
    Empty {
        /// Name of the array.
        what: &'static str,
    },
    /// A value is NaN or infinite.
    #[error("{what}: value {index} is not finite")]
    NotFinite {
        /// Name of the array.
        what: &'static str,
        /// Index of the first such value.
        index: usize,
    },
    /// A value outside its valid range.
    #[error("{what} is {found}, expected {expected}")]
    OutOfRange {
        /// Name of the quantity.
        what: &'static str,
        /// The valid range, in words.
        expected: &'static str,
        /// Value found.
        found: f64,
    },
    /// A grid that cannot be held in memory, or not within the limit set.
    #[error("{what} needs {bytes} bytes, more than the limit of {limit_bytes} bytes")]
    TooLarge {
        /// Quantity that would be allocated.
        what: &'static str,
        /// Bytes needed.
        bytes: u128,
        /// Bytes allowed.
        limit_bytes: u128,
    },
    /// An antenna is exactly on an image point, where 1/R² has no value.
    #[error("pulse {pulse} is exactly on image point {point}: 1/R² has no value there")]
    ZeroRange {
        /// Index of the pulse.
        pulse: usize,
        /// Index of the point (row-major in a grid).
        point: usize,
    },
    /// A weight by incidence over tilted or uneven ground.
    #[error("a weight by incidence needs a level image plane, this one is tilted or uneven")]
    NotLevel,
    /// The operation was cancelled through its [`Control`](crate::Control).
    #[error("cancelled")]
    Cancelled,
    /// The processor lacks the requested instructions.
    #[error("this processor has no {level}")]
    NoSuchLevel {
        /// The requested instruction set.
        level: &'static str,
    },
}

impl From<acerra_control::Cancelled> for ImagingError {
    fn from(_: acerra_control::Cancelled) -> Self {
        Self::Cancelled
    }
}
