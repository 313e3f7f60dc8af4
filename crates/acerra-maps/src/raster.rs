//! The values of a map, rows from south to north as in images.

use num_complex::Complex32;

use crate::error::MapError;

/// Pixels of an image, row-major `[ny, nx]`, row 0 at the smallest y.
#[derive(Clone, Copy, Debug)]
pub struct Raster<'a> {
    pub(crate) values: Values<'a>,
    pub(crate) nx: usize,
    pub(crate) ny: usize,
}

/// Reference of the levels, and the lowest that has data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelScale {
    /// The level written as 0 dB, in dB against power 1.
    pub zero_db: f64,
    /// The lowest level that is written, against `zero_db` (dB).
    pub floor_db: f64,
}

impl LevelScale {
    /// Levels relative to power 1, without a floor.
    pub const ABSOLUTE: Self = Self {
        zero_db: 0.0,
        floor_db: f64::NEG_INFINITY,
    };
}

/// Content of the pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Values<'a> {
    Power(&'a [f32]),
    Level(&'a [f32], LevelScale),
    Complex(&'a [Complex32]),
}

impl<'a> Raster<'a> {
    /// Powers, linear; overviews hold means. Values that are not finite have no data.
    #[must_use]
    pub fn power(values: &'a [f32], nx: usize, ny: usize) -> Self {
        Self::new(Values::Power(values), nx, ny)
    }

    /// Powers, written as levels in dB; overviews hold the level of the mean power. Zero, values that are not
    /// finite, and levels below the floor of `scale` have no data.
    #[must_use]
    pub fn level_db(power: &'a [f32], nx: usize, ny: usize, scale: LevelScale) -> Self {
        Self::new(Values::Level(power, scale), nx, ny)
    }

    /// Complex amplitudes; overviews hold one pixel out of four, as means would cancel.
    #[must_use]
    pub fn complex(values: &'a [Complex32], nx: usize, ny: usize) -> Self {
        Self::new(Values::Complex(values), nx, ny)
    }

    fn new(values: Values<'a>, nx: usize, ny: usize) -> Self {
        Self { values, nx, ny }
    }

    pub(crate) fn check(&self) -> Result<(), MapError> {
        let found = match self.values {
            Values::Power(v) | Values::Level(v, _) => v.len(),
            Values::Complex(v) => v.len(),
        };
        let expected = self.nx * self.ny;
        if found == expected && expected > 0 {
            Ok(())
        } else {
            Err(MapError::Pixels { expected, found })
        }
    }
}
