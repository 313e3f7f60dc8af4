//! What removing the background leaves of an echo.
//!
//! The mean, the mean of a window and principal components act on the traces alone, alike at every fast
//! time and frequency: what is left of an echo h (one complex number a trace) is (I − P)h. An image that
//! sums the echoes of a point in phase keeps the share hᴴ(I − P)h / hᴴh of its amplitude.

use num_complex::Complex64;

use super::CleanError;
use super::background::Background;
use super::components::strongest_directions;
use crate::control::Control;
use crate::radargram::{Radargram, Samples};

/// The removal of a background, as it acts on the echo of a point.
#[derive(Clone, Debug)]
pub struct BackgroundGain {
    traces: usize,
    removed: Removed,
}

/// P, the part of an echo that is taken for background.
#[derive(Clone, Debug)]
enum Removed {
    Nothing,
    Mean,
    Sliding { half: usize },
    Directions(Vec<Vec<Complex64>>),
}

impl BackgroundGain {
    /// The removal as it is estimated on `raw`; none for the median, which acts on no echo linearly.
    ///
    /// # Errors
    /// [`CleanError::Cancelled`].
    pub fn of(
        raw: &Radargram,
        background: Background,
        control: Control<'_>,
    ) -> Result<Option<Self>, CleanError> {
        let shape = [raw.traces, raw.samples_per_trace];
        let removed = match background {
            Background::None => Removed::Nothing,
            Background::Mean => Removed::Mean,
            Background::Sliding { window } => Removed::Sliding { half: window / 2 },
            Background::Components { components } => Removed::Directions(match &raw.samples {
                Samples::Real(v) => strongest_directions(v, shape, components, control)?,
                Samples::Complex(v) => strongest_directions(v, shape, components, control)?,
            }),
            Background::Median => return Ok(None),
        };
        Ok(Some(Self {
            traces: raw.traces,
            removed,
        }))
    }

    /// Share of its amplitude that an echo keeps in an image which sums it in phase; none where the echo
    /// has not one value a trace, or no power.
    ///
    /// ```
    /// use acerra_radar::{Radargram, Samples, clean::{Background, BackgroundGain}};
    /// use acerra_radar::Control;
    /// use num_complex::Complex64;
    /// let raw = Radargram::new(
    ///     vec![0.0, 1.0], 0.0, 1e-9, Samples::Real(vec![5.0, 1.0, 5.0, 3.0]),
    /// )?;
    /// let gain = BackgroundGain::of(&raw, Background::Mean, Control::new())?.unwrap();
    /// let [one, minus] = [1.0, -1.0].map(|re| Complex64::new(re, 0.0));
    /// assert_eq!(gain.kept(&[one, one]), Some(0.0));
    /// assert_eq!(gain.kept(&[one, minus]), Some(1.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn kept(&self, echo: &[Complex64]) -> Option<f64> {
        let power: f64 = echo.iter().map(Complex64::norm_sqr).sum();
        if echo.len() != self.traces || power.is_nan() || power <= 0.0 {
            return None;
        }
        Some(1.0 - self.taken(echo) / power)
    }

    /// hᴴPh.
    fn taken(&self, echo: &[Complex64]) -> f64 {
        match &self.removed {
            Removed::Nothing => 0.0,
            Removed::Mean => echo.iter().sum::<Complex64>().norm_sqr() / self.traces as f64,
            Removed::Sliding { half } => sliding_product(echo, *half),
            Removed::Directions(directions) => directions
                .iter()
                .map(|u| {
                    let along: Complex64 = u.iter().zip(echo).map(|(u, h)| u.conj() * h).sum();
                    along.norm_sqr()
                })
                .sum(),
        }
    }
}

