//! The direct coupling between the antennas: the echo that never moves.

use super::{robust_deviation, slope};
use crate::clean::{crest, envelope};
use crate::radargram::{Radargram, Samples};

/// Half of the interval about the coupling in which each trace's peak is taken, s.
const NEAR_S: f64 = 1e-9;

/// Where the direct coupling stands, and how still.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coupling {
    /// Fast time of its envelope's peak in the mean trace, s.
    pub fast_time_s: f64,
    /// Height of the peak, in samples' units.
    pub level: f64,
    /// The peak over the median of the mean trace's envelope, dB: how far it stands out.
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
/// The mean over the traces keeps what never moves; a platform that stands throughout keeps all.
#[must_use]
pub fn coupling(radargram: &Radargram) -> Option<Coupling> {
    let n = radargram.samples_per_trace;
    let envelope = mean_envelope(radargram)?;
    let top = (1..n - 1).max_by(|&a, &b| envelope[a].total_cmp(&envelope[b]))?;
    if envelope[top] <= 0.0 {
        return None;
    }
    let (fraction, level) = crest(&envelope, top);
    let fast_time_s = radargram.fast_time_s(top) + fraction * radargram.fast_time_step_s;
    let reach = (NEAR_S / radargram.fast_time_step_s).ceil() as usize;
    let near = top.saturating_sub(reach)..(top + reach + 1).min(n);
    let own = near_peaks(radargram, near);
    let times: Vec<f64> = own.iter().map(|p| p.0).collect();
    let levels: Vec<f64> = own.iter().map(|p| 20.0 * p.1.log10()).collect();
    Some(Coupling {
        fast_time_s,
        level,
        contrast_db: 20.0 * (level / super::median(&envelope).max(f64::MIN_POSITIVE)).log10(),
        spread_s: robust_deviation(&times),
        drift: slope(&radargram.time_s, &times),
        level_spread_db: robust_deviation(&levels),
    })
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
