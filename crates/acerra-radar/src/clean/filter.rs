//! Linear filters along fast time without delay.

use num_complex::Complex64;
use rayon::prelude::*;
use rustfft::FftPlanner;

use super::CleanError;
use super::envelope::in_band;
use crate::radargram::Radargram;
use crate::value::{InPlace, Shape, Value, in_place};
use acerra_control::Cancelled;

/// Subtracts from each trace the running mean over a window of fast time: "wow", the slow drift of the
/// receiver after the direct wave, and any offset. Near the ends of the record the window is cut at the
/// record's ends.
///
/// A window of one or two periods of the antenna's frequency preserves the antenna's echoes.
///
/// # Errors
/// A window of fewer than three samples.
///
/// ```
/// use acerra_radar::{Radargram, Samples, clean::dewow};
/// let drifts = (0..50).map(|k| 100.0 + k as f32).collect();
/// let raw = Radargram::new(vec![0.0], 0.0, 1e-9, Samples::Real(drifts))?;
/// let left = dewow(raw, 9e-9)?;
/// assert!((10..40).all(|k| left.samples.at(k).norm() < 1e-4));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn dewow(mut radargram: Radargram, window_s: f64) -> Result<Radargram, CleanError> {
    let half = (0.5 * window_s / radargram.fast_time_step_s).round();
    if half.is_nan() || half < 1.0 {
        return Err(CleanError::DewowWindow {
            window_s,
            step_s: radargram.fast_time_step_s,
        });
    }
    let half = (half as usize).min(radargram.samples_per_trace);
    in_place(&mut radargram, &Dewow { half })?;
    Ok(radargram)
}

/// Band-pass filter (Hz): 1 within the band, 0 further than a fifth of its width outside, a raised cosine
/// between. Complex samples have frequencies from 0 to the sampling rate, as in spectra.
///
/// # Errors
/// A band that is empty, or that reaches beyond the frequencies of the samples.
///
/// ```
/// use acerra_radar::{Radargram, Samples, clean::band_pass};
/// let tone = |f_hz: f64| (0..400).map(move |k| (std::f64::consts::TAU * f_hz * 1e-9 * f64::from(k)).cos());
/// let both = tone(0.1e9).zip(tone(0.3e9)).map(|(a, b)| (a + b) as f32).collect();
/// let raw = Radargram::new(vec![0.0], 0.0, 1e-9, Samples::Real(both))?;
/// let kept = band_pass(raw, [0.25e9, 0.35e9])?;
/// let alone: Vec<f64> = tone(0.3e9).collect();
/// assert!((100..300).all(|k| (kept.samples.at(k).re - alone[k]).abs() < 0.02));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn band_pass(mut radargram: Radargram, band_hz: [f64; 2]) -> Result<Radargram, CleanError> {
    let step_s = radargram.fast_time_step_s;
    let is_complex = radargram.samples.is_complex();
    let limit_hz = if is_complex { 1.0 } else { 0.5 } / step_s;
    if !(0.0 <= band_hz[0] && band_hz[0] < band_hz[1] && band_hz[1] <= limit_hz) {
        return Err(CleanError::PassBand { band_hz, limit_hz });
    }
    let n = radargram.samples_per_trace;
    let size = (n + n / 4).next_power_of_two();
    let frequency_hz = |k: usize| {
        let k = if is_complex { k } else { k.min(size - k) };
        k as f64 / (size as f64 * step_s)
    };
    let weight = (0..size).map(|k| in_band(frequency_hz(k), band_hz) / size as f64);
    let filter = BandPass {
        weight: weight.collect(),
    };
    in_place(&mut radargram, &filter)?;
    Ok(radargram)
}

struct Dewow {
    half: usize,
}

impl InPlace for Dewow {
    fn run<V: Value>(&self, samples: &mut [V], shape: Shape) -> Result<(), Cancelled> {
        let n = shape.samples_per_trace;
        samples.par_chunks_exact_mut(n).for_each(|row| {
            let mut before = Vec::with_capacity(n + 1);
            let mut sum = Complex64::default();
            before.push(sum);
            for value in row.iter() {
                sum += value.wide();
                before.push(sum);
            }
            for (k, value) in row.iter_mut().enumerate() {
                let (from, to) = (k.saturating_sub(self.half), (k + self.half + 1).min(n));
                let mean = (before[to] - before[from]) / (to - from) as f64;
                *value = V::narrow(value.wide() - mean);
            }
        });
        Ok(())
    }
}

