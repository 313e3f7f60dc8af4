//! The direct coupling between the antennas: the echo at constant delay.

use super::{robust_deviation, slope};
use crate::clean::{crest, envelope};
use crate::radargram::{Radargram, Samples};

/// Half of the interval about the coupling in which each trace's peak is taken, s.
const NEAR_S: f64 = 1e-9;

/// Least level of the direct wave relative to the strongest envelope: 12 dB below.
const SHARE_OF_STRONGEST: f64 = 0.25;

/// Fast time, level and constancy of the direct coupling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coupling {
    /// Fast time of its envelope's peak in the mean trace, s.
    pub fast_time_s: f64,
    /// Height of the peak, in samples' units.
    pub level: f64,
    /// The peak over the median of the mean trace's envelope, dB.
    pub contrast_db: f64,
    /// Standard deviation of the peak's fast time over the traces, s (by the median distance).
    pub spread_s: f64,
    /// Trend of the peak's fast time: seconds in a second.
    pub drift: f64,
    /// Standard deviation of the peak's level over the traces, dB (by the median distance).
    pub level_spread_db: f64,
}

/// The direct coupling: the strongest part of the mean trace. None where the mean trace is zero.
///
/// The mean over the traces keeps constant signals; with a platform at rest it keeps all.
#[must_use]
pub fn coupling(radargram: &Radargram) -> Option<Coupling> {
    let n = radargram.samples_per_trace;
    let envelope = mean_envelope(radargram)?;
    let top = (1..n - 1).max_by(|&a, &b| envelope[a].total_cmp(&envelope[b]))?;
    (envelope[top] > 0.0).then(|| seen_at(radargram, &envelope, top))
}

/// The direct wave between antennas that are apart: the first maximum of the mean trace's envelope that comes within
/// 12 dB of the strongest. None where the record begins after it.
///
/// No signal arrives earlier, and no path is known better than the one between the antennas: the direct wave
/// calibrates the fast time. Frequencies outside the antennas' band should be filtered out first.
#[must_use]
pub fn direct_wave(radargram: &Radargram) -> Option<Coupling> {
    let envelope = mean_envelope(radargram)?;
    let least = SHARE_OF_STRONGEST * envelope.iter().copied().fold(0.0, f64::max);
    let begins = envelope.iter().position(|e| *e > 0.0 && *e >= least)?;
    let is_top = |k: &usize| envelope[*k] > envelope[k - 1] && envelope[*k] >= envelope[k + 1];
    let top = (begins.max(1)..envelope.len() - 1).find(is_top)?;
    (begins > 0).then(|| seen_at(radargram, &envelope, top))
}

/// Statistics of a maximum of the mean trace's envelope over the traces.
fn seen_at(radargram: &Radargram, envelope: &[f64], top: usize) -> Coupling {
    let n = radargram.samples_per_trace;
    let (fraction, level) = crest(envelope, top);
    let fast_time_s = radargram.fast_time_s(top) + fraction * radargram.fast_time_step_s;
    let reach = (NEAR_S / radargram.fast_time_step_s).ceil() as usize;
    let near = top.saturating_sub(reach)..(top + reach + 1).min(n);
    let own = near_peaks(radargram, near);
    let times: Vec<f64> = own.iter().map(|p| p.0).collect();
    let levels: Vec<f64> = own.iter().map(|p| 20.0 * p.1.log10()).collect();
    Coupling {
        fast_time_s,
        level,
        contrast_db: 20.0 * (level / super::median(envelope).max(f64::MIN_POSITIVE)).log10(),
        spread_s: robust_deviation(&times),
        drift: slope(&radargram.time_s, &times),
        level_spread_db: robust_deviation(&levels),
    }
}

/// Envelope of the mean trace.
fn mean_envelope(radargram: &Radargram) -> Option<Vec<f64>> {
    let n = radargram.samples_per_trace;
    let mut mean = vec![num_complex::Complex64::default(); n];
    for trace in 0..radargram.traces {
        for (sum, k) in mean.iter_mut().zip(0..n) {
            *sum += radargram.at(trace, k) / radargram.traces as f64;
        }
    }
    let samples = if radargram.samples.is_complex() {
        let narrow =
            |z: &num_complex::Complex64| num_complex::Complex32::new(z.re as f32, z.im as f32);
        Samples::Complex(mean.iter().map(narrow).collect())
    } else {
        Samples::Real(mean.iter().map(|z| z.re as f32).collect())
    };
    let one = Radargram::new(
        vec![0.0],
        radargram.fast_time_start_s,
        radargram.fast_time_step_s,
        samples,
    );
    one.ok().map(|one| envelope(&one))
}

/// Fast time and level of each trace's largest envelope among some samples.
fn near_peaks(radargram: &Radargram, near: std::ops::Range<usize>) -> Vec<(f64, f64)> {
    let n = radargram.samples_per_trace;
    envelope(radargram)
        .chunks_exact(n)
        .map(|row| {
            let top = near
                .clone()
                .max_by(|&a, &b| row[a].total_cmp(&row[b]))
                .unwrap_or(near.start);
            let (fraction, level) = crest(row, top);
            let sample = top as f64 + fraction;
            (
                radargram.fast_time_start_s + sample * radargram.fast_time_step_s,
                level.max(f64::MIN_POSITIVE),
            )
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_S: f64 = 20e-12;

    /// Traces with a direct wave at 2 ns and an echo of `echo` times its level, later from trace to trace.
    fn traces(echo: f64, from_s: f64) -> Radargram {
        let pulse = |t_s: f64| {
            (std::f64::consts::TAU * 1.5e9 * t_s).cos() * (-(t_s / 0.4e-9).powi(2)).exp()
        };
        let sample = |trace: usize, k: usize| {
            let t_s = from_s + k as f64 * STEP_S;
            (pulse(t_s - 2e-9) + echo * pulse(t_s - 5e-9 - 1e-11 * trace as f64)) as f32
        };
        let samples = (0..9).flat_map(|trace| (0..600).map(move |k| sample(trace, k)));
        let time_s = (0..9).map(f64::from).collect();
        Radargram::new(time_s, from_s, STEP_S, Samples::Real(samples.collect())).unwrap()
    }

    #[test]
    fn the_direct_wave_is_the_first_arrival_and_not_the_strongest() {
        for echo in [0.1, 0.9, 3.0] {
            let seen = direct_wave(&traces(echo, 0.0)).unwrap();
            assert!((seen.fast_time_s - 2e-9).abs() < 0.02e-9, "{seen:?}");
            assert!(seen.spread_s < 5e-12, "{seen:?}");
        }
        let strongest = coupling(&traces(3.0, 0.0)).unwrap();
        assert!(strongest.fast_time_s > 4e-9);
        // A record that begins during the direct wave does not show it.
        assert_eq!(direct_wave(&traces(0.5, 2.1e-9)), None);
    }
}
