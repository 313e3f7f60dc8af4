//! Errors of inversion.

use acerra_imaging::ImagingError;
use thiserror::Error;

/// Reason why a scene cannot be solved for.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum InvertError {
    /// The imaging operators refuse data or pixels, or the caller cancelled.
    #[error(transparent)]
    Imaging(#[from] ImagingError),
    /// An array has another length than the operator asks for.
    #[error("{what}: expected {expected} values, found {found}")]
    Length {
        /// Name of the array.
        what: &'static str,
        /// Length that the operator asks for.
        expected: usize,
        /// Length found.
        found: usize,
    },
    /// A parameter outside its valid range.
    #[error("{what} is {found}, expected {expected}")]
    OutOfRange {
        /// Name of the parameter.
        what: &'static str,
        /// The valid range, in words.
        expected: &'static str,
        /// Value found.
        found: f64,
    },
    /// Data that are zero, or that no pixel explains.
    #[error("the data are zero: every value of {what} is zero")]
    NoSignal {
        /// Name of the array.
        what: &'static str,
    },
    /// Arrays that cannot be held within the limit set.
    #[error("{what} needs {bytes} bytes, more than the limit of {limit_bytes} bytes")]
    TooLarge {
        /// What would be allocated.
        what: &'static str,
        /// Bytes it needs.
        bytes: u128,
        /// Bytes allowed.
        limit_bytes: u128,
    },
    /// Single precision is insufficient for the accuracy requested of a plan.
    #[error(
        "the imaging operator keeps no relative error of {accuracy:.1e} in single precision on these \
         data, expected a geometry that it does"
    )]
    Inaccurate {
        /// Largest relative error that was tried.
        accuracy: f64,
    },
    /// A decomposition of a small matrix that does not converge.
    #[error("the singular values of a bidiagonal matrix of order {order} do not converge")]
    NoConvergence {
        /// Order of the matrix.
        order: usize,
    },
}

impl From<acerra_control::Cancelled> for InvertError {
    fn from(cancelled: acerra_control::Cancelled) -> Self {
        Self::Imaging(cancelled.into())
    }
}

impl InvertError {
    /// Whether the caller cancelled.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        matches!(self, Self::Imaging(ImagingError::Cancelled))
    }
}

pub(crate) fn check_length(
    what: &'static str,
    expected: usize,
    found: usize,
) -> Result<(), InvertError> {
    if expected == found {
        return Ok(());
    }
    Err(InvertError::Length {
        what,
        expected,
        found,
    })
}

pub(crate) fn check_range(
    what: &'static str,
    expected: &'static str,
    found: f64,
    holds: bool,
) -> Result<(), InvertError> {
    if holds && found.is_finite() {
        return Ok(());
    }
    Err(InvertError::OutOfRange {
        what,
        expected,
        found,
    })
}
