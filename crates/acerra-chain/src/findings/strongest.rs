//! The strongest points of an image.

use acerra_imaging::metrics::{ImageView, strongest_maxima};

use crate::focus::Focused;
use crate::prepare::Prepared;

/// Points at most, and how far apart (m).
const POINTS: usize = 6;
const APART_M: f64 = 1.0;

/// Local maxima looked through.
const MAXIMA: usize = 200;

/// The strongest points of the image down to `floor_db` below the first, apart from one another (m).
pub(super) fn strongest(prepared: &Prepared, focused: &Focused, floor_db: f64) -> Vec<[f64; 3]> {
    let grid = focused.pixels.grid;
    let Ok(view) = ImageView::new(&focused.image, grid) else {
        return Vec::new();
    };
    let mut kept: Vec<[f64; 3]> = Vec::new();
    for [x_m, y_m] in strongest_maxima(&view, floor_db, MAXIMA) {
        let is_apart = |other: &[f64; 3]| (other[0] - x_m).hypot(other[1] - y_m) >= APART_M;
        if kept.len() < POINTS && kept.iter().all(is_apart) {
            let z_m = match &focused.pixels.surface {
                Some(_) => prepared.scene.ground.below_m(x_m, y_m),
                None => grid.z_m,
            };
            kept.push([x_m, y_m, z_m]);
        }
    }
    kept
}
