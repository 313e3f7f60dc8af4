//! Images in the order in which the kernels of groups read pixels.

use crate::grid::tilted::TiltedGrid;
use crate::kernel::lanes::MAX_LANES;
use num_complex::Complex32;
use rayon::prelude::*;

/// Groups of neighbouring pixels that share an expansion of the range, and the way in which the pixels are
/// added to bins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GroupSpec {
    /// Pixels along the row and across: 4 × 4, 4 × 2 or 2 × 2.
    pub shape: [usize; 2],
    pub way: GroupWay,
}

/// Way in which the pixels of a group are added to bins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum GroupWay {
    /// Sum in registers, added to the bin of the group's middle: for fine pixels.
    Summed {
        /// Number of coefficients of the cosine over half a turn; the sine has one fewer.
        terms: usize,
        /// Distance from a group's middle up to which polynomials hold, m.
        reach_m: f64,
    },
    /// Every pixel to its own bin: for coarse pixels.
    Spread,
}

/// An image in groups of `shape` pixels, `[strips, blocks, shape[1], shape[0], MAX_LANES]`: pixels of the
/// same place in their groups contiguously, zeros beyond the image.
pub(super) struct Grouped {
    pub grid: TiltedGrid,
    pub shape: [usize; 2],
    pub real: Vec<f32>,
    pub imag: Vec<f32>,
}

/// Numbers of a row of groups.
fn strip_length(columns: usize, shape: [usize; 2]) -> usize {
    columns.div_ceil(shape[0]).next_multiple_of(MAX_LANES) * shape[0] * shape[1]
}

/// Pixels of an image in groups, padding included.
pub(crate) fn grouped_pixels(grid: &TiltedGrid, shape: [usize; 2]) -> u128 {
    strip_length(grid.columns, shape) as u128 * grid.rows.div_ceil(shape[1]) as u128
}

/// Index in a strip of pixel (`column`, `row`).
fn place(column: usize, row: usize, shape: [usize; 2]) -> usize {
    let group = column / shape[0];
    let block = group / MAX_LANES * shape[1] * shape[0];
    (block + row * shape[0] + column % shape[0]) * MAX_LANES + group % MAX_LANES
}

impl Grouped {
    /// Sorts an image `[rows, columns]` into groups.
    pub fn new(grid: &TiltedGrid, shape: [usize; 2], image: &[Complex32]) -> Self {
        let length = strip_length(grid.columns, shape);
        let all = length * grid.rows.div_ceil(shape[1]);
        let (mut real, mut imag) = (vec![0f32; all], vec![0f32; all]);
        let columns = grid.columns.max(1);
        real.par_chunks_mut(length.max(1))
            .zip(imag.par_chunks_mut(length.max(1)))
            .zip(image.par_chunks(columns * shape[1]))
            .for_each(|((real, imag), rows)| {
                for (j, row) in rows.chunks(columns).enumerate() {
                    for (i, v) in row.iter().enumerate() {
                        let at = place(i, j, shape);
                        (real[at], imag[at]) = (v.re, v.im);
                    }
                }
            });
        Self {
            grid: *grid,
            shape,
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

    /// Numbers from one row of groups to the next.
    pub fn stride(&self) -> usize {
        strip_length(self.grid.columns, self.shape)
    }

    /// Real and imaginary parts of the rows of groups from `strip` on.
    pub fn strips_from(&self, strip: usize) -> (&[f32], &[f32]) {
        let at = strip * self.stride();
        (&self.real[at..], &self.imag[at..])
    }

    /// Copies the pixels of a row from column `first` on, zeros beyond the row.
    pub fn copy_row(&self, row: usize, first: usize, real: &mut [f32], imag: &mut [f32]) {
        let (strip_re, strip_im) = self.strips_from(row / self.shape[1]);
        for (k, (re, im)) in real.iter_mut().zip(imag).enumerate() {
            let at = place(first + k, row % self.shape[1], self.shape);
            (*re, *im) = if first + k < self.grid.columns {
                (strip_re[at], strip_im[at])
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
