//! Heights of uneven ground under the rows of a grid, in the order in which their phases are taken.

use super::lattice::Lattice;
use crate::grid::image::Patch;
use crate::grid::terrain::Heights;
use crate::kernel::phase::RowHeights;
use rayon::prelude::*;

/// Heights of one row: the first pixels of all cells contiguously, then the second pixels, and so on.
#[derive(Debug, Clone)]
pub(super) struct SortedHeights {
    above_m: Vec<f32>,
    middle_m: Vec<f32>,
    /// Greatest height in each cell, while a row is read.
    highest_m: Vec<f32>,
    /// Greatest departure of a height from the middle of its cell.
    departure_m: f32,
    span_m: [f32; 2],
}

impl SortedHeights {
    /// Memory for rows of `cells` cells of `pixels` pixels.
    pub fn new(pixels: usize, cells: usize) -> Self {
        Self {
            above_m: vec![0.0; pixels * cells],
            middle_m: vec![0.0; cells],
            highest_m: vec![0.0; cells],
            departure_m: 0.0,
            span_m: [0.0; 2],
        }
    }

    /// Sorts the heights of a row; the last height is repeated to the end.
    pub fn fill(&mut self, row: &[f32]) {
        let cells = self.middle_m.len();
        let pixels = self.above_m.len() / cells;
        let last = row[row.len() - 1];
        for (p, to) in self.above_m.chunks_exact_mut(cells).enumerate() {
            let from = row[p.min(row.len())..].iter().step_by(pixels);
            let known = from.len().min(cells);
            for (to, from) in to.iter_mut().zip(from) {
                *to = *from;
            }
            to[known..].fill(last);
        }
        let (low, high) = (&mut self.middle_m, &mut self.highest_m);
        low.copy_from_slice(&self.above_m[..cells]);
        high.copy_from_slice(&self.above_m[..cells]);
        for heights in self.above_m.chunks_exact(cells).skip(1) {
            for ((low, high), height) in low.iter_mut().zip(&mut *high).zip(heights) {
                *low = if *height < *low { *height } else { *low };
                *high = if *height > *high { *height } else { *high };
            }
        }
        self.span_m = [f32::INFINITY, f32::NEG_INFINITY];
        self.departure_m = 0.0;
        for (low, high) in low.iter_mut().zip(high) {
            self.span_m = [self.span_m[0].min(*low), self.span_m[1].max(*high)];
            self.departure_m = self.departure_m.max(0.5 * (*high - *low));
            *low = 0.5 * (*low + *high);
        }
    }

    /// The heights in the form that kernels read.
    pub fn row(&self) -> RowHeights<'_> {
        RowHeights {
            above_m: &self.above_m,
            middle_m: &self.middle_m,
            departure_m: self.departure_m,
            span_m: self.span_m,
        }
    }
}

/// The ground under the samples of a coarse grid.
#[derive(Debug)]
pub(super) struct CoarseGround {
    pub heights: Heights,
    pub rows: Vec<SortedHeights>,
}

impl CoarseGround {
    /// The ground under the coarse grid of `patch`; `None` over a plane.
    pub fn under(lattice: &Lattice, patch: &Patch) -> Option<Self> {
        let coarse = &lattice.stage.coarse;
        let samples = coarse.cells[0].samples;
        let grid = coarse.grid(&patch.grid);
        let heights = patch.terrain.heights_on(&grid)?;
        let cells = coarse.row_samples(&patch.grid) / samples;
        let relief = heights.relief();
        let sorted = |j: usize| {
            let mut row = SortedHeights::new(samples, cells);
            row.fill(&relief.heights_m[j * relief.stride..][..grid.columns]);
            row
        };
        let rows = (0..grid.rows).into_par_iter().map(sorted).collect();
        Some(Self { heights, rows })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_stand_as_the_pixels_of_their_cells() {
        let row: Vec<f32> = (0..10).map(|i| i as f32 * i as f32).collect();
        let mut sorted = SortedHeights::new(3, 4);
        sorted.fill(&row);
        let heights = sorted.row();
        assert_eq!(heights.above_m[..4], [0.0, 9.0, 36.0, 81.0]);
        assert_eq!(heights.above_m[4..8], [1.0, 16.0, 49.0, 81.0]);
        assert_eq!(heights.middle_m, [2.0, 17.0, 50.0, 81.0]);
        assert_eq!((heights.departure_m, heights.span_m), (14.0, [0.0, 81.0]));
    }
}
