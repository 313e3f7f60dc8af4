//! Removing the echo of the surface of the ground, whose distance changes with the antenna's height.
//!
//! A trace is the sum of a constant part (coupling between the antennas), the echo of the surface and the
//! scene. At one frequency the constant part is the same number a in all traces and the surface's echo is
//! b·e^{−j2πfτ}, τ being the two-way time to the surface. Both are removed together: the part of the traces
//! orthogonal to the vectors 1 and e^{−j2πfτ} remains. Subtracting one mean after the other, in the two
//! alignments, would leave the smeared first mean in every trace. Shifts by τ are exact for band-limited
//! traces; a constant added to τ, such as an unknown delay, has no effect.

use std::f64::consts::TAU;

use num_complex::Complex64;
use rayon::prelude::*;
use rustfft::{Fft, FftPlanner};
use std::sync::Arc;

use super::CleanError;
use crate::radargram::Radargram;
use crate::value::{InPlace, Shape, Value, in_place};
use acerra_control::{Cancelled, Control};

/// Smallest share of its length by which the surface's vector differs from the constant one: where the
/// heights hardly change for a frequency, both vectors are equal.
const APART: f64 = 1e-3;

/// The joint removal of the constant part and the echo of the surface.
///
/// ```
/// use acerra_radar::clean::SurfaceRemoval;
/// use num_complex::Complex64;
/// let surface_s = [4.0e-9, 4.2e-9, 3.9e-9, 4.1e-9];
/// let removal = SurfaceRemoval::new(&surface_s)?;
/// let echo = surface_s.map(|t| Complex64::from_polar(1.0, -std::f64::consts::TAU * 1e9 * t));
/// assert!(removal.kept(1e9, &echo).unwrap() < 1e-12);
/// # Ok::<(), acerra_radar::clean::CleanError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceRemoval {
    surface_s: Vec<f64>,
}

impl SurfaceRemoval {
    /// The removal for the two-way time to the surface of each trace, s, up to a constant.
    ///
    /// # Errors
    /// Fewer than three traces, or a time that is not finite.
    pub fn new(surface_s: &[f64]) -> Result<Self, CleanError> {
        let traces = surface_s.len();
        if traces < 3 {
            return Err(CleanError::TooFewTraces {
                method: "surface",
                needed: 3,
                traces,
            });
        }
        if let Some(trace) = surface_s.iter().position(|t| !t.is_finite()) {
            return Err(CleanError::SurfaceTime { trace });
        }
        // Relative to the mean: shifts are small, and so is the padding.
        let mean = surface_s.iter().sum::<f64>() / traces as f64;
        Ok(Self {
            surface_s: surface_s.iter().map(|t| t - mean).collect(),
        })
    }

    /// Subtracts the constant part and the echo of the surface from every trace.
    ///
    /// # Errors
    /// A number of traces other than that of the times, and [`CleanError::Cancelled`].
    pub fn remove(
        &self,
        mut radargram: Radargram,
        control: Control<'_>,
    ) -> Result<Radargram, CleanError> {
        control.check()?;
        super::check_heights(radargram.traces, &self.surface_s)?;
        let step_s = radargram.fast_time_step_s;
        let removal = Removal {
            surface_s: &self.surface_s,
            step_s,
            control,
        };
        in_place(&mut radargram, &removal)?;
        Ok(radargram)
    }

    /// Share of its amplitude that an echo, one value a trace at one frequency, keeps in an image that sums
    /// the echo in phase; none for an echo without power, or for a wrong number of traces.
    #[must_use]
    pub fn kept(&self, frequency_hz: f64, echo: &[Complex64]) -> Option<f64> {
        if echo.len() != self.surface_s.len() {
            return None;
        }
        let power: f64 = echo.iter().map(Complex64::norm_sqr).sum();
        let turns = -TAU * frequency_hz;
        let mut sums = Sums::default();
        for (value, t) in echo.iter().zip(&self.surface_s) {
            sums.add(*value, Complex64::from_polar(1.0, turns * t));
        }
        let [constant, surface] = sums.fitted(echo.len());
        // hᴴ P h = a conj(Σ conj(h)) + …: the fitted amplitudes times the sums of the fit.
        let taken = (sums.constant.conj() * constant + sums.surface.conj() * surface).re;
        (power > 0.0).then(|| 1.0 - taken / power)
    }
}

/// Sums over the traces at one frequency.
#[derive(Clone, Copy, Default)]
struct Sums {
    /// Sum of the values.
    constant: Complex64,
    /// Sum of the values times the conjugate of the surface's vector.
    surface: Complex64,
    /// Sum of the surface's vector.
    vector: Complex64,
}

