//! A focused image as input of the metrics, and interpolation between its pixels.

use std::f64::consts::PI;

use num_complex::{Complex32, Complex64};

use rayon::prelude::*;

use super::field::Field;
use crate::checks::{check_finite, check_length};
use crate::error::ImagingError;
use crate::grid::plane::PlaneGrid;
use crate::grid::surface::SurfaceGrid;

/// A focused image on its grid, row-major `[ny, nx]`, row 0 at the smallest y. A magnitude image is
/// one whose imaginary parts are zero.
#[derive(Clone, Copy, Debug)]
pub struct ImageView<'a> {
    values: &'a [Complex32],
    grid: PlaneGrid,
    surface: Option<&'a SurfaceGrid>,
}

impl<'a> ImageView<'a> {
    /// A view of `values` as the image on `grid`.
    ///
    /// # Errors
    /// [`ImagingError::Length`] when the values do not fill the grid, [`ImagingError::NotFinite`]
    /// with the row-major index of a value that is no number.
    pub fn new(values: &'a [Complex32], grid: PlaneGrid) -> Result<Self, ImagingError> {
        check_length("image", grid.len(), values.len())?;
        // The index of a value that is not finite is searched only where one exists.
        let finite = |part: &[Complex32]| {
            let of = |v: &Complex32| v.re.is_finite() & v.im.is_finite();
            part.iter().fold(true, |all, v| all & of(v))
        };
        if !values.par_chunks(CHECKED_TOGETHER).all(finite) {
            check_finite(
                "image",
                values.iter().map(|v| f64::from(v.re) + f64::from(v.im)),
            )?;
        }
        Ok(Self {
            values,
            grid,
            surface: None,
        })
    }

    /// A view of `values` as the image on `surface`.
    ///
    /// # Errors
    /// As [`ImageView::new`].
    pub fn on_surface(
        values: &'a [Complex32],
        surface: &'a SurfaceGrid,
    ) -> Result<Self, ImagingError> {
        Ok(Self {
            surface: Some(surface),
            ..Self::new(values, *surface.base())?
        })
    }

    /// Height of the imaged surface at (x, y), m.
    pub fn z_m(&self, x_m: f64, y_m: f64) -> f64 {
        self.surface
            .map_or(self.grid.z_m, |surface| surface.height_m(x_m, y_m))
    }

    /// The grid.
    pub fn grid(&self) -> PlaneGrid {
        self.grid
    }

    /// The pixels, row-major `[ny, nx]`.
    pub fn values(&self) -> &'a [Complex32] {
        self.values
    }

    /// Centre (x, y) of pixel column `ix`, row `iy`, m.
    pub fn centre_m(&self, ix: usize, iy: usize) -> [f64; 2] {
        [self.grid.x_m(ix), self.grid.y_m(iy)]
    }

    pub(super) fn at(&self, ix: usize, iy: usize) -> Complex32 {
        self.values[iy * self.grid.nx + ix]
    }
}

/// Pixels that are checked together.
const CHECKED_TOGETHER: usize = 1 << 14;

/// Number of taps on either side of the interpolated place; content up to 0.6 of the pixels' Nyquist
/// frequency about the local carrier is reproduced to about −60 dB.
const HALF_TAPS: usize = 5;
const TAPS: usize = 2 * HALF_TAPS;
const KAISER_BETA: f64 = 6.0;
/// Terms of the window's power series: the next one is below a rounding error of the sum.
const KAISER_TERMS: usize = 20;

/// Band-limited interpolation between the pixels about one place of an image.
///
/// The complex image oscillates (up to four times per wavelength along track), the more so the
/// lower the flight. Interpolating its magnitude alone would blunt minima; so the carrier of the
/// neighbourhood (the phase that neighbouring pixels advance on the average) is taken out and the
/// remaining, slowly varying complex value is interpolated with a Kaiser-windowed sinc.
#[derive(Clone, Copy, Debug)]
pub struct InterpolatedImage<'a> {
    image: ImageView<'a>,
    /// Factors that remove the carrier from the pixels, from the first tap on, along x and y.
    without_carrier: [[Complex64; TAPS]; 2],
}

impl<'a> InterpolatedImage<'a> {
    /// Interpolates `image` with the carrier of the neighbourhood of (x, y) = `about_m`.
    pub fn about(image: ImageView<'a>, about_m: [f64; 2]) -> Self {
        Self {
            image,
            without_carrier: local_carrier_rad(&image, about_m).map(|advance_rad| {
                std::array::from_fn(|k| Complex64::from_polar(1.0, -advance_rad * k as f64))
            }),
        }
    }
}

