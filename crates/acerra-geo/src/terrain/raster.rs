//! A height raster in its coordinate reference system.

use super::{Crs, TerrainError};

/// Column and row of a point from its coordinates: the inverse of the raster's transformation.
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

    /// Coordinates of a column and row.
    pub fn coordinates(&self, [column, row]: [f64; 2]) -> [f64; 2] {
        let [[a, b], [c, d]] = self.inverse;
        let determinant = a * d - b * c;
        let x = (d * column - b * row) / determinant;
        let y = (a * row - c * column) / determinant;
        [self.origin[0] + x, self.origin[1] + y]
    }

    /// Column and row, counted from 0 at the centre of the first cell.
    pub fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let d = [x - self.origin[0], y - self.origin[1]];
        self.inverse.map(|r| r[0] * d[0] + r[1] * d[1])
    }
}

/// Place of a raster and meaning of its heights, before any height is read.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Header {
    pub columns: usize,
    pub rows: usize,
    pub placement: Placement,
    /// None where the file does not say.
    pub crs: Option<Crs>,
    /// The file's statement on its heights, for a remark.
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

    /// Height between four cells: cubic convolution (Keys 1981, a = −½) of these four and the surrounding
    /// ones, with continuous slopes. Beyond the last cell, and where one around them has no data, the slope
    /// continues. `None` where one of the four with a weight has no data. Column and row count from the first
    /// of the whole raster, and lie within the window.
    pub fn height_m(&self, column: f64, row: f64) -> Option<f64> {
        let place = |at: f64, first: usize, count: usize| {
            let t = (at - first as f64).clamp(0.0, (count - 1) as f64);
            (t.floor() as i64, t - t.floor())
        };
        let (i, u) = place(column, self.first_column, self.columns);
        let (j, v) = place(row, self.first_row, self.rows);
        if let Some(height_m) = self.amid_data((i, u), (j, v)) {
            return Some(height_m);
        }
        let cell = |i: i64, j: i64| {
            let (i, j) = (usize::try_from(i).ok()?, usize::try_from(j).ok()?);
            let height_m = (i < self.columns && j < self.rows)
                .then(|| f64::from(self.height_m[j * self.columns + i]))?;
            height_m.is_finite().then_some(height_m)
        };
        cubic((j, v), |j| cubic((i, u), |i| cell(i, j)))
    }

    /// The height where all sixteen cells have data.
    fn amid_data(&self, (i, u): (i64, f64), (j, v): (i64, f64)) -> Option<f64> {
        let (first, row) = (usize::try_from(i - 1).ok()?, usize::try_from(j - 1).ok()?);
        if first + 4 > self.columns || row + 4 > self.rows {
            return None;
        }
        let (along, across) = (weights(u), weights(v));
        let mut sum = 0.0;
        for (k, across) in across.into_iter().enumerate() {
            let cells = &self.height_m[(row + k) * self.columns + first..][..4];
            let line = cells.iter().zip(along).map(|(z, w)| w * f64::from(*z));
            sum += across * line.sum::<f64>();
        }
        sum.is_finite().then_some(sum)
    }
}

/// Weights of four samples at `u` from the second to the third.
fn weights(u: f64) -> [f64; 4] {
    [
        u * (-0.5 + u * (1.0 - 0.5 * u)),
        1.0 + u * u * (-2.5 + 1.5 * u),
        u * (0.5 + u * (2.0 - 1.5 * u)),
        u * u * (-0.5 + 0.5 * u),
    ]
}

/// The value at `u` from sample `low` to the next.
fn cubic((low, u): (i64, f64), sample: impl Fn(i64) -> Option<f64>) -> Option<f64> {
    let here = sample(low)?;
    if u == 0.0 {
        return Some(here);
    }
    let next = sample(low + 1)?;
    let before = sample(low - 1).unwrap_or(2.0 * here - next);
    let after = sample(low + 2).unwrap_or(2.0 * next - here);
    let samples = [before, here, next, after];
    Some((weights(u).iter().zip(samples)).map(|(w, z)| w * z).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_raster_is_placed() {
        let p = Placement::new([100.0, 50.0], [0.3, 0.4], [0.4, -0.3]).unwrap();
        let at = p.place([100.0 + 2.0 * 0.3 + 5.0 * 0.4, 50.0 + 2.0 * 0.4 - 5.0 * 0.3]);
        assert!((at[0] - 2.0).abs() < 1e-12 && (at[1] - 5.0).abs() < 1e-12);
        let back = p.coordinates([2.0, 5.0]);
        assert!((back[0] - 102.6).abs() < 1e-12 && (back[1] - 49.3).abs() < 1e-12);
        assert!(Placement::new([0.0; 2], [1.0, 1.0], [1.0, 1.0]).is_err());
        assert!(Placement::new([0.0; 2], [f64::NAN, 1.0], [1.0, 0.0]).is_err());
    }

    #[test]
    fn holes_are_seen_only_where_they_count() {
        let mut w = Window::empty(3..5, 7..9, 4).unwrap();
        w.height_m = vec![1.0, 2.0, 3.0, f32::NAN];
        assert_eq!(w.height_m(3.25, 7.0), Some(1.25));
        assert_eq!(w.height_m(3.0, 7.5), Some(2.0));
        assert_eq!(w.height_m(3.5, 7.5), None);
        assert!(Window::empty(0..3, 0..2, 5).is_err());
        // A hole next to the four cells costs no more than the curvature there.
        let mut w = Window::empty(0..4, 0..1, 4).unwrap();
        w.height_m = vec![1.0, 2.0, 3.0, f32::NAN];
        assert_eq!(w.height_m(1.5, 0.0), Some(2.5));
        assert_eq!(w.height_m(2.5, 0.0), None);
    }

    #[test]
    fn a_hill_is_met_and_its_slope_has_no_kinks() {
        // A knoll 1 m high and 10 m wide in a raster of 1 m.
        let hill = |x: f64, y: f64| (-0.04 * (x * x + 1.5 * y * y)).exp();
        let mut w = Window::empty(0..21, 0..21, 441).unwrap();
        let cells =
            (0..441).map(|k| hill(f64::from(k % 21) - 10.0, f64::from(k / 21) - 10.0) as f32);
        w.height_m = cells.collect();
        let at = |x: f64, y: f64| w.height_m(x + 10.0, y + 10.0).unwrap();
        let mut most = 0.0f64;
        for k in 0..4000 {
            let (x, y) = (
                f64::from(k % 63) * 0.25 - 8.0,
                f64::from(k / 63) * 0.25 - 8.0,
            );
            most = most.max((at(x, y) - hill(x, y)).abs());
        }
        // Chords of its greatest curvature, 0.12/m, would miss it by 15 mm.
        assert!(most < 1.5e-3, "{most}");
        for knot in [-3.0, 0.0, 2.0] {
            let slope = |x: f64| (at(x + 1e-3, 0.4) - at(x - 1e-3, 0.4)) / 2e-3;
            assert!((slope(knot - 2e-3) - slope(knot + 2e-3)).abs() < 1e-3);
        }
        // A plane is met up to the edges.
        let plane = |x: f64, y: f64| 0.3 * x - 0.2 * y;
        let cells = (0..441).map(|k| plane(f64::from(k % 21), f64::from(k / 21)) as f32);
        w.height_m = cells.collect();
        for (x, y) in [(0.0, 0.0), (0.3, 19.9), (20.0, 0.7), (10.5, 20.0)] {
            assert!((w.height_m(x, y).unwrap() - plane(x, y)).abs() < 1e-6);
        }
    }
}
