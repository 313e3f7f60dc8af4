//! Geometry of flight and image: resolution cell, and ranges covered by the data.

use std::f64::consts::TAU;

/// Flight, grid and band of an image.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ImageGeometry<'a> {
    /// Phase centre of each trace: east, north, up (m).
    pub position_m: &'a [[f64; 3]],
    /// Some pixels of the image, corners and middle at least (m).
    pub pixel_m: &'a [[f64; 3]],
    /// Lowest and highest frequency (Hz).
    pub band_hz: [f64; 2],
    /// Propagation speed (m/s).
    pub light_speed_m_s: f64,
}

/// Span of the two-way wavenumber along east and north (rad/m) at `pixel_m`, over all traces and the band:
/// the support of the pixel's point spread function.
pub(crate) fn wavenumber_span(geometry: &ImageGeometry<'_>, pixel_m: [f64; 3]) -> [f64; 2] {
    let mut low = [f64::INFINITY; 2];
    let mut high = [f64::NEG_INFINITY; 2];
    for position in geometry.position_m {
        let away: [f64; 3] = std::array::from_fn(|i| pixel_m[i] - position[i]);
        let range_m = away.iter().map(|v| v * v).sum::<f64>().sqrt();
        for frequency_hz in geometry.band_hz {
            let wavenumber = 2.0 * TAU * frequency_hz / geometry.light_speed_m_s;
            for axis in 0..2 {
                let along = wavenumber * away[axis] / range_m.max(1e-9);
                low[axis] = low[axis].min(along);
                high[axis] = high[axis].max(along);
            }
        }
    }
    std::array::from_fn(|axis| (high[axis] - low[axis]).max(0.0))
}

/// Coverage of the pixels' ranges by the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RangesHeld {
    /// Share of the pixels whose range of closest approach is covered: an echo is focused from the traces
    /// about its closest approach; distant traces alone leave smeared arcs.
    pub focused: f64,
    /// Whether any pixel is within the ranges of any trace.
    pub any: bool,
    /// Nearest and farthest range of all traces (m).
    pub range_m: [f64; 2],
}

/// Coverage of the pixels by `held_m`, the nearest and farthest range of each trace (m); `None` where the
/// lists have different lengths.
pub(crate) fn ranges_held(geometry: &ImageGeometry<'_>, held_m: &[[f64; 2]]) -> Option<RangesHeld> {
    if geometry.position_m.is_empty() || held_m.len() != geometry.position_m.len() {
        return None;
    }
    let stride = (geometry.position_m.len() / 256).max(1);
    let traces = || geometry.position_m.iter().zip(held_m).step_by(stride);
    let is_held = |range_m: f64, [near, far]: &[f64; 2]| (*near..=*far).contains(&range_m);
    let is_seen = |pixel: &[f64; 3]| {
        traces().any(|(position, held)| is_held(distance_m(*position, *pixel), held))
    };
    let is_focused = |pixel: &&[f64; 3]| {
        traces()
            .map(|(position, held)| (distance_m(*position, **pixel), held))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .is_some_and(|(range_m, held)| is_held(range_m, held))
    };
    let pixels = geometry.pixel_m.len().max(1) as f64;
    let widest = |[low, high]: [f64; 2], [near, far]: &[f64; 2]| [low.min(*near), high.max(*far)];
    Some(RangesHeld {
        focused: geometry.pixel_m.iter().filter(is_focused).count() as f64 / pixels,
        any: geometry.pixel_m.iter().any(is_seen),
        range_m: held_m
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], widest),
    })
}

/// Distance between two points (m).
pub(crate) fn distance_m(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
pub(crate) mod samples {
    use super::ImageGeometry;

    pub const BAND_HZ: [f64; 2] = [3.1e9, 4.8e9];
    pub fn track(step_m: f64, height_m: f64) -> Vec<[f64; 3]> {
        let count = (18.0 / step_m) as i32;
        (0..count)
            .map(|k| [f64::from(k) * step_m, -2.0, height_m])
            .collect()
    }

    pub fn geometry<'a>(position_m: &'a [[f64; 3]], pixel_m: &'a [[f64; 3]]) -> ImageGeometry<'a> {
        ImageGeometry {
            position_m,
            pixel_m,
            band_hz: BAND_HZ,
            light_speed_m_s: 299_792_458.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::samples::{geometry, track};
    use super::*;

    #[test]
    fn the_resolution_cell_is_that_of_aperture_and_band() {
        // Over the middle of a long track the along-track wavenumber spans ±2K sin θ.
        let track = track(0.05, 10.0);
        let pixels = [[9.0, -2.0, 0.0]];
        let [along, _] = wavenumber_span(&geometry(&track, &pixels), pixels[0]);
        let sine = 9.0 / 181.0_f64.sqrt();
        let expected = 2.0 * 2.0 * TAU * 4.8e9 / 299_792_458.0 * sine;
        assert!((along / expected - 1.0).abs() < 0.01, "{along} {expected}");
    }
}
