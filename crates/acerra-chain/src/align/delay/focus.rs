//! The strongest and the most coherent echoes at any delay, on any plane: for flights whose settings are all
//! unknown.

use std::f64::consts::LN_10;

use acerra_imaging::metrics::{ImageView, strongest_maxima};
use acerra_imaging::{ImagingError, PlaneGrid};
use acerra_radar::Spectrum;
use num_complex::Complex64;

use super::echo_power::StrongestEcho;
use super::error::DelayError;
use super::search::{DelayTrial, INDEPENDENT, PHASE_VARIANCE};
use super::view::middle_hz;
use crate::echoes::history::{Measured, distance_m};
use crate::echoes::window::Budget;

/// Contributions of traces to pixels in one image.
const CONTRIBUTIONS: f64 = 2e7;
/// Least and largest number of pixels of an image.
const PIXELS: [f64; 2] = [10_000.0, 60_000.0];
/// Number of delays at which maxima are searched to place the pixels.
const LOOKED_AT: usize = 5;
/// Least level of maxima whose coherence is computed, relative to the greatest (dB).
const FLOOR_DB: f64 = -25.0;
/// Largest number of these maxima.
const MAXIMA: usize = 80;
/// Number of echoes whose coherence counts.
const ECHOES: usize = 4;
/// Least distance of these echoes (m).
const APART_M: f64 = 0.5;

/// Clean traces whose strongest echo is searched.
pub(crate) struct Focus<'a> {
    trial: DelayTrial<'a>,
    spectrum: Spectrum,
    /// Weight of each trace.
    weights: Vec<f64>,
    /// Delay at which the spectra were cleaned (s).
    cleaned_s: f64,
}

impl<'a> DelayTrial<'a> {
    /// The traces cleaned at a delay; without a gate they are valid for every other delay.
    pub(crate) fn focus_about(self, delay_s: f64) -> Result<Focus<'a>, DelayError> {
        Ok(Focus {
            spectrum: self.cleaned_at(delay_s, 0.0)?,
            weights: self.weights(),
            trial: self,
            cleaned_s: delay_s,
        })
    }
}

impl Focus<'_> {
    /// Power of the strongest echo at a delay on some pixels (dB), and its place (x, y), m.
    pub fn strongest(
        &self,
        delay_s: f64,
        grid: PlaneGrid,
    ) -> Result<(f64, Option<[f64; 2]>), ImagingError> {
        let scan = self.trial.on(&self.spectrum, grid);
        let image = scan.image(delay_s - self.cleaned_s, grid)?;
        let echo = StrongestEcho::of(&image, grid)?;
        Ok((10.0 / LN_10 * echo.log_power, echo.place_m))
    }

    /// Log-likelihood by the coherence of the most coherent echoes on some pixels, and the place of the first
    /// echo (x, y), m. The echoes' power would prefer delays that move other, stronger echoes onto the
    /// pixels.
    pub fn most_coherent(
        &self,
        delay_s: f64,
        grid: PlaneGrid,
    ) -> Result<(f64, Option<[f64; 2]>), ImagingError> {
        let (position_m, speed_m_s) = (
            &self.trial.aligned.position_m,
            self.trial.scene.light_speed_m_s,
        );
        let scan = self.trial.on(&self.spectrum, grid);
        let spectrum = scan.spectrum_at(delay_s - self.cleaned_s);
        let image = scan.image_of(&spectrum, grid)?;
        let maxima = strongest_maxima(&ImageView::new(&image, grid)?, FLOOR_DB, MAXIMA);
        let traces = 0..position_m.len();
        let Some(measured) = Measured::part(position_m, &spectrum, traces, speed_m_s) else {
            return Ok((f64::NEG_INFINITY, None));
        };
        let mut found: Vec<(f64, [f64; 2])> = maxima
            .into_iter()
            .map(|[x_m, y_m]| {
                let place_m = [x_m, y_m, grid.z_m];
                (self.coherence(&measured, place_m), [x_m, y_m])
            })
            .collect();
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut kept: Vec<(f64, [f64; 2])> = Vec::new();
        for (coherence, [x_m, y_m]) in found {
            let is_apart = kept
                .iter()
                .all(|(_, [x, y])| (x - x_m).hypot(y - y_m) >= APART_M);
            if is_apart && kept.len() < ECHOES {
                kept.push((coherence, [x_m, y_m]));
            }
        }
        let mean = kept.iter().map(|k| k.0).sum::<f64>() / ECHOES as f64;
        let per_log = INDEPENDENT / (2.0 * PHASE_VARIANCE);
        Ok((
            per_log * mean.max(f64::MIN_POSITIVE).ln(),
            kept.first().map(|k| k.1),
        ))
    }

    /// Power of the coherent sum of a point's echoes, corrected for spreading, over the power of the in-phase
    /// sum of their amplitudes.
    fn coherence(&self, measured: &Measured<'_>, place_m: [f64; 3]) -> f64 {
        let history = measured.history(place_m);
        let places = measured.position_m.iter().zip(&self.weights);
        let (mut sum, mut power, mut total) = (Complex64::default(), 0.0, 0.0);
        for (echo, (position_m, weight)) in history.iter().zip(places) {
            if *weight <= 0.0 {
                continue;
            }
            // The echoes are weighted already.
            let value = echo * distance_m(*position_m, place_m).powi(2);
            sum += value;
            power += value.norm_sqr() / weight;
            total += weight;
        }
        if power > 0.0 {
            sum.norm_sqr() / (power * total)
        } else {
            0.0
        }
    }

    /// The part of a rectangle that contains most of the strongest echoes at `delays_s`, on pixels as fine as
    /// an echo.
    pub fn window(&self, whole: PlaneGrid, delays_s: &[f64]) -> Result<PlaneGrid, DelayError> {
        let traces = self.trial.aligned.position_m.len().max(1) as f64;
        let pixels = (CONTRIBUTIONS / traces).clamp(PIXELS[0], PIXELS[1]);
        let middle_hz = middle_hz(&self.trial.clean.frequency_hz);
        let budget = Budget::new(pixels, middle_hz, self.trial.scene.light_speed_m_s);
        let every = delays_s.len().div_ceil(LOOKED_AT).max(1);
        budget.window(whole, |look| {
            let mut maxima_m = Vec::new();
            for delay_s in delays_s.iter().step_by(every) {
                let scan = self.trial.on(&self.spectrum, look);
                let spectrum = scan.spectrum_at(delay_s - self.cleaned_s);
                maxima_m.extend(self.trial.on(&spectrum, look).strongest_m()?);
            }
            Ok(maxima_m)
        })
    }
}
