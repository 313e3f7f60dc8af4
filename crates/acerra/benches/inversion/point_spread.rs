//! Figure 7: a point 5 m below a straight and a curved track, at nadir and 2 m beside.

use acerra_chain::Pixels;
use acerra_imaging::PlaneGrid;
use acerra_imaging::psf::{TrackShape, synthetic_track};

use crate::scene::{Scene, Simulated, Target};

/// Pixel (m): the paper has half of it, at four times the time.
const PIXEL_M: f64 = 0.02;
/// Half the side of the square of ground (m).
const HALF_M: f64 = 3.0;
/// The point stands beside a pixel's centre, in pixels.
const OFF_GRID: [f64; 2] = [0.37, 0.29];

/// Panels a to d of the figure, and f; e is the mirror image of c.
pub fn scenes() -> Vec<Scene> {
    let curved = |amplitude_m| TrackShape::Cosine {
        amplitude_m,
        period_m: 24.0,
    };
    let panels = [
        ("a: straight, d 0", TrackShape::Straight, 0.0),
        ("b: straight, d 2", TrackShape::Straight, 2.0),
        ("c: +cos, d 0", curved(0.15), 0.0),
        ("d: +cos, d 2", curved(0.15), 2.0),
        ("f: −cos, d 2", curved(-0.15), 2.0),
    ];
    panels
        .map(|(name, shape, offset_m)| scene(name, shape, offset_m))
        .into()
}

fn scene(name: &str, shape: TrackShape, offset_m: f64) -> Scene {
    let [x_m, y_m] = OFF_GRID.map(|share| share * PIXEL_M);
    let place_m = [x_m, offset_m + y_m, 0.0];
    let simulated = Simulated {
        tracks_m: vec![synthetic_track(shape, 3.0, 0.01, 5.0).unwrap()],
        light_speed_m_s: 3e8,
        points_m: vec![place_m],
        noise_db: -40.0,
    };
    let side = [-HALF_M, HALF_M];
    let grid = PlaneGrid::from_ranges(side, side, 0.0, PIXEL_M).unwrap();
    let mut scene = simulated.scene(name, Pixels::plane(grid));
    scene.targets = vec![Target {
        name: String::new(),
        place_m,
    }];
    scene
}
