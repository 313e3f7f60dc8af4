//! The part of an image that a search images over and over.
//!
//! A search scores tens or hundreds of images, so that each image can have few pixels. Over a large scene few
//! pixels would be coarser than the image of a point, and the position of a maximum between pixels would
//! change the score more than the searched setting does. Pixels therefore stay fine, and the rectangle
//! shrinks to the strongest echoes.

use acerra_imaging::metrics::{ImageView, strongest_maxima};
use acerra_imaging::{ImagingError, PlaneGrid};
use acerra_radar::Spectrum;

use crate::echoes::quick_look;
use crate::echoes::sharpen::coarse;

/// Largest pixel in wavelengths: two thirds of the width of a point seen under 60°, λ / (4 sin 30°), so
/// that a top between pixels loses little.
const PIXEL_WAVELENGTHS: f64 = 1.0 / 3.0;
/// Maxima that are used: least level relative to the greatest (dB), and largest number.
const FLOOR_DB: f64 = -12.0;
const MAXIMA: usize = 50;

/// Pixels of a single image of the whole scene over the pixels of each of the tens of images of a search, and
/// their largest number.
const LOOK_FACTOR: f64 = 20.0;
const LOOK_PIXELS: f64 = 4e6;

/// Number and spacing of the pixels of a search.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// Pixels at most of each of its images.
    pub pixels: f64,
    /// Largest side of a pixel (m).
    pub pixel_m: f64,
}

impl Budget {
    /// At most this many pixels, fine enough for echoes of this frequency.
    #[must_use]
    pub fn new(pixels: f64, middle_hz: f64, light_speed_m_s: f64) -> Self {
        Self {
            pixels,
            pixel_m: PIXEL_WAVELENGTHS * light_speed_m_s / middle_hz,
        }
    }

    /// The rectangle, or the part of it with most of `maxima_m` where pixels would be too coarse; `maxima_m`
    /// is called only where needed, on pixels of the whole rectangle.
    ///
    /// # Errors
    /// A rectangle that makes no grid, and errors of `maxima_m`.
    pub fn window<E: From<ImagingError>>(
        self,
        grid: PlaneGrid,
        maxima_m: impl FnOnce(PlaneGrid) -> Result<Vec<[f64; 2]>, E>,
    ) -> Result<PlaneGrid, E> {
        let [x_m, y_m] = bounds(grid);
        let pixel_m = self.pixel_m;
        let fine = if grid.pixel_m > pixel_m {
            PlaneGrid::from_ranges(x_m, y_m, grid.z_m, pixel_m)?
        } else {
            grid
        };
        let whole = coarse(fine, self.pixels)?;
        if whole.pixel_m <= pixel_m {
            return Ok(whole);
        }
        let sides_m = self.sides_m([x_m[1] - x_m[0], y_m[1] - y_m[0]], pixel_m);
        let look_pixels = (LOOK_FACTOR * self.pixels).min(LOOK_PIXELS);
        let at_pixel = PlaneGrid::from_ranges(x_m, y_m, grid.z_m, pixel_m)?;
        let look = coarse(at_pixel, look_pixels)?;
        let centre_m = crowded(&maxima_m(look)?, sides_m)
            .unwrap_or([x_m, y_m].map(|[from, to]| 0.5 * (from + to)));
        let x_m = within(x_m, centre_m[0], sides_m[0]);
        let y_m = within(y_m, centre_m[1], sides_m[1]);
        Ok(PlaneGrid::from_ranges(x_m, y_m, grid.z_m, pixel_m)?)
    }

    /// Sides of a square of this many pixels, or of a rectangle where the scene is narrower.
    fn sides_m(self, scene_m: [f64; 2], pixel_m: f64) -> [f64; 2] {
        let square_m = pixel_m * self.pixels.sqrt();
        let area_m2 = square_m * square_m;
        let [x_m, y_m] = scene_m;
        if x_m < square_m {
            [x_m, (area_m2 / x_m.max(pixel_m)).min(y_m)]
        } else if y_m < square_m {
            [(area_m2 / y_m.max(pixel_m)).min(x_m), y_m]
        } else {
            [square_m; 2]
        }
    }
}

