//! Arrays cut into chunks, each compressed into a separate file.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use flate2::Compression;
use flate2::write::GzEncoder;
use rayon::prelude::*;

use super::metadata::GZIP_LEVEL;
use crate::cut::{Cut, Stored, unravelled};
use crate::dataset::Values;
use crate::error::CubeError;

/// Writes the chunks of an array into its directory.
pub(super) fn write_chunks(
    folder: &Path,
    values: &Values<'_>,
    shape: &[usize],
    chunk: &[usize],
) -> Result<(), CubeError> {
    let cut = Cut { shape, chunk };
    let written = match values {
        Values::Real32(v) => cut.write(folder, v),
        Values::Real64(v) => cut.write(folder, v),
        Values::Complex32(v) => cut.write(folder, v),
        Values::Whole(v) => cut.write(folder, v),
    };
    Ok(written?)
}

impl Cut<'_> {
    /// Writes every chunk of `values` into the directory of their array.
    fn write<T: Stored>(self, folder: &Path, values: &[T]) -> io::Result<()> {
        self.write_below(&folder.join("c"), values)
    }

    /// Writes every chunk of `values` to files below `folder`, several at a time.
    pub(super) fn write_below<T: Stored>(self, folder: &Path, values: &[T]) -> io::Result<()> {
        let counts = self.counts();
        let chunks: usize = counts.iter().product();
        (0..chunks).into_par_iter().try_for_each(|k| {
            let index = unravelled(k, &counts);
            let bytes = self.bytes(values, &index);
            write_chunk(folder, &index, &bytes)
        })
    }
}

/// Writes a chunk to the file that its indices name, such as `2/0`.
fn write_chunk(folder: &Path, index: &[usize], bytes: &[u8]) -> io::Result<()> {
    let path = index
        .iter()
        .fold(folder.to_owned(), |path, k| path.join(k.to_string()));
    if let Some(parent) = path.parent() {
        fs::create_dir_all(parent)?;
    }
    let mut gzip = GzEncoder::new(Vec::new(), Compression::new(GZIP_LEVEL));
    gzip.write_all(bytes)?;
    fs::write(path, gzip.finish()?)
}
