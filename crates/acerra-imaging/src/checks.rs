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

/// Refuses an array that contains NaN or an infinite value.
pub(crate) fn check_finite(
    what: &'static str,
    mut values: impl Iterator<Item = f64>,
) -> Result<(), ImagingError> {
    match values.position(|v| !v.is_finite()) {
        Some(index) => Err(ImagingError::NotFinite { what, index }),
        None => Ok(()),
    }
}

/// Farthest place (m) from the origin of the frame: fifteen times the Earth's radius. Double precision
/// resolves 15 nm at this distance, and bin numbers of range tables fit into 64-bit integers.
const FARTHEST_M: f64 = 1e8;

/// Smallest pixel (m): below a thousandth of any radar's wavelength.
const SMALLEST_PIXEL_M: f64 = 1e-6;

/// Refuses a place with a coordinate that is not a number or is beyond [`FARTHEST_M`].
pub(crate) fn check_places<'a>(
    what: &'static str,
    places: impl IntoIterator<Item = &'a [f64; 3]>,
) -> Result<(), ImagingError> {
    for (index, place) in places.into_iter().enumerate() {
        if !place.iter().all(|v| v.is_finite()) {
            return Err(ImagingError::NotFinite { what, index });
        }
        if let Some(&found) = place.iter().find(|v| v.abs() > FARTHEST_M) {
            return Err(ImagingError::OutOfRange {
                what,
                expected: "within 1e8 m of the frame's origin",
                found,
            });
        }
    }
    Ok(())
}

/// Refuses the side of a pixel, or the step of slices, that is not positive, below [`SMALLEST_PIXEL_M`] or
/// beyond [`FARTHEST_M`].
pub(crate) fn check_pixel(what: &'static str, found: f64) -> Result<(), ImagingError> {
    check_positive(what, "above 0 m", found)?;
    if (SMALLEST_PIXEL_M..=FARTHEST_M).contains(&found) {
        return Ok(());
    }
    Err(ImagingError::OutOfRange {
        what,
        expected: "1e-6 m to 1e8 m",
        found,
    })
}

/// Refuses a value that is not a finite number above zero; `expected` is the wording of the error, with the
/// unit.
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
