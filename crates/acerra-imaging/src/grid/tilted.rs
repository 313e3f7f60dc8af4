//! Parallelograms of evenly spaced pixels: planes at any height and tilt.

use super::plane::{DEFAULT_IMAGE_LIMIT_BYTES, PlaneGrid, check_pixels};
use crate::checks::{check_finite, check_places};
use crate::error::ImagingError;
use crate::vector::{dot, norm, range_m};

/// A parallelogram of pixels in space: pixel (i, j) is at `origin_m + i·u_m + j·v_m`, i along
/// the row. Images on it are `[rows, columns]` row-major.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TiltedGrid {
    /// Centre of pixel (0, 0), m.
    pub origin_m: [f64; 3],
    /// Step from one column to the next, m.
    pub u_m: [f64; 3],
    /// Step from one row to the next, m.
    pub v_m: [f64; 3],
    /// Pixels in a row.
    pub columns: usize,
    /// Number of rows.
    pub rows: usize,
}

impl TiltedGrid {
    /// Checks and makes a grid.
    ///
    /// # Errors
    /// No pixels, steps of no length, values that are not finite, or an image too large.
    pub fn new(
        origin_m: [f64; 3],
        u_m: [f64; 3],
        v_m: [f64; 3],
        columns: usize,
        rows: usize,
    ) -> Result<Self, ImagingError> {
        check_finite("grid", origin_m.into_iter().chain(u_m).chain(v_m))?;
        if columns == 0 || rows == 0 {
            return Err(ImagingError::Empty { what: "grid" });
        }
        for (what, step, count) in [("u_m", u_m, columns), ("v_m", v_m, rows)] {
            let length = norm(step);
            if length <= 0.0 && count > 1 {
                return Err(ImagingError::OutOfRange {
                    what,
                    expected: "a step of some length",
                    found: length,
                });
            }
        }
        check_pixels(columns as u128, rows as u128, DEFAULT_IMAGE_LIMIT_BYTES)?;
        let grid = Self {
            origin_m,
            u_m,
            v_m,
            columns,
            rows,
        };
        let [i, j] = [columns, rows].map(|count| (count - 1) as f64);
        let corners = [[0.0, 0.0], [i, 0.0], [0.0, j], [i, j]].map(|[i, j]| grid.point_m(i, j));
        check_places("grid", &corners)?;
        Ok(grid)
    }

    /// Centre of pixel (i, j), m.
    #[must_use]
    pub fn point_m(&self, i: f64, j: f64) -> [f64; 3] {
        std::array::from_fn(|axis| self.origin_m[axis] + i * self.u_m[axis] + j * self.v_m[axis])
    }

    /// The part of `rows` rows from row `first` on.
    pub(crate) fn rows_from(&self, first: usize, rows: usize) -> Self {
        Self {
            origin_m: self.point_m(0.0, first as f64),
            rows,
            ..*self
        }
    }

    /// Least and greatest range from `antenna_m` to the grid widened by `margin` columns either way.
    pub(crate) fn ranges_m(&self, antenna_m: [f64; 3], margin: f64) -> [f64; 2] {
        let (i0, i1) = (-margin, (self.columns - 1) as f64 + margin);
        let j1 = (self.rows - 1) as f64;
        let distance = |i: f64, j: f64| range_m(self.point_m(i, j), antenna_m);
        let corners = [
            distance(i0, 0.0),
            distance(i1, 0.0),
            distance(i0, j1),
            distance(i1, j1),
        ];
        let (i, j) = self.nearest(antenna_m, [i0, i1], [0.0, j1]);
        let least = corners.iter().copied().fold(distance(i, j), f64::min);
        [least, corners.into_iter().fold(0.0, f64::max)]
    }

