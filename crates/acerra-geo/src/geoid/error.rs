//! Reasons why a geoid grid cannot be read.

use std::io;
use std::path::PathBuf;

use super::binary::DAC_BYTES;
use crate::terrain::TerrainError;

/// Reason why a geoid grid cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GeoidError {
    /// Error of a named file.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Defect found.
        source: Box<GeoidError>,
    },
    /// The file cannot be read.
    #[error("cannot read: {0}")]
    Io(#[from] io::Error),
    /// The content is none of the known formats.
    #[error(
        "expected a geoid grid: NGA WW15MGH.DAC ({DAC_BYTES} bytes) or .GRD, NOAA .gtx, \
         GeographicLib .pgm, or a GeoTIFF; found {bytes} bytes of something else"
    )]
    Unknown {
        /// Size of the file.
        bytes: usize,
    },
    /// The header contradicts the file.
    #[error("{format} geoid grid: expected {expected}, found {found}")]
    Format {
        /// The format.
        format: &'static str,
        /// Text expected.
        expected: String,
        /// Text found.
        found: String,
    },
    /// The raster in a GeoTIFF cannot be read.
    #[error("GeoTIFF geoid grid: {0}")]
    GeoTiff(#[from] TerrainError),
    /// Larger than any known grid.
    #[error("the file exceeds the limit of {limit} bytes")]
    Limit {
        /// The limit.
        limit: u64,
    },
}
