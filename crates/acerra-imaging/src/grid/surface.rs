//! Uneven ground: columns and rows evenly spaced, a height for every pixel.

use super::axis_weights::AxisWeights;
use super::plane::{DEFAULT_IMAGE_LIMIT_BYTES, PlaneGrid, check_pixels};
use super::tilted::TiltedGrid;
use crate::checks::{check_finite, check_length};
use crate::error::ImagingError;
use crate::vector::range_m;
use rayon::prelude::*;

/// A surface over a horizontal rectangle: pixel (i, j) is at (x_i, y_j, z_ij). Images on it are
/// `[ny, nx]` row-major, row 0 at the smallest y.
///
/// Heights are held in single precision about their middle: to 30 µm over 500 m of relief.
///
/// ```
/// use acerra_imaging::{PlaneGrid, SurfaceGrid};
/// let base = PlaneGrid::from_ranges([0.0, 4.0], [0.0, 2.0], 0.0, 0.5)?;
/// let surface = SurfaceGrid::from_fn(base, |x_m, y_m| Ok::<_, acerra_imaging::ImagingError>(0.1 * x_m + y_m))?;
/// let [x_m, y_m, z_m] = surface.point_m(9 + 2);
/// assert!((x_m, y_m) == (1.0, 0.5) && (z_m - 0.6).abs() < 1e-6);
/// # Ok::<(), acerra_imaging::ImagingError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceGrid {
    base: PlaneGrid,
    relief_m: Vec<f32>,
    span_m: [f64; 2],
}

impl SurfaceGrid {
    /// The surface with the heights `z_m` `[ny, nx]` over the columns and rows of `base`, whose own
    /// height is not used.
    ///
    /// # Errors
    /// The number of heights differs from that of pixels, or a height is not finite.
    pub fn new(base: PlaneGrid, z_m: &[f64]) -> Result<Self, ImagingError> {
        check_length("z_m", base.len(), z_m.len())?;
        check_finite("z_m", z_m.iter().copied())?;
        let mut heights = z_m.iter().copied();
        Self::from_fn(base, |_, _| Ok(heights.next().unwrap_or(0.0)))
    }

    /// The surface whose height at (x, y) is `z_m(x, y)`, called row by row.
    ///
    /// # Errors
    /// Whatever `z_m` returns; a height that is not finite; more memory than an image may take.
    pub fn from_fn<E: From<ImagingError>>(
        base: PlaneGrid,
        mut z_m: impl FnMut(f64, f64) -> Result<f64, E>,
    ) -> Result<Self, E> {
        check_pixels(base.nx as u128, base.ny as u128, DEFAULT_IMAGE_LIMIT_BYTES)?;
        let mut relief_m = Vec::with_capacity(base.len());
        let mut datum_m = 0.0;
        for j in 0..base.ny {
            for i in 0..base.nx {
                let z = z_m(base.x_m(i), base.y_m(j))?;
                if !z.is_finite() {
                    return Err(ImagingError::NotFinite {
                        what: "z_m",
                        index: relief_m.len(),
                    }
                    .into());
                }
                // Heights count from the first one until the middle is known.
                if relief_m.is_empty() {
                    datum_m = z;
                }
                relief_m.push((z - datum_m) as f32);
            }
        }
        Ok(Self::about_middle(base, datum_m, relief_m))
    }

