//! Geometry of flight and image that the findings share.

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

/// Span of the two-way wavenumber along east and north (rad/m) at `pixel_m`: the support of its
/// point spread function, over all traces and the band.
pub(super) fn wavenumber_span(geometry: &ImageGeometry<'_>, pixel_m: [f64; 3]) -> [f64; 2] {
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

/// Distance between two points (m).
pub(super) fn distance_m(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
pub(super) mod samples {
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
