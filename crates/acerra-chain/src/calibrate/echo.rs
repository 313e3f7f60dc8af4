//! Range profiles of a track, matched to the band of the pulse, and the echoes read from them.

use acerra_imaging::delay_sums::{DelaySums, Delays, MixedTraces};
use acerra_radar::Radargram;
use acerra_radar::clean::for_analytic_rows;
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;

/// Envelopes of the traces of a track, over fast time.
#[derive(Clone, Debug)]
pub(super) struct Profiles {
    /// Radar time of each trace (s).
    pub time_s: Vec<f64>,
    /// Median of each trace's envelope: the measure of noise and clutter.
    pub floor: Vec<f64>,
    start_s: f64,
    step_s: f64,
    samples: usize,
    envelope: Vec<f32>,
    /// Analytic traces, mixed down by the middle of the band.
    mixed: Vec<Complex32>,
    middle_hz: f64,
}

/// An echo: the crest of an envelope.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crest {
    /// Fast time (s).
    pub fast_time_s: f64,
    /// Level, in units of the trace's floor.
    pub contrast: f64,
}

impl Profiles {
    /// The envelopes of the signals within a band (Hz).
    pub fn new(radargram: &Radargram, band_hz: [f64; 2]) -> Self {
        let middle_hz = 0.5 * (band_hz[0] + band_hz[1]);
        let mixed = mixed_down(radargram, band_hz);
        let envelope: Vec<f32> = mixed.iter().map(|z| z.norm()).collect();
        let floor = envelope
            .par_chunks_exact(radargram.samples_per_trace)
            .map(|row| median(row.iter().map(|v| f64::from(*v))).max(f64::MIN_POSITIVE))
            .collect();
        Self {
            time_s: radargram.time_s.clone(),
            floor,
            start_s: radargram.fast_time_start_s,
            step_s: radargram.fast_time_step_s,
            samples: radargram.samples_per_trace,
            envelope,
            mixed,
            middle_hz,
        }
    }

    fn row(&self, trace: usize) -> &[f32] {
        &self.envelope[trace * self.samples..(trace + 1) * self.samples]
    }

    /// The analytic signal of a trace, mixed down by [`Profiles::middle_hz`], between samples by a straight
    /// line; zero beyond the record.
    pub fn mixed_at(&self, trace: usize, fast_time_s: f64) -> Complex32 {
        let place = (fast_time_s - self.start_s) / self.step_s;
        if !(place >= 0.0 && place + 1.0 < self.samples as f64) {
            return Complex32::default();
        }
        let before = trace * self.samples + place as usize;
        let part = place.fract() as f32;
        self.mixed[before] * (1.0 - part) + self.mixed[before + 1] * part
    }

    /// The traces arranged for coherent sums at many delays.
    pub fn sums_at(&self, delays: Delays) -> DelaySums {
        let traces = MixedTraces {
            samples: &self.mixed,
            samples_per_trace: self.samples,
            start_s: self.start_s,
            step_s: self.step_s,
            carrier_hz: self.middle_hz,
        };
        DelaySums::new(&traces, delays)
    }

    /// The frequency by which signals are mixed down (Hz).
    pub fn middle_hz(&self) -> f64 {
        self.middle_hz
    }

    /// The envelope at the sample nearest to a fast time, in units of the floor.
    pub fn contrast_at(&self, trace: usize, fast_time_s: f64) -> Option<f64> {
        let index = ((fast_time_s - self.start_s) / self.step_s).round();
        if !(index >= 0.0 && index < self.samples as f64) {
            return None;
        }
        Some(f64::from(self.row(trace)[index as usize]) / self.floor[trace])
    }

    /// The highest crest within `half_width_s` of a fast time; none where the window leaves the
    /// record or the envelope is highest at an end of the window.
    pub fn crest(&self, trace: usize, fast_time_s: f64, half_width_s: f64) -> Option<Crest> {
        let at = |t: f64| (t - self.start_s) / self.step_s;
        let first = at(fast_time_s - half_width_s).ceil();
        let last = at(fast_time_s + half_width_s).floor();
        if !(first >= 1.0 && last + 2.0 < self.samples as f64 && first + 2.0 < last) {
            return None;
        }
        let (first, last) = (first as usize, last as usize);
        let row = self.row(trace);
        let top = (first..=last).max_by(|a, b| row[*a].total_cmp(&row[*b]))?;
        if top == first || top == last {
            return None;
        }
        let (fraction, level) = vertex(row, top);
        Some(Crest {
            fast_time_s: self.start_s + (top as f64 + fraction) * self.step_s,
            contrast: level / self.floor[trace],
        })
    }

