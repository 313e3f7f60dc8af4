//! Images with separate real and imaginary parts, ready for vector loads.

use crate::grid::tilted::TiltedGrid;
use crate::kernel::lanes::MAX_LANES;
use num_complex::Complex32;
use rayon::prelude::*;

/// Part of an image with real and imaginary parts apart, rows padded with zeros.
pub(crate) struct Planar<'a> {
    pub grid: TiltedGrid,
    /// Numbers from one row to the next, a multiple of [`MAX_LANES`] and at least the columns.
    pub stride: usize,
    pub real: &'a [f32],
    pub imag: &'a [f32],
}

/// Numbers a padded row takes: an odd number of vectors of [`MAX_LANES`], each as long as a cache line.
///
/// Rows that are read together would compete for few sets of the cache where the distance between
/// them contains a large power of two.
pub(crate) fn padded(columns: usize) -> usize {
    MAX_LANES * (columns.div_ceil(MAX_LANES) | 1)
}

/// An image `[rows, columns]` as [`Planar`] parts of rows of `stride` numbers.
pub(crate) fn split_parts(
    image: &[Complex32],
    columns: usize,
    stride: usize,
) -> (Vec<f32>, Vec<f32>) {
    let length = image.len() / columns.max(1) * stride;
    let (mut real, mut imag) = (vec![0f32; length], vec![0f32; length]);
    real.par_chunks_mut(stride)
        .zip(imag.par_chunks_mut(stride))
        .zip(image.par_chunks(columns))
        .for_each(|((real, imag), row)| {
            for ((re, im), v) in real.iter_mut().zip(imag).zip(row) {
                (*re, *im) = (v.re, v.im);
            }
        });
    (real, imag)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn padded_rows_spread_over_the_sets_of_a_cache() {
        for columns in [1, 16, 17, 1023, 1024, 1280, 4096] {
            let vectors = padded(columns) / MAX_LANES;
            assert!(padded(columns) >= columns && padded(columns) < columns + 2 * MAX_LANES);
            let sets: std::collections::BTreeSet<_> =
                (0..64).map(|row| row * vectors % 64).collect();
            assert_eq!(sets.len(), 64);
        }
    }
}
