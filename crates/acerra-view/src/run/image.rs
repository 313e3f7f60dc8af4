//! The image of a run in memory.

use std::path::Path;

use acerra_imaging::PlaneGrid;
use acerra_products::data::read_image;
use num_complex::Complex32;
use serde::Serialize;

use crate::error::ViewError;
use crate::raster::Field;

/// Most columns and rows of the heights of a terrain that is drawn.
const TERRAIN_NODES: usize = 256;

/// Heights of the ground under an image.
#[derive(Debug, Serialize)]
pub struct Terrain {
    /// Pixels from one height to the next, the first at pixel 0.
    pub stride: usize,
    /// Heights along x.
    pub columns: usize,
    /// Heights along y.
    pub rows: usize,
    /// Row-major, row 0 at the smallest y (m).
    pub height_m: Vec<f64>,
}

/// The image of a run.
#[derive(Debug)]
pub struct RunImage {
    /// Columns and rows; at the plane's height, or the mean of uneven ground.
    pub grid: PlaneGrid,
    /// Row-major, row 0 at the smallest y.
    pub values: Vec<Complex32>,
    /// Heights of uneven ground above that of the grid (m), one a pixel; empty on a plane.
    relief_m: Vec<f32>,
}

impl Field for RunImage {
    fn size(&self) -> [usize; 2] {
        [self.grid.nx, self.grid.ny]
    }
    fn at(&self, column: usize, row: usize) -> Complex32 {
        self.values[row * self.grid.nx + column]
    }
}

impl RunImage {
    /// Reads `image.npz`.
    ///
    /// # Errors
    /// A file that is absent or broken, axes that are not even.
    pub fn read(path: &Path) -> Result<Self, ViewError> {
        let contents = read_image(path).map_err(|cause| ViewError::Product {
            path: path.to_owned(),
            cause,
        })?;
        let pixel_m = contents.pixel_m();
        let at = |axis: &'static str, values: &[f64]| {
            even(values, pixel_m).map_err(|found| ViewError::Grid {
                path: path.to_owned(),
                axis,
                found,
            })
        };
        let (x0_m, y0_m) = (at("x_m", &contents.x_m)?, at("y_m", &contents.y_m)?);
        let count = contents.z_m.len() as f64;
        let z_m = contents.z_m.iter().sum::<f64>() / count;
        #[expect(clippy::cast_possible_truncation, reason = "heights about their mean")]
        let relief_m = if contents.z_m.len() == 1 {
            Vec::new()
        } else {
            contents.z_m.iter().map(|z| (z - z_m) as f32).collect()
        };
        let size = [contents.x_m.len(), contents.y_m.len()];
        let grid =
            PlaneGrid::new([x0_m, y0_m, z_m], pixel_m, size).map_err(|error| ViewError::Grid {
                path: path.to_owned(),
                axis: "image",
                found: error.to_string(),
            })?;
        Ok(Self {
            grid,
            values: contents.values.into_owned(),
            relief_m,
        })
    }

    /// Whether the pixels are on uneven ground.
    #[must_use]
    pub fn is_uneven(&self) -> bool {
        !self.relief_m.is_empty()
    }

    /// Heights of the ground at every n-th column and row; none on a plane.
    #[must_use]
    pub fn terrain(&self) -> Option<Terrain> {
        let [nx, ny] = [self.grid.nx, self.grid.ny];
        let stride = nx.max(ny).div_ceil(TERRAIN_NODES).max(1);
        let (columns, rows) = (nx.div_ceil(stride), ny.div_ceil(stride));
        let height = |k: usize| {
            let place = (k / columns) * stride * nx + (k % columns) * stride;
            self.grid.z_m + f64::from(self.relief_m[place])
        };
        self.is_uneven().then(|| Terrain {
            stride,
            columns,
            rows,
            height_m: (0..columns * rows).map(height).collect(),
        })
    }

    /// Column and row of the pixel nearest to (x, y); none outside the image.
    #[must_use]
    pub fn pixel_at(&self, x_m: f64, y_m: f64) -> Option<[usize; 2]> {
        let grid = &self.grid;
        let index = |v_m: f64, first_m: f64, n: usize| {
            let k = ((v_m - first_m) / grid.pixel_m).round();
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "within the image"
            )]
            (k >= 0.0 && k < n as f64).then_some(k as usize)
        };
        Some([
            index(x_m, grid.x0_m, grid.nx)?,
            index(y_m, grid.y0_m, grid.ny)?,
        ])
    }

    /// Height of the pixel nearest to (x, y), of the plane outside the image (m).
    #[must_use]
    pub fn height_m(&self, x_m: f64, y_m: f64) -> f64 {
        let relief = self
            .pixel_at(x_m, y_m)
            .and_then(|[i, j]| self.relief_m.get(j * self.grid.nx + i));
        self.grid.z_m + relief.map_or(0.0, |r| f64::from(*r))
    }
}

/// The first of evenly spaced values.
pub(super) fn even(values: &[f64], step: f64) -> Result<f64, String> {
    let first = *values.first().ok_or("none")?;
    let is_even = |(k, v): (usize, &f64)| (v - first - k as f64 * step).abs() <= 1e-3 * step;
    match values.iter().enumerate().find(|one| !is_even(*one)) {
        None if step > 0.0 && first.is_finite() => Ok(first),
        None => Err(format!("pixels of {step} m from {first} m")),
        Some((k, v)) => Err(format!("{v} m at pixel {k}")),
    }
}
