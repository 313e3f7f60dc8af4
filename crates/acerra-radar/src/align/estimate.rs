//! The clock offset from all cues together: an estimate with its standard deviation, or a refusal.

use super::curve::{LikelihoodCurve, Mode};
use super::echo::{Echoes, Search};
use super::height::height_cues;
use super::height_cue::{Grid, HeightCue};
use super::motion::{MotionCue, motion_cue};
use super::profile::STEP_S;
use super::scan::{Likely, Scan, posterior};
use super::sharpness::{Scored, SharpnessCue, least_images, offsets_about};
use super::surface::{any_of, surface_at};
use super::{AlignError, FlightProfile, activity};
use crate::radargram::Radargram;
use acerra_control::Control;

/// Largest number of products of picks and offsets in one pass.
const LARGEST_PASS: usize = 40_000_000;
/// Largest number of traces used: further ones hardly change an offset.
const TRACES: usize = 2000;
/// Largest number of offsets tried.
const MOST_OFFSETS: f64 = 2e6;
/// Factor by which images may at most narrow a stated standard deviation.
const VAGUE_BEFORE: f64 = 5.0;
/// Multiple of the caller's number of images that likely offsets may need.
const MOST_TIMES: usize = 3;
/// Largest number of candidates that are imaged.
const MOST_CANDIDATES: usize = 5;
/// Number of images where few do not decide; an image takes some milliseconds.
const MOST_IMAGES: f64 = 1000.0;
/// Spacing of these images, in steps of the few images.
const SCAN_STEPS: f64 = 2.0;
/// Least reach of these images to each side of a candidate, s.
const LEAST_SCAN_S: f64 = 0.5;
/// Distance below which likely offsets count as one, s.
const APART_S: f64 = 0.1;

/// Prior of the offset, from wall-clock stamps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClockPrior {
    /// Expected offset, s.
    pub offset_s: f64,
    /// Standard deviation of the prior, s.
    pub sigma_s: f64,
}

/// Parameters of the estimation.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct OffsetOptions {
    /// Smallest and largest offset, s; `None` tries all at which the logs overlap enough.
    pub range_s: Option<[f64; 2]>,
    /// Prior by wall-clock stamps.
    pub prior: Option<ClockPrior>,
    /// Share of the radar's time that must fall within the trajectory's.
    pub overlap: f64,
    /// Fast times at which range may be zero, s.
    pub delay_range_s: [f64; 2],
    /// Log-likelihood by which the best offset must exceed every other one.
    pub margin: f64,
    /// Largest accepted standard deviation of an offset, s.
    pub max_sigma_s: f64,
}

impl Default for OffsetOptions {
    /// All offsets at which half of the radar's log is covered, delays of −1 to 20 ns, a margin of
    /// 6 (odds of 400 to 1), a standard deviation of at most 0.1 s.
    fn default() -> Self {
        Self {
            range_s: None,
            prior: None,
            overlap: 0.5,
            delay_range_s: [-1e-9, 20e-9],
            margin: 6.0,
            max_sigma_s: 0.1,
        }
    }
}

impl OffsetOptions {
    /// These parameters within a range of offsets, s.
    #[must_use]
    pub const fn within(mut self, range_s: [f64; 2]) -> Self {
        self.range_s = Some(range_s);
        self
    }

    /// These parameters with a prior by wall-clock stamps.
    #[must_use]
    pub const fn with_prior(mut self, prior: ClockPrior) -> Self {
        self.prior = Some(prior);
        self
    }

    /// These parameters with a delay that is known to lie within an interval, s.
    #[must_use]
    pub const fn with_delay_range_s(mut self, delay_range_s: [f64; 2]) -> Self {
        self.delay_range_s = delay_range_s;
        self
    }
}