/// Places (x, y) of the strongest echoes of a look on these pixels, strongest first (m).
///
/// # Errors
/// Data that the imaging operators refuse.
pub fn strongest_m(
    position_m: &[[f64; 3]],
    spectrum: &Spectrum,
    grid: PlaneGrid,
    light_speed_m_s: f64,
) -> Result<Vec<[f64; 2]>, ImagingError> {
    let image = quick_look(position_m, spectrum, grid, light_speed_m_s)?;
    let view = ImageView::new(&image, grid)?;
    Ok(strongest_maxima(&view, FLOOR_DB, MAXIMA))
}

fn bounds(grid: PlaneGrid) -> [[f64; 2]; 2] {
    [
        [grid.x0_m, grid.x_m(grid.nx.saturating_sub(1))],
        [grid.y0_m, grid.y_m(grid.ny.saturating_sub(1))],
    ]
}

/// The centre of the places within the window about one place that holds most of them; of equal windows, the
/// first.
fn crowded(places_m: &[[f64; 2]], sides_m: [f64; 2]) -> Option<[f64; 2]> {
    let inside = |centre: &[f64; 2]| -> Vec<[f64; 2]> {
        let is_in = |p: &[f64; 2]| (0..2).all(|k| (p[k] - centre[k]).abs() <= 0.5 * sides_m[k]);
        places_m.iter().copied().filter(is_in).collect()
    };
    let most = places_m
        .iter()
        .map(inside)
        .reduce(|best, own| if own.len() > best.len() { own } else { best })?;
    let middle = |k: usize| {
        let along = most.iter().map(|p| p[k]);
        let (least, largest) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| {
            (a.min(v), b.max(v))
        });
        0.5 * (least + largest)
    };
    Some([middle(0), middle(1)])
}

/// A stretch of `side_m` about a centre, moved into the scene's.
fn within([from_m, to_m]: [f64; 2], centre_m: f64, side_m: f64) -> [f64; 2] {
    let start_m = (centre_m - 0.5 * side_m).min(to_m - side_m).max(from_m);
    [start_m, (start_m + side_m).min(to_m)]
}

#[cfg(test)]
mod tests {
    use super::*;

    const BUDGET: Budget = Budget {
        pixels: 10_000.0,
        pixel_m: 0.04,
    };

    fn grid(x_m: [f64; 2], y_m: [f64; 2]) -> PlaneGrid {
        PlaneGrid::from_ranges(x_m, y_m, 0.0, 0.01).unwrap()
    }

    fn window(grid: PlaneGrid, maxima_m: &[[f64; 2]]) -> [[f64; 2]; 2] {
        let found = BUDGET.window(grid, |_| Ok::<_, ImagingError>(maxima_m.to_vec()));
        let found = found.unwrap();
        assert!(found.pixel_m <= 0.04 + 1e-12, "{found:?}");
        let count = (found.nx * found.ny) as f64;
        assert!(count < 1.1 * BUDGET.pixels, "{found:?}");
        bounds(found)
    }

    #[test]
    fn a_small_scene_is_taken_whole() {
        let scene = grid([0.0, 3.0], [-1.5, 1.5]);
        let found = window(scene, &[]);
        assert!(found[0][0].abs() < 0.02 && (found[0][1] - 3.0).abs() < 0.05);
    }

    #[test]
    fn a_large_scene_shrinks_to_where_most_strong_echoes_are() {
        let scene = grid([0.0, 40.0], [0.0, 40.0]);
        let maxima_m = [[5.0, 5.0], [30.0, 31.0], [31.0, 30.0], [32.0, 32.0]];
        let [x_m, y_m] = window(scene, &maxima_m);
        // Sides of 100 pixels of 4 cm, about the middle of the three.
        for [from, to] in [x_m, y_m] {
            assert!((to - from - 4.0).abs() < 0.1, "{from} to {to}");
            assert!((0.5 * (from + to) - 31.0).abs() < 0.1, "{from} to {to}");
        }
    }

    #[test]
    fn windows_stay_inside_the_scene_and_use_a_narrow_one_whole() {
        let [x_m, y_m] = window(grid([0.0, 40.0], [0.0, 40.0]), &[[39.9, 0.1]]);
        assert!(x_m[1] <= 40.0 + 1e-9 && x_m[0] > 35.9 && y_m[0] >= 0.0 && y_m[1] < 4.1);
        let [x_m, y_m] = window(grid([0.0, 2.0], [0.0, 40.0]), &[[1.0, 20.0]]);
        assert!(x_m[1] - x_m[0] > 1.95 && (y_m[1] - y_m[0] - 8.0).abs() < 0.1);
    }
}
