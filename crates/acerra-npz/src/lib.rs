//! NumPy arrays and archives (NPY, NPZ): a reader for untrusted streams and a writer with equal files for
//! equal arrays.
//!
//! ```text
//! stream ──NpzReader──► shape, values      arrays ──NpzWriter──► archive that numpy.load reads
//! ```
//!
//! The reader allocates memory only for data that are present, whatever a header claims, and checks every
//! array against the archive's checksum. The writer accepts arrays whole or piece by piece.
//!
//! ```
//! use std::io::Cursor;
//! use acerra_npz::{NpzReader, NpzWriter};
//!
//! let mut npz = NpzWriter::stored(Cursor::new(Vec::new()));
//! npz.array("image", &[2, 2], [1.0_f32, 2.0, 3.0, 4.0])?;
//! let file = npz.finish()?;
//!
//! let mut npz = NpzReader::new(file)?;
//! let (shape, values) = npz.values("image", 1_000)?;
//! assert_eq!(shape, [2, 2]);
//! assert_eq!(values[3], (4.0, 0.0)); // real and imaginary part
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod error;
mod npy;
mod reader;
mod stored;
mod writer;

pub use error::NpzError;
pub use npy::{NpyError, NpyHeader};
pub use reader::NpzReader;
pub use stored::StoredArray;
pub use writer::{ArrayWriter, NpyValue, NpzWriter, OwnedArrayWriter};
