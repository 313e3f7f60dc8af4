//! Reasons why something cannot be put on a map.

use std::io;

use crate::crs::CrsError;

/// Reason why something cannot be put on a map.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MapError {
    /// A system that is unknown, cannot be used or does not cover the place.
    #[error(transparent)]
    Crs(#[from] CrsError),
    /// Pixels that a straight grid cannot place well enough.
    #[error(
        "EPSG:{code}: pixels of {pixel_m} m would be up to {residual_m:.3} m off their places; \
         expected a smaller image, coarser pixels, or a system with less distortion (UTM)"
    )]
    NotStraight {
        /// The code.
        code: u32,
        /// Side of a pixel (m).
        pixel_m: f64,
        /// Largest distance of a pixel from its place (m).
        residual_m: f64,
    },
    /// More or fewer values than pixels.
    #[error("expected {expected} pixels, found {found}")]
    Pixels {
        /// Columns times rows.
        expected: usize,
        /// Values.
        found: usize,
    },
    /// The file cannot be written.
    #[error(transparent)]
    Io(#[from] io::Error),
}
