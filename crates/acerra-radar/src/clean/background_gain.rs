//! Share of an echo that remains after background removal.
//!
//! The mean and the mean of a window combine traces in the same way at every fast time and frequency: an echo
//! h (one complex number a trace) becomes (I − P)h. An image that sums the echoes of a point in phase keeps
//! the share hᴴ(I − P)h / hᴴh of its amplitude.

use std::ops::Range;

use num_complex::Complex64;

use super::background::Background;

/// Background removal as an operator on the echo of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BackgroundGain {
    /// Nothing is removed.
    None,
    /// The mean of all traces.
    Mean,
    /// The mean of the traces about each trace.
    Sliding {
        /// Traces of the window to either side.
        half: usize,
    },
}

impl BackgroundGain {
    /// The operator; none for the median, which is not linear, and for principal components, which depend on
    /// all echoes of the traces.
    #[must_use]
    pub const fn of(background: Background) -> Option<Self> {
        match background {
            Background::None => Some(Self::None),
            Background::Mean => Some(Self::Mean),
            Background::Sliding { window } => Some(Self::Sliding { half: window / 2 }),
            Background::Components { .. } | Background::Median => None,
        }
    }

    /// Share of its amplitude that an echo, one value a trace, keeps in an image that sums the echo in phase;
    /// none for an echo without power. `lines` are the ranges of traces at whose ends a sliding window ends.
    ///
    /// ```
    /// use acerra_radar::clean::{Background, BackgroundGain};
    /// use num_complex::Complex64;
    /// let gain = BackgroundGain::of(Background::Mean).unwrap();
    /// let [one, minus] = [1.0, -1.0].map(|re| Complex64::new(re, 0.0));
    /// assert_eq!(gain.kept(&[one, one], &[0..2]), Some(0.0));
    /// assert_eq!(gain.kept(&[one, minus], &[0..2]), Some(1.0));
    /// ```
    #[must_use]
    pub fn kept(self, echo: &[Complex64], lines: &[Range<usize>]) -> Option<f64> {
        let power: f64 = echo.iter().map(Complex64::norm_sqr).sum();
        let taken = match self {
            Self::None => 0.0,
            Self::Mean => echo.iter().sum::<Complex64>().norm_sqr() / echo.len() as f64,
            Self::Sliding { half } => {
                let own = |line: &Range<usize>| echo.get(line.clone()).unwrap_or_default();
                lines.iter().map(|l| sliding_product(own(l), half)).sum()
            }
        };
        (power > 0.0).then(|| 1.0 - taken / power)
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
        let (from, to) = (
            i.saturating_sub(half),
            i.saturating_add(half + 1).min(echo.len()),
        );
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
    use crate::radargram::{Radargram, Samples};
    use num_complex::Complex32;

    const TRACES: usize = 60;

    /// The echo of a point passed at 3 m distance at one frequency.
    fn echo() -> Vec<Complex64> {
        (0..TRACES)
            .map(|t| {
                let along_m = 0.1 * t as f64 - 3.0;
                Complex64::from_polar(1.0, -166.0 * 3.0_f64.hypot(along_m))
            })
            .collect()
    }

    /// The share kept, measured by removing the background of traces that hold the echo.
    fn kept_by_removal(background: Background) -> f64 {
        let h = echo();
        let values = h
            .iter()
            .flat_map(|h| [Complex32::new(h.re as f32, h.im as f32); 2]);
        let time_s = (0..TRACES).map(|t| t as f64).collect();
        let traces = Radargram::new(time_s, 0.0, 1e-9, Samples::Complex(values.collect())).unwrap();
        let left = remove_background(traces, background).unwrap();
        let sum: Complex64 = (0..TRACES)
            .map(|t| h[t].conj() * left.samples.at(2 * t))
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
            let kept = BackgroundGain::of(background)
                .unwrap()
                .kept(&echo(), std::slice::from_ref(&(0..TRACES)));
            let (kept, expected) = (kept.unwrap(), kept_by_removal(background));
            assert!((kept - expected).abs() < 1e-5, "{kept} for {expected}");
        }
        // A window longer than the lines takes the mean of each.
        let lines = [0..20, 20..TRACES];
        let long = BackgroundGain::Sliding { half: 1000 };
        let of_lines = long.kept(&echo(), &lines).unwrap();
        let by_hand = lines.iter().map(|line| {
            let sum: Complex64 = echo()[line.clone()].iter().sum();
            sum.norm_sqr() / line.len() as f64
        });
        let by_hand = 1.0 - by_hand.sum::<f64>() / TRACES as f64;
        assert!((of_lines - by_hand).abs() < 1e-9, "{of_lines} {by_hand}");
        // A window of a few traces removes the echo where it changes slowly.
        let short = BackgroundGain::of(Background::Sliding { window: 5 }).unwrap();
        assert!(
            short
                .kept(&echo(), std::slice::from_ref(&(0..TRACES)))
                .unwrap()
                < 0.9
        );
    }

    #[test]
    fn an_echo_without_power_says_nothing() {
        let gain = BackgroundGain::of(Background::Mean).unwrap();
        assert_eq!(
            gain.kept(&[Complex64::default(); 4], std::slice::from_ref(&(0..4))),
            None
        );
        assert_eq!(gain.kept(&[], &[]), None);
    }
}
