//! The surface echo against the height.

use super::{median, robust_deviation, slope};
use crate::align::correlation_length;
use crate::clean::SurfaceTrack;
use crate::constants::two_way_delay_s;

/// How well a surface echo follows 2h/c.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceStatistics {
    /// Traces with an echo and a height.
    pub traces: usize,
    /// Median level of the echo, in samples' units.
    pub level: f64,
    /// Standard deviation of the level, dB (by the median distance).
    pub level_spread_db: f64,
    /// Median of the echo less 2h/c, s: the delay at which range is zero, or, zero-timed, 0.
    pub delay_s: f64,
    /// Standard deviation of the echo less 2h/c, s (by the median distance).
    pub spread_s: f64,
    /// Trend of the echo less 2h/c: seconds in a second of slow time.
    pub drift: f64,
    /// Slope of the echo over 2h/c, 1 where range scale and heights are right; `None` where 2h/c
    /// changes by less than its error.
    pub scale: Option<f64>,
    /// Traces that are worth one independent one.
    pub correlation_length: f64,
}

impl SurfaceStatistics {
    /// Standard deviation of the delay, s: the spread over the independent traces.
    #[must_use]
    pub fn delay_sigma_s(&self) -> f64 {
        self.spread_s * (self.correlation_length / self.traces as f64).sqrt()
    }
}

/// Statistics of a surface echo; none with fewer than eight picks that have a height.
///
/// `time_s` and `height_m` hold one value a trace, as the track does.
#[must_use]
pub fn surface_statistics(
    track: &SurfaceTrack,
    time_s: &[f64],
    height_m: &[f64],
) -> Option<SurfaceStatistics> {
    let mut picks = Vec::new();
    for ((pick, &t), &h) in track.picks.iter().zip(time_s).zip(height_m) {
        if let Some(pick) = pick
            && h.is_finite()
            && h > 0.0
        {
            picks.push((t, two_way_delay_s(h), *pick));
        }
    }
    if picks.len() < 8 {
        return None;
    }
    let times: Vec<f64> = picks.iter().map(|p| p.0).collect();
    let expected: Vec<f64> = picks.iter().map(|p| p.1).collect();
    let found: Vec<f64> = picks.iter().map(|p| p.2.fast_time_s).collect();
    let residual: Vec<f64> = found.iter().zip(&expected).map(|(f, e)| f - e).collect();
    let levels: Vec<f64> = picks.iter().map(|p| p.2.level).collect();
    let levels_db: Vec<f64> = levels
        .iter()
        .map(|l| 20.0 * l.max(f64::MIN_POSITIVE).log10())
        .collect();
    let spread_s = robust_deviation(&residual);
    let told = robust_deviation(&expected) > 2.0 * spread_s.max(1e-12);
    Some(SurfaceStatistics {
        traces: picks.len(),
        level: median(&levels),
        level_spread_db: robust_deviation(&levels_db),
        delay_s: median(&residual),
        spread_s,
        drift: slope(&times, &residual),
        scale: told.then(|| slope(&expected, &found)),
        correlation_length: correlation_length(&residual),
    })
}
