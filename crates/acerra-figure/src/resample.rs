//! From data cells to device pixels, without losing single bright cells.

use rayon::prelude::*;

/// The cells `[from, to)` of `cells` that pixel `pixel` of `pixels` shows: with more cells than
/// pixels a partition of the cells, with fewer the one cell under the pixel's centre.
fn covered(pixel: usize, pixels: usize, cells: usize) -> (usize, usize) {
    if cells <= pixels {
        let cell = ((2 * pixel + 1) * cells / (2 * pixels)).min(cells - 1);
        (cell, cell + 1)
    } else {
        (pixel * cells / pixels, (pixel + 1) * cells / pixels)
    }
}

/// Resamples a row-major grid of `columns × rows` cells to `wide × high` pixels: each pixel takes
/// the value of largest `rank` among the cells that it covers, so that a bright cell survives any
/// reduction, and each cell keeps its edges in any enlargement. NaN only where every cell is NaN.
pub(super) fn peak_pool(
    value: impl Fn(usize) -> f64 + Sync,
    rank: impl Fn(f64) -> f64 + Sync,
    (columns, rows): (usize, usize),
    (wide, high): (usize, usize),
) -> Vec<f64> {
    let spans: Vec<_> = (0..wide).map(|x| covered(x, wide, columns)).collect();
    let mut out = vec![f64::NAN; wide * high];
    if wide == 0 {
        return out;
    }
    out.par_chunks_exact_mut(wide)
        .enumerate()
        .for_each(|(y, line)| {
            let (first_row, end_row) = covered(y, high, rows);
            for (best, &(first, end)) in line.iter_mut().zip(&spans) {
                for row in first_row..end_row {
                    for column in first..end {
                        let v = value(row * columns + column);
                        if best.is_nan() || rank(v) > rank(*best) {
                            *best = v;
                        }
                    }
                }
            }
        });
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_is_covered_exactly_once_when_reducing() {
        for (cells, pixels) in [(7, 3), (1800, 601), (5, 5), (100, 99)] {
            let mut next = 0;
            for pixel in 0..pixels {
                let (from, to) = covered(pixel, pixels, cells);
                assert_eq!(from, next);
                assert!(to > from);
                next = to;
            }
            assert_eq!(next, cells);
        }
    }

    #[test]
    fn enlarging_repeats_cells_evenly() {
        let shown: Vec<_> = (0..9).map(|p| covered(p, 9, 3).0).collect();
        assert_eq!(shown, [0, 0, 0, 1, 1, 1, 2, 2, 2]);
    }

    #[test]
    fn nan_gives_way_to_any_value() {
        let data = [f64::NAN, 1.0, f64::NAN, f64::NAN];
        assert_eq!(peak_pool(|i| data[i], |v| v, (4, 1), (2, 1))[0], 1.0);
        assert!(peak_pool(|i| data[i], |v| v, (4, 1), (2, 1))[1].is_nan());
    }
}
