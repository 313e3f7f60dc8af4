//! Power of the strongest echo of an image: the coherent sum over the pulses that observe a point is largest
//! for correct ranges.
//!
//! Unlike the contrast of the whole image, a maximum does not grow where a target overlaps with its ghost or
//! where its lobe widens towards the track: no pixel can sum more than the energy of the pulses.

use acerra_imaging::metrics::{ImageView, strongest_maxima};
use acerra_imaging::{Complex32, ImagingError, PlaneGrid};

/// Number of maxima compared between pixels: the greatest on the pixels need not be the greatest between
/// pixels.
const COMPARED: usize = 6;
/// Level of these maxima relative to the greatest, at least (dB).
const FLOOR_DB: f64 = -3.0;

/// Logarithm of the smallest power.
const NO_POWER: f64 = -708.0;

/// The strongest echo of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StrongestEcho {
    /// Logarithm of the power.
    pub log_power: f64,
    /// The pixel nearest to the maximum (x, y), m; `None` in an empty image.
    pub place_m: Option<[f64; 2]>,
}

impl StrongestEcho {
    /// No echo.
    pub const NONE: Self = Self {
        log_power: NO_POWER,
        place_m: None,
    };

    /// The strongest echo of `image`.
    ///
    /// # Errors
    /// An image of another size than its grid.
    pub fn of(image: &[Complex32], grid: PlaneGrid) -> Result<Self, ImagingError> {
        let view = ImageView::new(image, grid)?;
        let maxima = strongest_maxima(&view, FLOOR_DB, COMPARED);
        let powers = maxima.iter().map(|p| (top_power(image, grid, *p), *p));
        let top = powers.max_by(|a, b| a.0.total_cmp(&b.0));
        Ok(top.map_or(Self::NONE, |(power, place_m)| Self {
            log_power: power.ln().max(NO_POWER),
            place_m: Some(place_m),
        }))
    }
}

/// The power of a maximum between its pixels: the top of parabolas through the logarithms of its
/// neighbours' powers, along x and y.
fn top_power(image: &[Complex32], grid: PlaneGrid, [x_m, y_m]: [f64; 2]) -> f64 {
    let ix = ((x_m - grid.x0_m) / grid.pixel_m).round() as usize;
    let iy = ((y_m - grid.y0_m) / grid.pixel_m).round() as usize;
    let log = |ix: usize, iy: usize| -> Option<f64> {
        let is_inside = ix < grid.nx && iy < grid.ny;
        let value = is_inside.then(|| f64::from(image[iy * grid.nx + ix].norm_sqr()))?;
        (value > 0.0).then(|| value.ln())
    };
    let Some(here) = log(ix, iy) else {
        return 0.0;
    };
    let rise = |before: Option<f64>, after: Option<f64>| {
        let (Some(before), Some(after)) = (before, after) else {
            return 0.0;
        };
        let curvature = before - 2.0 * here + after;
        if curvature < 0.0 {
            -(after - before).powi(2) / (8.0 * curvature)
        } else {
            0.0
        }
    };
    let left = ix.checked_sub(1).and_then(|ix| log(ix, iy));
    let below = iy.checked_sub(1).and_then(|iy| log(ix, iy));
    (here + rise(left, log(ix + 1, iy)) + rise(below, log(ix, iy + 1))).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of unit power at places (m), each a Gaussian lobe `width_m` wide (m), on pixels of 2.5 cm.
    fn image_of(points_m: &[[f64; 2]], width_m: f64) -> (Vec<Complex32>, PlaneGrid) {
        let grid = PlaneGrid::from_ranges([0.0, 6.0], [0.0, 4.0], 0.0, 0.025).unwrap();
        let at = |k: usize| {
            let (x_m, y_m) = (grid.x_m(k % grid.nx), grid.y_m(k / grid.nx));
            let lobe = |p: &[f64; 2]| {
                (-((p[0] - x_m).powi(2) + (p[1] - y_m).powi(2)) / (2.0 * width_m * width_m)).exp()
            };
            Complex32::new(points_m.iter().map(lobe).sum::<f64>() as f32, 0.0)
        };
        ((0..grid.len()).map(at).collect(), grid)
    }

    #[test]
    fn tops_between_pixels_count_in_full_and_wide_lobes_no_more() {
        for (place_m, width_m) in [
            ([2.0125, 1.0125], 0.04),
            ([2.0, 1.0], 0.04),
            ([1.0, 1.0], 0.3),
        ] {
            let (image, grid) = image_of(&[place_m, [4.0, 3.0]], width_m);
            let log = StrongestEcho::of(&image, grid).unwrap().log_power;
            assert!(log.abs() < 0.01, "{log} at {place_m:?}");
        }
    }

    #[test]
    fn an_empty_image_has_an_echo_of_no_power() {
        let (image, grid) = image_of(&[], 0.04);
        let none = StrongestEcho::of(&image, grid).unwrap();
        assert!(none.log_power < -500.0 && none.place_m.is_none());
    }
}
