//! Reasons why an archive of arrays cannot be read.

use std::io;

use thiserror::Error;

use crate::npy::NpyError;

/// Reason why an archive could not be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum NpzError {
    /// The archive itself is broken.
    #[error("not a readable NPZ archive: {0}")]
    Archive(io::Error),
    /// A part of a compressed array is requested.
    #[error("array `{array}`: expected an uncompressed array, found a compressed one")]
    Compressed {
        /// The array's name.
        array: &'static str,
    },
    /// An array is there but broken.
    #[error("array `{array}`: {source}")]
    Array {
        /// The array's name.
        array: &'static str,
        /// Fault of the input.
        source: NpyError,
    },
}
