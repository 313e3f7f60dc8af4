//! Expected resolution about a point.

use super::spread::PointSpread;
use crate::metrics::track::LocalTrack;

/// Expected Rayleigh distances about one point of the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Along the track, m.
    pub along_m: f64,
    /// Across it, m.
    pub across_m: f64,
}

impl Cell {
    /// The cell at `at_m`: Eq. (6) with the angles that the flight spans, and Eq. (9) with the local track's
    /// height and offset.
    ///
    /// Along the track Eq. (6) gives c/(4 f_c sin θ) for views from −θ to θ; views from θ₁ to θ₂ give c/(2
    /// f_c (sin θ₂ − sin θ₁)). Neither distance exceeds the range itself, so that it is finite for a single
    /// pulse or a single frequency.
    pub fn expected(spread: &PointSpread, track: &LocalTrack, at_m: [f64; 3]) -> Self {
        let (low, high) = spread.band_hz();
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for p in spread.position_m() {
            let d = [p[0] - at_m[0], p[1] - at_m[1], p[2] - at_m[2]];
            let range = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
            if range > 0.0 {
                let sine = (d[0] * track.tangent[0] + d[1] * track.tangent[1]) / range;
                least = least.min(sine);
                most = most.max(sine);
            }
        }
        let offset_m = track.offset_m.abs();
        let range_m = offset_m.hypot(track.height_m);
        let c = spread.light_speed_m_s();
        let along_m = c / (low + high) / (most - least).max(1e-12);
        let step_m = 0.5 * c / (high - low).max(1e-3);
        let across_m =
            (offset_m.powi(2) + step_m.powi(2) + 2.0 * step_m * range_m).sqrt() - offset_m;
        // The smallest bound only guards a target on the antenna itself.
        let bound_m = range_m.max(1e-3);
        Self {
            along_m: along_m.min(bound_m),
            across_m: across_m.min(bound_m),
        }
    }
}
