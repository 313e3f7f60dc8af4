//! Merging of coarse images on the rows of a finer grid.

use super::cell::Cell;
use super::heights::SortedHeights;
use super::lattice::Lattice;
use crate::engine::planar::padded;
use crate::grid::image::Patch;
use crate::grid::relief::Relief;
use crate::grid::tilted::TiltedGrid;
use crate::kernel::dispatch::dispatch;
use crate::kernel::level::SimdLevel;
use crate::kernel::merge::{MOST_REACH, MergeAcross, MergeRow, merge_across, merge_row};
use acerra_control::Control;

/// A sub-aperture's coarse image without the carrier's phase of the range to the sub-aperture's centre, real
/// and imaginary: rows of [`padded`] numbers, in which the first samples of all cells are adjacent, then the
/// second samples, and so on.
#[derive(Default)]
pub(super) struct CoarseImage {
    pub centre_m: [f64; 3],
    pub real: Vec<f32>,
    pub imag: Vec<f32>,
}

/// Data of merging on a grid that all rows share.
pub(super) struct Merger<'a> {
    lattice: &'a Lattice,
    level: SimdLevel,
    grid: &'a TiltedGrid,
    relief: Option<Relief<'a>>,
    /// Samples of a coarse row that are merged, and numbers from one row to the next.
    row_samples: usize,
    stride: usize,
    /// Places in a row of the samples that the first cell's pixels take.
    offsets: [usize; MOST_REACH],
    /// Cells in a padded row of the grid.
    intervals: usize,
}

/// Memory of a thread that merges.
pub(super) struct Scratch {
    numbers: Vec<f32>,
    /// Heights of the rows of a cell, over uneven ground.
    heights: Vec<SortedHeights>,
}

/// Sums on a row of the grid: pixels of one place in their cells contiguously, `[D, cells]`.
pub(super) struct MergedRow<'s> {
    real: &'s [f32],
    imag: &'s [f32],
    intervals: usize,
    pixels: usize,
}

impl<'a> Merger<'a> {
    /// The merger for an image of `patch`.
    pub fn new(lattice: &'a Lattice, level: SimdLevel, patch: &'a Patch) -> Self {
        let grid = &patch.grid;
        let coarse = &lattice.stage.coarse;
        let row_samples = coarse.row_samples(grid);
        Self {
            lattice,
            level,
            grid,
            relief: patch.relief,
            row_samples,
            stride: padded(row_samples),
            offsets: offsets(coarse.cells[0], row_samples),
            intervals: coarse.padded_cells(grid),
        }
    }

    /// Number of rows of a cell, which share their coarse rows.
    pub fn rows_of_cell(&self) -> usize {
        self.lattice.stage.coarse.cells[1].pixels
    }

    /// Scratch for [`Self::cell`].
    pub fn scratch(&self) -> Scratch {
        let numbers = self.rows_of_cell() * (2 * self.row_samples + self.row_length());
        let pixels = self.lattice.stage.coarse.cells[0].pixels;
        let heights = || SortedHeights::new(pixels, self.intervals);
        let rows = (self.relief).map_or(0, |_| self.rows_of_cell());
        Scratch {
            numbers: vec![0.0; numbers],
            heights: (0..rows).map(|_| heights()).collect(),
        }
    }

    /// Numbers of a row's sums, real and imaginary.
    fn row_length(&self) -> usize {
        2 * self.lattice.stage.coarse.cells[0].pixels * self.intervals
    }

    /// The sums of coarse images on the first `rows` rows of a cell; incomplete after cancellation.
    pub fn cell<'s>(
        &self,
        images: &[CoarseImage],
        (cell, rows): (usize, usize),
        scratch: &'s mut Scratch,
        control: Control,
    ) -> impl Iterator<Item = MergedRow<'s>> + use<'s> {
        let [along, across] = self.lattice.stage.coarse.cells;
        let row_length = self.row_length();
        let Scratch { numbers, heights } = scratch;
        if let Some(relief) = self.relief {
            for (j, heights) in (cell * across.pixels..).zip(&mut heights[..rows]) {
                heights.fill(&relief.heights_m[j * relief.stride..][..self.grid.columns]);
            }
        }
        let (lines, sums) = numbers.split_at_mut(2 * self.row_samples * self.rows_of_cell());
        let lines = &mut lines[..2 * self.row_samples * rows];
        let sums = &mut sums[..row_length * rows];
        sums.fill(0.0);
        for image in images {
            if control.is_cancelled() {
                break;
            }
            let last = image.real.len() / self.stride - 1;
            let job = MergeAcross {
                rows: std::array::from_fn(|k| {
                    // Samples beyond the last one are not read.
                    let at = (cell * across.samples + k).min(last) * self.stride;
                    let samples = at..at + self.row_samples;
                    (&image.real[samples.clone()], &image.imag[samples])
                }),
                stencil: &self.lattice.stencils[1],
            };
            dispatch!(self.level, s => merge_across(s, &job, lines));
            let lines = lines.chunks_exact(2 * self.row_samples);
            let rows = lines.zip(sums.chunks_exact_mut(row_length)).enumerate();
            for (row, (line, sums)) in rows {
                let (real, imag) = sums.split_at_mut(row_length / 2);
                let j = cell * across.pixels + row;
                let job = MergeRow {
                    phase: self.lattice.phase_row(self.grid, j, image.centre_m),
                    heights: heights.get(row).map(SortedHeights::row),
                    line: line.split_at(self.row_samples),
                    stencil: &self.lattice.stencils[0],
                    offsets: &self.offsets,
                    intervals: self.grid.columns.div_ceil(along.pixels),
                    padded: self.intervals,
                };
                dispatch!(self.level, s => merge_row(s, &job, real, imag));
            }
        }
        let (intervals, pixels) = (self.intervals, along.pixels);
        sums.chunks_exact(row_length).map(move |sums| {
            let (real, imag) = sums.split_at(row_length / 2);
            MergedRow {
                real,
                imag,
                intervals,
                pixels,
            }
        })
    }
}

impl MergedRow<'_> {
    /// Writes the pixels in their order in space.
    pub fn write<T>(&self, row: &mut [T], of: impl Fn(f32, f32) -> T) {
        let phases =
            (self.real.chunks_exact(self.intervals)).zip(self.imag.chunks_exact(self.intervals));
        for (p, (real, imag)) in phases.enumerate() {
            let pixels = row.iter_mut().skip(p).step_by(self.pixels);
            for ((to, re), im) in pixels.zip(real).zip(imag) {
                *to = of(*re, *im);
            }
        }
    }
}

/// Places, in a sorted row of `columns` samples, of the samples that the pixels of the first cell read.
fn offsets(cell: Cell, columns: usize) -> [usize; MOST_REACH] {
    let cells = columns / cell.samples;
    std::array::from_fn(|sample| sample % cell.samples * cells + sample / cell.samples)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_of_a_kind_stand_side_by_side() {
        let cell = Cell {
            pixels: 5,
            samples: 3,
        };
        let found = offsets(cell, 300);
        assert_eq!(found[..7], [0, 100, 200, 1, 101, 201, 2]);
        let whole = Cell {
            pixels: 4,
            samples: 1,
        };
        assert_eq!(offsets(whole, 300)[..4], [0, 1, 2, 3]);
    }
}
