//! The strongest points of an image.

use acerra_imaging::metrics::{ImageView, strongest_maxima};

use crate::focus::Focused;

/// Largest number of points, and their least distance (m).
const POINTS: usize = 6;
const APART_M: f64 = 1.0;

/// Local maxima looked through.
const MAXIMA: usize = 200;

/// The strongest points of the image down to `floor_db` below the first, apart from one another (m).
pub(super) fn strongest(focused: &Focused, floor_db: f64) -> Vec<[f64; 3]> {
    let grid = focused.pixels.grid;
    let Ok(view) = ImageView::new(&focused.image, grid) else {
        return Vec::new();
    };
    let mut kept: Vec<[f64; 3]> = Vec::new();
    for [x_m, y_m] in strongest_maxima(&view, floor_db, MAXIMA) {
        let is_apart = |other: &[f64; 3]| (other[0] - x_m).hypot(other[1] - y_m) >= APART_M;
        if kept.len() < POINTS && kept.iter().all(is_apart) {
            let nearest = |place: f64, from: f64, count: usize| {
                (((place - from) / grid.pixel_m).round().max(0.0) as usize).min(count - 1)
            };
            let (column, row) = (
                nearest(x_m, grid.x0_m, grid.nx),
                nearest(y_m, grid.y0_m, grid.ny),
            );
            let [_, _, z_m] = focused.pixels.place_m(row * grid.nx + column);
            kept.push([x_m, y_m, z_m]);
        }
    }
    kept
}
