//! Heights on a regular grid of latitude and longitude.

use super::GeoidError;

/// Heights of the geoid above the ellipsoid lie within these bounds (m).
const HEIGHTS_M: std::ops::RangeInclusive<f64> = -150.0..=150.0;

/// Least step of a grid (degrees): a metre on the ground, a thousandth of the finest published.
const LEAST_STEP_DEG: f64 = 1e-5;

/// Heights of a geoid above the WGS84 ellipsoid on a regular grid.
#[derive(Clone, PartialEq)]
pub struct GeoidGrid {
    /// Latitude of the first row and step to the next (degrees, towards the north).
    south_deg: f64,
    latitude_step_deg: f64,
    /// Longitude of the first column and step to the next (degrees, towards the east).
    west_deg: f64,
    longitude_step_deg: f64,
    columns: usize,
    /// Whether the columns go around the Earth.
    around: bool,
    /// Rows from south to north (m).
    heights_m: Vec<f32>,
}

impl std::fmt::Debug for GeoidGrid {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("GeoidGrid")
            .field("rows", &self.rows())
            .field("columns", &self.columns)
            .finish_non_exhaustive()
    }
}

/// The edges and steps of a grid (degrees).
pub(super) struct Layout {
    pub south: f64,
    pub west: f64,
    /// Of latitude and longitude.
    pub steps: [f64; 2],
    pub rows: usize,
    pub columns: usize,
}

impl GeoidGrid {
    pub(super) fn new(
        layout: &Layout,
        heights_m: Vec<f32>,
        format: &'static str,
    ) -> Result<Self, GeoidError> {
        let wrong = |expected: &str, found: String| GeoidError::Format {
            format,
            expected: expected.to_owned(),
            found,
        };
        let [latitude_step_deg, longitude_step_deg] = layout.steps;
        let north = layout.south + latitude_step_deg * (layout.rows - 1) as f64;
        let sane = layout.rows >= 2
            && layout.columns >= 2
            && latitude_step_deg >= LEAST_STEP_DEG
            && longitude_step_deg >= LEAST_STEP_DEG
            && layout.south >= -90.001
            && north <= 90.001
            && layout.west.abs() <= 360.0
            && longitude_step_deg * (layout.columns - 1) as f64 <= 360.001;
        if !sane {
            let found = format!(
                "{} × {} from {}° {}° by {latitude_step_deg}° {longitude_step_deg}°",
                layout.rows, layout.columns, layout.south, layout.west
            );
            return Err(wrong("rows and columns on the Earth", found));
        }
        if let Some(bad) = heights_m
            .iter()
            .find(|h| !HEIGHTS_M.contains(&f64::from(**h)))
        {
            return Err(wrong("heights within ±150 m", format!("{bad} m")));
        }
        let width_deg = longitude_step_deg * layout.columns as f64;
        Ok(Self {
            south_deg: layout.south,
            latitude_step_deg,
            west_deg: layout.west,
            longitude_step_deg,
            columns: layout.columns,
            around: width_deg > 359.999,
            heights_m,
        })
    }

    /// Rows of the grid, from south to north.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.heights_m.len() / self.columns
    }

    /// Columns of the grid, from west to east.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// South-western corner: latitude and longitude (degrees).
    #[must_use]
    pub fn south_west_deg(&self) -> [f64; 2] {
        [self.south_deg, self.west_deg]
    }

    /// Steps of latitude and longitude (degrees).
    #[must_use]
    pub fn steps_deg(&self) -> [f64; 2] {
        [self.latitude_step_deg, self.longitude_step_deg]
    }

    /// Lowest and highest height (m).
    #[must_use]
    pub fn range_m(&self) -> [f64; 2] {
        let ends = [f64::INFINITY, f64::NEG_INFINITY];
        self.heights_m.iter().fold(ends, |[low, high], h| {
            [low.min(f64::from(*h)), high.max(f64::from(*h))]
        })
    }

    /// Height of the geoid above the ellipsoid (m), bilinear between the grid's points; `None`
    /// outside the grid and where a coordinate is not a number.
    #[must_use]
    pub fn height_m(&self, latitude_deg: f64, longitude_deg: f64) -> Option<f64> {
        if !longitude_deg.is_finite() {
            return None;
        }
        let y = (latitude_deg - self.south_deg) / self.latitude_step_deg;
        let x = (longitude_deg - self.west_deg).rem_euclid(360.0) / self.longitude_step_deg;
        let last_row = (self.rows() - 1) as f64;
        // Roundoff at the very edges.
        let y = if y > -1e-9 && y < last_row + 1e-9 {
            y.clamp(0.0, last_row)
        } else {
            return None;
        };
        let (row, column) = (y.floor() as usize, x.floor() as usize);
        let next_row = (row + 1).min(self.rows() - 1);
        let next_column = if column + 1 < self.columns {
            column + 1
        } else if self.around {
            0
        } else if column + 1 == self.columns && x.fract() < 1e-9 {
            column
        } else {
            return None;
        };
        let at = |row: usize, column: usize| {
            let index = row * self.columns + column % self.columns;
            self.heights_m.get(index).copied().map(f64::from)
        };
        let (dy, dx) = (y - row as f64, x - column as f64);
        let south = at(row, column)? * (1.0 - dx) + at(row, next_column)? * dx;
        let north = at(next_row, column)? * (1.0 - dx) + at(next_row, next_column)? * dx;
        Some(south * (1.0 - dy) + north * dy)
    }
}

/// Rows turned around, so that they go from south to north.
pub(super) fn northwards(heights_m: &[f32], columns: usize) -> Vec<f32> {
    heights_m.chunks(columns).rev().flatten().copied().collect()
}