    /// The point of the parallelogram i × j nearest to `antenna_m`, in pixels.
    pub(crate) fn nearest(&self, antenna_m: [f64; 3], i: [f64; 2], j: [f64; 2]) -> (f64, f64) {
        let d: [f64; 3] = std::array::from_fn(|axis| antenna_m[axis] - self.origin_m[axis]);
        let (uu, uv, vv) = (
            dot(self.u_m, self.u_m),
            dot(self.u_m, self.v_m),
            dot(self.v_m, self.v_m),
        );
        let (du, dv) = (dot(d, self.u_m), dot(d, self.v_m));
        let along = |num: f64, den: f64, r: [f64; 2]| {
            if den > 0.0 {
                (num / den).clamp(r[0], r[1])
            } else {
                r[0]
            }
        };
        let determinant = uu * vv - uv * uv;
        if determinant > 1e-12 * uu * vv {
            let (a, b) = (
                (du * vv - dv * uv) / determinant,
                (dv * uu - du * uv) / determinant,
            );
            if (i[0]..=i[1]).contains(&a) && (j[0]..=j[1]).contains(&b) {
                return (a, b);
            }
        }
        // Otherwise the nearest point lies on an edge.
        let candidates = [
            (along(du - j[0] * uv, uu, i), j[0]),
            (along(du - j[1] * uv, uu, i), j[1]),
            (i[0], along(dv - i[0] * uv, vv, j)),
            (i[1], along(dv - i[1] * uv, vv, j)),
        ];
        let distance = |p: &(f64, f64)| range_m(self.point_m(p.0, p.1), antenna_m);
        candidates
            .into_iter()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
            .unwrap_or((i[0], j[0]))
    }

    /// The pixel centre that an antenna is on exactly, if any, as row-major index.
    pub(crate) fn pixel_at(&self, antenna_m: [f64; 3]) -> Option<usize> {
        let (i1, j1) = ((self.columns - 1) as f64, (self.rows - 1) as f64);
        let (i, j) = self.nearest(antenna_m, [0.0, i1], [0.0, j1]);
        for (i, j) in [(i.floor(), j.floor()), (i.ceil(), j.floor())]
            .into_iter()
            .chain([(i.floor(), j.ceil()), (i.ceil(), j.ceil())])
        {
            if self.point_m(i, j) == antenna_m {
                return Some(j as usize * self.columns + i as usize);
            }
        }
        None
    }
}

impl From<PlaneGrid> for TiltedGrid {
    fn from(g: PlaneGrid) -> Self {
        Self {
            origin_m: [g.x0_m, g.y0_m, g.z_m],
            u_m: [g.pixel_m, 0.0, 0.0],
            v_m: [0.0, g.pixel_m, 0.0],
            columns: g.nx,
            rows: g.ny,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_enclose_all_pixels() {
        let grids = [
            PlaneGrid::new([-1.0, 2.0, 0.5], 0.1, [30, 20])
                .unwrap()
                .into(),
            TiltedGrid::new([0.0; 3], [0.1, 0.05, 0.1], [0.05, 0.2, 0.0], 15, 25).unwrap(),
            TiltedGrid::new([0.0; 3], [0.1, 0.0, 0.0], [0.0; 3], 15, 1).unwrap(),
        ];
        for grid in grids {
            for antenna in [
                [0.3, 2.5, 4.0],
                [-5.0, 0.0, 1.0],
                [0.5, 3.0, 0.5],
                [0.7, 0.0, 0.0],
            ] {
                let [least, most] = grid.ranges_m(antenna, 0.0);
                let mut found = [f64::INFINITY, 0.0f64];
                for j in 0..grid.rows {
                    for i in 0..grid.columns {
                        let r = range_m(grid.point_m(i as f64, j as f64), antenna);
                        found = [found[0].min(r), found[1].max(r)];
                    }
                }
                assert!(least <= found[0] + 1e-12 && (most - found[1]).abs() < 1e-12);
                assert!(found[0] - least < 0.15, "{least} {found:?}");
            }
        }
    }

    #[test]
    fn an_antenna_on_a_pixel_is_found() {
        let grid: TiltedGrid = PlaneGrid::new([0.0, 0.0, 0.5], 0.25, [8, 8])
            .unwrap()
            .into();
        assert_eq!(grid.pixel_at([0.5, 0.25, 0.5]), Some(10));
        assert_eq!(grid.pixel_at([0.5, 0.25, 0.4]), None);
        assert_eq!(grid.pixel_at([0.51, 0.25, 0.5]), None);
        assert_eq!(grid.pixel_at([-1.0, 0.0, 0.5]), None);
    }
}
