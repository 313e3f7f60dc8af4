//! The values of an image and their levels.

use num_complex::Complex32;

/// The values of an image, row-major `[ny, nx]`.
#[derive(Clone, Copy, Debug)]
pub enum PixelValues<'a> {
    /// Complex amplitudes; the modulus is shown.
    Complex(&'a [Complex32]),
    /// Amplitudes; the modulus is shown.
    Amplitude(&'a [f32]),
    /// Levels that are in decibels already, shown below their maximum.
    Decibel(&'a [f32]),
}

impl PixelValues<'_> {
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Complex(v) => v.len(),
            Self::Amplitude(v) | Self::Decibel(v) => v.len(),
        }
    }

    /// A number that rises with the level of one pixel and is cheap to compute for every pixel; NaN where
    /// there is no finite value.
    pub(super) fn strength(&self, index: usize) -> f64 {
        let strength = match self {
            Self::Complex(v) => {
                let (re, im) = (f64::from(v[index].re), f64::from(v[index].im));
                re * re + im * im
            }
            Self::Amplitude(v) => f64::from(v[index]).powi(2),
            Self::Decibel(v) => f64::from(v[index]),
        };
        if strength == f64::INFINITY {
            f64::NAN
        } else {
            strength
        }
    }

    /// Level, in dB against amplitude 1, of a [`strength`](Self::strength); −∞ for
    /// zero, NaN where there is no value.
    pub(super) fn level_db(&self, strength: f64) -> f64 {
        match self {
            Self::Complex(_) | Self::Amplitude(_) => 10.0 * strength.log10(),
            Self::Decibel(_) => strength,
        }
    }
}