struct BandPass {
    /// Factor of each frequency of the padded record, with the scale of the transform included.
    weight: Vec<f64>,
}

impl InPlace for BandPass {
    fn run<V: Value>(&self, samples: &mut [V], shape: Shape) -> Result<(), Cancelled> {
        let size = self.weight.len();
        let mut planner = FftPlanner::new();
        let forward = planner.plan_fft_forward(size);
        let inverse = planner.plan_fft_inverse(size);
        samples
            .par_chunks_exact_mut(shape.samples_per_trace)
            .for_each(|row| {
                let mut work: Vec<Complex64> = row.iter().map(|v| v.wide()).collect();
                work.resize(size, Complex64::default());
                forward.process(&mut work);
                work.iter_mut()
                    .zip(&self.weight)
                    .for_each(|(z, w)| *z *= *w);
                inverse.process(&mut work);
                for (value, z) in row.iter_mut().zip(&work) {
                    *value = V::narrow(*z);
                }
            });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radargram::Samples;
    use num_complex::Complex32;

    fn pulse(at: usize) -> Vec<f32> {
        (0..512)
            .map(|k| {
                let t = (k as f64 - at as f64) / 10.0;
                ((-t * t).exp() * (std::f64::consts::TAU * 0.05 * (k as f64 - at as f64)).cos())
                    as f32
            })
            .collect()
    }

    fn one(samples: Vec<f32>) -> Radargram {
        Radargram::new(vec![0.0], 0.0, 1e-9, Samples::Real(samples)).unwrap()
    }

    #[test]
    fn filters_are_linear_and_do_not_move_echoes() {
        let filters: [fn(Radargram) -> Radargram; 2] = [
            |r| dewow(r, 41e-9).unwrap(),
            |r| band_pass(r, [0.03e9, 0.08e9]).unwrap(),
        ];
        for filter in filters {
            let [a, b] = [pulse(200), pulse(320)].map(|p| filter(one(p)));
            let both = pulse(200)
                .into_iter()
                .zip(pulse(320))
                .map(|(a, b)| 2.0 * a - b);
            let both = filter(one(both.collect()));
            for k in 0..512 {
                let expected = 2.0 * a.samples.at(k).re - b.samples.at(k).re;
                assert!((both.samples.at(k).re - expected).abs() < 1e-5);
                // Even about the pulse: no delay.
                if k < 200 {
                    let mirrored = [200 - k, 200 + k].map(|i| a.samples.at(i).re);
                    assert!((mirrored[0] - mirrored[1]).abs() < 1e-4, "{k}");
                }
            }
        }
    }

    #[test]
    fn complex_samples_have_frequencies_of_one_sign() {
        let tone = |f: f64| {
            (0..256).map(move |k| Complex64::from_polar(1.0, std::f64::consts::TAU * f * k as f64))
        };
        let samples = tone(0.8).map(|z| Complex32::new(z.re as f32, z.im as f32));
        let samples = Samples::Complex(samples.collect());
        let raw = Radargram::new(vec![0.0], 0.0, 1e-9, samples).unwrap();
        let kept = band_pass(raw.clone(), [0.7e9, 0.9e9]).unwrap();
        assert!((kept.samples.at(128) - raw.samples.at(128)).norm() < 0.02);
        let gone = band_pass(raw, [0.1e9, 0.3e9]).unwrap();
        assert!(gone.samples.at(128).norm() < 0.02);
    }

    #[test]
    fn windows_and_bands_that_are_none_are_refused() {
        for window_s in [0.0, 0.9e-9, -5e-9, f64::NAN] {
            let refused = dewow(one(pulse(9)), window_s);
            assert!(matches!(refused, Err(CleanError::DewowWindow { .. })));
        }
        for band in [[0.2e9, 0.1e9], [0.1e9, 0.6e9], [f64::NAN, 0.1e9]] {
            let refused = band_pass(one(pulse(9)), band);
            assert!(matches!(refused, Err(CleanError::PassBand { .. })));
        }
        // A window longer than the record averages the record.
        assert!(dewow(one(pulse(9)), 1.0).is_ok());
    }
}