/// An interval of offsets that agrees with the data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Most likely offset of the interval, s.
    pub offset_s: f64,
    /// Standard deviation about the most likely offset, s.
    pub sigma_s: f64,
    /// Log-likelihood below the best of all, 0 for the best itself.
    pub below_best: f64,
}

/// Likelihood of every offset by height and motion.
#[derive(Debug, Clone, PartialEq)]
pub struct OffsetLikelihood {
    /// The height cue of the echo identified as the surface by all cues together; `None` where no echo
    /// follows the height.
    pub height: Option<HeightCue>,
    /// The motion cue; `None` where the radargram or the motion never changes.
    pub motion: Option<MotionCue>,
    /// Sum of the log-likelihoods of the cues and of the prior.
    pub total: LikelihoodCurve,
    /// Offsets that agree with the data, the most likely first; never empty.
    pub candidates: Vec<Candidate>,
    options: OffsetOptions,
    /// The cues of the echoes that may be the surface.
    heights: Vec<HeightCue>,
    /// Sum of the log-likelihoods of the cues.
    by_cues: LikelihoodCurve,
}

/// A clock offset with its evidence.
#[derive(Debug, Clone, PartialEq)]
pub struct OffsetEstimate {
    /// Trajectory time − radar time, s.
    pub offset_s: f64,
    /// Standard deviation of the offset, s.
    pub sigma_s: f64,
    /// The most likely other offset, s, and the log-likelihood by which the best offset exceeds it; `None`
    /// where every other offset tried is excluded.
    pub second: Option<(f64, f64)>,
    /// Fast time of zero range by the surface echo and the standard deviation of this time, s; `None` where
    /// no echo follows the height.
    pub delay_s: Option<(f64, f64)>,
    /// The sharpness cue, where images were scored and had a sharpest offset.
    pub sharpness: Option<SharpnessCue>,
}

/// Log-likelihood of every offset between the clocks of a radargram and a trajectory, by height
/// and by motion.
///
/// The offset is trajectory time − radar time, the campaign file's `time_offset_s`. The radargram is raw and
/// has all traces: background and fast-time zero as recorded.
///
/// # Errors
/// If the logs never overlap enough, no cue depends on the offset, or the caller cancels.
pub fn offset_likelihood(
    radargram: &Radargram,
    profile: &FlightProfile,
    options: &OffsetOptions,
    control: Control<'_>,
) -> Result<OffsetLikelihood, AlignError> {
    check_times(&radargram.time_s)?;
    let grid = grid(&radargram.time_s, profile, options)?;
    let traces = (LARGEST_PASS / grid.count).clamp(200, TRACES);
    let (time_s, change) = thinned_change(radargram, traces);
    let motion = motion_cue((&time_s, &change), profile, grid, control)?;
    let by_motion = motion
        .as_ref()
        .map(|cue| perhaps_unrelated(&cue.curve, cue.evidence));
    let likely_s = by_motion
        .as_ref()
        .map_or(grid.count as f64 * grid.step_s, LikelihoodCurve::likely_s);
    let heights = match profile.echo_delay_range_s() {
        Some([low, high]) => {
            let search = Search {
                window_s: [low + grid.delay_s[0], high + grid.delay_s[1]],
                rate: profile.fast_echo_rate(),
                traces,
            };
            match Echoes::of(radargram, search, control)? {
                Some(echoes) => height_cues(&echoes, profile, grid, likely_s, control)?,
                None => Vec::new(),
            }
        }
        None => Vec::new(),
    };
    if heights.is_empty() && motion.is_none() {
        return Err(AlignError::NoCue);
    }
    let mut total = any_of(&heights, grid);
    if let Some(curve) = &by_motion {
        total.add(curve);
    }
    Ok(combined(heights, motion, total, options))
}

