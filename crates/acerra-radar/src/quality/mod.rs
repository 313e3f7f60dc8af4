//! Quality measures of a radargram: the evidence of a run.
//!
//! ```text
//! Radargram ──► scan_outliers      scans to drop, and why
//!           ──► coupling           direct coupling: delay, level, stability
//!           ──► direct_wave        first arrival between antennas that are apart
//!           ──► spectrum_occupancy where in frequency the energy is
//! ```
//!
//! All functions are pure and judge nothing: the thresholds belong to the caller.

mod coupling;
mod occupancy;
mod outliers;

pub use coupling::{Coupling, coupling, direct_wave};
pub use occupancy::{SpectrumOccupancy, spectrum_occupancy};
pub use outliers::{OutlierKind, OutlierOptions, ScanOutlier, scan_outliers};

/// Median of numbers without NaN; NaN of none.
pub(crate) fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    median_of_sorted(&sorted)
}

/// Median of values that rise; NaN of none.
pub(crate) fn median_of_sorted(sorted: &[f64]) -> f64 {
    match sorted.len() {
        0 => f64::NAN,
        n if n % 2 == 1 => sorted[n / 2],
        n => 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]),
    }
}

/// Median of |N(0, 1)|.
const MEDIAN_ABS: f64 = 0.674_489_750_196_081_7;

/// Standard deviation by the median distance from the median: a few outliers have no effect.
pub(crate) fn robust_deviation(values: &[f64]) -> f64 {
    let middle = median(values);
    let distances: Vec<f64> = values.iter().map(|v| (v - middle).abs()).collect();
    median(&distances) / MEDIAN_ABS
}

/// [`robust_deviation`] of values that rise, without sorting: the distances from their median rise to both sides of it.
pub(crate) fn robust_deviation_of_sorted(sorted: &[f64]) -> f64 {
    let middle = median_of_sorted(sorted);
    let mut above = sorted.partition_point(|v| *v < middle);
    let mut below = above;
    let mut next = || {
        let down = below.checked_sub(1).map(|k| middle - sorted[k]);
        let up = sorted.get(above).map(|v| v - middle);
        match (down, up) {
            (Some(down), Some(up)) if down < up => {
                below -= 1;
                down
            }
            (Some(down), None) => {
                below -= 1;
                down
            }
            (_, Some(up)) => {
                above += 1;
                up
            }
            (None, None) => f64::NAN,
        }
    };
    let n = sorted.len();
    let (mut before, mut at) = (f64::NAN, f64::NAN);
    for _ in 0..=n / 2 {
        (before, at) = (at, next());
    }
    let median = if n % 2 == 1 { at } else { 0.5 * (before + at) };
    median / MEDIAN_ABS
}

/// Least-squares slope of y over x; 0 where x does not change.
fn slope(x: &[f64], y: &[f64]) -> f64 {
    let n = x.len().max(1) as f64;
    let (mx, my) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let (mut xx, mut xy) = (0.0, 0.0);
    for (a, b) in x.iter().zip(y) {
        xx += (a - mx).powi(2);
        xy += (a - mx) * (b - my);
    }
    if xx > 0.0 { xy / xx } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deviation_of_sorted_values_is_that_of_any_order() {
        assert!(robust_deviation_of_sorted(&[]).is_nan());
        for n in 1..40 {
            let values: Vec<f64> = (0..n).map(|k| (12.9898 * f64::from(k * k)).sin()).collect();
            let mut sorted = values.clone();
            sorted.sort_by(f64::total_cmp);
            let apart = robust_deviation_of_sorted(&sorted) - robust_deviation(&values);
            assert!(apart.abs() < 1e-15, "{n}: {apart:e}");
        }
    }
}
