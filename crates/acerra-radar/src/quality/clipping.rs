//! Samples at the receiver's limit.

use crate::radargram::{Radargram, Samples};

/// How much of a radargram is clipped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clipping {
    /// The limit: largest modulus of a sample.
    pub level: f64,
    /// Share of all samples that are at the limit among others that do.
    pub share: f64,
    /// Share of the traces that hold such samples.
    pub traces_share: f64,
}

/// Samples at the receiver's limit: those that equal the largest modulus of their sign and stand
/// beside another one that does, in the same trace or at the same fast time of the next trace. A
/// maximum that is met once is a maximum; one that is met again and again is a limit.
///
/// None for complex samples, where a limit leaves no mark of this kind.
///
/// ```
/// use acerra_radar::quality::clipping;
/// use acerra_radar::{Radargram, Samples};
/// let trace = |top: f32| (0..64).map(move |k| (1.5 * (k as f32 * 0.4).sin()).clamp(-top, top));
/// let radargram = |top| Radargram::new(vec![0.0], 0.0, 1e-9, Samples::Real(trace(top).collect()));
/// assert!(clipping(&radargram(1.0)?).is_some_and(|c| c.share > 0.3));
/// assert!(clipping(&radargram(2.0)?).is_some_and(|c| c.share == 0.0));
/// # Ok::<(), acerra_radar::RadargramError>(())
/// ```
#[must_use]
pub fn clipping(radargram: &Radargram) -> Option<Clipping> {
    let Samples::Real(samples) = &radargram.samples else {
        return None;
    };
    let n = radargram.samples_per_trace;
    let low = samples.iter().copied().fold(f32::INFINITY, f32::min);
    let high = samples.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let at_limit = |i: usize| samples[i] == low || samples[i] == high;
    let level = f64::from(high.abs().max(low.abs()));
    if low == high {
        return Some(Clipping {
            level,
            share: 0.0,
            traces_share: 0.0,
        });
    }
    let is_clipped = |i: usize| {
        let same = |j: usize| samples[j] == samples[i];
        let column = i % n;
        at_limit(i)
            && ((column > 0 && same(i - 1))
                || (column + 1 < n && same(i + 1))
                || (i >= n && same(i - n))
                || (i + n < samples.len() && same(i + n)))
    };
    let (mut count, mut traces) = (0usize, 0usize);
    for first in (0..samples.len()).step_by(n) {
        let clipped = (first..first + n).filter(|&i| is_clipped(i)).count();
        count += clipped;
        traces += usize::from(clipped > 0);
    }
    Some(Clipping {
        level,
        share: count as f64 / samples.len() as f64,
        traces_share: traces as f64 / radargram.traces as f64,
    })
}
