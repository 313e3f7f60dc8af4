//! Targets off the image plane: Figures 13 and 14 and Table 5.

use num_complex::Complex32;
use serde::Serialize;

use super::analysis::{expected_place_m, track_at};
use super::cell::Cell;
use super::field::PsfField;
use super::spread::PointSpread;
use crate::error::ImagingError;
use crate::grid::plane::PlaneGrid;
use crate::metrics::crest::climb_crest;
use crate::metrics::image::ImageView;

/// Below this level relative to the strongest, a target counts as absent from the image, dB.
pub const ABSENT_DB: f64 = -20.0;

/// The image of one target on a plane that need not contain the target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Retrieved {
    /// Place of the target (x, y, z), m.
    pub target_m: [f64; 3],
    /// Place of the target's image on the plane (x, y) by Eq. (14), m; `None` where the plane lies too far
    /// below the target.
    pub expected_m: Option<[f64; 2]>,
    /// Place of the maximum in the target's strip of the image (x, y), m.
    pub found_m: [f64; 2],
    /// Level of that maximum below the strongest target's, dB.
    pub level_db: f64,
    /// Whether the level is above [`ABSENT_DB`].
    pub detected: bool,
    /// Whether the image also contains the target's mirror image on the other side of the track.
    pub mirrored: bool,
}

/// Half-width along the track of the strip in which a target's image is searched, m, unless another target is
/// nearer than twice this width.
const STRIP_M: f64 = 0.5;

/// Finds the image of each of `target_m` in their common image on `grid`: the maximum in a strip across the
/// track at the target, on the target's side of the track where Eq. (14) displaces the image.
///
/// `image` is the image of the same targets on the same grid, as
/// [`psf_image`](super::psf_image) gives it.
///
/// # Errors
/// A target or plane that is not below the flight, an image that does not fill the grid, a target
/// whose strip lies outside the grid.
pub fn retrieve(
    spread: &PointSpread,
    target_m: &[[f64; 3]],
    image: &[Complex32],
    grid: PlaneGrid,
) -> Result<Vec<Retrieved>, ImagingError> {
    let view = ImageView::new(image, grid)?;
    let field = PsfField::new(spread, target_m, grid.z_m);
    let mut found = Vec::with_capacity(target_m.len());
    for (index, target) in target_m.iter().enumerate() {
        let track = track_at(spread, *target)?;
        let expected_m = expected_place_m(spread, *target, grid.z_m)?;
        let along = |p: [f64; 2]| {
            (p[0] - target[0]) * track.tangent[0] + (p[1] - target[1]) * track.tangent[1]
        };
        let left_of_track = |p: [f64; 2]| {
            (p[1] - track.closest_m[1]) * track.tangent[0]
                - (p[0] - track.closest_m[0]) * track.tangent[1]
        };
        let nearest = target_m
            .iter()
            .enumerate()
            .filter(|(other, _)| *other != index)
            .map(|(_, t)| along([t[0], t[1]]).abs())
            .filter(|gap| *gap > 0.0)
            .fold(f64::INFINITY, f64::min);
        let half_m = STRIP_M.min(0.5 * nearest);
        let side = expected_m
            .map(left_of_track)
            .filter(|s| s.abs() > grid.pixel_m);
        let start = strongest_pixel(&view, |p| {
            along(p).abs() <= half_m && side.is_none_or(|s| s * left_of_track(p) >= 0.0)
        })
        .ok_or(ImagingError::Empty {
            what: "the part of the grid about a target",
        })?;
        let cell = Cell::expected(spread, &track, *target);
        let step_m = grid.pixel_m.min(0.25 * cell.along_m);
        let (found_m, amplitude) =
            climb_crest(&field, start, step_m, track.tangent, cell).unwrap_or((start, 0.0));
        found.push(Retrieved {
            target_m: *target,
            expected_m,
            found_m,
            level_db: 20.0 * amplitude.max(f64::MIN_POSITIVE).log10(),
            detected: false,
            mirrored: side.is_some(),
        });
    }
    let strongest = found
        .iter()
        .map(|r| r.level_db)
        .fold(f64::NEG_INFINITY, f64::max);
    for r in &mut found {
        r.level_db -= strongest;
        r.detected = r.level_db > ABSENT_DB;
    }
    Ok(found)
}

fn strongest_pixel(view: &ImageView<'_>, inside: impl Fn([f64; 2]) -> bool) -> Option<[f64; 2]> {
    let grid = view.grid();
    let mut best: Option<([f64; 2], f32)> = None;
    for (k, value) in view.values().iter().enumerate() {
        let at = [grid.x_m(k % grid.nx), grid.y_m(k / grid.nx)];
        let power = value.norm_sqr();
        if best.is_none_or(|(_, highest)| power > highest) && inside(at) {
            best = Some((at, power));
        }
    }
    best.map(|(at, _)| at)
}
