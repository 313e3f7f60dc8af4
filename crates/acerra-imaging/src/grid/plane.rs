//! Horizontal rectangles of square pixels.

use crate::checks::{check_finite, check_pixel, check_places};
use crate::error::ImagingError;

/// Largest image that a grid accepts by default: 64 GiB of complex single precision.
pub const DEFAULT_IMAGE_LIMIT_BYTES: u128 = 64 << 30;

const BYTES_PER_PIXEL: u128 = size_of::<num_complex::Complex32>() as u128;

/// A horizontal rectangle of square pixels; images on it are `[ny, nx]` row-major, row 0 at the
/// smallest y.
///
/// ```
/// use acerra_imaging::PlaneGrid;
/// let grid = PlaneGrid::from_ranges([0.0, 18.0], [-9.0, 9.0], 0.0, 0.01)?;
/// assert_eq!((grid.nx, grid.ny), (1801, 1801)); // the end falls on a pixel and is kept
/// assert!((grid.x_m(1800) - 18.0).abs() < 1e-9);
/// # Ok::<(), acerra_imaging::ImagingError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneGrid {
    /// Centre of the first column, m.
    pub x0_m: f64,
    /// Centre of the first row, m.
    pub y0_m: f64,
    /// Height of the plane, m.
    pub z_m: f64,
    /// Distance of neighbouring pixel centres, m.
    pub pixel_m: f64,
    /// Pixels along x.
    pub nx: usize,
    /// Pixels along y.
    pub ny: usize,
}

impl PlaneGrid {
    /// A grid of `size` = `[nx, ny]` pixels, `pixel_m` apart, whose first centre is at
    /// `origin_m` = `[x, y, z]`.
    ///
    /// # Errors
    /// A side of no pixels, a pixel that is not positive, a corner that is not finite or farther than 1e8 m, or an
    /// image above [`DEFAULT_IMAGE_LIMIT_BYTES`].
    pub fn new(origin_m: [f64; 3], pixel_m: f64, size: [usize; 2]) -> Result<Self, ImagingError> {
        let ([x0_m, y0_m, z_m], [nx, ny]) = (origin_m, size);
        check_pixel("pixel_m", pixel_m)?;
        if nx == 0 || ny == 0 {
            return Err(ImagingError::Empty { what: "grid" });
        }
        let grid = Self {
            x0_m,
            y0_m,
            z_m,
            pixel_m,
            nx,
            ny,
        };
        grid.check_limit(DEFAULT_IMAGE_LIMIT_BYTES)?;
        check_places(
            "grid",
            [&origin_m, &[grid.x_m(nx - 1), grid.y_m(ny - 1), z_m]],
        )?;
        Ok(grid)
    }

    /// Pixel centres at `x[0], x[0] + pixel, …` up to and including `x[1]` where it falls on one
    /// (within 10⁻⁶ of a pixel), and likewise along y.
    ///
    /// # Errors
    /// As [`PlaneGrid::new`], and a range whose end lies before its start.
    pub fn from_ranges(
        x_m: [f64; 2],
        y_m: [f64; 2],
        z_m: f64,
        pixel_m: f64,
    ) -> Result<Self, ImagingError> {
        check_finite("grid", [x_m[0], x_m[1], y_m[0], y_m[1]].into_iter())?;
        check_pixel("pixel_m", pixel_m)?;
        let count = |what, [start, end]: [f64; 2]| {
            if end < start {
                return Err(ImagingError::OutOfRange {
                    what,
                    expected: "an end not before the start",
                    found: end,
                });
            }
            // The count may exceed every memory: the limit check below reports the bytes.
            let steps = ((end - start) / pixel_m + 1e-6).floor();
            Ok(if steps < 1e18 {
                steps as u128 + 1
            } else {
                1 << 60
            })
        };
        let (nx, ny) = (count("x_m", x_m)?, count("y_m", y_m)?);
        check_pixels(nx, ny, DEFAULT_IMAGE_LIMIT_BYTES)?;
        Self::new([x_m[0], y_m[0], z_m], pixel_m, [nx as usize, ny as usize])
    }