fn check_times(time_s: &[f64]) -> Result<(), AlignError> {
    let what = "radargram";
    if time_s.len() < 16 {
        return Err(AlignError::Length {
            what,
            times: time_s.len(),
            values: time_s.len(),
        });
    }
    let rises = |w: &[f64]| w[1] > w[0];
    match time_s.windows(2).position(|w| !rises(w)) {
        Some(i) => Err(AlignError::Order { what, index: i + 1 }),
        None => Ok(()),
    }
}

/// The offsets to try.
fn grid(
    time_s: &[f64],
    profile: &FlightProfile,
    options: &OffsetOptions,
) -> Result<Grid, AlignError> {
    let [from_s, to_s] = options.delay_range_s;
    if !(from_s < to_s && from_s.is_finite() && to_s.is_finite()) {
        return Err(AlignError::DelayRange { from_s, to_s });
    }
    let (first, last) = (time_s[0], time_s[time_s.len() - 1]);
    let outside_s = (1.0 - options.overlap) * (last - first);
    let mut from_s = profile.start_s() - first - outside_s;
    let mut to_s = profile.end_s() - last + outside_s;
    if let Some([low, high]) = options.range_s {
        from_s = from_s.max(low);
        to_s = to_s.min(high);
    }
    if from_s.is_nan() || to_s.is_nan() || from_s > to_s {
        return Err(AlignError::NoOverlap {
            from_s,
            to_s,
            percent: 100.0 * options.overlap,
        });
    }
    let range_s = to_s - from_s;
    if range_s / STEP_S > MOST_OFFSETS {
        return Err(AlignError::Step {
            step_s: STEP_S,
            range_s,
        });
    }
    Ok(Grid {
        start_s: from_s,
        step_s: STEP_S,
        count: (range_s / STEP_S) as usize + 1,
        delay_s: options.delay_range_s,
    })
}

/// The change about each trace, averaged to a largest number of values.
fn thinned_change(radargram: &Radargram, most: usize) -> (Vec<f64>, Vec<f64>) {
    let change = activity(radargram);
    let size = change.len().div_ceil(most.max(1)).max(1);
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    (
        radargram.time_s.chunks(size).map(mean).collect(),
        change.chunks(size).map(mean).collect(),
    )
}

fn combined(
    heights: Vec<HeightCue>,
    motion: Option<MotionCue>,
    by_cues: LikelihoodCurve,
    options: &OffsetOptions,
) -> OffsetLikelihood {
    let mut total = by_cues.clone();
    if let Some(prior) = options.prior {
        for k in 0..total.log_likelihood.len() {
            let x = (total.offset_s(k) - prior.offset_s) / prior.sigma_s.max(1e-6);
            total.log_likelihood[k] -= 0.5 * x * x;
        }
    }
    let (offset_s, best) = total.best();
    let height = surface_at(&heights, offset_s);
    let candidate = |mode: &Mode| Candidate {
        offset_s: total.vertex_s(mode.peak),
        sigma_s: total.sigma_s(*mode),
        below_best: best - total.log_likelihood[mode.peak],
    };
    let candidates = total
        .modes(options.margin, APART_S)
        .iter()
        .map(candidate)
        .collect();
    OffsetLikelihood {
        height,
        motion,
        candidates,
        total,
        options: *options,
        heights,
        by_cues,
    }
}

/// The likelihood of a cue that may be unrelated to the flight (another echo, a change that is not motion),
/// in which case every offset is as likely as without the cue. A strong cue is nearly unchanged.
fn perhaps_unrelated(curve: &LikelihoodCurve, evidence: f64) -> LikelihoodCurve {
    let (_, best) = curve.best();
    let log_likelihood = curve
        .log_likelihood
        .iter()
        .map(|l| {
            // ln(1 + exp(x)), without overflow.
            let x = l - best + evidence;
            x.max(0.0) + (-x.abs()).exp().ln_1p()
        })
        .collect();
    LikelihoodCurve {
        log_likelihood,
        ..*curve
    }
}

impl OffsetLikelihood {
    /// The prior of the options.
    #[must_use]
    pub const fn prior(&self) -> Option<ClockPrior> {
        self.options.prior
    }

