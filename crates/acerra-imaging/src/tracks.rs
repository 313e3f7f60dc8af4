//! Several tracks in one coherent image: delay and phase of each track's instrument, and their estimation on
//! a target that all tracks see.
//!
//! An instrument that adds the delay τ and the phase φ turns the echo E(f) into E(f)·e^{j(φ − 2πfτ)}. Tracks
//! whose τ and φ differ do not add up; relative to the first track, τ and φ of the other tracks are estimated
//! as follows. At a point p the sum over track k is S_k(f) = Σ_m w_m E_k(m, f) e^{j4πfR_m(p)/c}/R_m². For a
//! target at p it is a constant times the instrument's e^{j(φ − 2πfτ)}: the profile |Σ_f S_k(f) e^{j2πfτ}| is
//! greatest at the track's delay, and its phase there is the track's phase. The point p is a maximum of the
//! first track's image; of several maxima, the one that all tracks agree on, since the ghost of one track is
//! absent from a parallel track.

use crate::checks::{check_finite, check_length, check_positive};
use crate::error::ImagingError;
use crate::pulses::{Pulses, Spreading};
use crate::vector::range_m;
use acerra_control::Control;
use num_complex::Complex64;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Delay and phase that a track's instrument adds to its echoes: E(f)·e^{j(φ − 2πfτ)}.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Calibration {
    /// Delay τ, s.
    pub delay_s: f64,
    /// Phase φ, rad.
    pub phase_rad: f64,
}

impl Calibration {
    /// Removes delay and phase from `spectrum` `[M, N]` at `frequency_hz` `[N]`.
    ///
    /// # Errors
    /// Values that are not finite, or a spectrum that is not a whole number of rows.
    ///
    /// ```
    /// use acerra_imaging::Complex64;
    /// use acerra_imaging::tracks::Calibration;
    /// let late = Calibration { delay_s: 1e-9, phase_rad: 0.5 };
    /// let frequency_hz = [3e9, 4.25e9];
    /// let mut echo = frequency_hz.map(|f| Complex64::cis(0.5 - std::f64::consts::TAU * f * 1e-9));
    /// late.remove(&frequency_hz, &mut echo)?;
    /// assert!((echo[0] - 1.0).norm() < 1e-9 && (echo[1] - 1.0).norm() < 1e-9);
    /// # Ok::<(), acerra_imaging::ImagingError>(())
    /// ```
    pub fn remove(
        self,
        frequency_hz: &[f64],
        spectrum: &mut [Complex64],
    ) -> Result<(), ImagingError> {
        check_finite("calibration", [self.delay_s, self.phase_rad].into_iter())?;
        if frequency_hz.is_empty() {
            return Err(ImagingError::Empty {
                what: "frequency_hz",
            });
        }
        let rows = spectrum.len() / frequency_hz.len();
        check_length("spectrum", rows * frequency_hz.len(), spectrum.len())?;
        let phasors: Vec<Complex64> = frequency_hz
            .iter()
            .map(|f| Complex64::cis((TAU * f * self.delay_s) % TAU - self.phase_rad))
            .collect();
        for row in spectrum.chunks_mut(frequency_hz.len()) {
            for (e, phasor) in row.iter_mut().zip(&phasors) {
                *e *= phasor;
            }
        }
        Ok(())
    }
}

/// A calibration found from the data, with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Delay and phase relative to the first track.
    pub calibration: Calibration,
    /// Standard deviation of the delay, s.
    pub delay_sigma_s: f64,
    /// Standard deviation of the phase at the middle of the band, rad. (At frequency zero, where
    /// [`Calibration::phase_rad`] is defined, the delay's error is added.)
    pub phase_sigma_rad: f64,
    /// Level of the target over the rest of the profile, dB.
    pub contrast_db: f64,
}

/// Calibrations from the target that all tracks see.
#[derive(Debug, Clone, PartialEq)]
pub struct CommonTarget {
    /// Place of the target, `[x, y, z]` m.
    pub position_m: [f64; 3],
    /// One estimate a track, relative to the first track.
    pub estimates: Vec<Estimate>,
}

