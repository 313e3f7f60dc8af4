//! The method applied to single points at the strongest targets, compared with the adjoint.

use acerra_imaging::metrics::{ImageView, LocalTrack};
use acerra_imaging::psf::Cell;
use acerra_imaging::{Complex32, Complex64, Control as ImagingControl};
use acerra_invert::{
    InvertError, LinearOperator, PointResponse, SceneOperator, Weighted, point_response,
};

use super::record::ResolutionRecord;
use super::solve::{Setting, Solved, solve};
use crate::scene::pixels::Pixels;

/// Least amplitude of a target relative to the strongest.
const WEAKEST: f64 = 0.25;
/// Least distance of a target from stronger ones, in resolution cells.
const APART_CELLS: f64 = 6.0;
/// Offset of the points from the pixels' centres, in pixels: real points are off the grid.
const OFF_GRID: [f64; 2] = [0.37, 0.29];

/// Applies the method to the echoes of a point at each of the strongest targets of `image`.
pub(super) fn at_strongest(
    setting: &Setting<'_>,
    (solved, image): (&Solved, &[Complex32]),
    data: &[Complex64],
    pixels: &Pixels,
    control: ImagingControl<'_>,
) -> Result<Vec<ResolutionRecord>, InvertError> {
    let count = setting.options.parameters.resolution_points;
    let operator = setting.operator;
    let flight = operator.flight();
    let mut records = Vec::new();
    for point_m in strongest(operator, image, pixels, count) {
        let mut unit = vec![Complex64::ZERO; operator.samples()];
        flight.add_echo(point_m, Complex64::ONE, &mut unit);
        // The point is as strong as the target, since sparse methods and CLEAN are not linear.
        let norm = flight.column_norm(point_m);
        let amplitude = flight.correlate(point_m, data).norm() / (norm * norm);
        if !(amplitude > 0.0 && amplitude.is_finite()) {
            continue;
        }
        let adjoint = adjoint_of(operator, setting.weight, &unit, control)?;
        unit.iter_mut().for_each(|v| *v *= amplitude);
        let mut method = solve(setting, &unit, solved.absolute, control.silent())?.scene;
        method.iter_mut().for_each(|v| *v /= amplitude);
        records.push(ResolutionRecord {
            point_m,
            method: respond(&method, pixels, operator, point_m),
            adjoint: respond(&adjoint, pixels, operator, point_m),
        });
    }
    Ok(records)
}

/// The adjoint normalised to the reflectivity of a point: ⟨Lᵢ, d⟩/‖Lᵢ‖².
fn adjoint_of(
    operator: &SceneOperator<'_>,
    weight: &[f32],
    data: &[Complex64],
    control: ImagingControl<'_>,
) -> Result<Vec<Complex64>, InvertError> {
    let even = Weighted::new(operator, weight)?;
    let mut image = vec![Complex64::ZERO; operator.pixels()];
    even.adjoint(data, &mut image, control.silent())?;
    even.scene_from(&mut image);
    Ok(image)
}

fn respond(
    scene: &[Complex64],
    pixels: &Pixels,
    operator: &SceneOperator<'_>,
    point_m: [f64; 3],
) -> Option<PointResponse> {
    let image = narrow(scene);
    let view = match &pixels.surface {
        Some(surface) => ImageView::on_surface(&image, surface),
        None => ImageView::new(&image, pixels.grid),
    };
    point_response(&view.ok()?, operator.flight().spread(), point_m)
}

/// Places next to the strongest pixels, a few resolution cells apart (m).
fn strongest(
    operator: &SceneOperator<'_>,
    image: &[Complex32],
    pixels: &Pixels,
    count: usize,
) -> Vec<[f64; 3]> {
    let spread = operator.flight().spread();
    let mut places: Vec<([f64; 3], Cell, LocalTrack)> = Vec::new();
    let mut first = None;
    while places.len() < count {
        let is_apart = |at: [f64; 3]| {
            places.iter().all(|(place, cell, track)| {
                let off = [at[0] - place[0], at[1] - place[1]];
                let on = |axis: [f64; 2]| off[0] * axis[0] + off[1] * axis[1];
                let along = on(track.tangent) / cell.along_m;
                let across = on(track.left()) / cell.across_m;
                along.hypot(across) > APART_CELLS
            })
        };
        let mut best = (0, 0.0_f32);
        for (k, v) in image.iter().enumerate() {
            let power = v.norm_sqr();
            if power > best.1 && is_apart(pixels.place_m(k)) {
                best = (k, power);
            }
        }
        let amplitude = f64::from(best.1).sqrt();
        let most = *first.get_or_insert(amplitude);
        if amplitude <= 0.0 || amplitude < WEAKEST * most {
            break;
        }
        let mut at = pixels.place_m(best.0);
        at[0] += OFF_GRID[0] * pixels.grid.pixel_m;
        at[1] += OFF_GRID[1] * pixels.grid.pixel_m;
        let Some(track) = LocalTrack::at(spread.position_m(), at) else {
            break;
        };
        places.push((at, Cell::expected(spread, &track, at), track));
    }
    places.into_iter().map(|(at, _, _)| at).collect()
}

/// A scene in single precision.
pub(super) fn narrow(scene: &[Complex64]) -> Vec<Complex32> {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "pixels are single precision"
    )]
    let value = |v: &Complex64| Complex32::new(v.re as f32, v.im as f32);
    scene.iter().map(value).collect()
}
