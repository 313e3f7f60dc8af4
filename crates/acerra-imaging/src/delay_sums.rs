//! Coherent sums of traces along a curve of fast time, at every delay of an even set: the quantity that a
//! search over delays evaluates at each possible place of an echo.
//!
//! The traces are resampled so that the delay step is a whole number of samples, and samples are stored by
//! their remainder modulo that number: values at consecutive delays are adjacent, whatever the fast time of
//! the first.

use num_complex::Complex32;

use crate::kernel::delay_sums::{BLOCK, Term, sum, weighted_phasors};
use crate::kernel::dispatch::dispatch;
use crate::kernel::lanes::{DOUBLES, Lanes};
use crate::kernel::level::SimdLevel;

/// Traces mixed down by a carrier, evenly sampled in fast time.
#[derive(Debug, Clone, Copy)]
pub struct MixedTraces<'a> {
    /// Samples, `[traces, samples]` row-major.
    pub samples: &'a [Complex32],
    /// Samples of a trace.
    pub samples_per_trace: usize,
    /// Fast time of the first sample (s).
    pub start_s: f64,
    /// Spacing of the samples (s).
    pub step_s: f64,
    /// Frequency by which the traces are mixed down (Hz).
    pub carrier_hz: f64,
}

/// Delays `start_s` + k · `step_s`.
#[derive(Debug, Clone, Copy)]
pub struct Delays {
    /// The first (s).
    pub start_s: f64,
    /// Spacing (s), above 0.
    pub step_s: f64,
    /// Number of delays.
    pub count: usize,
}

/// An echo's fast time in some of the traces.
#[derive(Debug, Clone, Copy)]
pub struct EchoCurve<'a> {
    /// Numbers of the traces.
    pub trace: &'a [usize],
    /// Weight of each trace.
    pub weight: &'a [f64],
    /// Fast time of the echo in each trace at zero delay (s).
    pub time_s: &'a [f64],
}

/// Working memory of [`DelaySums::powers`].
#[derive(Debug, Default)]
pub struct SumScratch {
    terms: Vec<Term>,
    re: Vec<f32>,
    im: Vec<f32>,
}

/// Traces arranged for sums at every delay of an even set.
///
/// ```
/// use acerra_imaging::delay_sums::{DelaySums, Delays, EchoCurve, MixedTraces, SumScratch};
/// use acerra_imaging::Complex32;
/// // Two traces whose echoes begin at samples 30 and 34, mixed down by 1 GHz.
/// let at = |first: usize, k: usize| Complex32::new(if k < first { 0.0 } else { 1.0 }, 0.0);
/// let samples: Vec<_> = [30, 34].iter().flat_map(|f| (0..80).map(|k| at(*f, k))).collect();
/// let traces = MixedTraces {
///     samples: &samples,
///     samples_per_trace: 80,
///     start_s: 0.0,
///     step_s: 0.25e-9,
///     carrier_hz: 1e9,
/// };
/// let delays = Delays { start_s: 0.0, step_s: 0.5e-9, count: 20 };
/// let sums = DelaySums::new(&traces, delays);
/// let curve = EchoCurve { trace: &[0, 1], weight: &[1.0; 2], time_s: &[5e-9, 6e-9] };
/// let scratch = &mut SumScratch::default();
/// let powers: Vec<f64> = sums.powers(curve, scratch).collect();
/// // From a delay of 2.5 ns on both traces show the echo, a whole cycle of the carrier apart.
/// assert!(powers[4] < 1e-9 && (powers[5] - 4.0).abs() < 1e-5);
/// ```
#[derive(Debug)]
pub struct DelaySums {
    level: SimdLevel,
    carrier_hz: f64,
    delays: usize,
    /// Earliest fast time of the table, and first delay (s).
    start_s: f64,
    first_delay_s: f64,
    /// Spacing of the table (s).
    step_s: f64,
    /// Samples of the table from one delay to the next.
    a_delay: usize,
    /// Number of samples of fast time at which a curve meets the record at some delay.
    places: f64,
    /// Numbers of a row.
    row: usize,
    /// `[traces, samples of a delay, parts, row]`.
    table: Vec<f32>,
}