impl Field for InterpolatedImage<'_> {
    fn amplitude(&self, x_m: f64, y_m: f64) -> Option<f64> {
        let grid = &self.image.grid;
        let x = taps((x_m - grid.x0_m) / grid.pixel_m, grid.nx)?;
        let y = taps((y_m - grid.y0_m) / grid.pixel_m, grid.ny)?;
        let [column_phasor, row_phasor] = self.without_carrier;
        // All rows are summed column by column first, then along the row.
        let mut column_sums = [Complex64::default(); TAPS];
        let factors = row_phasor.iter().zip(&y.weight).take(y.count);
        for (j, (phasor, weight)) in factors.enumerate() {
            let row = &self.image.values[(y.first + j) * grid.nx + x.first..][..x.count];
            let factor = phasor * *weight;
            for (sum, v) in column_sums.iter_mut().zip(row) {
                let (re, im) = (f64::from(v.re), f64::from(v.im));
                sum.re += re * factor.re - im * factor.im;
                sum.im += re * factor.im + im * factor.re;
            }
        }
        let columns = column_sums.iter().zip(column_phasor).zip(x.weight);
        let sum: Complex64 = columns.map(|((sum, phasor), w)| sum * phasor * w).sum();
        Some(sum.norm())
    }
}

struct Taps {
    first: usize,
    count: usize,
    /// Weights of the taps, zero from `count` on.
    weight: [f64; TAPS],
}

/// Weights for fractional index `at` among `n` samples; `None` outside the first and last.
fn taps(at: f64, n: usize) -> Option<Taps> {
    let last = (n - 1) as f64;
    // A point on the border may fall outside by rounding alone.
    if !(at >= -1e-9 && at <= last + 1e-9) {
        return None;
    }
    let at = at.clamp(0.0, last);
    let below = at.floor() as usize;
    let first = (below + 1).saturating_sub(HALF_TAPS);
    let count = (below + HALF_TAPS + 1).min(n) - first;
    // sin π(x − k) equals sin πx except for the sign.
    let sine = (PI * (at - below as f64)).sin() * [1.0, -1.0][(below - first) % 2];
    let (mut inside, mut sinc) = ([0.0; TAPS], [0.0; TAPS]);
    for k in 0..TAPS {
        let t = at - (first + k) as f64;
        inside[k] = (1.0 - (t / HALF_TAPS as f64).powi(2)).max(0.0);
        let alternating = if k % 2 == 0 { sine } else { -sine };
        sinc[k] = if t.abs() < 1e-12 {
            1.0
        } else {
            alternating / (PI * t)
        };
    }
    let mut weight = kaiser(inside);
    for k in 0..TAPS {
        weight[k] *= if k < count && inside[k] > 0.0 {
            sinc[k]
        } else {
            0.0
        };
    }
    let total: f64 = weight.iter().sum();
    for w in &mut weight {
        *w /= total;
    }
    Some(Taps {
        first,
        count,
        weight,
    })
}

/// The Kaiser window I₀(β√u)/I₀(β) at places of a squared distance 1 − `u` from its middle.
fn kaiser(u: [f64; TAPS]) -> [f64; TAPS] {
    const SERIES: [f64; KAISER_TERMS] = kaiser_series();
    let mut value = [SERIES[KAISER_TERMS - 1]; TAPS];
    for coefficient in SERIES[..KAISER_TERMS - 1].iter().rev() {
        for (value, u) in value.iter_mut().zip(u) {
            *value = *value * u + coefficient;
        }
    }
    value
}

/// Coefficients of I₀(β√u)/I₀(β) in powers of u: (β²/4)^k/(k!)², divided by their sum.
const fn kaiser_series() -> [f64; KAISER_TERMS] {
    let mut term = [1.0; KAISER_TERMS];
    let mut sum = 1.0;
    let mut k = 1;
    while k < KAISER_TERMS {
        term[k] = term[k - 1] * 0.25 * KAISER_BETA * KAISER_BETA / (k * k) as f64;
        sum += term[k];
        k += 1;
    }
    k = 0;
    while k < KAISER_TERMS {
        term[k] /= sum;
        k += 1;
    }
    term
}

