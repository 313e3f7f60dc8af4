//! The resolution operator at chosen points: a method's image of a unit point's echoes.
//!
//! A sharper image need not be better resolved. A method's image of the noise-free echoes of a single point
//! shows the width and level of the point's response, and the artefacts that the method adds around it.

use acerra_imaging::metrics::{
    ImageView, InterpolatedImage, LocalTrack, climb_crest, measure_shape,
};
use acerra_imaging::psf::{Cell, PointSpread};
use serde::Serialize;

/// A method's image of a unit point.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PointResponse {
    /// Position of the point, `[x, y, z]` m.
    pub point_m: [f64; 3],
    /// Horizontal distance of the image's peak from it, m.
    pub displacement_m: f64,
    /// Amplitude of the image at its peak, for a unit reflectivity.
    pub peak: f64,
    /// Full width at −3 dB along the track, m.
    pub along_3db_m: Option<f64>,
    /// Full width at −3 dB across it, m.
    pub across_3db_m: Option<f64>,
    /// Greatest amplitude farther than two Rayleigh distances of the adjoint from the point, below the
    /// peak, dB: sidelobes, ghosts and artefacts.
    pub artefact_db: Option<f64>,
    /// Share of the image's energy within those two distances.
    pub main_share: f64,
}

/// Rayleigh distances of the adjoint that count as the point's surroundings.
const OWN_CELLS: f64 = 2.0;

/// Measures a method's image of a unit point at `point_m`; `None` where the image is zero there.
#[must_use]
pub fn point_response(
    view: &ImageView<'_>,
    spread: &PointSpread,
    point_m: [f64; 3],
) -> Option<PointResponse> {
    let track = LocalTrack::at(spread.position_m(), point_m)?;
    let cell = Cell::expected(spread, &track, point_m);
    let own = |x_m: f64, y_m: f64| {
        let off = [x_m - point_m[0], y_m - point_m[1]];
        let on = |axis: [f64; 2]| off[0] * axis[0] + off[1] * axis[1];
        let along = on(track.tangent) / (OWN_CELLS * cell.along_m);
        let across = on(track.left()) / (OWN_CELLS * cell.across_m);
        along.hypot(across) <= 1.0
    };
    let grid = view.grid();
    let (mut inside, mut outside) = (0.0, 0.0);
    let (mut peak, mut artefact) = ((0.0, [0, 0]), 0.0_f64);
    for j in 0..grid.ny {
        for i in 0..grid.nx {
            let amplitude = f64::from(view.values()[j * grid.nx + i].norm());
            let [x_m, y_m] = view.centre_m(i, j);
            if own(x_m, y_m) {
                inside += amplitude * amplitude;
                if amplitude > peak.0 {
                    peak = (amplitude, [i, j]);
                }
            } else {
                outside += amplitude * amplitude;
                artefact = artefact.max(amplitude);
            }
        }
    }
    if peak.0 <= 0.0 {
        return None;
    }
    let start_m = view.centre_m(peak.1[0], peak.1[1]);
    let field = InterpolatedImage::about(*view, start_m);
    let (peak_m, amplitude) = climb_crest(&field, start_m, grid.pixel_m, track.tangent, cell)?;
    let shape = measure_shape(&field, &track, peak_m, cell);
    Some(PointResponse {
        point_m,
        displacement_m: (peak_m[0] - point_m[0]).hypot(peak_m[1] - point_m[1]),
        peak: amplitude,
        along_3db_m: shape.and_then(|s| s.along.width_3db_m),
        across_3db_m: shape.and_then(|s| s.across.width_3db_m),
        artefact_db: (artefact > 0.0).then(|| 20.0 * (artefact / amplitude).log10()),
        main_share: inside / (inside + outside),
    })
}
