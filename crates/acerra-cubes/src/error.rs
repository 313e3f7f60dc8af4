//! Reasons why arrays cannot be written or read.

use std::io;
use std::path::PathBuf;

/// Reason why arrays cannot be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CubeError {
    /// A name that not every program can open.
    #[error("{name:?}: expected a name of letters, digits and _ that begins with a letter")]
    Name {
        /// The name.
        name: String,
    },
    /// Two variables or dimensions with one name.
    #[error("{name}: expected different names, found this one twice")]
    SameName {
        /// The name.
        name: String,
    },
    /// A dimension that is not declared.
    #[error("{variable}: expected declared dimensions, found {dimension:?}")]
    Dimension {
        /// The variable.
        variable: String,
        /// The dimension.
        dimension: String,
    },
    /// A variable with more or fewer values than its dimensions hold.
    #[error("{variable}: expected {expected} values, found {found}")]
    Length {
        /// The variable.
        variable: String,
        /// Product of its dimensions.
        expected: usize,
        /// Values there are.
        found: usize,
    },
    /// An attribute that no header of an HDF5 file holds.
    #[error("{name}: expected an attribute of up to {most} bytes in HDF5, found {found}")]
    Attribute {
        /// The attribute.
        name: String,
        /// Bytes of its name and values that a header holds.
        most: usize,
        /// Bytes there are.
        found: usize,
    },
    /// More or fewer slices than announced.
    #[error("{variable}: expected {expected} slices, found {found}")]
    Slices {
        /// The variable.
        variable: String,
        /// Slices announced.
        expected: usize,
        /// Slices written.
        found: usize,
    },
    /// A tile with more or fewer bytes than its pixels take.
    #[error("{path}: expected {expected} bytes, found {found}")]
    Tile {
        /// The file.
        path: PathBuf,
        /// Bytes of a tile.
        expected: usize,
        /// Bytes there are.
        found: usize,
    },
    /// A file cannot be written or read.
    #[error(transparent)]
    Io(#[from] io::Error),
}
