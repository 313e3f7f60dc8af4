//! Heights of the pixels of a block, split into a straight line per group and the rest.

use crate::kernel::lanes::MAX_LANES;

/// Heights of one block of one row: the centre's, and lines through the groups.
#[derive(Clone, Copy)]
pub(super) struct Profile {
    /// Height at the block's centre above the plane, m.
    pub centre_m: f64,
    /// Line through each group: height at its middle above the centre (m), slope, and the largest
    /// departure from it (m); one lane a group.
    pub line_m: [f32; MAX_LANES],
    pub slope: [f32; MAX_LANES],
    pub uneven_m: [f32; MAX_LANES],
}

impl Profile {
    /// Level ground.
    pub const LEVEL: Self = Self {
        centre_m: 0.0,
        line_m: [0.0; MAX_LANES],
        slope: [0.0; MAX_LANES],
        uneven_m: [0.0; MAX_LANES],
    };

    /// Fits lines to `heights_m` (at most a block; the last height is repeated up to its end), and
    /// stores every pixel's height above the block's centre and beside its line.
    pub fn fit(
        heights_m: &[f32],
        pixel_m: f64,
        group: usize,
        above_m: &mut [f32],
        beside_m: &mut [f32],
    ) -> Self {
        let mut profile = Self::LEVEL;
        let width = above_m.len();
        let last = heights_m.len() - 1;
        profile.centre_m = f64::from(heights_m[(width / 2).min(last)]);
        for (k, above) in above_m.iter_mut().enumerate() {
            *above = (f64::from(heights_m[k.min(last)]) - profile.centre_m) as f32;
        }
        let half = 0.5 * (group - 1) as f64;
        let spread: f64 = (0..group).map(|k| (k as f64 - half).powi(2)).sum();
        for (k, (above, beside)) in above_m
            .chunks(group)
            .zip(beside_m.chunks_mut(group))
            .enumerate()
        {
            let moment: f64 = above
                .iter()
                .enumerate()
                .map(|(i, z)| (i as f64 - half) * f64::from(*z))
                .sum();
            let rise = moment / spread;
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for (i, z) in above.iter().enumerate() {
                let residual = f64::from(*z) - rise * (i as f64 - half);
                low = low.min(residual);
                high = high.max(residual);
            }
            let middle = 0.5 * (low + high);
            for (i, (z, b)) in above.iter().zip(beside).enumerate() {
                *b = (f64::from(*z) - rise * (i as f64 - half) - middle) as f32;
            }
            profile.line_m[k] = middle as f32;
            profile.slope[k] = (rise / pixel_m) as f32;
            profile.uneven_m[k] = (0.5 * (high - low)) as f32;
        }
        profile
    }
}
