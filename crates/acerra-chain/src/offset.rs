//! The clock offset found from the data alone: motion against change, then sharpness.

use acerra_imaging::{Complex32, PlaneGrid};
use acerra_radar::align::{CoarseOffset, activity, coarse_offset};
use acerra_radar::{Radargram, Spectrum};
use anyhow::{Context, bail};

use super::align::{Aligned, align, interpolator};
use super::focus::quick_look;
use super::ground::{Ground, Site};
use super::position::Positions;
use super::progress::Progress;
use super::warnings::Warnings;
use crate::campaign::Campaign;

/// A score over the offsets tried.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// Offsets (s), rising.
    pub offset_s: Vec<f64>,
    /// Scores.
    pub score: Vec<f64>,
}

impl Curve {
    /// The best offset, refined by a parabola through its neighbours, and its score.
    #[must_use]
    pub fn best(&self) -> Option<(f64, f64)> {
        let (k, _) = self
            .score
            .iter()
            .enumerate()
            .max_by(|a, b| a.1.total_cmp(b.1))?;
        let (offset, score) = (self.offset_s[k], self.score[k]);
        if k == 0 || k + 1 == self.score.len() {
            return Some((offset, score));
        }
        let (before, after) = (self.score[k - 1], self.score[k + 1]);
        let bend = before - 2.0 * score + after;
        let shift = if bend < 0.0 {
            0.5 * (before - after) / bend
        } else {
            0.0
        };
        let step = 0.5 * (self.offset_s[k + 1] - self.offset_s[k - 1]);
        Some((offset + shift * step, score))
    }
}

/// How an offset was found.
#[derive(Clone, Debug)]
pub struct OffsetSearch {
    /// The offset taken: trajectory time minus radar time (s).
    pub time_offset_s: f64,
    /// Correlation of the radargram's change with the platform's speed.
    pub motion: CoarseOffset,
    /// Sharpness of the image about that offset.
    pub sharpness: Curve,
    /// Best sharpness over the median of those tried.
    pub sharpness_ratio: f64,
    /// Log-likelihood of the offsets tried, by motion and sharpness together.
    pub likelihood: Curve,
}

impl OffsetSearch {
    /// Whether the data speak clearly: motion correlates well and nowhere else as well.
    #[must_use]
    pub fn is_clear(&self) -> bool {
        self.motion.correlation >= 0.5 && self.motion.confidence >= 0.2
    }
}

/// Spacing of the speeds that the radargram's change is compared with (s).
const SPEED_STEP_S: f64 = 0.02;
/// Longest trajectory that is searched (s).
const LONGEST_S: f64 = 1e6;
/// Sharpness is tried where the correlation is within this of its best…
const CORRELATION_SLACK: f64 = 0.02;
/// …and no further away than this (s).
const SHARPNESS_REACH_S: f64 = 0.12;
/// Pixels of the image whose sharpness is tried.
const SHARPNESS_PIXELS: f64 = 60_000.0;
/// Speeds further apart than this count as independent (s).
const MEMORY_OF_MOTION_S: f64 = 0.5;

/// First step: the offset at which the radargram changes while the platform moves.
///
/// # Errors
/// Too few traces, a platform or a radargram that does not change, no overlap.
pub fn by_motion(
    campaign: &Campaign,
    radargram: &Radargram,
    positions: &Positions,
) -> anyhow::Result<CoarseOffset> {
    let Positions::Trajectory(trajectory) = positions else {
        bail!(
            "[trajectory] time_offset_s = \"auto\": positions that come with the traces need no \
             offset"
        );
    };
    let at = interpolator(campaign, trajectory);
    let half_s = 0.05_f64.max(trajectory.sample_interval_s().unwrap_or(0.1));
    let span_s = trajectory.end_s() - trajectory.start_s();
    if span_s.is_nan() || span_s >= LONGEST_S {
        bail!(
            "[trajectory] time_offset_s = \"auto\": expected a trajectory of less than \
             {LONGEST_S:.0} s, found {span_s:.0} s"
        );
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "checked to be a moderate positive number"
    )]
    let (time_s, speed_m_s): (Vec<f64>, Vec<f64>) = (0..=(span_s / SPEED_STEP_S) as usize)
        .map(|k| {
            let t = trajectory.start_s() + k as f64 * SPEED_STEP_S;
            let [a, b] = [t - half_s, t + half_s].map(|t| at.at(t));
            let d = [0, 1, 2].map(|i| b.position_m[i] - a.position_m[i]);
            let covered = a.flag.is_covered() && b.flag.is_covered();
            let speed = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt() / (2.0 * half_s);
            (t, if covered { speed } else { f64::NAN })
        })
        .unzip();
    // Change saturates when the platform moves a quarter of a wavelength between traces; its root
    // is closer to a measure of motion than of what happens to be in view.
    let change: Vec<f64> = activity(radargram).iter().map(|a| a.sqrt()).collect();
    coarse_offset(
        &radargram.time_s,
        &change,
        &time_s,
        &speed_m_s,
        &acerra_radar::align::OffsetSearch::default(),
    )
    .context("[trajectory] time_offset_s = \"auto\"")
}

