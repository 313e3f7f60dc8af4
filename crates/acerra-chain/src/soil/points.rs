//! Points below the surface in an image.

use acerra_imaging::metrics::{ImageView, strongest_maxima};
use acerra_imaging::{Complex32, PlaneGrid};

use crate::focus::Focused;
use crate::focus::underground::Underground;
use crate::scene::Ground;

/// Points at most.
const POINTS: usize = 6;
/// Points weaker than this relative to the strongest are left out (dB).
const FLOOR_DB: f64 = -20.0;
/// Local maxima looked through.
const MAXIMA: usize = 200;
/// Cells of distance from a stronger point from which a point is separate.
const APART_CELLS: f64 = 4.0;

/// Places of the strongest points of a volume at least `least_depth_m` below the surface, apart from one another, strongest first (m). `cell_m` is the resolution cell of the range in air. In a vertical section
/// all maxima are used, in a volume the maxima of its view from above.
pub(crate) fn buried_points(
    focused: &Focused,
    underground: &Underground,
    scene_ground: &Ground,
    cell_m: f64,
    least_depth_m: f64,
) -> Vec<[f64; 3]> {
    let Some(projections) = &focused.projections else {
        return Vec::new();
    };
    let volume = &projections.volume;
    let base = volume.base;
    let candidates: Vec<[f64; 3]> = if base.ny == 1 {
        let section: Vec<Complex32> = (projections.front.iter())
            .map(|v| Complex32::new(*v, 0.0))
            .collect();
        // Rows are heights, in steps of a pixel.
        let grid = PlaneGrid {
            y0_m: 0.0,
            ny: volume.nz,
            ..base
        };
        let height_m = |y_m: f64| base.z_m + volume.step_m * (y_m / base.pixel_m);
        maxima(&section, grid)
            .into_iter()
            .map(|[x_m, y_m]| [x_m, base.y0_m, height_m(y_m)])
            .collect()
    } else {
        let nearest = |at: f64, from: f64, count: usize| {
            (((at - from) / base.pixel_m).round().max(0.0) as usize).min(count - 1)
        };
        maxima(&focused.image, base)
            .into_iter()
            .map(|[x_m, y_m]| {
                let column = nearest(x_m, base.x0_m, base.nx);
                let row = nearest(y_m, base.y0_m, base.ny);
                let [_, _, z_m] = focused.pixels.place_m(row * base.nx + column);
                [x_m, y_m, z_m]
            })
            .collect()
    };
    let top = underground.layers.first();
    let index = top.map_or(1.0, |layer| {
        layer.soil.relative_permittivity.max(1.0).sqrt()
    });
    let surface_m = |place: &[f64; 3]| match underground.is_uneven {
        true => scene_ground.below_m(place[0], place[1]),
        false => underground.surface_z_m,
    };
    let is_inside = |place: &[f64; 3]| {
        let top_m = base.z_m + volume.step_m * volume.nz.saturating_sub(1) as f64;
        place[2] > base.z_m && place[2] < top_m
    };
    let mut kept: Vec<[f64; 3]> = Vec::new();
    for place in candidates {
        let is_deep = surface_m(&place) - place[2] >= least_depth_m;
        let is_apart = |other: &[f64; 3]| {
            let away: f64 = (0..3).map(|axis| (place[axis] - other[axis]).powi(2)).sum();
            away.sqrt() >= APART_CELLS * cell_m / index
        };
        if kept.len() < POINTS && is_deep && is_inside(&place) && kept.iter().all(is_apart) {
            kept.push(place);
        }
    }
    kept
}

fn maxima(image: &[Complex32], grid: PlaneGrid) -> Vec<[f64; 2]> {
    ImageView::new(image, grid).map_or_else(
        |_| Vec::new(),
        |view| strongest_maxima(&view, FLOOR_DB, MAXIMA),
    )
}