    /// The likelihood of the same cues with another prior.
    #[must_use]
    pub fn with_prior(&self, prior: ClockPrior) -> Self {
        combined(
            self.heights.clone(),
            self.motion.clone(),
            self.by_cues.clone(),
            &self.options.with_prior(prior),
        )
    }

    /// The offset by height and motion alone.
    ///
    /// # Errors
    /// [`AlignError::Vague`] if too wide an interval of offsets agrees with the data,
    /// [`AlignError::Ambiguous`] if two do.
    pub fn decide(&self) -> Result<OffsetEstimate, AlignError> {
        self.check_sigma(&self.candidates[0], 1.0)?;
        self.check_second(&self.candidates)?;
        Ok(self.estimate(self.candidates[0], None))
    }

    /// The offset by height, motion and the sharpness of images.
    ///
    /// `score` is called with the rising offsets about each candidate and returns, for each offset, one
    /// positive score for each independent part of the data (a sub-aperture, a target), larger for sharper
    /// images, such as the brightest pixel over the median one. An offset without scores is left out. Images
    /// are scored `step_s` apart (a third of the width of the peak in sharpness, or less), up to four
    /// standard deviations to each side of every candidate as far as `most` images allow. At least two
    /// standard deviations are covered, with up to three times as many images; where these do not suffice,
    /// the offset is [vague](AlignError::Vague).
    ///
    /// `common_sigma_s` is the standard deviation of the offset's error that is common to all parts and does
    /// not appear in their scatter: motion of the phase centre by unrecorded attitudes.
    ///
    /// # Errors
    /// As [`Self::decide`] with sharpness included, [`AlignError::Contradiction`] if sharpness disagrees with
    /// height and motion by more than five standard deviations, and errors of `score`.
    pub fn decide_with<E: From<AlignError>>(
        &self,
        step_s: f64,
        most: usize,
        common_sigma_s: f64,
        mut score: impl FnMut(&[f64]) -> Result<Vec<Vec<f64>>, E>,
    ) -> Result<OffsetEstimate, E> {
        let refused = match self.by_few_images(step_s, most, common_sigma_s, &mut score)? {
            Ok(estimate) => return Ok(estimate),
            Err(refused) => refused,
        };
        match refused {
            AlignError::Vague { .. } | AlignError::Ambiguous { .. } => {
                let found = self.by_many_images(step_s, common_sigma_s, &mut score)?;
                Ok(found.ok_or(refused)?)
            }
            _ => Err(refused.into()),
        }
    }

    /// The offset by images over all intervals that agree with height and motion; `None` where the intervals
    /// need too many images, or where the posterior is too wide.
    fn by_many_images<E>(
        &self,
        step_s: f64,
        common_sigma_s: f64,
        score: &mut impl FnMut(&[f64]) -> Result<Vec<Vec<f64>>, E>,
    ) -> Result<Option<OffsetEstimate>, E> {
        let spacing_s = SCAN_STEPS * step_s;
        let aside = |of: &Candidate| ((3.0 * of.sigma_s).max(LEAST_SCAN_S) / spacing_s).ceil();
        let tried = &self.candidates[..self.candidates.len().min(MOST_CANDIDATES)];
        let needed: f64 = tried.iter().map(|of| 2.0 * aside(of) + 1.0).sum();
        if needed > MOST_IMAGES {
            return Ok(None);
        }
        let mut scans: Vec<Scan> = Vec::new();
        for (candidate, of) in tried.iter().enumerate() {
            let aside = aside(of);
            let offsets_s: Vec<f64> = (0..=(2.0 * aside) as usize)
                .map(|k| of.offset_s + spacing_s * (k as f64 - aside))
                .collect();
            for (scores, &offset_s) in score(&offsets_s)?.into_iter().zip(&offsets_s) {
                if scores.is_empty() {
                    continue;
                }
                let is_of = |scan: &&mut Scan| {
                    scan.candidate == candidate && scan.scores[0].1.len() == scores.len()
                };
                match scans.iter_mut().find(is_of) {
                    Some(scan) => scan.scores.push((offset_s, scores)),
                    None => scans.push(Scan {
                        candidate,
                        scores: vec![(offset_s, scores)],
                    }),
                }
            }
        }
        let (_, top) = self.total.best();
        let mut likely: Vec<Likely> = scans.iter().flat_map(Scan::by_images).collect();
        for at in &mut likely {
            at.log_likelihood += self.total.at(at.offset_s) - top;
        }
        let Some((best, sigma_s)) = posterior(&likely) else {
            return Ok(None);
        };
        if sigma_s > self.options.max_sigma_s {
            return Ok(None);
        }
        let of_best = scans.iter().filter(|scan| scan.candidate == best.candidate);
        let cue = of_best
            .filter_map(|scan| scan.cue_near(best.offset_s))
            .next();
        Ok(cue.map(|cue| {
            let cue = SharpnessCue {
                sigma_s: cue.sigma_s.hypot(sigma_s).hypot(common_sigma_s),
                ..cue
            };
            self.estimate(tried[best.candidate], Some(cue))
        }))
    }