    /// As [`Self::from_fn`], with heights that several threads may compute at a time. Of several errors the
    /// first one in the order of the rows is returned.
    ///
    /// ```
    /// use acerra_imaging::{ImagingError, PlaneGrid, SurfaceGrid};
    /// let base = PlaneGrid::from_ranges([0.0, 4.0], [0.0, 2.0], 0.0, 0.5)?;
    /// let slope = |x_m: f64, y_m: f64| Ok::<_, ImagingError>(0.1 * x_m + y_m);
    /// assert_eq!(SurfaceGrid::in_parallel(base, slope)?, SurfaceGrid::from_fn(base, slope)?);
    /// # Ok::<(), ImagingError>(())
    /// ```
    ///
    /// # Errors
    /// As [`SurfaceGrid::from_fn`].
    pub fn in_parallel<E: From<ImagingError> + Send>(
        base: PlaneGrid,
        z_m: impl Fn(f64, f64) -> Result<f64, E> + Sync,
    ) -> Result<Self, E> {
        check_pixels(base.nx as u128, base.ny as u128, DEFAULT_IMAGE_LIMIT_BYTES)?;
        let finite = |i: usize, j: usize| {
            let z = z_m(base.x_m(i), base.y_m(j))?;
            if z.is_finite() {
                return Ok(z);
            }
            Err(E::from(ImagingError::NotFinite {
                what: "z_m",
                index: j * base.nx + i,
            }))
        };
        let datum_m = finite(0, 0)?;
        let mut relief_m = vec![0f32; base.nx * base.ny];
        let rows: Vec<Result<(), E>> = relief_m
            .par_chunks_mut(base.nx)
            .enumerate()
            .map(|(j, row)| {
                for (i, height) in row.iter_mut().enumerate() {
                    *height = (finite(i, j)? - datum_m) as f32;
                }
                Ok(())
            })
            .collect();
        rows.into_iter().collect::<Result<(), E>>()?;
        Ok(Self::about_middle(base, datum_m, relief_m))
    }

    /// The surface of heights above a datum, counted from their middle.
    fn about_middle(base: PlaneGrid, datum_m: f64, mut relief_m: Vec<f32>) -> Self {
        let [low, high] = extremes(&relief_m);
        let middle = f64::from((0.5 * (low + high)) as f32);
        for r in &mut relief_m {
            *r = (f64::from(*r) - middle) as f32;
        }
        let [low, high] = extremes(&relief_m);
        let datum_m = datum_m + middle;
        Self {
            base: PlaneGrid {
                z_m: datum_m,
                ..base
            },
            relief_m,
            span_m: [datum_m + low, datum_m + high],
        }
    }

    /// The grid of columns and rows, at the middle of the surface's heights.
    #[must_use]
    pub fn base(&self) -> &PlaneGrid {
        &self.base
    }

    /// Least and greatest height, m.
    #[must_use]
    pub fn span_m(&self) -> [f64; 2] {
        self.span_m
    }

    /// Number of pixels.
    #[must_use]
    #[allow(clippy::len_without_is_empty)] // never empty
    pub fn len(&self) -> usize {
        self.relief_m.len()
    }

    /// Height of pixel `index` of the row-major image, m.
    #[must_use]
    pub fn z_m(&self, index: usize) -> f64 {
        self.base.z_m + f64::from(self.relief_m[index])
    }

    /// The point of pixel `index` of the row-major image, `[x, y, z]` in metres.
    #[must_use]
    pub fn point_m(&self, index: usize) -> [f64; 3] {
        let [x, y, _] = self.base.point_m(index);
        [x, y, self.z_m(index)]
    }

    /// Height at (x, y), bilinear between pixels and continued level beyond the edge, m.
    #[must_use]
    pub fn height_m(&self, x_m: f64, y_m: f64) -> f64 {
        let place = |at: f64, start: f64, count: usize| {
            let t = ((at - start) / self.base.pixel_m).clamp(0.0, (count - 1) as f64);
            let first = (t as usize).min(count.saturating_sub(2));
            (first, (first + 1).min(count - 1), t - first as f64)
        };
        let (i, i1, u) = place(x_m, self.base.x0_m, self.base.nx);
        let (j, j1, v) = place(y_m, self.base.y0_m, self.base.ny);
        let z = |i: usize, j: usize| self.z_m(j * self.base.nx + i);
        let low = z(i, j) + u * (z(i1, j) - z(i, j));
        let high = z(i, j1) + u * (z(i1, j1) - z(i, j1));
        low + v * (high - low)
    }