/// Options of the search for a common target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CalibrationOptions {
    /// Largest delay searched, to either side, s.
    pub window_s: f64,
    /// Weight by range.
    pub spreading: Spreading,
}

/// Estimates delay and phase of `tracks` relative to the first on a target that all tracks see.
///
/// `candidates_m` are possible places of the target: maxima of the first track's image. The best candidate is
/// refined to the maximum along x and y on the surface `z_m(x, y)`. A target off the surface is found next to
/// its true place, where the tracks' phases then agree best.
///
/// Uncertainties follow from delay and phase of a pulse in white noise, with the profile outside the target
/// as noise: 1/(2πβ√(2s)) and 1/√(2s), β being the band's standard deviation and s the contrast in power.
///
/// # Errors
/// No track, no candidate, a window that is not positive, a single frequency, cancellation.
pub fn calibrate_on_target(
    tracks: &[Pulses],
    candidates_m: &[[f64; 3]],
    options: CalibrationOptions,
    z_m: &(dyn Fn(f64, f64) -> f64 + Sync),
    control: Control,
) -> Result<CommonTarget, ImagingError> {
    let CalibrationOptions {
        window_s,
        spreading,
    } = options;
    if tracks.is_empty() {
        return Err(ImagingError::Empty { what: "tracks" });
    }
    check_positive("window_s", "above 0 s", window_s)?;
    for track in tracks {
        let (low, high) = band(track);
        if high <= low {
            return Err(ImagingError::OutOfRange {
                what: "frequency_hz",
                expected: "a band",
                found: low,
            });
        }
    }
    let score = |point: [f64; 3]| -> f64 {
        if control.is_cancelled() {
            return 0.0;
        }
        tracks
            .iter()
            .enumerate()
            .map(|(k, track)| {
                let profile = Profile::at(track, point, spreading);
                let value = if k == 0 {
                    profile.value(0.0).norm()
                } else {
                    profile.peak(window_s).1.norm()
                };
                value.max(f64::MIN_POSITIVE).ln()
            })
            .sum()
    };
    let scores: Vec<f64> = candidates_m.par_iter().map(|p| score(*p)).collect();
    control.check()?;
    let best = (0..scores.len())
        .max_by(|a, b| scores[*a].total_cmp(&scores[*b]))
        .ok_or(ImagingError::Empty {
            what: "candidates_m",
        })?;
    let position_m = climb(&tracks[0], candidates_m[best], (spreading, z_m), control);
    control.check()?;

    let mut estimates: Vec<Estimate> = tracks
        .iter()
        .enumerate()
        .map(|(k, track)| {
            let profile = Profile::at(track, position_m, spreading);
            let (delay_s, value) = if k == 0 {
                (0.0, profile.value(0.0))
            } else {
                profile.peak(window_s)
            };
            let contrast = value.norm_sqr() / profile.rest(delay_s, window_s);
            let (low, high) = band(track);
            let deviation_hz = (high - low) / 12f64.sqrt();
            let phase_sigma_rad = (2.0 * contrast).sqrt().recip();
            Estimate {
                calibration: Calibration {
                    delay_s,
                    phase_rad: value.arg(),
                },
                delay_sigma_s: phase_sigma_rad / (TAU * deviation_hz),
                phase_sigma_rad,
                contrast_db: 10.0 * contrast.log10(),
            }
        })
        .collect();
    let first = estimates[0].calibration.phase_rad;
    for estimate in &mut estimates {
        let phase = estimate.calibration.phase_rad - first;
        estimate.calibration.phase_rad = phase - TAU * (phase / TAU).round();
    }
    Ok(CommonTarget {
        position_m,
        estimates,
    })
}

fn band(pulses: &Pulses) -> (f64, f64) {
    let f = pulses.frequency_hz();
    let low = f.iter().copied().fold(f64::INFINITY, f64::min);
    let high = f.iter().copied().fold(0.0, f64::max);
    (low, high)
}