impl DelaySums {
    /// Arranges traces, which are linear between samples and zero beyond the record. The table's spacing is
    /// the samples' spacing or a little less; the table covers the record and the span of the delays to
    /// either side.
    #[must_use]
    pub fn new(traces: &MixedTraces<'_>, delays: Delays) -> Self {
        Self::at_level(traces, delays, SimdLevel::detect())
    }

    fn at_level(traces: &MixedTraces<'_>, delays: Delays, level: SimdLevel) -> Self {
        let a_delay = (delays.step_s / traces.step_s).ceil().max(1.0) as usize;
        let step_s = delays.step_s / a_delay as f64;
        let padded = delays.count.next_multiple_of(BLOCK);
        let start_s = traces.start_s - padded as f64 * delays.step_s;
        let last = traces.samples_per_trace.saturating_sub(1) as f64;
        let places = (traces.start_s + last * traces.step_s - start_s) / step_s;
        let row = (places / a_delay as f64).ceil() as usize + 2 + padded;
        let mut table = Vec::new();
        for trace in traces.samples.chunks_exact(traces.samples_per_trace.max(1)) {
            for phase in 0..a_delay {
                let at = |q: usize| {
                    let time_s = start_s + (phase + q * a_delay) as f64 * step_s;
                    between(trace, (time_s - traces.start_s) / traces.step_s)
                };
                table.extend((0..row).map(|q| at(q).re));
                table.extend((0..row).map(|q| at(q).im));
            }
        }
        Self {
            level,
            carrier_hz: traces.carrier_hz,
            delays: delays.count,
            start_s,
            first_delay_s: delays.start_s,
            step_s,
            a_delay,
            places,
            row,
            table,
        }
    }

    /// Number of delays.
    #[must_use]
    pub fn delays(&self) -> usize {
        self.delays
    }

    /// |Σ w e^{j2πft} s(t + delay)|² over the traces of a curve, w the weight, f the carrier and t the fast
    /// time, at every delay. The lists of a curve are cut to the shortest.
    ///
    /// Panics where a trace number of the curve is beyond the traces.
    pub fn powers<'s>(
        &self,
        curve: EchoCurve<'_>,
        scratch: &'s mut SumScratch,
    ) -> impl Iterator<Item = f64> + use<'s> {
        let padded = self.delays.next_multiple_of(BLOCK);
        scratch.re.resize(padded, 0.0);
        scratch.im.resize(padded, 0.0);
        let SumScratch { terms, re, im } = scratch;
        terms.clear();
        dispatch!(self.level, s => {
            self.terms(s, curve, terms);
            sum(s, &self.table, self.row, terms, [re, im]);
        });
        let parts = re[..self.delays].iter().zip(&im[..self.delays]);
        parts.map(|(re, im)| f64::from(re * re + im * im))
    }

    /// The rows of the table that a curve reads, and their factors.
    #[inline(always)]
    fn terms<S: Lanes>(&self, s: S, curve: EchoCurve<'_>, terms: &mut Vec<Term>) {
        let count = (curve.time_s.len())
            .min(curve.trace.len())
            .min(curve.weight.len());
        for from in (0..count).step_by(DOUBLES) {
            let some = (count - from).min(DOUBLES);
            let (mut turns, mut weight) = ([0.0; DOUBLES], [0.0; DOUBLES]);
            for k in 0..some {
                turns[k] = self.carrier_hz * curve.time_s[from + k];
                weight[k] = curve.weight[from + k];
            }
            let factors = weighted_phasors(s, turns, weight);
            for (k, factor) in factors.into_iter().enumerate().take(some) {
                let time_s = curve.time_s[from + k] + self.first_delay_s;
                if let Some(term) = self.term(curve.trace[from + k], time_s, factor) {
                    terms.push(term);
                }
            }
        }
    }

    /// The two rows about a time, in proportion; none where no delay meets the record.
    #[inline(always)]
    fn term(&self, trace: usize, time_s: f64, [re, im]: [f64; 2]) -> Option<Term> {
        let place = (time_s - self.start_s) / self.step_s;
        if !(place >= 0.0 && place < self.places) {
            return None;
        }
        let before = place as usize;
        let part = place - before as f64;
        let row = |n: usize| {
            let (q, phase) = (n / self.a_delay, n % self.a_delay);
            2 * self.row * (trace * self.a_delay + phase) + q
        };
        let factor = |share: f64| [(share * re) as f32, (share * im) as f32];
        Some(Term {
            start: [row(before), row(before + 1)],
            factor: [factor(1.0 - part), factor(part)],
        })
    }
}