impl Sums {
    fn add(&mut self, value: Complex64, vector: Complex64) {
        self.constant += value;
        self.surface += value * vector.conj();
        self.vector += vector;
    }

    /// Least-squares amplitudes of the constant vector and the surface's vector.
    fn fitted(&self, traces: usize) -> [Complex64; 2] {
        let count = traces as f64;
        // The part of the surface's vector that is orthogonal to the constant one: its share of the power.
        let apart = 1.0 - (self.vector / count).norm_sqr();
        if apart <= APART * APART {
            return [self.constant / count, Complex64::default()];
        }
        let surface = (self.surface - self.constant * self.vector.conj() / count) / (count * apart);
        [(self.constant - surface * self.vector) / count, surface]
    }
}

struct Removal<'a> {
    surface_s: &'a [f64],
    step_s: f64,
    control: Control<'a>,
}

/// Traces whose transforms are held at a time.
const BLOCK: usize = 64;

impl Removal<'_> {
    /// Length of a transform: the trace and the largest shift fit in it without wrapping round.
    fn length(&self, samples: usize) -> usize {
        let most = self.surface_s.iter().fold(0.0_f64, |m, t| m.max(t.abs()));
        let shift = (most / self.step_s).ceil().min(samples as f64) as usize;
        (samples + 2 * shift + 64).next_power_of_two()
    }

    /// The surface's vector at bin `k` of `length`, for a trace.
    fn vector(&self, trace: usize, k: usize, length: usize) -> Complex64 {
        let signed = if 2 * k <= length {
            k as f64
        } else {
            k as f64 - length as f64
        };
        if 2 * k == length {
            // The middle bin of real samples is real.
            return Complex64::new(1.0, 0.0);
        }
        let turns = -TAU * signed / (length as f64 * self.step_s);
        Complex64::from_polar(1.0, turns * self.surface_s[trace])
    }
}

fn transformed<V: Value>(row: &[V], length: usize, fft: &Arc<dyn Fft<f64>>) -> Vec<Complex64> {
    let mut values: Vec<Complex64> = row.iter().map(|v| v.wide()).collect();
    values.resize(length, Complex64::default());
    fft.process(&mut values);
    values
}

