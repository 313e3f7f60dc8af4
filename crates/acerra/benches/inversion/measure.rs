//! What an image shows of a point: widths, place, artefacts, ghost.

use acerra_imaging::metrics::{ImageView, InterpolatedImage, LocalTrack, climb_to_peak};
use acerra_imaging::psf::PointSpread;
use acerra_imaging::{Complex32, PlaneGrid};
use acerra_invert::{PointResponse, point_response};

use crate::scene::Scene;

/// An image is measured this far from a target along x (m), clear of the next one.
const STRIP_M: f64 = 3.0;
/// A ghost is looked for this far from the mirrored place, across the track (m).
const GHOST_M: f64 = 0.7;
/// A target's spot is looked for this far from its place (m).
const NEAR_M: f64 = 0.7;
/// Ghosts below this are zeros of a sparse scene, dB.
const NOTHING_DB: f64 = -100.0;

pub struct Measured {
    /// About the peak nearest to the target.
    pub response: Option<PointResponse>,
    /// Horizontal distance of that peak from the target (m).
    pub off_m: Option<f64>,
    /// Greatest amplitude about the mirrored place over that about the target; none at nadir.
    pub ghost_db: Option<f64>,
}

/// Measures the image of the scene's target `index`.
pub fn measure(scene: &Scene, image: &[Complex32], index: usize) -> Measured {
    let place_m = scene.targets[index].place_m;
    let strip_m = [place_m[0] - STRIP_M, place_m[0] + STRIP_M];
    let everywhere = [f64::NEG_INFINITY, f64::INFINITY];
    let (values, grid) = crop(image, scene.pixels.grid, strip_m, everywhere);
    let position_m = scene.aligned.position_m.clone();
    let frequency_hz = scene.spectrum.frequency_hz.clone();
    let spread = PointSpread::new(position_m, None, frequency_hz, scene.light_speed_m_s).unwrap();
    let view = ImageView::new(&values, grid).unwrap();
    let peak_m = peak_near(&view, place_m);
    let at_peak = |[x_m, y_m]: [f64; 2]| point_response(&view, &spread, [x_m, y_m, place_m[2]]);
    Measured {
        response: peak_m.and_then(at_peak),
        off_m: peak_m.map(|[x_m, y_m]| (x_m - place_m[0]).hypot(y_m - place_m[1])),
        ghost_db: ghost_db(&values, grid, place_m, mirrored_m(scene, index)),
    }
}

/// The peak of the strongest spot near `place_m` (m).
fn peak_near(view: &ImageView<'_>, place_m: [f64; 3]) -> Option<[f64; 2]> {
    let grid = view.grid();
    let is_near = |k: &usize| {
        let at_m = grid.point_m(*k);
        (at_m[0] - place_m[0]).hypot(at_m[1] - place_m[1]) < NEAR_M
    };
    let power = |k: &usize| view.values()[*k].norm_sqr();
    let strongest = (0..view.values().len())
        .filter(is_near)
        .max_by(|a, b| power(a).total_cmp(&power(b)))?;
    let [x_m, y_m, _] = grid.point_m(strongest);
    let start_m = [x_m, y_m];
    let field = InterpolatedImage::about(*view, start_m);
    climb_to_peak(&field, start_m, grid.pixel_m).map(|(peak_m, _)| peak_m)
}

/// Where a level straight track would show the ghost of target `index` (m).
pub fn mirrored_m(scene: &Scene, index: usize) -> [f64; 2] {
    let place_m = scene.targets[index].place_m;
    let track = LocalTrack::at(&scene.aligned.position_m, place_m).unwrap();
    let left = track.left();
    [0, 1].map(|axis| place_m[axis] - 2.0 * track.offset_m * left[axis])
}

fn ghost_db(
    values: &[Complex32],
    grid: PlaneGrid,
    place_m: [f64; 3],
    mirrored_m: [f64; 2],
) -> Option<f64> {
    if (place_m[1] - mirrored_m[1]).abs() < 2.0 * GHOST_M {
        return None;
    }
    let about = |y_m: f64| {
        (0..values.len())
            .filter(|k| (grid.point_m(*k)[1] - y_m).abs() < GHOST_M)
            .map(|k| f64::from(values[k].norm()))
            .fold(f64::MIN_POSITIVE, f64::max)
    };
    let level_db = 20.0 * (about(mirrored_m[1]) / about(place_m[1])).log10();
    (level_db > NOTHING_DB).then_some(level_db)
}

/// The pixels of an image between these coordinates.
pub fn crop(
    image: &[Complex32],
    grid: PlaneGrid,
    x_m: [f64; 2],
    y_m: [f64; 2],
) -> (Vec<Complex32>, PlaneGrid) {
    let within = |[from, to]: [f64; 2], v: f64| from <= v && v <= to;
    let columns: Vec<usize> = (0..grid.nx).filter(|i| within(x_m, grid.x_m(*i))).collect();
    let rows: Vec<usize> = (0..grid.ny).filter(|j| within(y_m, grid.y_m(*j))).collect();
    let row_values = |j: &usize| {
        columns
            .iter()
            .map(move |i| image[j * grid.nx + i])
            .collect::<Vec<_>>()
    };
    let values = rows.iter().flat_map(row_values).collect();
    let part = PlaneGrid {
        x0_m: grid.x_m(columns[0]),
        y0_m: grid.y_m(rows[0]),
        nx: columns.len(),
        ny: rows.len(),
        ..grid
    };
    (values, part)
}
