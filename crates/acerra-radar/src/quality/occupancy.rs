//! The band that the radar's energy occupies.

use num_complex::Complex64;
use rustfft::FftPlanner;

use crate::radargram::Radargram;

/// Largest number of traces averaged.
const TRACES: usize = 512;
/// Level below the spectrum's top down to which frequencies are occupied, dB.
const OCCUPIED_DB: f64 = 10.0;
/// Width over which the spectrum is smoothed, Hz.
const SMOOTH_HZ: f64 = 50e6;

/// Mean power spectrum of a radargram's traces.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectrumOccupancy {
    /// Frequencies, Hz, from 0 up to half the sampling rate (the whole rate for complex samples).
    pub frequency_hz: Vec<f64>,
    /// Mean power at each, less the noise, in samples' units squared.
    pub power: Vec<f64>,
    /// Lowest and highest frequency within 10 dB of the top of the smoothed spectrum, Hz.
    pub band_hz: [f64; 2],
}

impl SpectrumOccupancy {
    /// Share of the energy within a band, 0 to 1.
    #[must_use]
    pub fn share_within(&self, [from_hz, to_hz]: [f64; 2]) -> f64 {
        let inside = |f: &f64| (from_hz..=to_hz).contains(f);
        let total: f64 = self.power.iter().sum();
        let part: f64 = self
            .frequency_hz
            .iter()
            .zip(&self.power)
            .filter(|(f, _)| inside(f))
            .map(|(_, p)| p)
            .sum();
        if total > 0.0 { part / total } else { 0.0 }
    }

    /// Share of a band that the energy occupies, 0 to 1.
    #[must_use]
    pub fn occupied_share_of(&self, [from_hz, to_hz]: [f64; 2]) -> f64 {
        let common = self.band_hz[1].min(to_hz) - self.band_hz[0].max(from_hz);
        (common / (to_hz - from_hz)).clamp(0.0, 1.0)
    }
}

/// The band of the energy of up to 512 traces, evenly spread. The noise is the median of the lower half of
/// all frequencies' power. None where every sample is zero.
#[must_use]
pub fn spectrum_occupancy(radargram: &Radargram) -> Option<SpectrumOccupancy> {
    let n = radargram.samples_per_trace;
    let size = n.next_power_of_two();
    let fft = FftPlanner::new().plan_fft_forward(size);
    let bins = if radargram.samples.is_complex() {
        size
    } else {
        size / 2
    };
    let mut power = vec![0.0; bins];
    let stride = radargram.traces.div_ceil(TRACES).max(1);
    let kept = (0..radargram.traces).step_by(stride);
    let count = kept.len() as f64;
    for trace in kept {
        let mut work = radargram.trace(trace);
        let mean = work.iter().sum::<Complex64>() / n as f64;
        work.iter_mut().for_each(|z| *z -= mean);
        work.resize(size, Complex64::default());
        fft.process(&mut work);
        for (p, z) in power.iter_mut().zip(&work) {
            *p += z.norm_sqr() / count;
        }
    }
    let step_hz = 1.0 / (size as f64 * radargram.fast_time_step_s);
    let mut sorted = power.clone();
    sorted.sort_by(f64::total_cmp);
    let noise = sorted[bins / 4];
    power.iter_mut().for_each(|p| *p = (*p - noise).max(0.0));
    let smooth = smoothed(&power, (SMOOTH_HZ / step_hz).ceil() as usize);
    let top = smooth.iter().copied().fold(0.0, f64::max);
    if top <= 0.0 {
        return None;
    }
    let floor = top * 10f64.powf(-0.1 * OCCUPIED_DB);
    let first = smooth.iter().position(|p| *p >= floor)?;
    let last = smooth.iter().rposition(|p| *p >= floor)?;
    Some(SpectrumOccupancy {
        frequency_hz: (0..bins).map(|k| k as f64 * step_hz).collect(),
        power,
        band_hz: [first as f64 * step_hz, last as f64 * step_hz],
    })
}

/// Mean over a number of neighbours.
fn smoothed(values: &[f64], width: usize) -> Vec<f64> {
    let half = width / 2;
    (0..values.len())
        .map(|i| {
            let near = &values[i.saturating_sub(half)..(i + half + 1).min(values.len())];
            near.iter().sum::<f64>() / near.len() as f64
        })
        .collect()
}
