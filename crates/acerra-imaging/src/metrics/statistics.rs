//! Maximum and median level of an image.

use rayon::prelude::*;
use serde::Serialize;

use super::image::ImageView;

/// Levels of an image as a whole.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ImageStatistics {
    /// Largest magnitude.
    pub maximum: f64,
    /// Column and row of the largest magnitude.
    pub maximum_at: [usize; 2],
    /// Median magnitude: the level of noise, clutter and sidelobes.
    pub median: f64,
    /// Median below the maximum, dB; `None` for an image of zeros.
    pub median_db: Option<f64>,
}

impl ImageStatistics {
    /// Measures `image`.
    pub fn of(image: &ImageView<'_>) -> Self {
        let mut power: Vec<f32> = image.values().par_iter().map(|v| v.norm_sqr()).collect();
        let mut at = 0;
        for (k, p) in power.iter().enumerate() {
            if *p > power[at] {
                at = k;
            }
        }
        let maximum = f64::from(power[at]).sqrt();
        let middle = power.len() / 2;
        let (_, median, _) = power.select_nth_unstable_by(middle, f32::total_cmp);
        let median = f64::from(*median).sqrt();
        let median_db = (maximum > 0.0).then(|| 20.0 * (median / maximum).max(1e-15).log10());
        Self {
            maximum,
            maximum_at: [at % image.grid().nx, at / image.grid().nx],
            median,
            median_db,
        }
    }
}