    /// Spacing of the samples (s).
    pub fn step_s(&self) -> f64 {
        self.step_s
    }

    /// First and last fast time of the record (s).
    pub fn span_s(&self) -> [f64; 2] {
        let last = self.samples.saturating_sub(1) as f64;
        [self.start_s, self.start_s + last * self.step_s]
    }
}

/// Vertex of the least-squares parabola through the upper third of a crest, taken symmetrically
/// about it: its place in samples from `top`, and its height.
fn vertex(row: &[f32], top: usize) -> (f64, f64) {
    const MOST_SAMPLES: usize = 32;
    let floor = row[top] * (2.0 / 3.0);
    let above = |v: &&f32| **v >= floor;
    let left = row[..top].iter().rev().take(MOST_SAMPLES);
    let right = row[top + 1..].iter().take(MOST_SAMPLES);
    let reach = left
        .take_while(above)
        .count()
        .min(right.take_while(above).count())
        .max(1);
    let (mut s2, mut s4, mut y0, mut y1, mut y2) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (k, y) in row[top - reach..=top + reach].iter().enumerate() {
        let (x, y) = (k as f64 - reach as f64, f64::from(*y));
        s2 += x * x;
        s4 += x.powi(4);
        y0 += y;
        y1 += x * y;
        y2 += x * x * y;
    }
    let n = (2 * reach + 1) as f64;
    let curvature = (n * y2 - s2 * y0) / (n * s4 - s2 * s2);
    if curvature >= 0.0 {
        return (0.0, f64::from(row[top]));
    }
    let fraction = (-0.5 * (y1 / s2) / curvature).clamp(-1.0, 1.0);
    let constant = (y0 - curvature * s2) / n;
    (fraction, constant + 0.5 * (y1 / s2) * fraction)
}

/// The analytic signal within a band, mixed down by the middle of the band, row by row; complex samples keep
/// their band.
fn mixed_down(radargram: &Radargram, band_hz: [f64; 2]) -> Vec<Complex32> {
    let n = radargram.samples_per_trace;
    let middle_hz = 0.5 * (band_hz[0] + band_hz[1]);
    let mixer: Vec<Complex64> = (0..n)
        .map(|k| radargram.fast_time_start_s + k as f64 * radargram.fast_time_step_s)
        .map(|t| Complex64::cis(-std::f64::consts::TAU * middle_hz * t))
        .collect();
    let single = |z: Complex64| Complex32::new(z.re as f32, z.im as f32);
    if radargram.samples.is_complex() {
        let mix = |i: usize| single(radargram.samples.at(i) * mixer[i % n]);
        return (0..radargram.samples.len()).map(mix).collect();
    }
    let mut out = vec![Complex32::default(); radargram.samples.len()];
    let gain = |frequency_hz| pass(frequency_hz, band_hz);
    for_analytic_rows(radargram, gain, &mut out, |work, row| {
        for ((out, z), mixer) in row.iter_mut().zip(work).zip(&mixer) {
            *out = single(z * mixer);
        }
    });
    out
}

/// A cosine window over a band. A flat band leaves range sidelobes of −13 dB, by which the surface echo
/// and other reflectors displace a crest; these leave −23 dB, and cost half the signal-to-noise ratio that
/// a Hann window would (0.9 dB of 1.8 dB).
fn pass(frequency_hz: f64, [from_hz, to_hz]: [f64; 2]) -> f64 {
    let place = (frequency_hz - from_hz) / (to_hz - from_hz);
    if (0.0..=1.0).contains(&place) {
        (std::f64::consts::PI * place).sin()
    } else {
        0.0
    }
}

/// The median of some numbers; zero of an empty list.
pub(super) fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
