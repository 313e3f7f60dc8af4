//! Why something cannot be put on a map.

use std::io;

/// Why something cannot be put on a map.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MapError {
    /// A code that the table of coordinate reference systems does not hold.
    #[error("EPSG:{code}: expected a coordinate reference system of the EPSG registry, found none")]
    UnknownCrs {
        /// The code.
        code: u32,
    },
    /// A system that is known but cannot be used.
    #[error(
        "EPSG:{code}: {reason}; expected a system whose datum is related to WGS84, such as UTM"
    )]
    UnusableCrs {
        /// The code.
        code: u32,
        /// Why not.
        reason: String,
    },
    /// A place outside of the area in which a system is defined.
    #[error(
        "EPSG:{code}: {latitude_deg:.6}°, {longitude_deg:.6}° has no coordinates there; expected a \
         system that covers the image"
    )]
    OutsideCrs {
        /// The code.
        code: u32,
        /// Latitude of the place (degrees).
        latitude_deg: f64,
        /// Longitude of the place (degrees).
        longitude_deg: f64,
    },
    /// Pixels that a straight grid cannot place well enough.
    #[error(
        "EPSG:{code}: pixels of {pixel_m} m would stand up to {residual_m:.3} m off their places; \
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
