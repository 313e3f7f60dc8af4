//! Images as the kernel of groups reads them.

use crate::grid::tilted::TiltedGrid;
use crate::kernel::lanes::MAX_LANES;
use num_complex::Complex32;
use rayon::prelude::*;

/// An image in groups of `shape` pixels, `[rows, shape[0], stride]` with rows filled up to whole groups:
/// pixels of the same place in their groups side by side, zeros beyond the image.
pub(super) struct Grouped {
    pub grid: TiltedGrid,
    pub shape: [usize; 2],
    /// Groups a row, a multiple of [`MAX_LANES`].
    pub stride: usize,
    pub real: Vec<f32>,
    pub imag: Vec<f32>,
}

/// Groups a row, filled up to whole vectors.
fn groups_a_row(columns: usize, shape: [usize; 2]) -> usize {
    columns.div_ceil(shape[0]).next_multiple_of(MAX_LANES)
}

/// Pixels of an image in groups, padding included.
pub(crate) fn grouped_pixels(grid: &TiltedGrid, shape: [usize; 2]) -> u128 {
    let columns = groups_a_row(grid.columns, shape) * shape[0];
    columns as u128 * grid.rows.next_multiple_of(shape[1]) as u128
}

impl Grouped {
    /// Sorts an image `[rows, columns]` into groups.
    pub fn new(grid: &TiltedGrid, shape: [usize; 2], image: &[Complex32]) -> Self {
        let stride = groups_a_row(grid.columns, shape);
        let row_length = stride * shape[0];
        let length = row_length * grid.rows.next_multiple_of(shape[1]);
        let (mut real, mut imag) = (vec![0f32; length], vec![0f32; length]);
        real.par_chunks_mut(row_length)
            .zip(imag.par_chunks_mut(row_length))
            .zip(image.par_chunks(grid.columns.max(1)))
            .for_each(|((real, imag), row)| {
                for (group, pixels) in row.chunks(shape[0]).enumerate() {
                    for (place, v) in pixels.iter().enumerate() {
                        real[place * stride + group] = v.re;
                        imag[place * stride + group] = v.im;
                    }
                }
            });
        Self {
            grid: *grid,
            shape,
            stride,
            real,
            imag,
        }
    }

    /// Rows of groups.
    pub fn strips(&self) -> usize {
        self.grid.rows.div_ceil(self.shape[1])
    }

    /// Groups a row that hold pixels.
    pub fn groups(&self) -> usize {
        self.grid.columns.div_ceil(self.shape[0])
    }

    /// Real and imaginary parts of a row of groups.
    pub fn strip(&self, strip: usize) -> (&[f32], &[f32]) {
        let length = self.stride * self.shape[0] * self.shape[1];
        let at = strip * length..(strip + 1) * length;
        (&self.real[at.clone()], &self.imag[at])
    }

    /// Copies the pixels of a row from column `first` on, a multiple of the groups' columns, zeros beyond
    /// the row.
    pub fn copy_row(&self, row: usize, first: usize, real: &mut [f32], imag: &mut [f32]) {
        let columns = self.shape[0];
        let start = row * self.stride * columns;
        for (k, (re, im)) in real.iter_mut().zip(imag).enumerate() {
            let (group, place) = ((first + k) / columns, (first + k) % columns);
            let at = start + place * self.stride + group;
            (*re, *im) = if group < self.stride {
                (self.real[at], self.imag[at])
            } else {
                (0.0, 0.0)
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_back_from_their_groups() {
        let grid = TiltedGrid::new([0.0; 3], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], 37, 5).unwrap();
        let image: Vec<Complex32> = (0..37 * 5)
            .map(|k| Complex32::new(k as f32 + 1.0, -(k as f32)))
            .collect();
        for shape in [[4, 4], [4, 2], [2, 2]] {
            let grouped = Grouped::new(&grid, shape, &image);
            assert_eq!(
                grouped.real.len() as u128,
                grouped_pixels(&grid, shape),
                "{shape:?}"
            );
            for row in 0..5 {
                for first in [0, 32] {
                    let (mut real, mut imag) = ([9f32; 128], [9f32; 128]);
                    grouped.copy_row(row, first, &mut real, &mut imag);
                    for k in 0..128 {
                        let expected = if first + k < 37 {
                            image[row * 37 + first + k]
                        } else {
                            Complex32::ZERO
                        };
                        assert_eq!(Complex32::new(real[k], imag[k]), expected);
                    }
                }
            }
        }
    }
}