/// Real part of Σᵢ conj(hᵢ) · (mean of h over the window about i).
fn sliding_product(echo: &[Complex64], half: usize) -> f64 {
    let mut before = Vec::with_capacity(echo.len() + 1);
    let mut sum = Complex64::default();
    before.push(sum);
    for value in echo {
        sum += value;
        before.push(sum);
    }
    let mean_about = |i: usize| {
        let (from, to) = (i.saturating_sub(half), (i + half + 1).min(echo.len()));
        (before[to] - before[from]) / (to - from) as f64
    };
    echo.iter()
        .enumerate()
        .map(|(i, h)| (h.conj() * mean_about(i)).re)
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clean::remove_background;

    const TRACES: usize = 60;
    const SAMPLES: usize = 40;

    /// The echo of a point passed at 3 m distance at one frequency, and a radargram about it.
    fn echo() -> Vec<Complex64> {
        (0..TRACES)
            .map(|t| {
                let along_m = 0.1 * t as f64 - 3.0;
                Complex64::from_polar(1.0, -166.0 * 3.0_f64.hypot(along_m))
            })
            .collect()
    }

    /// Rows of the echo at each sample, under a strong still background and weak noise.
    fn radargram(amplitude: f64) -> Radargram {
        let mut state = 7u64;
        let mut noise = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 40) as f64 / (1u64 << 24) as f64 - 0.5
        };
        let samples = echo()
            .iter()
            .flat_map(|h| {
                (0..SAMPLES)
                    .map(|j| {
                        let still = 30.0 * (j as f64).cos();
                        let z = amplitude * h + still + Complex64::new(noise(), noise());
                        num_complex::Complex32::new(z.re as f32, z.im as f32)
                    })
                    .collect::<Vec<_>>()
            })
            .collect();
        let time_s = (0..TRACES).map(|t| t as f64).collect();
        Radargram::new(time_s, 0.0, 1e-9, Samples::Complex(samples)).unwrap()
    }

    /// The share kept, by removing the background of traces that hold the echo in place of their own.
    fn kept_by_removal(background: Background) -> f64 {
        let h = echo();
        let mut alone = radargram(0.0);
        let values = h.iter().flat_map(|h| {
            std::iter::repeat_n(
                num_complex::Complex32::new(h.re as f32, h.im as f32),
                SAMPLES,
            )
        });
        alone.samples = Samples::Complex(values.collect());
        let left = remove_background(alone, background).unwrap();
        let sum: Complex64 = (0..TRACES)
            .map(|t| h[t].conj() * left.samples.at(t * SAMPLES))
            .sum();
        sum.re / TRACES as f64
    }

    #[test]
    fn mean_and_window_leave_what_their_removal_leaves() {
        for background in [
            Background::None,
            Background::Mean,
            Background::Sliding { window: 5 },
            Background::Sliding { window: 21 },
        ] {
            let gain = BackgroundGain::of(&radargram(0.0), background, Control::new());
            let kept = gain.unwrap().unwrap().kept(&echo()).unwrap();
            let expected = kept_by_removal(background);
            assert!((kept - expected).abs() < 1e-5, "{kept} for {expected}");
        }
    }

    #[test]
    fn components_take_an_echo_that_is_among_the_strongest() {
        let of = |amplitude, components| {
            let background = Background::Components { components };
            let raw = radargram(amplitude);
            let gain = BackgroundGain::of(&raw, background, Control::new());
            gain.unwrap().unwrap().kept(&echo()).unwrap()
        };
        // The still background comes first, the echo second.
        assert!(of(5.0, 1) > 0.9, "{}", of(5.0, 1));
        assert!(of(5.0, 2) < 0.02, "{}", of(5.0, 2));
        // No echo in the data: two directions of noise among sixty take little of it.
        assert!(of(0.0, 3) > 0.8, "{}", of(0.0, 3));
    }

    #[test]
    fn an_echo_of_another_length_or_without_power_says_nothing() {
        let gain = BackgroundGain::of(&radargram(0.0), Background::Mean, Control::new());
        let gain = gain.unwrap().unwrap();
        assert_eq!(gain.kept(&[Complex64::default(); TRACES]), None);
        assert_eq!(gain.kept(&echo()[1..]), None);
    }
}