/// Linear interpolation of a trace, zero beyond the record.
fn between(trace: &[Complex32], place: f64) -> Complex32 {
    if !(place >= 0.0 && place + 1.0 < trace.len() as f64) {
        return Complex32::ZERO;
    }
    let before = place as usize;
    let part = place.fract() as f32;
    trace[before] * (1.0 - part) + trace[before + 1] * part
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_complex::Complex64;
    use std::f64::consts::TAU;

    const CARRIER_HZ: f64 = 3.95e9;
    const STEP_S: f64 = 61e-12;

    /// A tone of 300 MHz in seven traces of 400 samples from 3 ns on, each with a different phase.
    fn tone(trace: usize, time_s: f64) -> Complex64 {
        let record_s = [3e-9, 3e-9 + 399.0 * STEP_S];
        if time_s < record_s[0] || time_s > record_s[1] {
            return Complex64::ZERO;
        }
        Complex64::cis(TAU * 3e8 * time_s + 0.7 * trace as f64)
    }

    #[test]
    fn every_level_sums_along_any_curve() {
        let samples: Vec<Complex32> = (0..7 * 400)
            .map(|k| tone(k / 400, 3e-9 + (k % 400) as f64 * STEP_S))
            .map(|z| Complex32::new(z.re as f32, z.im as f32))
            .collect();
        let traces = MixedTraces {
            samples: &samples,
            samples_per_trace: 400,
            start_s: 3e-9,
            step_s: STEP_S,
            carrier_hz: CARRIER_HZ,
        };
        let delays = Delays {
            start_s: -20e-9,
            step_s: 0.45e-9,
            count: 90,
        };
        let trace: Vec<usize> = vec![6, 0, 2, 3, 1, 5, 4, 2, 0];
        let weight: Vec<f64> = (0..9).map(|k| 1.0 + 0.3 * f64::from(k)).collect();
        // Within the record, at its ends, and so far away that no delay meets it.
        for middle_s in [14.3e-9, 1e-9, 29e-9, 48.2e-9, -30e-9, 900e-9] {
            let time_s: Vec<f64> = (0..9)
                .map(|k| middle_s + 0.83e-9 * f64::from(k - 4))
                .collect();
            let expected = |d: usize| {
                let delay_s = delays.start_s + d as f64 * delays.step_s;
                let terms = (0..9).map(|k| {
                    let turned = Complex64::cis(TAU * CARRIER_HZ * time_s[k]) * weight[k];
                    turned * tone(trace[k], time_s[k] + delay_s)
                });
                terms.sum::<Complex64>().norm_sqr()
            };
            let is_at_end = |d: usize| {
                let delay_s = delays.start_s + d as f64 * delays.step_s;
                let ends_s = [3e-9, 3e-9 + 399.0 * STEP_S];
                let is_near = |t: &f64, end_s: f64| (t + delay_s - end_s).abs() < 2.0 * STEP_S;
                time_s.iter().any(|t| ends_s.iter().any(|e| is_near(t, *e)))
            };
            let curve = EchoCurve {
                trace: &trace,
                weight: &weight,
                time_s: &time_s,
            };
            for &level in SimdLevel::available() {
                let sums = DelaySums::at_level(&traces, delays, level);
                let scratch = &mut SumScratch::default();
                let found: Vec<f64> = sums.powers(curve, scratch).collect();
                assert_eq!(found.len(), 90);
                for (d, found) in found
                    .into_iter()
                    .enumerate()
                    .filter(|(d, _)| !is_at_end(*d))
                {
                    let expected = expected(d);
                    // Straight lines between samples of a tone: 1.7e-3 of its amplitude, twice.
                    let most = 0.01 * expected.sqrt() * 19.8 + 1e-4;
                    assert!(
                        (found - expected).abs() < most,
                        "{level} {middle_s} {d}: {found} for {expected}"
                    );
                }
            }
        }
    }
}
