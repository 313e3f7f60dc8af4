//! The pulse on the air and the record that its echoes make.

use std::f64::consts::{PI, TAU};

use num_complex::Complex64;
use rustfft::{Fft, FftPlanner};
use std::sync::Arc;

use super::model::RadarModel;
use super::scatter::Echo;

/// Turns echoes into the samples of one record, exactly band-limited.
///
/// The spectrum of a thousand echoes is a non-uniform discrete Fourier transform of type 1; it is computed by
/// Gaussian gridding (Greengard and Lee, *SIAM Review* 46, 2004) to twelve digits.
pub struct PulseShaper {
    /// First frequency bin of the band and the amplitude of each, adding up to 1.
    first_bin: usize,
    amplitude: Vec<f64>,
    /// Bins are the multiples of this (Hz).
    bin_hz: f64,
    samples: usize,
    start_s: f64,
    gridding: Gridding,
    inverse: Arc<dyn Fft<f64>>,
    /// Scratch, so that traces allocate nothing: the band's spectrum, the record.
    spectrum: Vec<Complex64>,
    record: Vec<Complex64>,
    fft_scratch: Vec<Complex64>,
}

impl std::fmt::Debug for PulseShaper {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("PulseShaper")
            .field("bin_hz", &self.bin_hz)
            .field("bins", &self.amplitude.len())
            .field("samples", &self.samples)
            .finish_non_exhaustive()
    }
}

impl PulseShaper {
    /// A shaper for the window and band of `radar`, samples `step_s` apart.
    #[must_use]
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "bin numbers are small and positive"
    )]
    pub fn new(radar: &RadarModel, step_s: f64) -> Self {
        // Twice the window, so that echoes from behind it do not come round to its start.
        let length = 2 * radar.samples;
        let bin_hz = 1.0 / (length as f64 * step_s);
        let [low_hz, high_hz] = radar.band_ghz.map(|f| f * 1e9);
        let first_bin = (low_hz / bin_hz).ceil() as usize;
        let last_bin = ((high_hz / bin_hz).floor() as usize).max(first_bin);
        let edge_hz = 0.5 * radar.band_taper * (high_hz - low_hz);
        let mut amplitude: Vec<f64> = (first_bin..=last_bin)
            .map(|k| {
                let f = k as f64 * bin_hz;
                let inside = (f - low_hz).min(high_hz - f).max(0.0);
                if inside >= edge_hz {
                    1.0
                } else {
                    0.5 - 0.5 * (TAU * 0.5 * inside / edge_hz).cos()
                }
            })
            .collect();
        let sum: f64 = amplitude.iter().sum();
        if sum > 0.0 {
            amplitude.iter_mut().for_each(|a| *a /= sum);
        }
        let inverse = FftPlanner::new().plan_fft_inverse(length);
        let fft_scratch = vec![Complex64::default(); inverse.get_inplace_scratch_len()];
        Self {
            first_bin,
            gridding: Gridding::new(amplitude.len()),
            spectrum: vec![Complex64::default(); amplitude.len()],
            amplitude,
            bin_hz,
            samples: radar.samples,
            start_s: radar.window_start_ns * 1e-9,
            inverse,
            record: vec![Complex64::default(); length],
            fft_scratch,
        }
    }

    /// The record of `echoes`, each late by `delay_s`: an echo of strength 1 has an envelope that
    /// peaks at 1. `record` is overwritten.
    pub fn shape(&mut self, echoes: &[Echo], delay_s: f64, record: &mut Vec<f64>) {
        let window_s = 0.5 / self.bin_hz;
        #[expect(clippy::cast_precision_loss, reason = "bin numbers are small")]
        let middle_hz = (self.first_bin + self.amplitude.len() / 2) as f64 * self.bin_hz;
        self.gridding.clear();
        for echo in echoes {
            let late_s = echo.delay_s + delay_s - self.start_s;
            if late_s <= -window_s || late_s >= 2.0 * window_s {
                continue;
            }
            let phase_rad = echo.phase_rad - TAU * middle_hz * late_s;
            let value = Complex64::from_polar(echo.strength, phase_rad);
            self.gridding.add(late_s * self.bin_hz, value);
        }
        self.gridding.transform(&mut self.spectrum);
        self.record.fill(Complex64::default());
        let band = self.record[self.first_bin..].iter_mut();
        for ((bin, value), amplitude) in band.zip(&self.spectrum).zip(&self.amplitude) {
            *bin = amplitude * value;
        }
        self.inverse
            .process_with_scratch(&mut self.record, &mut self.fft_scratch);
        record.clear();
        record.extend(self.record[..self.samples].iter().map(|v| v.re));
    }
}

/// Grid points to each side over which a value is spread: as many digits.
const SPREAD: usize = 12;