    /// Height above [`SurfaceGrid::base`] at (x, y): cubic between pixels, with continuous slopes, and reflected at
    /// the last pixels beyond them, so that slopes continue, m.
    pub(crate) fn smooth_relief_m(&self, x_m: f64, y_m: f64) -> f64 {
        let columns = self.column_weights(x_m);
        let of_row = |j: usize| columns.of(&self.relief_m[j * self.base.nx..][..self.base.nx]);
        let rows = self.row_weights(y_m);
        rows.taken().map(|(j, w)| w * of_row(j)).sum()
    }

    /// Column and row of the pixel nearest to (x, y).
    fn nearest(&self, x_m: f64, y_m: f64) -> [usize; 2] {
        let g = &self.base;
        let at = |t: f64, count: usize| (t.round().max(0.0) as usize).min(count - 1);
        [
            at((x_m - g.x0_m) / g.pixel_m, g.nx),
            at((y_m - g.y0_m) / g.pixel_m, g.ny),
        ]
    }

    /// Height of the pixel nearest to (x, y) above [`SurfaceGrid::base`], m.
    pub(crate) fn nearest_relief_m(&self, x_m: f64, y_m: f64) -> f64 {
        let [i, j] = self.nearest(x_m, y_m);
        f64::from(self.relief_m[j * self.base.nx + i])
    }

    /// Slopes along x and y at the pixel nearest to (x, y), between its neighbours.
    pub(crate) fn nearest_slopes(&self, x_m: f64, y_m: f64) -> [f64; 2] {
        let ([i, j], g) = (self.nearest(x_m, y_m), &self.base);
        let height = |i: usize, j: usize| f64::from(self.relief_m[j * g.nx + i]);
        let slope = |k: usize, count: usize, height: &dyn Fn(usize) -> f64| {
            let (before, after) = (k.saturating_sub(1), (k + 1).min(count - 1));
            match after - before {
                0 => 0.0,
                steps => (height(after) - height(before)) / (steps as f64 * g.pixel_m),
            }
        };
        [
            slope(i, g.nx, &|i| height(i, j)),
            slope(j, g.ny, &|j| height(i, j)),
        ]
    }

    /// Weights of the columns for heights at x.
    pub(crate) fn column_weights(&self, x_m: f64) -> AxisWeights {
        AxisWeights::at((x_m - self.base.x0_m) / self.base.pixel_m, self.base.nx)
    }

    /// Weights of the rows for heights at y.
    pub(crate) fn row_weights(&self, y_m: f64) -> AxisWeights {
        AxisWeights::at((y_m - self.base.y0_m) / self.base.pixel_m, self.base.ny)
    }

    /// Fills `line` with the heights of all columns above [`SurfaceGrid::base`] (m), weighted over the rows.
    pub(crate) fn weigh_rows(&self, rows: &AxisWeights, line: &mut Vec<f64>) {
        line.clear();
        line.resize(self.base.nx, 0.0);
        for (j, weight) in rows.taken() {
            let row = &self.relief_m[j * self.base.nx..][..self.base.nx];
            for (sum, height) in line.iter_mut().zip(row) {
                *sum += weight * f64::from(*height);
            }
        }
    }

    /// Heights above [`SurfaceGrid::base`], `[ny, nx]`, m.
    pub(crate) fn relief_m(&self) -> &[f32] {
        &self.relief_m
    }

    /// Bounds of the ranges from `antenna_m` to the surface widened by `margin` columns.
    pub(crate) fn ranges_m(&self, antenna_m: [f64; 3], margin: f64) -> [f64; 2] {
        Self::ranges_over(&self.base.into(), self.span_m, antenna_m, margin)
    }

    /// Bounds of the ranges from `antenna_m` to heights `span_m` over a grid on the base, widened by `margin`
    /// columns.
    pub(crate) fn ranges_over(
        grid: &TiltedGrid,
        span_m: [f64; 2],
        antenna_m: [f64; 3],
        margin: f64,
    ) -> [f64; 2] {
        let [x0, y0, _] = grid.point_m(-margin, 0.0);
        let [x1, y1, _] = grid.point_m((grid.columns - 1) as f64 + margin, (grid.rows - 1) as f64);
        let sides = [[x0, x1], [y0, y1], span_m];
        let corner = |pick: fn(f64, [f64; 2]) -> f64| -> [f64; 3] {
            std::array::from_fn(|a| pick(antenna_m[a], sides[a]))
        };
        let nearest = corner(|p, [low, high]| p.clamp(low, high));
        let farthest = corner(|p, [low, high]| {
            if (p - low).abs() > (p - high).abs() {
                low
            } else {
                high
            }
        });
        [nearest, farthest].map(|c| range_m(c, antenna_m))
    }

