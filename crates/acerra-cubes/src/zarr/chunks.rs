//! Arrays cut into chunks, each compressed into a file of its own.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use flate2::Compression;
use flate2::write::GzEncoder;
use num_complex::Complex32;
use rayon::prelude::*;

use super::metadata::GZIP_LEVEL;
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

/// A value as it stands in a chunk.
pub(super) trait Stored: Copy + Sync {
    /// What fills a chunk beyond the edge of its array.
    const FILL: Self;
    /// Appends its bytes, the least significant first.
    fn put(self, bytes: &mut Vec<u8>);
}

impl Stored for f32 {
    const FILL: Self = Self::NAN;
    fn put(self, bytes: &mut Vec<u8>) {
        bytes.extend(self.to_le_bytes());
    }
}

impl Stored for f64 {
    const FILL: Self = Self::NAN;
    fn put(self, bytes: &mut Vec<u8>) {
        bytes.extend(self.to_le_bytes());
    }
}

impl Stored for i32 {
    const FILL: Self = 0;
    fn put(self, bytes: &mut Vec<u8>) {
        bytes.extend(self.to_le_bytes());
    }
}

impl Stored for Complex32 {
    const FILL: Self = Self::new(f32::NAN, f32::NAN);
    fn put(self, bytes: &mut Vec<u8>) {
        self.re.put(bytes);
        self.im.put(bytes);
    }
}

/// How an array is cut.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cut<'a> {
    pub shape: &'a [usize],
    pub chunk: &'a [usize],
}

impl Cut<'_> {
    /// Writes every chunk of `values` into the directory of their array.
    fn write<T: Stored>(self, folder: &Path, values: &[T]) -> io::Result<()> {
        self.write_below(&folder.join("c"), values)
    }

    /// Writes every chunk of `values` to files below `folder`, several at a time.
    pub fn write_below<T: Stored>(self, folder: &Path, values: &[T]) -> io::Result<()> {
        let counts: Vec<usize> = self
            .shape
            .iter()
            .zip(self.chunk)
            .map(|(n, c)| n.div_ceil(*c))
            .collect();
        let chunks: usize = counts.iter().product();
        (0..chunks).into_par_iter().try_for_each(|k| {
            let index = unravelled(k, &counts);
            let bytes = self.bytes(values, &index);
            write_chunk(folder, &index, &bytes)
        })
    }

    /// The bytes of the chunk at `index`, filled up beyond the array's edges.
    fn bytes<T: Stored>(self, values: &[T], index: &[usize]) -> Vec<u8> {
        let length: usize = self.chunk.iter().product();
        let mut bytes = Vec::with_capacity(length * size_of::<T>());
        let Some((row, outer)) = self.chunk.split_last() else {
            values.iter().for_each(|value| value.put(&mut bytes));
            return bytes;
        };
        let last = self.chunk.len() - 1;
        let columns = self.shape[last];
        let first = index[last] * row;
        let within = columns.saturating_sub(first).min(*row);
        for k in 0..outer.iter().product() {
            let mut inside = true;
            let mut start = 0;
            for (axis, offset) in unravelled(k, outer).iter().enumerate() {
                let place = index[axis] * self.chunk[axis] + offset;
                inside &= place < self.shape[axis];
                start = start * self.shape[axis] + place;
            }
            let kept = if inside { within } else { 0 };
            let from = start * columns + first;
            let line = if inside {
                &values[from..from + kept]
            } else {
                &[]
            };
            line.iter().for_each(|value| value.put(&mut bytes));
            (kept..*row).for_each(|_| T::FILL.put(&mut bytes));
        }
        bytes
    }
}

/// The indices of element `k`, counted row by row, of an array of these lengths.
fn unravelled(mut k: usize, lengths: &[usize]) -> Vec<usize> {
    let mut index = vec![0; lengths.len()];
    for (place, n) in index.iter_mut().zip(lengths).rev() {
        *place = k % n;
        k /= n;
    }
    index
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
