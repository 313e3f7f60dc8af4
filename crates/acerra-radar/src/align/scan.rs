//! The posterior of the offset by images over every interval that agrees with height and motion, where few
//! images do not decide.
//!
//! The sharpness of images at wrong offsets scatters about a common level; at the right offset it is an
//! outlier. The likelihood that an image is at the right offset therefore depends on the distance of its
//! score (the mean over parts of ln) from the median over the interval, in deviations z of the interval: the
//! likelihood ratio to chance is exp(z²/2) divided by the number of images. The right image may also be no
//! sharper than the others (on a circular track, which an offset only rotates): then every offset is as
//! likely as before.

use super::sharpness::{Scored, SharpnessCue};

/// Least number of images of an interval that determine the common level.
const LEAST_IMAGES: usize = 40;
/// Ratio of the standard deviation of a normal distribution to the median distance from its median.
const SIGMA_OF_MEDIAN: f64 = 1.4826;
/// Reach of the images about the sharpest one that give its offset, s.
const NEAR_S: f64 = 0.15;

/// Images of one interval of offsets, of the same parts.
pub(super) struct Scan {
    /// Index of the candidate of the interval.
    pub candidate: usize,
    /// Offset (s) and one score for each part.
    pub scores: Vec<(f64, Vec<f64>)>,
}

/// An offset of a candidate with its log-likelihood by all cues.
#[derive(Debug, Clone, Copy)]
pub(super) struct Likely {
    pub candidate: usize,
    pub offset_s: f64,
    pub log_likelihood: f64,
}

impl Scan {
    /// Whether the number of images suffices for the common level, and all are of the same parts.
    fn is_sound(&self) -> bool {
        let parts = self.scores.first().map_or(0, |(_, scores)| scores.len());
        let is_whole = |scores: &[f64]| {
            scores.len() == parts && scores.iter().all(|s| *s > 0.0 && s.is_finite())
        };
        parts > 0
            && self.scores.len() >= LEAST_IMAGES
            && self.scores.iter().all(|(_, scores)| is_whole(scores))
    }

    /// Log-likelihood ratio of each offset by images alone, relative to an image that is sharp by chance.
    pub(super) fn by_images(&self) -> Vec<Likely> {
        if !self.is_sound() {
            return Vec::new();
        }
        let log_mean = |(_, scores): &(f64, Vec<f64>)| {
            scores.iter().map(|score| score.ln()).sum::<f64>() / scores.len() as f64
        };
        let logs: Vec<f64> = self.scores.iter().map(log_mean).collect();
        let middle = median(&logs);
        let away: Vec<f64> = logs.iter().map(|log| (log - middle).abs()).collect();
        let sigma = (SIGMA_OF_MEDIAN * median(&away)).max(f64::MIN_POSITIVE);
        let chances = (self.scores.len() as f64).ln();
        let likely = |((offset_s, _), log): (&(f64, Vec<f64>), f64)| {
            let z = (log - middle) / sigma;
            let over_chance = 0.5 * z * z.abs() - chances;
            Likely {
                candidate: self.candidate,
                offset_s: *offset_s,
                // ln(1 + exp(x)), without overflow.
                log_likelihood: over_chance.max(0.0) + (-over_chance.abs()).exp().ln_1p(),
            }
        };
        self.scores.iter().zip(logs).map(likely).collect()
    }

    /// The sharpest offset near `offset_s`.
    pub(super) fn cue_near(&self, offset_s: f64) -> Option<SharpnessCue> {
        let near = |(t, _): &&(f64, Vec<f64>)| (t - offset_s).abs() <= NEAR_S;
        let scores = self.scores.iter().filter(near).cloned().collect();
        Scored { scores }.cue()
    }
}

/// The most likely offset, and the standard deviation of the posterior about this offset, s.
pub(super) fn posterior(likely: &[Likely]) -> Option<(Likely, f64)> {
    let best =
        (likely.iter().copied()).max_by(|a, b| a.log_likelihood.total_cmp(&b.log_likelihood))?;
    let (mut weight, mut moment) = (0.0, 0.0);
    for at in likely {
        let w = (at.log_likelihood - best.log_likelihood).exp();
        weight += w;
        moment += w * (at.offset_s - best.offset_s).powi(2);
    }
    Some((best, (moment / weight).sqrt()))
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    let middle = sorted.len() / 2;
    *sorted.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Scores of three parts that scatter by a tenth, with a peak of `height` (in ln) at 1 s.
    fn scan(height: f64) -> Scan {
        let mut state = 7_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
        };
        let score = |k: usize| {
            let t = 0.02 * k as f64;
            let peak = height * (-((t - 1.0) / 0.05).powi(2)).exp();
            let parts = (0..3).map(|_| (2.0 + 0.35 * random() + peak).exp());
            (t, parts.collect())
        };
        Scan {
            candidate: 0,
            scores: (0..=150).map(score).collect(),
        }
    }

    #[test]
    fn a_peak_beyond_the_scatter_of_images_is_the_offset() {
        let (best, sigma_s) = posterior(&scan(1.0).by_images()).unwrap();
        assert!((best.offset_s - 1.0).abs() <= 0.04, "{best:?}");
        assert!(sigma_s < 0.05, "{sigma_s}");
    }

    #[test]
    fn images_that_only_scatter_leave_the_offset_open() {
        let (_, sigma_s) = posterior(&scan(0.0).by_images()).unwrap();
        assert!(sigma_s > 0.3, "{sigma_s}");
    }

    #[test]
    fn too_few_images_give_no_likelihood() {
        let mut few = scan(1.0);
        few.scores.truncate(LEAST_IMAGES - 1);
        assert!(few.by_images().is_empty());
        let mut uneven = scan(1.0);
        uneven.scores[3].1.pop();
        assert!(uneven.by_images().is_empty());
    }
}
