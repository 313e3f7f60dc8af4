//! Coarse grids of sub-apertures.

use super::cell::Cell;
use super::interpolation::before;
use crate::engine::planar::padded;
use crate::grid::tilted::TiltedGrid;
use crate::kernel::lanes::MAX_LANES;

/// Ratio of a coarse grid to the fine grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Coarse {
    /// Fine pixels and coarse samples of a cell, along the row and across.
    pub cells: [Cell; 2],
    /// Number of samples from which a value is interpolated, in either direction.
    pub taps: usize,
}

impl Coarse {
    /// The coarse grid that covers `grid`.
    pub fn grid(&self, grid: &TiltedGrid) -> TiltedGrid {
        let [u, v] = self.cells;
        let before = |cell: Cell| -(before(self.taps) as f64 * cell.interval());
        TiltedGrid {
            origin_m: grid.point_m(before(u), before(v)),
            u_m: grid.u_m.map(|x| x * u.interval()),
            v_m: grid.v_m.map(|x| x * v.interval()),
            columns: grid.columns.div_ceil(u.pixels) * u.samples + self.taps,
            rows: grid.rows.div_ceil(v.pixels) * v.samples + self.taps,
        }
    }

    /// Samples of a row in merging: the cells of a padded row of the fine grid, and the samples around them.
    pub fn row_samples(&self, grid: &TiltedGrid) -> usize {
        let samples = self.cells[0].samples;
        let around = (self.taps + samples - 1).div_ceil(samples);
        samples * (self.padded_cells(grid) + around)
    }

    /// Cells of a padded row of the fine grid.
    pub fn padded_cells(&self, grid: &TiltedGrid) -> usize {
        (grid.columns.div_ceil(self.cells[0].pixels)).next_multiple_of(MAX_LANES)
    }

    /// Fine pixels of a cell, along the row and across.
    pub fn cell_pixels(&self) -> [usize; 2] {
        self.cells.map(|cell| cell.pixels)
    }

    /// Bytes of the heights of uneven ground under the coarse grid: in their order in space, and in the order
    /// of the cells with two numbers a cell.
    pub fn ground_bytes(&self, grid: &TiltedGrid) -> u128 {
        let samples = self.row_samples(grid);
        let coarse = self.grid(grid);
        let of_row = coarse.columns + samples + 2 * (samples / self.cells[0].samples);
        of_row as u128 * coarse.rows as u128 * 4
    }

    /// Bytes of the coarse images of `parts` sub-apertures.
    pub fn bytes(&self, grid: &TiltedGrid, parts: usize) -> u128 {
        let coarse = self.grid(grid);
        let stride = padded(self.row_samples(grid));
        let pixels = stride as u128 * coarse.rows as u128;
        // Unfinished rows on every thread are included.
        pixels * 8 * (parts as u128 + 1)
    }
}
