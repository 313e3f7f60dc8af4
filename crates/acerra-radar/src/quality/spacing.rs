//! Regularity of the scans.

use super::{median, robust_deviation};

/// How evenly scans follow each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanSpacing {
    /// Median time between scans, s.
    pub interval_s: f64,
    /// Standard deviation of that time, s (by the median distance).
    pub jitter_s: f64,
    /// Shortest and longest time between scans, s.
    pub range_s: [f64; 2],
    /// Intervals longer than one and a half of the median: pauses and lost scans.
    pub gaps: usize,
    /// Intervals that are not positive.
    pub disorders: usize,
}

/// Regularity of scans at the given times, s; none for fewer than two.
///
/// ```
/// let spacing = acerra_radar::quality::scan_spacing(&[0.0, 0.1, 0.2, 0.5, 0.6]).unwrap();
/// assert_eq!((spacing.gaps, spacing.disorders), (1, 0));
/// assert!((spacing.interval_s - 0.1).abs() < 1e-12);
/// ```
#[must_use]
pub fn scan_spacing(time_s: &[f64]) -> Option<ScanSpacing> {
    let intervals: Vec<f64> = time_s.windows(2).map(|w| w[1] - w[0]).collect();
    if intervals.is_empty() {
        return None;
    }
    let interval_s = median(&intervals);
    let low = intervals.iter().copied().fold(f64::INFINITY, f64::min);
    let high = intervals.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Some(ScanSpacing {
        interval_s,
        jitter_s: robust_deviation(&intervals),
        range_s: [low, high],
        gaps: intervals.iter().filter(|i| **i > 1.5 * interval_s).count(),
        disorders: intervals.iter().filter(|i| **i <= 0.0).count(),
    })
}