    /// The offset by images about every candidate, or the reason for which the images do not decide.
    fn by_few_images<E>(
        &self,
        step_s: f64,
        most: usize,
        common_sigma_s: f64,
        score: &mut impl FnMut(&[f64]) -> Result<Vec<Vec<f64>>, E>,
    ) -> Result<Result<OffsetEstimate, AlignError>, E> {
        if let Err(vague) = self.check_sigma(&self.candidates[0], VAGUE_BEFORE) {
            return Ok(Err(vague));
        }
        let tried = &self.candidates[..self.candidates.len().min(MOST_CANDIDATES)];
        let each = most / tried.len();
        // Candidates whose intervals need more images than their share get these images, as long as all
        // candidates together need no more than a few times `most`.
        let needed: usize = tried.iter().map(|c| least_images(c.sigma_s, step_s)).sum();
        if needed > MOST_TIMES * most {
            return Ok(Err(self.vague()));
        }
        let mut judged: Vec<(Candidate, Option<SharpnessCue>)> = Vec::new();
        for candidate in tried {
            let mut scored = Scored { scores: Vec::new() };
            let offsets_s = offsets_about(candidate.offset_s, candidate.sigma_s, step_s, each);
            let scores = score(&offsets_s)?;
            let known = offsets_s
                .into_iter()
                .zip(scores)
                .filter(|(_, scores)| !scores.is_empty());
            scored.scores.extend(known);
            let cue = scored.cue().map(|cue| SharpnessCue {
                sigma_s: cue.sigma_s.hypot(common_sigma_s),
                ..cue
            });
            judged.push((*candidate, cue));
        }
        // Between candidates the sharper image decides: amplitudes of a coherent peak.
        let top = |cue: &Option<SharpnessCue>| {
            let cue = cue.as_ref()?;
            let values = cue.log_score.iter().map(|p| p.1);
            Some(2.0 * values.fold(f64::NEG_INFINITY, f64::max))
        };
        let lowest = judged
            .iter()
            .filter_map(|(_, cue)| top(cue))
            .fold(f64::INFINITY, f64::min);
        let worth = |(candidate, cue): &(Candidate, Option<SharpnessCue>)| {
            top(cue).unwrap_or(lowest.min(0.0)) - candidate.below_best
        };
        judged.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
        let best = worth(&judged[0]);
        // Intervals whose sharpest images are at one offset are one answer: a narrow peak on a wide one.
        let sharpest_s = judged[0].1.as_ref().map(|cue| cue.offset_s);
        let is_same = |cue: &Option<SharpnessCue>| {
            let pair = sharpest_s.zip(cue.as_ref());
            pair.is_some_and(|(best_s, cue)| (cue.offset_s - best_s).abs() < APART_S)
        };
        let others = judged[1..].iter().filter(|(_, cue)| !is_same(cue));
        let ranked: Vec<Candidate> = judged[..1]
            .iter()
            .chain(others)
            .map(|pair| Candidate {
                below_best: best - worth(pair),
                ..pair.0
            })
            .collect();
        if let Err(ambiguous) = self.check_second(&ranked) {
            return Ok(Err(ambiguous));
        }
        let (candidate, cue) = judged.swap_remove(0);
        if cue.is_none()
            && let Err(vague) = self.check_sigma(&candidate, 1.0)
        {
            return Ok(Err(vague));
        }
        if let Some(cue) = &cue {
            let apart_s = (cue.offset_s - candidate.offset_s).abs();
            if apart_s > 5.0 * cue.sigma_s.hypot(candidate.sigma_s) {
                return Ok(Err(AlignError::Contradiction {
                    height_s: candidate.offset_s,
                    height_sigma_s: candidate.sigma_s,
                    sharpness_s: cue.offset_s,
                    sharpness_sigma_s: cue.sigma_s,
                }));
            }
        }
        Ok(Ok(self.estimate(candidate, cue)))
    }