/// S(f) of a track at a point.
struct Profile<'a> {
    frequency_hz: &'a [f64],
    sum: Vec<Complex64>,
    band_hz: f64,
}

impl<'a> Profile<'a> {
    fn at(pulses: &Pulses<'a>, point: [f64; 3], spreading: Spreading) -> Self {
        let frequency_hz = pulses.frequency_hz();
        let mut sum = vec![Complex64::ZERO; frequency_hz.len()];
        for (m, p) in pulses.position_m().iter().enumerate() {
            let range = range_m(*p, point).max(1e-9);
            let weight = pulses.weight()[m] * spreading.weight(range);
            let delay = 4.0 * PI * range / pulses.light_speed_m_s();
            for ((s, e), f) in sum.iter_mut().zip(pulses.spectrum_of(m)).zip(frequency_hz) {
                *s += e * Complex64::cis(f * delay) * weight;
            }
        }
        let (low, high) = band(pulses);
        Self {
            frequency_hz,
            sum,
            band_hz: high - low,
        }
    }

    /// Σ_f S(f) e^{j2πfτ}.
    fn value(&self, delay_s: f64) -> Complex64 {
        self.frequency_hz
            .iter()
            .zip(&self.sum)
            .map(|(f, s)| s * Complex64::cis(TAU * f * delay_s))
            .sum()
    }

    /// Delay within ±`window_s` at which the profile's magnitude is greatest, and the profile's value there.
    fn peak(&self, window_s: f64) -> (f64, Complex64) {
        let step = 0.1 / self.band_hz;
        let count = (window_s / step).ceil().min(1e5) as i64;
        let step = window_s / count as f64;
        let power = |t: f64| self.value(t).norm_sqr();
        let (mut best, mut most) = (0.0, -1.0);
        for k in -count..=count {
            let p = power(k as f64 * step);
            if p > most {
                (best, most) = (k as f64 * step, p);
            }
        }
        // Parabolas about the maximum, each four times narrower.
        let mut half = step;
        for _ in 0..6 {
            let (a, b, c) = (power(best - half), power(best), power(best + half));
            let bend = a - 2.0 * b + c;
            if bend < 0.0 {
                best += (0.5 * half * (a - c) / bend).clamp(-half, half);
            }
            half *= 0.25;
        }
        (best, self.value(best))
    }

    /// Mean power of the profile more than two resolution cells from `delay_s`.
    fn rest(&self, delay_s: f64, window_s: f64) -> f64 {
        let step = 0.25 / self.band_hz;
        let reach = (window_s / step).min(4e4) as i64 + 32;
        let powers: Vec<f64> = (-reach..=reach)
            .filter(|k| k.abs() >= 8)
            .map(|k| self.value(delay_s + k as f64 * step).norm_sqr())
            .collect();
        (powers.iter().sum::<f64>() / powers.len() as f64).max(f64::MIN_POSITIVE)
    }
}

/// The maximum of a track's image next to `start`, to a fraction of a millimetre.
fn climb(
    pulses: &Pulses,
    start: [f64; 3],
    (spreading, z_m): (Spreading, &(dyn Fn(f64, f64) -> f64 + Sync)),
    control: Control,
) -> [f64; 3] {
    let wavelength_m = pulses.light_speed_m_s() / band(pulses).1;
    let level = |p: [f64; 3]| Profile::at(pulses, p, spreading).value(0.0).norm_sqr();
    let (mut here, mut most) = (start, level(start));
    let mut step = 0.2 * wavelength_m;
    let mut steps = 0;
    while step > 0.002 * wavelength_m && steps < 400 && !control.is_cancelled() {
        let moves = [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)];
        let found = moves
            .par_iter()
            .map(|(dx, dy)| {
                let (x, y) = (here[0] + dx * step, here[1] + dy * step);
                let p = [x, y, z_m(x, y)];
                (p, level(p))
            })
            .max_by(|a, b| a.1.total_cmp(&b.1));
        match found {
            Some((p, l)) if l > most => (here, most) = (p, l),
            _ => step *= 0.5,
        }
        steps += 1;
    }
    here
}
