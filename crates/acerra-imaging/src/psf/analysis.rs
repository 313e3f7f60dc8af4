//! Analysis of the image of one point: place, widths, sidelobes, ghost.

use serde::Serialize;

use super::cell::Cell;
use super::field::PsfField;
use super::spread::PointSpread;
use crate::checks::check_places;
use crate::error::ImagingError;
use crate::metrics::crest::climb_crest;
use crate::metrics::field::Field;
use crate::metrics::ghost::find_ghost;
use crate::metrics::shape::measure_shape;
use crate::metrics::target::{AcrossTrack, AlongTrack, Ghost};
use crate::metrics::track::LocalTrack;
use crate::resolution::equations::displacement_m;

/// Resolution at the same place by the theory of a straight track, m.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Theory {
    /// Along-track resolution: Eq. (6) with the angles that the flight spans.
    pub along_m: f64,
    /// Range resolution: Eq. (8).
    pub range_m: f64,
    /// Across-track resolution: Eq. (9) at the local height and offset.
    pub across_m: f64,
}

/// The image of a unit point: place, widths, sidelobes, ghost, theory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Analysis {
    /// The point, m.
    pub target_m: [f64; 3],
    /// Place (x, y) of the point's image by Eq. (14), m; `None` where the plane is too far below the point.
    pub expected_m: Option<[f64; 2]>,
    /// Place (x, y) of the image's peak, m.
    pub peak_m: [f64; 2],
    /// Amplitude of the peak, the sum of Eq. (5).
    pub amplitude: f64,
    /// Straight-line approximation of the track at the closest approach to the peak.
    pub track: LocalTrack,
    /// Expected resolution at the peak, which determines the sampling of the cuts.
    pub cell: Cell,
    /// Widths along the track.
    pub along: AlongTrack,
    /// Widths across the track.
    pub across: AcrossTrack,
    /// Highest sidelobe of the two cuts, dB.
    pub pslr_db: Option<f64>,
    /// Sidelobe energy over main-lobe energy, added over the two cuts, dB.
    pub islr_db: Option<f64>,
    /// The mirrored partner.
    pub ghost: Option<Ghost>,
    /// The theory of a straight track.
    pub theory: Theory,
}

impl Analysis {
    /// Measures the image of a unit point at `target_m` on the plane at height `plane_z_m`.
    ///
    /// The cuts run through the peak of the image. Where the target is not seen on the plane by Eq. (14), the
    /// residue above the target's place is measured and [`Analysis::expected_m`] is `None`.
    ///
    /// # Errors
    /// A target or plane that is not below the flight, not finite or farther than 1e8 m, a band of no width.
    ///
    /// ```
    /// use acerra_imaging::psf::{Analysis, PointSpread};
    /// let track: Vec<[f64; 3]> = (0..301).map(|m| [-3.0 + 0.02 * m as f64, 0.0, 5.0]).collect();
    /// let frequency_hz: Vec<f64> = (0..86).map(|n| 3.1e9 + 20e6 * n as f64).collect();
    /// let spread = PointSpread::new(track, None, frequency_hz, 3e8)?;
    /// let found = Analysis::of(&spread, [0.0, 2.0, 0.0], 0.0)?;
    /// assert!((found.across.rayleigh_m.unwrap() - 0.247).abs() < 0.005); // Table 1
    /// # Ok::<(), acerra_imaging::ImagingError>(())
    /// ```
    pub fn of(
        spread: &PointSpread,
        target_m: [f64; 3],
        plane_z_m: f64,
    ) -> Result<Self, ImagingError> {
        check_places(
            "target",
            [&target_m, &[target_m[0], target_m[1], plane_z_m]],
        )?;
        let (low, high) = spread.band_hz();
        let theory_range_m = crate::resolution::range_m(high - low, spread.light_speed_m_s())?;
        let expected_m = expected_place_m(spread, target_m, plane_z_m)?;
        let start = expected_m.unwrap_or([target_m[0], target_m[1]]);
        let scene = [target_m];
        let field = PsfField::new(spread, &scene, plane_z_m);
        let about = |at: [f64; 2]| {
            let point = [at[0], at[1], plane_z_m];
            let track = track_at(spread, point)?;
            Ok::<_, ImagingError>((track, Cell::expected(spread, &track, point)))
        };
        let (track, cell) = about(start)?;
        let (peak_m, amplitude) =
            climb_crest(&field, start, 0.25 * cell.along_m, track.tangent, cell)
                .unwrap_or((start, 0.0));
        let (track, cell) = about(peak_m)?;
        let shape = measure_shape(&field as &dyn Field, &track, peak_m, cell).ok_or(
            ImagingError::Empty {
                what: "the response to the target",
            },
        )?;
        Ok(Self {
            target_m,
            expected_m,
            peak_m,
            amplitude,
            track,
            cell,
            along: shape.along,
            across: shape.across,
            pslr_db: shape.pslr_db,
            islr_db: shape.islr_db,
            ghost: find_ghost(&field, &track, peak_m, amplitude, cell),
            theory: Theory {
                along_m: cell.along_m,
                range_m: theory_range_m,
                across_m: cell.across_m,
            },
        })
    }
}

/// The local track of a point that must lie below it.
pub(crate) fn track_at(
    spread: &PointSpread,
    point_m: [f64; 3],
) -> Result<LocalTrack, ImagingError> {
    let track = LocalTrack::at(spread.position_m(), point_m)
        .ok_or(ImagingError::Empty { what: "position_m" })?;
    if track.height_m.is_finite() && track.height_m > 0.0 {
        Ok(track)
    } else {
        Err(ImagingError::OutOfRange {
            what: "height of the flight above the target or image plane, m,",
            expected: "above 0 m (both must lie below the drone)",
            found: track.height_m,
        })
    }
}

/// Eq. (14): expected place of the image of `target_m` on the plane at `plane_z_m`, on the target's side of
/// the track (on the left for a target under the track). `None` where the target is not seen on the plane.
///
/// # Errors
/// A target or plane that is not below the flight.
pub fn expected_place_m(
    spread: &PointSpread,
    target_m: [f64; 3],
    plane_z_m: f64,
) -> Result<Option<[f64; 2]>, ImagingError> {
    let track = track_at(spread, target_m)?;
    track_at(spread, [target_m[0], target_m[1], plane_z_m])?;
    let outward_m = displacement_m(
        track.height_m,
        track.offset_m.abs(),
        plane_z_m - target_m[2],
    )?;
    let side = if track.offset_m < 0.0 { -1.0 } else { 1.0 };
    let left = track.left();
    Ok(outward_m.map(|o| {
        [
            target_m[0] + side * o * left[0],
            target_m[1] + side * o * left[1],
        ]
    }))
}
