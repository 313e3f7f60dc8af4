//! Latency from pulses to the picture.

use std::collections::VecDeque;
use std::time::Duration;

use serde::Serialize;

/// Pulses that figures are of: ten seconds at 50 pulses a second, of which 25 lie beyond the 95 %.
const LATEST: usize = 500;

/// Latencies of the latest pulses.
#[derive(Debug, Default)]
pub struct Latencies {
    milliseconds: VecDeque<f32>,
}

/// Median and 95 % of latencies.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LatencyFigures {
    /// Half of the pulses took no longer (ms).
    pub median_ms: f64,
    /// The 95th percentile of the latency (ms).
    pub p95_ms: f64,
    /// The longest (ms).
    pub most_ms: f64,
    /// Pulses that these are of.
    pub pulses: usize,
}

impl Latencies {
    /// Takes a pulse's latency.
    pub fn push(&mut self, latency: Duration) {
        if self.milliseconds.len() == LATEST {
            self.milliseconds.pop_front();
        }
        self.milliseconds.push_back(1e3 * latency.as_secs_f32());
    }

    /// The figures of the latest; none without pulses.
    ///
    /// ```
    /// use std::time::Duration;
    /// let mut latencies = acerra_live::latency::Latencies::default();
    /// assert_eq!(latencies.figures(), None);
    /// for ms in 1..=100 {
    ///     latencies.push(Duration::from_millis(ms));
    /// }
    /// let figures = latencies.figures().unwrap();
    /// assert_eq!((figures.median_ms.round(), figures.p95_ms.round()), (50.0, 95.0));
    /// ```
    #[must_use]
    pub fn figures(&self) -> Option<LatencyFigures> {
        let mut sorted: Vec<f32> = self.milliseconds.iter().copied().collect();
        sorted.sort_by(f32::total_cmp);
        let at = |share: f64| {
            let place = (share * sorted.len() as f64).ceil() as usize;
            sorted.get(place.saturating_sub(1)).copied().map(f64::from)
        };
        Some(LatencyFigures {
            median_ms: at(0.5)?,
            p95_ms: at(0.95)?,
            most_ms: at(1.0)?,
            pulses: sorted.len(),
        })
    }
}
