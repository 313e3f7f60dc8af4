//! Sharpness of the strongest echoes, for settings that are found by focusing.
//!
//! Small patches about the maxima of a coarse image are imaged finely; the sharpness of a patch is the fourth
//! moment of its amplitudes. Each patch gives an independent estimate, so that the scatter over the patches
//! gives the uncertainty.

use acerra_imaging::metrics::{ImageView, strongest_maxima};
use acerra_imaging::{Complex32, ImagingError, PlaneGrid};
use acerra_radar::Spectrum;

use crate::echoes::quick_look;

/// Patches at most.
const PATCHES: usize = 6;
/// Patches are at least this far apart (m).
const APART_M: f64 = 1.5;
/// Half of a patch's side (m), and its pixels (m).
const HALF_SIDE_M: f64 = 0.6;
const PIXEL_M: f64 = 0.025;
/// Maxima further than this below the greatest are not looked at (dB).
const FLOOR_DB: f64 = -12.0;

/// The best of a setting's values, and its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sharpest {
    /// The value.
    pub value: f64,
    /// Standard deviation: the scatter of the patches' values.
    pub sigma: f64,
    /// Number of patches with a maximum inside.
    pub patches: usize,
}

/// The rectangle of a scene with at most this many pixels, to be imaged many times.
///
/// # Errors
/// A rectangle that makes no grid.
pub fn coarse(fine: PlaneGrid, pixels: f64) -> Result<PlaneGrid, ImagingError> {
    let x_m = [fine.x0_m, fine.x_m(fine.nx - 1)];
    let y_m = [fine.y0_m, fine.y_m(fine.ny - 1)];
    let area_m2 = (x_m[1] - x_m[0] + fine.pixel_m) * (y_m[1] - y_m[0] + fine.pixel_m);
    let pixel_m = fine.pixel_m.max((area_m2 / pixels).sqrt());
    PlaneGrid::from_ranges(x_m, y_m, fine.z_m, pixel_m)
}

/// Patches about the strongest maxima of a coarse image of these echoes.
///
/// # Errors
/// Data that the imaging operators refuse.
pub fn patches(
    position_m: &[[f64; 3]],
    spectrum: &Spectrum,
    grid: PlaneGrid,
    light_speed_m_s: f64,
) -> Result<Vec<PlaneGrid>, ImagingError> {
    let image = quick_look(position_m, spectrum, grid, light_speed_m_s)?;
    let view = ImageView::new(&image, grid)?;
    let mut kept: Vec<[f64; 2]> = Vec::new();
    for [x_m, y_m] in strongest_maxima(&view, FLOOR_DB, 20 * PATCHES) {
        let is_apart = |other: &[f64; 2]| (other[0] - x_m).hypot(other[1] - y_m) >= APART_M;
        if kept.len() < PATCHES && kept.iter().all(is_apart) {
            kept.push([x_m, y_m]);
        }
    }
    let about = |v: f64| [v - HALF_SIDE_M, v + HALF_SIDE_M];
    kept.into_iter()
        .map(|[x_m, y_m]| PlaneGrid::from_ranges(about(x_m), about(y_m), grid.z_m, PIXEL_M))
        .collect()
}

/// Fourth moment of an image's amplitudes: largest where its energy is on the fewest pixels.
#[must_use]
pub fn fourth_moment(image: &[Complex32]) -> f64 {
    image.iter().map(|v| f64::from(v.norm_sqr()).powi(2)).sum()
}

/// Logarithm of the [fourth moment](fourth_moment) of an image's amplitudes.
#[must_use]
pub fn log_fourth_moment(image: &[Complex32]) -> f64 {
    fourth_moment(image).max(f64::MIN_POSITIVE).ln()
}

/// The sharpest of `values` (rising), given the score of every patch at each value; none where no patch has a
/// maximum inside.
#[must_use]
pub fn sharpest(values: &[f64], scores: &[Vec<f64>]) -> Option<Sharpest> {
    let patches = scores.first()?.len();
    let of_patch = |p: usize| -> Vec<f64> { scores.iter().map(|s| s[p]).collect() };
    let mean: Vec<f64> = scores
        .iter()
        .map(|s| s.iter().sum::<f64>() / patches.max(1) as f64)
        .collect();
    let value = vertex(values, &mean)?;
    let own: Vec<f64> = (0..patches)
        .filter_map(|p| vertex(values, &of_patch(p)))
        .collect();
    let count = own.len() as f64;
    let step = values.get(1)? - values.first()?;
    // Few patches estimate their own scatter poorly: at least half a step for two or fewer.
    let sigma = if own.len() < 3 {
        step
    } else {
        let centre = own.iter().sum::<f64>() / count;
        let power: f64 = own.iter().map(|v| (v - centre).powi(2)).sum();
        (power / (count * (count - 1.0))).sqrt().max(0.1 * step)
    };
    Some(Sharpest {
        value,
        sigma,
        patches: own.len(),
    })
}

/// Vertex of the parabola through the highest point and its neighbours; none at an end.
fn vertex(values: &[f64], score: &[f64]) -> Option<f64> {
    let k = (0..score.len()).max_by(|a, b| score[*a].total_cmp(&score[*b]))?;
    if k == 0 || k + 1 >= score.len() {
        return None;
    }
    let (before, top, after) = (score[k - 1], score[k], score[k + 1]);
    let curvature = before - 2.0 * top + after;
    let shift = if curvature < 0.0 {
        0.5 * (before - after) / curvature
    } else {
        0.0
    };
    Some(values[k] + shift * (values[k + 1] - values[k]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sharpest_value_lies_between_those_tried_and_scatters_as_the_patches_do() {
        let values: Vec<f64> = (0..21).map(|k| f64::from(k) * 0.01).collect();
        let centres = [0.100, 0.104, 0.096];
        let scores: Vec<Vec<f64>> = values
            .iter()
            .map(|v| centres.iter().map(|c| -((v - c) / 0.05).powi(2)).collect())
            .collect();
        let best = sharpest(&values, &scores).unwrap();
        assert!((best.value - 0.100).abs() < 1e-9);
        assert!((best.sigma - 0.0023).abs() < 1e-4, "{best:?}");
        assert_eq!(best.patches, 3);
        let falling: Vec<Vec<f64>> = values.iter().map(|v| vec![-v]).collect();
        assert_eq!(sharpest(&values, &falling), None);
    }

    #[test]
    fn energy_on_one_pixel_is_sharper_than_on_two() {
        let one = [Complex32::new(2.0, 0.0), Complex32::default()];
        let two = [Complex32::new(2.0_f32.sqrt(), 0.0); 2];
        assert!(log_fourth_moment(&one) > log_fourth_moment(&two));
    }
}