/// Mean phase advance per pixel (the argument of the lag-one autocorrelation) over a
/// neighbourhood of ±8 pixels.
fn local_carrier_rad(image: &ImageView<'_>, about_m: [f64; 2]) -> [f64; 2] {
    const REACH: usize = 8;
    let grid = &image.grid;
    let index = |at: f64, start: f64, n: usize| {
        (((at - start) / grid.pixel_m).round().max(0.0) as usize).min(n - 1)
    };
    let cx = index(about_m[0], grid.x0_m, grid.nx);
    let cy = index(about_m[1], grid.y0_m, grid.ny);
    let (mut sum_x, mut sum_y) = (Complex64::default(), Complex64::default());
    let wide = |v: Complex32| Complex64::new(f64::from(v.re), f64::from(v.im));
    for iy in cy.saturating_sub(REACH)..=(cy + REACH).min(grid.ny - 1) {
        for ix in cx.saturating_sub(REACH)..=(cx + REACH).min(grid.nx - 1) {
            let here = wide(image.at(ix, iy)).conj();
            if ix + 1 < grid.nx {
                sum_x += here * wide(image.at(ix + 1, iy));
            }
            if iy + 1 < grid.ny {
                sum_y += here * wide(image.at(ix, iy + 1));
            }
        }
    }
    [sum_x.arg(), sum_y.arg()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// A Gaussian spot on a carrier of 0.35 cycles a pixel: interpolated amplitude must follow the envelope,
    /// which interpolation of the magnitude could not at the pixel's edge.
    #[test]
    fn follows_a_modulated_spot_between_pixels() {
        let (nx, ny, pixel) = (64, 48, 0.01);
        let spot = |x: f64, y: f64| {
            let envelope = (-((x - 0.313) / 0.05).powi(2) - ((y - 0.227) / 0.04).powi(2)).exp();
            Complex64::from_polar(envelope, TAU * (35.0 * x - 20.0 * y))
        };
        let values: Vec<Complex32> = (0..nx * ny)
            .map(|k| {
                let v = spot((k % nx) as f64 * pixel, (k / nx) as f64 * pixel);
                Complex32::new(v.re as f32, v.im as f32)
            })
            .collect();
        let grid = PlaneGrid::new([0.0, 0.0, 0.0], pixel, [nx, ny]).unwrap();
        let view = ImageView::new(&values, grid).unwrap();
        let field = InterpolatedImage::about(view, [0.31, 0.22]);
        for k in 0..200 {
            let (x, y) = (0.2 + 0.001 * k as f64, 0.15 + 0.0007 * k as f64);
            let found = field.amplitude(x, y).unwrap();
            assert!((found - spot(x, y).norm()).abs() < 1e-3, "{x} {y}: {found}");
        }
        let (place, level) = super::super::climb_to_peak(&field, [0.31, 0.23], pixel).unwrap();
        assert!(
            (place[0] - 0.313).abs() < 1e-4 && (place[1] - 0.227).abs() < 1e-4,
            "{place:?}"
        );
        assert!((level - 1.0).abs() < 1e-3);
    }

    /// The window by the integral of I₀, whose trapezoidal rule converges to a rounding error.
    #[test]
    fn weights_are_those_of_a_kaiser_windowed_sinc() {
        let bessel_i0 = |x: f64| {
            let points = (0..64).map(|k| (x * (TAU * f64::from(k) / 64.0).cos()).exp());
            points.sum::<f64>() / 64.0
        };
        for at in [0.0, 0.3, 4.0, 4.5, 7.25, 12.999_999, 13.0, 18.7, 19.0] {
            let found = taps(at, 20).unwrap();
            let expected: Vec<f64> = (0..found.count)
                .map(|k| {
                    let t = at - (found.first + k) as f64;
                    let sinc = if t == 0.0 {
                        1.0
                    } else {
                        (PI * t).sin() / (PI * t)
                    };
                    let inside = (1.0 - (t / HALF_TAPS as f64).powi(2)).max(0.0);
                    sinc * bessel_i0(KAISER_BETA * inside.sqrt())
                })
                .collect();
            let total: f64 = expected.iter().sum();
            for (found, expected) in found.weight.iter().zip(&expected) {
                assert!((found - expected / total).abs() < 1e-14, "{at}: {found}");
            }
            assert!(found.weight[found.count..].iter().all(|w| *w == 0.0));
        }
    }

    #[test]
    fn outside_is_unknown_and_one_row_is_enough() {
        let values = vec![Complex32::new(1.0, 0.0); 16];
        let view = ImageView::new(
            &values,
            PlaneGrid::new([0.0, 0.0, 0.0], 0.1, [16, 1]).unwrap(),
        )
        .unwrap();
        let field = InterpolatedImage::about(view, [0.5, 0.0]);
        assert!((field.amplitude(0.77, 0.0).unwrap() - 1.0).abs() < 1e-12);
        assert!(field.amplitude(1.6, 0.0).is_none());
        assert!(field.amplitude(0.5, 0.01).is_none());
    }

    #[test]
    fn refuses_what_is_no_image() {
        let values = vec![Complex32::new(1.0, 0.0); 6];
        let grid = |nx| PlaneGrid::new([0.0, 0.0, 0.0], 0.1, [nx, 2]).unwrap();
        assert!(matches!(
            ImageView::new(&values, grid(4)),
            Err(ImagingError::Length {
                expected: 8,
                found: 6,
                ..
            })
        ));
        let mut bad = values.clone();
        bad[4] = Complex32::new(f32::NAN, 0.0);
        assert!(matches!(
            ImageView::new(&bad, grid(3)),
            Err(ImagingError::NotFinite { index: 4, .. })
        ));
    }
}
