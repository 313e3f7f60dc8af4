//! What a radargram says of its own quality: the evidence that a run weighs.
//!
//! ```text
//! Radargram ──► scan_outliers      scans to drop, and why
//!           ──► coupling           direct coupling: delay, level, stability
//!           ──► direct_wave        first arrival between antennas that are apart
//!           ──► clipping           samples at the receiver's limit
//!           ──► spectrum_occupancy where in frequency the energy is
//! times     ──► scan_spacing       regularity of the scans
//! SurfaceTrack + heights ──► surface_statistics
//! ```
//!
//! All functions are pure and judge nothing: thresholds of what is doubtful belong to the caller.

mod clipping;
mod coupling;
mod occupancy;
mod outliers;
mod spacing;
mod surface;

pub use clipping::{Clipping, clipping};
pub use coupling::{Coupling, coupling, direct_wave};
pub use occupancy::{SpectrumOccupancy, spectrum_occupancy};
pub use outliers::{OutlierKind, OutlierOptions, ScanOutlier, scan_outliers};
pub use spacing::{ScanSpacing, scan_spacing};
pub use surface::{SurfaceStatistics, surface_statistics};

/// Median of numbers without NaN; NaN of none.
pub(crate) fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => f64::NAN,
        n if n % 2 == 1 => sorted[n / 2],
        n => 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]),
    }
}

/// Standard deviation by the median distance from the median: a few wild values do nothing.
pub(crate) fn robust_deviation(values: &[f64]) -> f64 {
    /// Median of |N(0, 1)|.
    const MEDIAN_ABS: f64 = 0.674_489_750_196_081_7;
    let middle = median(values);
    let distances: Vec<f64> = values.iter().map(|v| (v - middle).abs()).collect();
    median(&distances) / MEDIAN_ABS
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
