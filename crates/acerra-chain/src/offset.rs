//! The clock offset found from the data alone: motion against change, then sharpness.

use acerra_geo::trajectory::Trajectory;
use acerra_imaging::{Complex32, ImagingError, PlaneGrid};
use acerra_radar::align::{CoarseOffset, activity, coarse_offset};
use acerra_radar::{Radargram, align::AlignError as MotionError};

use crate::align::{AlignError, AlignOptions, Flight, align, interpolator};
use crate::choices::Select;
use crate::control::{Cancelled, Control};
use crate::echoes::{Echoes, quick_look};
use crate::pixels::Pixels;
use crate::warnings::Warnings;

/// A score over the offsets tried.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// Offsets (s), rising.
    pub offset_s: Vec<f64>,
    /// Scores.
    pub score: Vec<f64>,
}

impl Curve {
    fn push(&mut self, offset_s: f64, score: f64) {
        self.offset_s.push(offset_s);
        self.score.push(score);
    }

    /// The best score over the median one; NaN without scores.
    fn peak_over_median(&self) -> f64 {
        let mut sorted = self.score.clone();
        sorted.sort_by(f64::total_cmp);
        let median = sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN);
        sorted.last().copied().unwrap_or(f64::NAN) / median
    }

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

/// Why the clock offset cannot be found.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OffsetError {
    /// The trajectory is too long to be searched.
    #[error(
        "[trajectory] time_offset_s = \"auto\": expected a trajectory of less than {LONGEST_S:.0} s, \
         found {found_s:.0} s"
    )]
    TooLong {
        /// Its length (s).
        found_s: f64,
    },
    /// Motion and change cannot be compared.
    #[error("[trajectory] time_offset_s = \"auto\": {0}")]
    Motion(MotionError),
    /// No trace can be placed at an offset that is tried.
    #[error(transparent)]
    Align(#[from] AlignError),
    /// The images of the search cannot be made.
    #[error(transparent)]
    Imaging(#[from] ImagingError),
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// First step: the offset at which the radargram changes while the platform moves.
///
/// # Errors
/// Too few traces, a platform or a radargram that does not change, no overlap.
pub fn by_motion(
    radargram: &Radargram,
    trajectory: &Trajectory,
    max_gap_s: Option<f64>,
) -> Result<CoarseOffset, OffsetError> {
    let at = interpolator(max_gap_s, trajectory);
    let half_s = 0.05_f64.max(trajectory.sample_interval_s().unwrap_or(0.1));
    let span_s = trajectory.end_s() - trajectory.start_s();
    if span_s.is_nan() || span_s >= LONGEST_S {
        return Err(OffsetError::TooLong { found_s: span_s });
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
    .map_err(OffsetError::Motion)
}

/// What offsets are tried on: a track, cleaned at the first step's offset.
#[derive(Clone, Copy, Debug)]
pub struct Trial<'a> {
    /// The track.
    pub flight: Flight<'a>,
    /// How its traces are placed.
    pub options: &'a AlignOptions,
    /// Its clean spectra, made at the first step's offset.
    pub echoes: Echoes<'a>,
}

/// Second step: among the offsets about the best correlation, the one with the sharpest image.
///
/// # Errors
/// Data that cannot be imaged, cancellation.
pub fn refine(
    trial: Trial<'_>,
    motion: CoarseOffset,
    control: &Control<'_>,
) -> Result<OffsetSearch, OffsetError> {
    let candidates = near_the_best(&motion);
    let independent = independent_speeds(trial.flight.radar.time_s());
    let grid = coarse_grid(&trial.flight.scene.pixels)?;
    control.start("align", candidates.len() as u64);
    let mut sharpness = Curve::default();
    let mut likelihood = Curve::default();
    for (k, (offset_s, correlation)) in candidates.into_iter().enumerate() {
        control.check()?;
        if let Some(contrast) = trial.contrast_at(offset_s, grid)? {
            sharpness.push(offset_s, contrast);
            // Correlated Gaussian pairs; a coherent peak against its surroundings.
            let of_motion = -0.5 * independent * (1.0 - correlation.powi(2)).ln();
            likelihood.push(offset_s, 2.0 * contrast.ln() + of_motion);
        }
        control.at(k as u64 + 1);
    }
    control.finish();
    Ok(OffsetSearch {
        time_offset_s: likelihood
            .best()
            .map_or(motion.offset_s, |(offset_s, _)| offset_s),
        motion,
        sharpness_ratio: sharpness.peak_over_median(),
        sharpness,
        likelihood,
    })
}

/// The offsets whose correlation is close to the best, with that correlation.
fn near_the_best(motion: &CoarseOffset) -> Vec<(f64, f64)> {
    let is_near = |(offset_s, score): &&(f64, f64)| {
        *score >= motion.correlation - CORRELATION_SLACK
            && (offset_s - motion.offset_s).abs() <= SHARPNESS_REACH_S
    };
    motion.curve.iter().filter(is_near).copied().collect()
}

/// How many independent speeds a log of these times compares.
fn independent_speeds(time_s: &[f64]) -> f64 {
    let length_s = time_s.last().unwrap_or(&0.0) - time_s.first().unwrap_or(&0.0);
    (length_s / MEMORY_OF_MOTION_S).max(4.0)
}

impl Trial<'_> {
    /// The contrast of the image at an offset; none where a trace of the echoes has no place then.
    fn contrast_at(&self, offset_s: f64, grid: PlaneGrid) -> Result<Option<f64>, OffsetError> {
        // The same traces at every offset: what changes is where they stand.
        let everywhere = AlignOptions {
            select: Select::All,
            ..self.options.clone()
        };
        let unsaid = &mut Warnings::default();
        let all = align(self.flight, &everywhere, offset_s, unsaid)?;
        let position_of = |trace: &usize| {
            let at = all.traces.binary_search(trace).ok()?;
            Some(all.position_m[at])
        };
        let Echoes {
            spectrum,
            aligned,
            light_speed_m_s,
        } = self.echoes;
        let places: Option<Vec<[f64; 3]>> = aligned.traces.iter().map(position_of).collect();
        let Some(places) = places else {
            return Ok(None);
        };
        let image = quick_look(&places, spectrum, grid, light_speed_m_s)?;
        Ok(Some(contrast(&image)))
    }
}

/// The image's rectangle with few enough pixels to image it many times.
fn coarse_grid(pixels: &Pixels) -> Result<PlaneGrid, ImagingError> {
    let fine = &pixels.grid;
    let x_m = [fine.x0_m, fine.x_m(fine.nx - 1)];
    let y_m = [fine.y0_m, fine.y_m(fine.ny - 1)];
    let area_m2 = (x_m[1] - x_m[0] + fine.pixel_m) * (y_m[1] - y_m[0] + fine.pixel_m);
    let pixel_m = fine.pixel_m.max((area_m2 / SHARPNESS_PIXELS).sqrt());
    PlaneGrid::from_ranges(x_m, y_m, pixels.middle_m(), pixel_m)
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