impl InPlace for Removal<'_> {
    fn run<V: Value>(&self, samples: &mut [V], shape: Shape) -> Result<(), Cancelled> {
        let (traces, n) = (shape.traces, shape.samples_per_trace);
        if n == 0 {
            return Ok(());
        }
        let length = self.length(n);
        let mut planner = FftPlanner::new();
        let (forward, inverse) = (
            planner.plan_fft_forward(length),
            planner.plan_fft_inverse(length),
        );
        let mut sums = vec![Sums::default(); length];
        for (block, rows) in samples.chunks(BLOCK * n).enumerate() {
            self.control.check()?;
            let spectra: Vec<Vec<Complex64>> = rows
                .par_chunks(n)
                .map(|row| transformed(row, length, &forward))
                .collect();
            sums.par_iter_mut().enumerate().for_each(|(k, sum)| {
                for (i, spectrum) in spectra.iter().enumerate() {
                    sum.add(spectrum[k], self.vector(block * BLOCK + i, k, length));
                }
            });
        }
        let fitted: Vec<[Complex64; 2]> = sums.iter().map(|s| s.fitted(traces)).collect();
        self.control.check()?;
        let scale = 1.0 / length as f64;
        samples
            .par_chunks_exact_mut(n)
            .enumerate()
            .try_for_each(|(trace, row)| {
                self.control.check()?;
                let mut part: Vec<Complex64> = fitted
                    .iter()
                    .enumerate()
                    .map(|(k, [constant, surface])| {
                        constant + surface * self.vector(trace, k, length)
                    })
                    .collect();
                inverse.process(&mut part);
                for (v, p) in row.iter_mut().zip(part) {
                    *v = V::narrow(v.wide() - p * scale);
                }
                Ok(())
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radargram::Samples;

    const TRACES: usize = 48;
    const SAMPLES: usize = 400;
    const STEP_S: f64 = 40e-12;

    fn ricker(t_s: f64) -> f64 {
        let x = (std::f64::consts::PI * 1.3e9 * t_s).powi(2);
        (1.0 - 2.0 * x) * (-x).exp()
    }

    /// Two-way times to a surface 0.9 m below an antenna that rises and falls by 4 cm.
    fn surface_s() -> Vec<f64> {
        (0..TRACES)
            .map(|m| 6.0e-9 + 0.27e-9 * (0.21 * m as f64).sin())
            .collect()
    }

    fn target_s(m: usize) -> f64 {
        let along_m = 0.04 * (m as f64 - 24.0);
        (2.0 * 1.1_f64.hypot(along_m)) / 0.299_792_458 * 1e-9
    }

    fn traces(value: impl Fn(usize, f64) -> f64) -> Radargram {
        let samples = (0..TRACES)
            .flat_map(|m| (0..SAMPLES).map(move |k| (m, k as f64 * STEP_S)))
            .map(|(m, t)| value(m, t) as f32)
            .collect();
        let time_s = (0..TRACES).map(|m| m as f64).collect();
        Radargram::new(time_s, 0.0, STEP_S, Samples::Real(samples)).unwrap()
    }

    fn power(radargram: &Radargram) -> f64 {
        (0..radargram.samples.len())
            .map(|k| radargram.samples.at(k).norm_sqr())
            .sum()
    }

    #[test]
    fn coupling_and_surface_leave_and_a_target_stays() {
        let s = surface_s();
        let clutter = |m: usize, t: f64| 1000.0 * ricker(t - 1.5e-9) + 100.0 * ricker(t - s[m]);
        let removal = SurfaceRemoval::new(&s).unwrap();
        let remove = |r: Radargram| removal.remove(r, Control::default()).unwrap();
        let alone = remove(traces(clutter));
        let before = power(&traces(clutter));
        // Single precision of the samples limits the residual: 120 dB below.
        assert!(power(&alone) < 1e-12 * before, "{}", power(&alone) / before);
        let target = |m: usize, t: f64| ricker(t - target_s(m));
        let kept = remove(traces(target));
        let both = remove(traces(|m, t| clutter(m, t) + target(m, t)));
        // Two directions of 48, with which an echo that is level near its vertex overlaps more.
        let ratio = power(&kept) / power(&traces(target));
        assert!(ratio > 0.75, "{ratio}");
        let off: f64 = (0..both.samples.len())
            .map(|k| (both.samples.at(k) - kept.samples.at(k)).norm_sqr())
            .sum();
        assert!(off < 1e-4 * power(&kept), "{}", off / power(&kept));
    }

    #[test]
    fn the_share_kept_is_that_of_the_removal() {
        let s = surface_s();
        let removal = SurfaceRemoval::new(&s).unwrap();
        for f in [0.6e9, 1.3e9, 2.4e9] {
            let echo: Vec<Complex64> = (0..TRACES)
                .map(|m| Complex64::from_polar(1.0, -TAU * f * target_s(m)))
                .collect();
            // Complex traces that hold the echo at one frequency, in all of a transform's bins.
            let row = |m: usize| {
                let h = echo[m];
                (0..SAMPLES).map(move |k| {
                    let z = h * Complex64::from_polar(1.0, TAU * f * k as f64 * STEP_S);
                    num_complex::Complex32::new(z.re as f32, z.im as f32)
                })
            };
            let values = (0..TRACES).flat_map(row).collect();
            let time_s = (0..TRACES).map(|m| m as f64).collect();
            let raw = Radargram::new(time_s, 0.0, STEP_S, Samples::Complex(values)).unwrap();
            let left = removal.remove(raw.clone(), Control::default()).unwrap();
            let middle = SAMPLES / 2;
            let product: f64 = (0..TRACES)
                .map(|m| {
                    let k = m * SAMPLES + middle;
                    (raw.samples.at(k).conj() * left.samples.at(k)).re
                })
                .sum();
            let expected = product / TRACES as f64;
            let kept = removal.kept(f, &echo).unwrap();
            assert!((kept - expected).abs() < 0.02, "{kept} {expected}");
        }
    }

    #[test]
    fn a_constant_height_takes_the_mean_alone() {
        let removal = SurfaceRemoval::new(&[3e-9; TRACES]).unwrap();
        let raw = traces(|m, t| ricker(t - target_s(m)) + ricker(t - 3e-9));
        let aligned = removal.remove(raw.clone(), Control::default()).unwrap();
        let mean = crate::clean::remove_background(raw, crate::clean::Background::Mean).unwrap();
        for k in 0..mean.samples.len() {
            assert!((aligned.samples.at(k) - mean.samples.at(k)).norm() < 1e-5);
        }
    }

    #[test]
    fn times_that_are_none_are_refused() {
        assert!(SurfaceRemoval::new(&[1e-9, 2e-9]).is_err());
        let found = SurfaceRemoval::new(&[1e-9, f64::NAN, 2e-9]).unwrap_err();
        assert_eq!(found, CleanError::SurfaceTime { trace: 1 });
    }
}
