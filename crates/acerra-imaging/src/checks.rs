//! Checks of arguments that several operations share.

use crate::error::ImagingError;

/// Refuses an array of another length than `expected`.
pub(crate) fn check_length(
    what: &'static str,
    expected: usize,
    found: usize,
) -> Result<(), ImagingError> {
    if expected == found {
        Ok(())
    } else {
        Err(ImagingError::Length {
            what,
            expected,
            found,
        })
    }
}

/// Refuses values of which one is NaN or infinite.
pub(crate) fn check_finite(
    what: &'static str,
    mut values: impl Iterator<Item = f64>,
) -> Result<(), ImagingError> {
    match values.position(|v| !v.is_finite()) {
        Some(index) => Err(ImagingError::NotFinite { what, index }),
        None => Ok(()),
    }
}

/// Refuses a value that is not a finite number above zero; `expected` says so with its unit.
pub(crate) fn check_positive(
    what: &'static str,
    expected: &'static str,
    found: f64,
) -> Result<(), ImagingError> {
    if found.is_finite() && found > 0.0 {
        Ok(())
    } else {
        Err(ImagingError::OutOfRange {
            what,
            expected,
            found,
        })
    }
}
