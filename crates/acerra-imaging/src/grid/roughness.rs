//! Classes of roughness of uneven ground.

use super::image::ImageGrid;
use super::relief::Relief;
use crate::sampling::Random;
use rayon::prelude::*;
use std::ops::Range;

/// Pixels along a side of a cell.
const CELL: usize = 4;
/// Number of cells of the roughest class, followed by the bounds of the next classes as shares of all cells.
const ROUGHEST: usize = 16;
const SHARES: [f64; 4] = [0.001, 0.01, 0.1, 1.0];

/// Cells of pixels in classes of roughness, the roughest first: kinks, walls and single boulders are few, and
/// random pixels would miss them.
#[derive(Debug)]
pub(crate) struct Roughness {
    /// Indices of all cells, class after class.
    cells: Vec<u32>,
    classes: Vec<Range<usize>>,
    /// Columns and rows of the image.
    sizes: [usize; 2],
    /// Cells of a row.
    columns: usize,
}

impl Roughness {
    /// Classes of uneven ground; `None` for a plane.
    pub fn of(grid: &ImageGrid) -> Option<Self> {
        let relief = grid.whole().relief?;
        let sizes = [grid.columns(), grid.rows()];
        let [columns, rows] = sizes.map(|n| n.div_ceil(CELL));
        let mut bends = vec![0f32; columns * rows];
        bends
            .par_chunks_mut(columns)
            .enumerate()
            .for_each(|(j, bends)| bends_of_cells(&relief, sizes, CELL * j, bends));
        let mut cells: Vec<u32> = (0..(columns * rows) as u32).collect();
        let mut classes = Vec::new();
        let mut start = 0;
        for share in std::iter::once(0.0).chain(SHARES) {
            let end = ((share * cells.len() as f64) as usize)
                .max(ROUGHEST)
                .min(cells.len());
            if end > start {
                let rougher = |a: &u32, b: &u32| bends[*b as usize].total_cmp(&bends[*a as usize]);
                cells[start..].select_nth_unstable_by(end - start - 1, rougher);
                classes.push(start..end);
                start = end;
            }
        }
        Some(Self {
            cells,
            classes,
            sizes,
            columns,
        })
    }

    /// Share of the pixels in each class.
    pub fn shares(&self) -> impl Iterator<Item = f64> {
        let all = self.cells.len() as f64;
        self.classes
            .iter()
            .map(move |class| class.len() as f64 / all)
    }

    /// A random pixel of a class.
    pub fn draw(&self, class: usize, random: &mut Random) -> [usize; 2] {
        let class = &self.classes[class];
        let cell = self.cells[class.start + random.below(class.len())] as usize;
        let first = [cell % self.columns, cell / self.columns];
        let pixel =
            |axis: usize, within: usize| (CELL * first[axis] + within).min(self.sizes[axis] - 1);
        [pixel(0, random.below(CELL)), pixel(1, random.below(CELL))]
    }
}

/// Writes to `bends` the largest second difference of the heights, along rows and columns, in each cell from
/// row `first` of the cells on.
fn bends_of_cells(relief: &Relief, sizes: [usize; 2], first: usize, bends: &mut [f32]) {
    let row = |j: usize| &relief.heights_m[j * relief.stride..][..sizes[0]];
    for j in first..(first + CELL).min(sizes[1]) {
        let here = row(j);
        let [above, below] = match j > 0 && j + 1 < sizes[1] {
            true => [row(j - 1), row(j + 1)],
            false => [here; 2],
        };
        for (cell, bend) in bends.iter_mut().enumerate() {
            for i in CELL * cell..(CELL * (cell + 1)).min(sizes[0]) {
                let across = (above[i] - 2.0 * here[i] + below[i]).abs();
                let along = match i > 0 && i + 1 < sizes[0] {
                    true => (here[i - 1] - 2.0 * here[i] + here[i + 1]).abs(),
                    false => 0.0,
                };
                *bend = bend.max(along).max(across);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::ImagingError;
    use crate::grid::plane::PlaneGrid;
    use crate::grid::surface::SurfaceGrid;

    #[test]
    fn a_single_wall_is_of_the_roughest_class() {
        let base = PlaneGrid::new([0.0; 3], 1.0, [403, 301]).unwrap();
        let height = |x: f64, y: f64| {
            let wall = x > 200.0 && (100.0..105.0).contains(&y);
            Ok::<_, ImagingError>(0.1 * (0.05 * x).sin() + if wall { 0.2 } else { 0.0 })
        };
        let ground = SurfaceGrid::from_fn(base, height).unwrap();
        let roughness = Roughness::of(&(&ground).into()).unwrap();
        let shares: Vec<f64> = roughness.shares().collect();
        assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12 && shares.len() == 4);
        let mut random = Random(3);
        for _ in 0..50 {
            let [i, j] = roughness.draw(0, &mut random);
            assert!(i >= 196 && (96..112).contains(&j), "{i} {j}");
            let [i, j] = roughness.draw(3, &mut random);
            assert!(
                i < 403 && j < 301 && !(i > 204 && (96..108).contains(&j)),
                "{i} {j}"
            );
        }
        assert!(Roughness::of(&base.into()).is_none());
    }
}