/// Sums Σ v exp(−2πi k x) of values v at places x, for k from −`count`/2 on.
struct Gridding {
    /// Grid of twice as many points as sums or more, with [`SPREAD`] points more at either end for what wraps.
    grid: Vec<Complex64>,
    size: usize,
    /// 1/(4τ), τ being the width of the Gaussian, in grid points.
    sharpness: f64,
    /// exp(−j²/(4τ)) for j = 1 − `SPREAD` … `SPREAD`.
    gaussian: [f64; 2 * SPREAD],
    /// Removes the Gaussian's spectrum from each sum.
    correction: Vec<f64>,
    forward: Arc<dyn Fft<f64>>,
    scratch: Vec<Complex64>,
}

impl Gridding {
    #[expect(
        clippy::cast_precision_loss,
        reason = "grid points and sums are counted in thousands"
    )]
    fn new(count: usize) -> Self {
        let size = (2 * count).max(4 * SPREAD).next_multiple_of(16);
        // Equations (9) and (15) there, for twice as many grid points as sums, in grid points.
        let tau = SPREAD as f64 / (3.0 * PI);
        let sharpness = 0.25 / tau;
        let gaussian = std::array::from_fn(|i| {
            let j = i as f64 + 1.0 - SPREAD as f64;
            (-sharpness * j * j).exp()
        });
        let per_sum = TAU / size as f64;
        let correction = (0..count).map(|i| {
            let k = per_sum * (i as f64 - (count / 2) as f64);
            (tau * k * k).exp() / (4.0 * PI * tau).sqrt()
        });
        let forward = FftPlanner::new().plan_fft_forward(size);
        Self {
            grid: vec![Complex64::default(); size + 2 * SPREAD],
            size,
            sharpness,
            gaussian,
            correction: correction.collect(),
            scratch: vec![Complex64::default(); forward.get_inplace_scratch_len()],
            forward,
        }
    }

    fn clear(&mut self) {
        self.grid.fill(Complex64::default());
    }

    /// Adds a value at a place; places are periodic with period 1.
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a grid point, counted in thousands"
    )]
    fn add(&mut self, place: f64, value: Complex64) {
        let at = place.rem_euclid(1.0) * self.size as f64;
        let nearest = (at as usize).min(self.size - 1);
        let beyond = at - nearest as f64;
        // exp(−(beyond − j)²/(4τ)) by factors: of `beyond`, of j, and the j-th power of one.
        let per_point = (2.0 * self.sharpness * beyond).exp();
        let mut power =
            (-self.sharpness * beyond * beyond).exp() / per_point.powi(SPREAD as i32 - 1);
        let points = &mut self.grid[nearest + 1..=nearest + 2 * SPREAD];
        for (point, gaussian) in points.iter_mut().zip(&self.gaussian) {
            *point += value * (power * gaussian);
            power *= per_point;
        }
    }

    /// The sums of the added echoes.
    fn transform(&mut self, sums: &mut [Complex64]) {
        let (size, grid) = (self.size, &mut self.grid);
        for i in 0..SPREAD {
            let (before, after) = (grid[i], grid[size + SPREAD + i]);
            grid[size + i] += before;
            grid[SPREAD + i] += after;
        }
        let period = &mut grid[SPREAD..SPREAD + size];
        self.forward.process_with_scratch(period, &mut self.scratch);
        let first = size - self.correction.len() / 2;
        for (i, (sum, correction)) in sums.iter_mut().zip(&self.correction).enumerate() {
            *sum = correction * period[(first + i) % size];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gridded_sums_are_the_direct_ones_to_eleven_digits() {
        for count in [1, 2, 7, 64, 341] {
            let values: Vec<(f64, Complex64)> = (0..300)
                .map(|n| {
                    let place = (f64::from(n) * 0.754_877_666).fract() * 2.0 - 0.7;
                    let strength = 1.0 + f64::from(n % 5);
                    (
                        place,
                        Complex64::from_polar(strength, f64::from(n * n % 97)),
                    )
                })
                .chain(
                    [0.0, 1.0, 1.0 - 1e-17, -1e-17].map(|place| (place, Complex64::new(1.0, 0.0))),
                )
                .collect();
            let mut gridding = Gridding::new(count);
            for round in 0..2 {
                gridding.clear();
                values
                    .iter()
                    .for_each(|(place, value)| gridding.add(*place, *value));
                let mut sums = vec![Complex64::default(); count];
                gridding.transform(&mut sums);
                let total: f64 = values.iter().map(|(_, value)| value.norm()).sum();
                for (i, sum) in sums.iter().enumerate() {
                    let k = i as f64 - (count / 2) as f64;
                    let terms = values.iter().map(|(x, v)| v * Complex64::cis(-TAU * k * x));
                    let direct: Complex64 = terms.sum();
                    assert!(
                        (sum - direct).norm() < 1e-11 * total,
                        "{count} {round} {k}: {sum} {direct}"
                    );
                }
            }
        }
    }
}