    /// The pixel centre that an antenna is on exactly, if any, as row-major index.
    pub(crate) fn pixel_at(&self, antenna_m: [f64; 3]) -> Option<usize> {
        let grid = TiltedGrid::from(self.base);
        let at = grid.pixel_at([antenna_m[0], antenna_m[1], self.base.z_m])?;
        (self.point_m(at) == antenna_m).then_some(at)
    }
}

fn extremes(values: &[f32]) -> [f64; 2] {
    let low = values.iter().copied().fold(f32::INFINITY, f32::min);
    let high = values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    [f64::from(low), f64::from(high)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hill() -> SurfaceGrid {
        let base = PlaneGrid::new([-1.0, 2.0, 50.0], 0.25, [9, 5]).unwrap();
        SurfaceGrid::from_fn(base, |x, y| Ok::<_, ImagingError>(100.0 + x * x - 0.5 * y)).unwrap()
    }

    #[test]
    fn every_pixel_has_its_height() {
        let s = hill();
        assert_eq!(s.len(), 45);
        for k in 0..45 {
            let [x, y, z] = s.point_m(k);
            assert!((z - (100.0 + x * x - 0.5 * y)).abs() < 1e-6);
            assert!((s.span_m()[0]..=s.span_m()[1]).contains(&z));
        }
        assert!((s.height_m(-0.875, 2.0) - (100.0 + 0.5 * (1.0 + 0.5625) - 1.0)).abs() < 1e-6);
        assert_eq!(s.height_m(-99.0, 2.0), s.z_m(0));
    }

    #[test]
    fn ranges_enclose_the_surface() {
        let s = hill();
        for antenna in [[0.0, 2.5, 103.0], [5.0, -3.0, 100.2], [0.25, 2.5, 98.7]] {
            let [least, most] = s.ranges_m(antenna, 0.0);
            for k in 0..s.len() {
                let r = range_m(s.point_m(k), antenna);
                assert!(least <= r && r <= most);
            }
        }
    }

    #[test]
    fn impossible_surfaces_are_refused() {
        let base = PlaneGrid::new([0.0, 0.0, 0.0], 1.0, [2, 2]).unwrap();
        assert!(matches!(
            SurfaceGrid::new(base, &[0.0; 3]),
            Err(ImagingError::Length { expected: 4, .. })
        ));
        assert_eq!(
            SurfaceGrid::new(base, &[0.0, 1.0, f64::NAN, 0.0]).unwrap_err(),
            ImagingError::NotFinite {
                what: "z_m",
                index: 2
            }
        );
        // The first error in the order of the rows, whichever thread finds another one first.
        let holes = |x: f64, y: f64| {
            let is_hole = (x, y) == (1.0, 0.0) || (x, y) == (0.0, 1.0);
            Ok::<_, ImagingError>(if is_hole { f64::NAN } else { 0.0 })
        };
        for _ in 0..20 {
            assert_eq!(
                SurfaceGrid::in_parallel(base, holes).unwrap_err(),
                ImagingError::NotFinite {
                    what: "z_m",
                    index: 1
                }
            );
        }
        let one = PlaneGrid::new([0.0, 0.0, 0.0], 1.0, [1, 1]).unwrap();
        let one = SurfaceGrid::new(one, &[3.0]).unwrap();
        assert_eq!(one.height_m(5.0, 5.0), 3.0);
        assert_eq!(one.pixel_at([0.0, 0.0, 3.0]), Some(0));
        assert_eq!(one.pixel_at([0.0, 0.0, 2.0]), None);
    }
}
