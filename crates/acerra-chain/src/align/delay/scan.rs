//! Images of the same traces at many delays.

use std::f64::consts::TAU;

use acerra_imaging::{Complex32, ImagingError, PlaneGrid, TrialImage, TrialImages};
use acerra_radar::Spectrum;
use num_complex::Complex64;

use crate::echoes::sharpen::log_fourth_moment;
use crate::echoes::{Searched, quick_look};

/// Clean traces with their positions, imaged with range zero at other fast times.
#[derive(Clone, Copy, Debug)]
pub struct DelayScan<'a> {
    /// Positions of the traces (m).
    pub position_m: &'a [[f64; 3]],
    /// Clean spectra of the traces.
    pub spectrum: &'a Spectrum,
    /// The pixels.
    pub grid: PlaneGrid,
    /// Propagation speed (m/s).
    pub light_speed_m_s: f64,
}

/// Sharpness of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScanPoint {
    /// Delay in addition to the one at which the spectra were cleaned (s).
    pub later_s: f64,
    /// Contrast: logarithm of the mean of fourth powers of the amplitudes over the squared mean of
    /// their squares.
    pub log_contrast: f64,
    /// Standard deviation of the contrast by the clutter between the targets.
    pub sigma: f64,
}

impl ScanPoint {
    /// Sharpness of an image at a delay.
    pub(super) fn of(later_s: f64, image: &[Complex32]) -> Self {
        Self {
            later_s,
            log_contrast: log_contrast(image),
            sigma: clutter_sigma(image),
        }
    }
}

impl DelayScan<'_> {
    /// The traces for images at many delays.
    pub(super) fn searched(&self) -> Searched<'_> {
        Searched::new(self.position_m, self.spectrum, self.light_speed_m_s)
    }

    /// Change of range for a change `reach_s` of the delay (m).
    pub(super) fn reach_m(&self, reach_s: f64) -> f64 {
        0.5 * self.light_speed_m_s * reach_s
    }

    /// The image with range zero `later_s` after the delay at which the spectra were cleaned, from tables of
    /// the same traces.
    ///
    /// # Errors
    /// Data that the imaging operators refuse.
    pub(super) fn tabulated_image(
        &self,
        looks: &TrialImages,
        later_s: f64,
        grid: PlaneGrid,
    ) -> Result<Vec<Complex32>, ImagingError> {
        looks.image(&TrialImage {
            position_m: self.position_m,
            beyond_m: self.reach_m(later_s),
            grid,
        })
    }

    /// The image at another delay, on any pixels.
    ///
    /// # Errors
    /// Data that the imaging operators refuse.
    pub fn image(&self, later_s: f64, grid: PlaneGrid) -> Result<Vec<Complex32>, ImagingError> {
        self.image_of(&self.spectrum_at(later_s), grid)
    }

    /// The spectra with range zero `later_s` after the delay at which they were cleaned.
    pub(super) fn spectrum_at(&self, later_s: f64) -> Spectrum {
        delayed(self.spectrum, -later_s)
    }

    /// The image of the shifted spectra, on any pixels.
    ///
    /// # Errors
    /// Data that the imaging operators refuse.
    pub(super) fn image_of(
        &self,
        spectrum: &Spectrum,
        grid: PlaneGrid,
    ) -> Result<Vec<Complex32>, ImagingError> {
        quick_look(self.position_m, spectrum, grid, self.light_speed_m_s)
    }
}

/// The spectra of echoes delayed by `later_s`.
#[must_use]
pub fn delayed(spectrum: &Spectrum, later_s: f64) -> Spectrum {
    let turn: Vec<Complex64> = spectrum
        .frequency_hz
        .iter()
        .map(|f| Complex64::from_polar(1.0, -TAU * f * later_s))
        .collect();
    let mut delayed = spectrum.clone();
    for trace in delayed.values.chunks_mut(turn.len().max(1)) {
        trace.iter_mut().zip(&turn).for_each(|(v, t)| *v *= t);
    }
    delayed
}

/// Contrast of an image. Unlike the fourth moment alone, contrast does not grow with the energy, which
/// changes where targets overlap with their ghosts.
pub(super) fn log_contrast(image: &[Complex32]) -> f64 {
    let energy: f64 = image.iter().map(|v| f64::from(v.norm_sqr())).sum();
    if energy <= 0.0 {
        return 0.0;
    }
    log_fourth_moment(image) + (image.len() as f64).ln() - 2.0 * energy.ln()
}

/// Standard deviation of the log of the fourth moment S₄ by complex normal clutter of power p on every pixel:
/// √(8 p S₆) / S₄. The clutter's power follows from the median amplitude, √(p ln 2).
fn clutter_sigma(image: &[Complex32]) -> f64 {
    let mut power: Vec<f64> = image.iter().map(|v| f64::from(v.norm_sqr())).collect();
    let (fourth, sixth) = power
        .iter()
        .fold((0.0, 0.0), |(s4, s6), p| (s4 + p * p, s6 + p.powi(3)));
    if fourth <= 0.0 {
        return f64::INFINITY;
    }
    let middle = power.len() / 2;
    let (_, median, _) = power.select_nth_unstable_by(middle, f64::total_cmp);
    let clutter = *median / std::f64::consts::LN_2;
    (8.0 * clutter * sixth).sqrt() / fourth
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contrast_ignores_the_level() {
        let image = |level: f32| [Complex32::new(level, 0.0), Complex32::default()];
        assert!((log_contrast(&image(3.0)) - 2f64.ln()).abs() < 1e-6);
        assert!((log_contrast(&image(30.0)) - 2f64.ln()).abs() < 1e-6);
    }

    #[test]
    fn clutter_moves_the_fourth_moment_by_what_is_stated() {
        // One pixel of 10 among clutter of mean power 1, drawn for each trial.
        let mut state = 7_u64;
        let mut uniform = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            ((state >> 11) as f64 + 0.5) / 2f64.powi(53)
        };
        let mut draw = || {
            let (u, v) = (uniform(), uniform());
            Complex64::from_polar((-u.ln()).sqrt(), TAU * v)
        };
        let (mut moments, mut stated) = (Vec::new(), 0.0);
        for _ in 0..400 {
            let mut image: Vec<Complex32> = (0..401)
                .map(|_| draw())
                .map(|v| Complex32::new(v.re as f32, v.im as f32))
                .collect();
            image[200] += Complex32::new(10.0, 0.0);
            moments.push(log_fourth_moment(&image));
            stated += clutter_sigma(&image) / 400.0;
        }
        let mean = moments.iter().sum::<f64>() / 400.0;
        let seen = (moments.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / 400.0).sqrt();
        assert!((seen / stated - 1.0).abs() < 0.25, "{seen} {stated}");
    }
}