/// Second step: among the offsets about the best correlation, the one with the sharpest image.
///
/// `spectrum` holds the clean spectra of `aligned`, made at the first step's offset.
///
/// # Errors
/// Data that cannot be imaged.
pub fn refine(
    campaign: &Campaign,
    radar_time_s: &[f64],
    site: Site<'_>,
    motion: CoarseOffset,
    aligned: &Aligned,
    spectrum: &Spectrum,
    progress: &dyn Progress,
) -> anyhow::Result<OffsetSearch> {
    let near: Vec<(f64, f64)> = motion
        .curve
        .iter()
        .filter(|(offset, score)| {
            *score >= motion.correlation - CORRELATION_SLACK
                && (offset - motion.offset_s).abs() <= SHARPNESS_REACH_S
        })
        .copied()
        .collect();
    let length_s = radar_time_s.last().unwrap_or(&0.0) - radar_time_s.first().unwrap_or(&0.0);
    let independent = (length_s / MEMORY_OF_MOTION_S).max(4.0);
    let grid = coarse_grid(campaign, site.ground)?;
    progress.start("align", near.len() as u64);
    let mut sharpness = Curve::default();
    let mut likelihood = Curve::default();
    for (k, (offset, correlation)) in near.into_iter().enumerate() {
        let everywhere = Campaign {
            radar: crate::campaign::RadarSection {
                select: crate::campaign::Select::All,
                ..campaign.radar.clone()
            },
            ..campaign.clone()
        };
        let all = align(
            &everywhere,
            radar_time_s,
            site,
            offset,
            &mut Warnings::default(),
        )?;
        // The same traces at every offset: what changes is where they stand.
        let position_of = |trace: &usize| {
            all.traces
                .binary_search(trace)
                .ok()
                .map(|at| all.position_m[at])
        };
        let places: Option<Vec<[f64; 3]>> = aligned.traces.iter().map(position_of).collect();
        if let Some(places) = places {
            let image = quick_look(&places, spectrum, grid, campaign.image.light_speed_m_s)?;
            let sharp = contrast(&image);
            sharpness.offset_s.push(offset);
            sharpness.score.push(sharp);
            likelihood.offset_s.push(offset);
            // Correlated Gaussian pairs; a coherent peak against its surroundings.
            likelihood
                .score
                .push(2.0 * sharp.ln() - 0.5 * independent * (1.0 - correlation.powi(2)).ln());
        }
        progress.at(k as u64 + 1);
    }
    progress.finish();
    let time_offset_s = likelihood
        .best()
        .map_or(motion.offset_s, |(offset, _)| offset);
    let mut sorted = sharpness.score.clone();
    sorted.sort_by(f64::total_cmp);
    let median = sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN);
    let sharpest = sorted.last().copied().unwrap_or(f64::NAN);
    Ok(OffsetSearch {
        time_offset_s,
        motion,
        sharpness,
        sharpness_ratio: sharpest / median,
        likelihood,
    })
}

/// The campaign's rectangle with few enough pixels to image it many times.
fn coarse_grid(campaign: &Campaign, ground: &Ground) -> anyhow::Result<PlaneGrid> {
    let image = &campaign.image;
    let area_m2 = (image.x_m[1] - image.x_m[0] + image.pixel_m)
        * (image.y_m[1] - image.y_m[0] + image.pixel_m);
    let pixel_m = image.pixel_m.max((area_m2 / SHARPNESS_PIXELS).sqrt());
    Ok(PlaneGrid::from_ranges(
        image.x_m,
        image.y_m,
        ground.middle_m(),
        pixel_m,
    )?)
}

/// The brightest pixel's modulus over the median one's; 1 for an image of zeros.
fn contrast(image: &[Complex32]) -> f64 {
    let mut power: Vec<f32> = image.iter().map(|value| value.norm_sqr()).collect();
    let middle = power.len() / 2;
    if power.is_empty() {
        return 1.0;
    }
    let (_, median, above) = power.select_nth_unstable_by(middle, f32::total_cmp);
    let brightest = above.iter().copied().fold(*median, f32::max);
    if *median > 0.0 {
        f64::from(brightest / *median).sqrt()
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_of_a_curve_lies_between_its_points() {
        let offset_s: Vec<f64> = (0..11).map(|k| f64::from(k) * 0.1).collect();
        let score = offset_s
            .iter()
            .map(|t| 1.0 - (t - 0.437) * (t - 0.437))
            .collect();
        let (best, _) = Curve { offset_s, score }.best().unwrap();
        assert!((best - 0.437).abs() < 1e-12, "{best}");
        assert_eq!(Curve::default().best(), None);
    }

    #[test]
    fn contrast_is_the_peak_over_the_median() {
        let mut image = vec![Complex32::new(0.0, 2.0); 101];
        assert!((contrast(&image) - 1.0).abs() < 1e-6);
        image[3] = Complex32::new(-6.0, 8.0);
        assert!((contrast(&image) - 5.0).abs() < 1e-6);
        assert!((contrast(&[]) - 1.0).abs() < f64::EPSILON);
    }
}
