//! Selection of the traces of the background and the image.

use std::ops::Range;

/// Criteria for the moving part of a flight.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct MovingOptions {
    /// Speed from which the platform counts as moving, m/s; `None` takes a quarter of the speed
    /// that is exceeded in one twentieth of the traces.
    pub threshold_m_s: Option<f64>,
    /// Slower stretches of at most this number of traces inside the moving part do not end it.
    pub bridge: usize,
}

impl Default for MovingOptions {
    fn default() -> Self {
        Self {
            threshold_m_s: None,
            bridge: 50,
        }
    }
}

impl MovingOptions {
    /// These criteria with a speed from which the platform counts as moving, m/s.
    #[must_use]
    pub const fn with_threshold_m_s(mut self, threshold_m_s: f64) -> Self {
        self.threshold_m_s = Some(threshold_m_s);
        self
    }

    /// These criteria with another number of traces that a halt may last.
    #[must_use]
    pub const fn with_bridge(mut self, bridge: usize) -> Self {
        self.bridge = bridge;
        self
    }
}

/// The longest stretch of traces over which the platform moves; empty if it never does.
///
/// `speed_m_s` is the platform's speed at each trace; NaN (unknown) counts as at rest.
///
/// ```
/// use acerra_radar::{MovingOptions, moving_traces};
/// let mut speed = vec![0.01; 100];
/// speed[30..80].fill(1.2);
/// assert_eq!(moving_traces(&speed, &MovingOptions::default()), 30..80);
/// ```
#[must_use]
pub fn moving_traces(speed_m_s: &[f64], options: &MovingOptions) -> Range<usize> {
    let threshold = options.threshold_m_s.unwrap_or_else(|| {
        let mut known: Vec<f64> = speed_m_s
            .iter()
            .copied()
            .filter(|v| v.is_finite())
            .collect();
        known.sort_by(f64::total_cmp);
        known
            .get(known.len() * 19 / 20)
            .map_or(f64::INFINITY, |fast| 0.25 * fast)
    });
    let mut best = 0..0;
    let mut current: Option<Range<usize>> = None;
    for (i, &v) in speed_m_s.iter().enumerate() {
        if v.is_nan() || v <= threshold {
            continue;
        }
        let range = match current {
            Some(r) if i - r.end <= options.bridge => r.start..i + 1,
            _ => i..i + 1,
        };
        if range.len() > best.len() {
            best = range.clone();
        }
        current = Some(range);
    }
    best
}