    /// Refuses an image of more than `limit_bytes` (one complex single-precision value a pixel).
    ///
    /// # Errors
    /// [`ImagingError::TooLarge`] with the bytes needed.
    pub fn check_limit(&self, limit_bytes: u128) -> Result<(), ImagingError> {
        check_pixels(self.nx as u128, self.ny as u128, limit_bytes)
    }

    /// Number of pixels.
    #[must_use]
    #[allow(clippy::len_without_is_empty)] // never empty
    pub fn len(&self) -> usize {
        self.nx * self.ny
    }

    /// Centre of column `i`, m.
    #[must_use]
    pub fn x_m(&self, i: usize) -> f64 {
        self.x0_m + i as f64 * self.pixel_m
    }

    /// Centre of row `j`, m.
    #[must_use]
    pub fn y_m(&self, j: usize) -> f64 {
        self.y0_m + j as f64 * self.pixel_m
    }

    /// The point of pixel `index` of the row-major image, `[x, y, z]` in metres.
    #[must_use]
    pub fn point_m(&self, index: usize) -> [f64; 3] {
        [
            self.x_m(index % self.nx),
            self.y_m(index / self.nx),
            self.z_m,
        ]
    }

    /// All points, row-major.
    pub fn points_m(&self) -> impl ExactSizeIterator<Item = [f64; 3]> + '_ {
        (0..self.len()).map(|k| self.point_m(k))
    }
}

pub(crate) fn check_pixels(nx: u128, ny: u128, limit_bytes: u128) -> Result<(), ImagingError> {
    let bytes = nx.saturating_mul(ny).saturating_mul(BYTES_PER_PIXEL);
    if bytes > limit_bytes {
        return Err(ImagingError::TooLarge {
            what: "the image",
            bytes,
            limit_bytes,
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_beyond_any_flight_are_refused() {
        let size = [2, 2];
        for x_m in [1e18, -1e300, f64::MAX, f64::NAN, f64::INFINITY] {
            assert!(PlaneGrid::new([x_m, 0.0, 0.0], 0.1, size).is_err(), "{x_m}");
            assert!(PlaneGrid::new([0.0, 0.0, x_m], 0.1, size).is_err(), "{x_m}");
            let side = [x_m, x_m + 1.0];
            assert!(PlaneGrid::from_ranges(side, [0.0, 1.0], 0.0, 0.1).is_err());
        }
        for pixel_m in [0.0, -0.1, 1e-307, f64::MIN_POSITIVE, 1e300, f64::NAN] {
            assert!(
                PlaneGrid::new([0.0; 3], pixel_m, size).is_err(),
                "{pixel_m}"
            );
        }
        assert!(PlaneGrid::new([9.9e7, 0.0, 0.0], 1e6, size).is_ok());
        assert!(PlaneGrid::new([9.9e7, 0.0, 0.0], 1e6, [3, 1]).is_err());
    }

    #[test]
    fn ends_are_kept_where_they_fall_on_a_pixel() {
        let g = PlaneGrid::from_ranges([0.0, 0.3], [0.0, 0.25], 1.0, 0.1).unwrap();
        assert_eq!((g.nx, g.ny), (4, 3));
        assert_eq!(g.point_m(5), [0.1, 0.1, 1.0]);
        let line = PlaneGrid::from_ranges([2.0, 2.0], [0.0, 1.0], 0.0, 0.5).unwrap();
        assert_eq!((line.nx, line.ny), (1, 3));
    }

    #[test]
    fn impossible_grids_are_refused() {
        assert!(PlaneGrid::from_ranges([1.0, 0.0], [0.0, 1.0], 0.0, 0.1).is_err());
        assert!(PlaneGrid::from_ranges([0.0, 1.0], [0.0, 1.0], 0.0, 0.0).is_err());
        assert!(PlaneGrid::from_ranges([0.0, 1.0], [0.0, 1.0], f64::NAN, 0.1).is_err());
        match PlaneGrid::from_ranges([0.0, 1e6], [0.0, 1e6], 0.0, 0.01) {
            Err(ImagingError::TooLarge { bytes, .. }) => {
                assert_eq!(bytes, 100_000_001_u128.pow(2) * 8);
            }
            other => panic!("{other:?}"),
        }
        assert!(PlaneGrid::from_ranges([0.0, 1e300], [0.0, 1e300], 0.0, 1e-9).is_err());
    }
}