    fn check_sigma(&self, best: &Candidate, times: f64) -> Result<(), AlignError> {
        if best.sigma_s <= times * self.options.max_sigma_s {
            return Ok(());
        }
        Err(self.vague())
    }

    /// The error with the range of all offsets that agree with the data, over all candidates.
    fn vague(&self) -> AlignError {
        let last = self.total.log_likelihood.len().saturating_sub(1);
        let (first_s, last_s) = (self.total.offset_s(0), self.total.offset_s(last));
        let ends = |sign: f64| {
            self.candidates
                .iter()
                .map(move |c| c.offset_s + sign * 3.0 * c.sigma_s)
        };
        AlignError::Vague {
            best_s: self.candidates[0].offset_s,
            from_s: ends(-1.0).fold(f64::INFINITY, f64::min).max(first_s),
            to_s: ends(1.0).fold(f64::NEG_INFINITY, f64::max).min(last_s),
        }
    }

    fn check_second(&self, ranked: &[Candidate]) -> Result<(), AlignError> {
        match ranked {
            [best, second, ..] if second.below_best < self.options.margin => {
                Err(AlignError::Ambiguous {
                    best_s: best.offset_s,
                    second_s: second.offset_s,
                    margin: second.below_best,
                    needed: self.options.margin,
                })
            }
            _ => Ok(()),
        }
    }

    fn estimate(&self, best: Candidate, sharpness: Option<SharpnessCue>) -> OffsetEstimate {
        let (mut offset_s, mut sigma_s) = (best.offset_s, best.sigma_s);
        if let Some(cue) = &sharpness {
            let (a, b) = (sigma_s.powi(-2), cue.sigma_s.powi(-2));
            offset_s = (a * offset_s + b * cue.offset_s) / (a + b);
            sigma_s = (a + b).sqrt().recip();
        }
        // The best offset outside the interval about the accepted one.
        let near_s = 5.0 * best.sigma_s + APART_S;
        let (_, top) = self.total.best();
        let second = (0..self.total.log_likelihood.len())
            .filter(|&k| (self.total.offset_s(k) - best.offset_s).abs() > near_s)
            .max_by(|&a, &b| self.total.log_likelihood[a].total_cmp(&self.total.log_likelihood[b]))
            .map(|k| (self.total.offset_s(k), top - self.total.log_likelihood[k]));
        OffsetEstimate {
            offset_s,
            sigma_s,
            second,
            delay_s: self.height.as_ref().map(|h| (h.delay_s, h.delay_sigma_s)),
            sharpness,
        }
    }
}
