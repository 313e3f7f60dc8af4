//! A height raster in its own coordinates.

use super::{Crs, TerrainError};

/// Column and row of a point from its coordinates: the inverse of the raster's own transformation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Placement {
    /// Coordinates of the centre of cell (0, 0).
    pub origin: [f64; 2],
    /// Change of (column, row) with the coordinates.
    pub inverse: [[f64; 2]; 2],
}

impl Placement {
    /// From the steps of the coordinates a column and a row.
    ///
    /// # Errors
    /// Steps that are not finite or span no area.
    pub fn new(origin: [f64; 2], column: [f64; 2], row: [f64; 2]) -> Result<Self, TerrainError> {
        let determinant = column[0] * row[1] - column[1] * row[0];
        let values = origin.iter().chain(&column).chain(&row);
        if !values.copied().all(f64::is_finite) || !(1.0 / determinant).is_finite() {
            return Err(TerrainError::Tag {
                at: "the raster's transformation",
                expected: "finite steps that span an area",
                found: format!("{column:?} a column, {row:?} a row"),
            });
        }
        Ok(Self {
            origin,
            inverse: [
                [row[1] / determinant, -row[0] / determinant],
                [-column[1] / determinant, column[0] / determinant],
            ],
        })
    }

    /// Column and row, counted from 0 at the centre of the first cell.
    pub fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let d = [x - self.origin[0], y - self.origin[1]];
        self.inverse.map(|r| r[0] * d[0] + r[1] * d[1])
    }
}

/// Where a raster stands and what its heights mean, before any of them is read.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Header {
    pub columns: usize,
    pub rows: usize,
    pub placement: Placement,
    /// None where the file does not say.
    pub crs: Option<Crs>,
    /// What the file says of its heights, for a remark.
    pub vertical: Option<String>,
}

/// Part of a raster: heights (m) of some columns and rows, NaN where there is no data.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Window {
    pub first_column: usize,
    pub first_row: usize,
    pub columns: usize,
    pub rows: usize,
    pub height_m: Vec<f32>,
}

impl Window {
    /// No data yet.
    ///
    /// # Errors
    /// More cells than `limit`.
    pub fn empty(
        columns: std::ops::Range<usize>,
        rows: std::ops::Range<usize>,
        limit: usize,
    ) -> Result<Self, TerrainError> {
        let cells = columns.len() as u128 * rows.len() as u128;
        if cells > limit as u128 {
            return Err(TerrainError::Limit {
                what: "cells under the image",
                found: cells,
                limit: limit as u128,
            });
        }
        Ok(Self {
            first_column: columns.start,
            first_row: rows.start,
            columns: columns.len(),
            rows: rows.len(),
            height_m: vec![f32::NAN; cells as usize],
        })
    }

    /// Height between four cells, bilinear; `None` where one of them that counts has no data.
    /// Column and row count from the first of the whole raster, and lie within the window.
    pub fn bilinear(&self, column: f64, row: f64) -> Option<f64> {
        let place = |at: f64, first: usize, count: usize| {
            let t = (at - first as f64).clamp(0.0, (count - 1) as f64);
            let low = (t as usize).min(count.saturating_sub(2));
            (low, (low + 1).min(count - 1), t - low as f64)
        };
        let (i, i1, u) = place(column, self.first_column, self.columns);
        let (j, j1, v) = place(row, self.first_row, self.rows);
        let mut sum = 0.0;
        for (k, weight) in [
            (j * self.columns + i, (1.0 - u) * (1.0 - v)),
            (j * self.columns + i1, u * (1.0 - v)),
            (j1 * self.columns + i, (1.0 - u) * v),
            (j1 * self.columns + i1, u * v),
        ] {
            if weight != 0.0 {
                sum += weight * f64::from(self.height_m[k]);
            }
        }
        sum.is_finite().then_some(sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_raster_is_placed() {
        let p = Placement::new([100.0, 50.0], [0.3, 0.4], [0.4, -0.3]).unwrap();
        let at = p.place([100.0 + 2.0 * 0.3 + 5.0 * 0.4, 50.0 + 2.0 * 0.4 - 5.0 * 0.3]);
        assert!((at[0] - 2.0).abs() < 1e-12 && (at[1] - 5.0).abs() < 1e-12);
        assert!(Placement::new([0.0; 2], [1.0, 1.0], [1.0, 1.0]).is_err());
        assert!(Placement::new([0.0; 2], [f64::NAN, 1.0], [1.0, 0.0]).is_err());
    }

    #[test]
    fn heights_are_bilinear_and_holes_are_seen_only_where_they_count() {
        let mut w = Window::empty(3..5, 7..9, 4).unwrap();
        w.height_m = vec![1.0, 2.0, 3.0, f32::NAN];
        assert_eq!(w.bilinear(3.25, 7.0), Some(1.25));
        assert_eq!(w.bilinear(3.0, 7.5), Some(2.0));
        assert_eq!(w.bilinear(3.5, 7.5), None);
        assert!(Window::empty(0..3, 0..2, 5).is_err());
    }
}
