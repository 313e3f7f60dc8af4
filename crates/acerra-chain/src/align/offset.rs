//! Estimation of the clock offset from the data alone: by height and motion over all offsets at which the
//! logs overlap, then by the sharpness of images about the offsets that agree.

use std::ops::Range;

use acerra_geo::interpolate::Interpolated;
use acerra_geo::trajectory::Trajectory;
use acerra_imaging::{Complex32, ImagingError, PlaneGrid, TrialImage};
use acerra_radar::align::{
    AlignError as Undecided, Candidate, ClockPrior, FlightProfile, FlightState, OffsetEstimate,
    OffsetLikelihood, OffsetOptions, OffsetSearch as MotionSearch, activity, coarse_offset,
    offset_likelihood,
};
use acerra_radar::{Radargram, Spectrum};
use rayon::prelude::*;

use crate::align::{AlignError, AlignOptions, Flight, TracePlaces, align, interpolator};
use crate::choices::Select;
use crate::clean::{CleanError, CleanOptions, clean};
use crate::control::{Cancelled, Control};
use crate::echoes::Searched;
use crate::echoes::history::distance_m;
use crate::echoes::sharpen::coarse;
use crate::journal::warnings::Warnings;
use crate::position::aligned::Aligned;
use crate::position::height_noise::{height_noise_m, lasting_error_m, stated_error_m};
use crate::position::informative::{is_informative, largest_informative_m};
use crate::scene::Scene;

/// A score over the offsets tried.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// Offsets (s), rising.
    pub offset_s: Vec<f64>,
    /// Scores.
    pub score: Vec<f64>,
}

/// An offset found from the data, with its evidence.
#[derive(Clone, Debug)]
pub struct OffsetSearch {
    /// The offset with its standard deviation, its strongest rival, and the delay found together with the
    /// offset.
    pub estimate: OffsetEstimate,
    /// Log-likelihood of every offset by height and motion.
    pub likelihood: OffsetLikelihood,
    /// Sharpness of the images that were tried.
    pub sharpness: Curve,
}

/// Longest trajectory that is searched (s): the work grows with the duration.
const LONGEST_S: f64 = 4.0 * 3600.0;
/// Spacing of the offsets at which images are tried (s): 2 cm at 2 m/s.
const SHARPNESS_STEP_S: f64 = 0.01;
/// Largest number of images tried.
const SHARPNESS_IMAGES: usize = 100;
/// Number of pixels of each image.
const SHARPNESS_PIXELS: f64 = 60_000.0;
/// Largest number of sub-apertures whose images are scored separately: the scatter of their offsets gives the
/// standard deviation of the offset.
const SUB_APERTURES: usize = 4;
/// Least number of traces of a sub-aperture.
const LEAST_TRACES: usize = 40;
/// Spacing of the offsets at which the whole aperture is imaged (s).
const WHOLE_STEP_S: f64 = 0.005;
/// Range of these offsets to either side of the estimate (s).
const WHOLE_REACH_S: f64 = 0.12;
/// Noise of heights from fix to fix above which the heights are smoothed (m).
const QUIET_M: f64 = 1.5e-3;
/// Half window of the smoothing (s): the wander of a platform is slower.
const SMOOTHED_S: f64 = 0.7;
/// Least correlation of change and speed for which motion alone narrows the offsets.
const CLEAR_CORRELATION: f64 = 0.6;
/// Largest correlation at other offsets, as a share of this one.
const CLEAR_SHARE: f64 = 0.5;
/// Standard deviation to which such motion narrows the offset (s).
const CLEAR_MOTION_SIGMA_S: f64 = 0.05;
/// Swing of the phase centre by unrecorded tilts (m): 2° at a distance of 20 cm.
const SWING_M: f64 = 7e-3;
/// Period of the tilts and of a platform's wander (s).
const SWING_PERIOD_S: f64 = 3.0;

/// Unknown motion of the phase centre that correlates with another motion of the platform (m): two unrelated
/// motions correlate by one over the root of the number of periods.
pub(crate) fn lasting_motion_m(duration_s: f64) -> f64 {
    SWING_M / (duration_s / SWING_PERIOD_S).max(1.0).sqrt()
}
/// Range of offsets over which traces are placed and cleaned as at the middle of the range (s).
const CLEANED_ANEW_S: f64 = 0.5;

/// Reason for which the clock offset cannot be found.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OffsetError {
    /// The trajectory is too long to be searched.
    #[error(
        "[trajectory] time_offset_s = \"auto\": expected a trajectory of less than {LONGEST_S:.0} s, \
         found {found_s:.0} s (are its times in seconds?); state the offset, or give the positions of the \
         flight alone"
    )]
    TooLong {
        /// Length of the trajectory (s).
        found_s: f64,
    },
    /// The data leave the offset open, or agree with several offsets.
    #[error("[trajectory] time_offset_s = \"auto\": {cause}; {}", settling(cause))]
    Undecided {
        /// Reason, with the offsets that remain.
        cause: Undecided,
    },
    /// No trace can be placed at an offset that is tried.
    #[error(transparent)]
    Align(#[from] AlignError),
    /// The traces of the search cannot be cleaned.
    #[error(transparent)]
    Clean(#[from] CleanError),
    /// The images of the search cannot be made.
    #[error(transparent)]
    Imaging(#[from] ImagingError),
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<Undecided> for OffsetError {
    fn from(cause: Undecided) -> Self {
        Self::Undecided { cause }
    }
}

/// The measurement that settles an offset which the data leave open.
fn settling(refusal: &Undecided) -> &'static str {
    match refusal.open_offsets() {
        Some(_) => {
            "one reflector at a known place settles the offset (acerra calibrate --reflector X,Y,Z; guide, \
             \"Clocks\"), or state it"
        }
        None => "state the offset",
    }
}

/// Inputs and constraints of the search.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SearchRange {
    /// Longest gap of the trajectory that is interpolated over (s).
    pub max_gap_s: Option<f64>,
    /// Fast times at which range may be zero (s); by default those of usual instruments.
    pub delay_s: Option<[f64; 2]>,
}

/// Log-likelihood by height and motion of every offset at which radar log and trajectory overlap.
///
/// # Errors
/// Logs that never overlap enough, a radargram in which no echo follows the flight, cancellation.
pub fn by_height_and_motion(
    radargram: &Radargram,
    trajectory: &Trajectory,
    scene: &Scene,
    range: SearchRange,
    control: &Control<'_>,
) -> Result<OffsetLikelihood, OffsetError> {
    let span_s = [trajectory.start_s(), trajectory.end_s()];
    let length_s = span_s[1] - span_s[0];
    if length_s.is_nan() || length_s >= LONGEST_S {
        return Err(OffsetError::TooLong { found_s: length_s });
    }
    let at = interpolator(range.max_gap_s, trajectory);
    let half_s = 0.05_f64.max(trajectory.sample_interval_s().unwrap_or(0.1));
    let largest_m = largest_informative_m(trajectory);
    let profile = FlightProfile::sample(span_s, |t| {
        let [before, now, after] = [t - half_s, t, t + half_s].map(|t| at.at(t));
        let is_used =
            |p: &Interpolated| p.flag.is_covered() && is_informative(p.covariance_m2, largest_m);
        let is_known = [before, now, after].iter().all(is_used);
        let [x, y, z] = now.position_m;
        let moved: f64 = (0..3)
            .map(|i| (after.position_m[i] - before.position_m[i]).powi(2))
            .sum();
        is_known.then(|| FlightState {
            height_m: z - scene.ground.below_m(x, y),
            speed_m_s: moved.sqrt() / (2.0 * half_s),
        })
    })?;
    let profile = if height_noise_m(trajectory).is_some_and(|noise_m| noise_m > QUIET_M) {
        profile.smoothed(SMOOTHED_S)
    } else {
        profile
    };
    let profile = profile
        .with_lasting_error_m(lasting_error_m(trajectory).unwrap_or(0.0))
        .with_stated_error_m(stated_error_m(trajectory).unwrap_or(0.0));
    let mut options = OffsetOptions::default();
    if let Some(delay_s) = range.delay_s {
        options = options.with_delay_range_s(delay_s);
    }
    let control = control.operation();
    let found = offset_likelihood(radargram, &profile, &options, control)?;
    // Scenery that comes into view changes the radargram as starts and halts do: starts and halts alone
    // decide only where no echo follows the height.
    if found.height.is_some() {
        return Ok(found);
    }
    Ok(match clear_motion(radargram, &profile) {
        Some(prior) => found.with_prior(prior),
        None => found,
    })
}

/// The offset at which the radargram changes while the platform moves, where no other offset correlates
/// nearly as well: unmistakable starts and halts.
fn clear_motion(radargram: &Radargram, profile: &FlightProfile) -> Option<ClockPrior> {
    // Change saturates when the platform moves a quarter of a wavelength between traces; its root depends
    // more on motion than on the scenery in view.
    let change: Vec<f64> = activity(radargram).iter().map(|a| a.sqrt()).collect();
    let found = coarse_offset(
        &radargram.time_s,
        &change,
        &profile.times_s(),
        profile.speed_m_s(),
        &MotionSearch::default(),
    )
    .ok()?;
    let is_clear = found.correlation >= CLEAR_CORRELATION
        && found.runner_up <= CLEAR_SHARE * found.correlation;
    is_clear.then_some(ClockPrior {
        offset_s: found.offset_s,
        sigma_s: CLEAR_MOTION_SIGMA_S,
    })
}

/// Options for placing and cleaning the traces of a track while offsets are tried.
#[derive(Clone, Copy, Debug)]
pub struct Trial<'a> {
    /// The track.
    pub flight: Flight<'a>,
    /// Options of the placement of the traces.
    pub align: &'a AlignOptions,
    /// Options of the cleaning.
    pub clean: &'a CleanOptions,
}

/// The offset with the sharpest images among the offsets that agree with height and motion.
///
/// # Errors
/// Two offsets that remain, data that cannot be imaged, cancellation.
pub fn refine(
    trial: Trial<'_>,
    likelihood: OffsetLikelihood,
    control: &Control<'_>,
) -> Result<OffsetSearch, OffsetError> {
    let grid = coarse(trial.rectangle(&likelihood)?, SHARPNESS_PIXELS)?;
    control.start("align", SHARPNESS_IMAGES as u64);
    let mut sharpness = Vec::new();
    let common_s = trial.common_sigma_s(&likelihood);
    let places = TracePlaces::of(trial.flight, trial.align);
    let score = |offsets_s: &[f64]| {
        let mut scores = Vec::with_capacity(offsets_s.len());
        let span_s = (offsets_s.last().copied().unwrap_or(0.0))
            - (offsets_s.first().copied().unwrap_or(0.0));
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a search takes thousands at most"
        )]
        let stretches = (span_s / CLEANED_ANEW_S).ceil().max(1.0) as usize;
        for near_s in offsets_s.chunks(offsets_s.len().div_ceil(stretches).max(1)) {
            control.check()?;
            let middle_s = 0.5 * (near_s[0] + near_s[near_s.len() - 1]);
            let of_these = match trial.cleaned_at(middle_s)? {
                Some(cleaned) => trial.contrasts((&cleaned, places.as_ref()), near_s, grid)?,
                None => vec![Vec::new(); near_s.len()],
            };
            for (offset_s, scores) in near_s.iter().zip(&of_these) {
                if !scores.is_empty() {
                    let mean = scores.iter().sum::<f64>() / scores.len() as f64;
                    sharpness.push((*offset_s, mean));
                }
            }
            control.at(sharpness.len() as u64);
            scores.extend(of_these);
        }
        Ok::<_, OffsetError>(scores)
    };
    let estimate = likelihood.decide_with(SHARPNESS_STEP_S, SHARPNESS_IMAGES, common_s, score)?;
    let estimate = match trial.cleaned_at(estimate.offset_s)? {
        Some(cleaned) => {
            let whole = WholeAperture {
                cleaned: &cleaned,
                places: places.as_ref(),
                grid,
                common_s,
                least_sigma_s: least_sigma_s(&likelihood, &estimate, common_s),
            };
            trial.by_whole_aperture(&whole, estimate, control)?
        }
        None => estimate,
    };
    control.finish();
    sharpness.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (offset_s, score) = sharpness.into_iter().unzip();
    Ok(OffsetSearch {
        estimate,
        likelihood,
        sharpness: Curve { offset_s, score },
    })
}

/// Traces cleaned at the positions of an offset.
struct CleanedAt {
    aligned: Aligned,
    spectrum: Spectrum,
}

/// Echoes whose image over the whole aperture is scored.
struct WholeAperture<'a> {
    cleaned: &'a CleanedAt,
    /// Interpolation of the traces' positions; `None` where positions depend on more than the trajectory.
    places: Option<&'a TracePlaces<'a>>,
    grid: PlaneGrid,
    /// Standard deviation of the error of the sharpest offset that is common to all images (s).
    common_s: f64,
    /// Lower bound of the offset's standard deviation for any number of images (s).
    least_sigma_s: f64,
}

impl Trial<'_> {
    /// Standard deviation of the sharpest offset by unrecorded tilts, which swing the phase centre: an offset
    /// moves traces by the deviation of the velocity from its mean, and the sharpest offset compensates for
    /// part of such a swing.
    fn common_sigma_s(&self, likelihood: &OffsetLikelihood) -> f64 {
        let discarded = &mut Warnings::default();
        let aligned = likelihood
            .candidates
            .first()
            .and_then(|best| align(self.flight, self.align, best.offset_s, discarded).ok());
        aligned.map_or(0.0, |aligned| {
            let wander_m_s = velocity_wander_m_s(&aligned);
            let ends = (aligned.time_s.first(), aligned.time_s.last());
            let duration_s = ends.1.zip(ends.0).map_or(0.0, |(last, first)| last - first);
            lasting_motion_m(duration_s) / wander_m_s.max(1e-6)
        })
    }

    /// The image's rectangle; where the sides are left to the flight, a rectangle about the traces at the
    /// most likely offset.
    fn rectangle(&self, likelihood: &OffsetLikelihood) -> Result<PlaneGrid, OffsetError> {
        let scene = self.flight.scene;
        let grid = PlaneGrid {
            z_m: scene.pixels.middle_m(),
            ..scene.pixels.grid
        };
        let Some(best) = likelihood.candidates.first() else {
            return Ok(grid);
        };
        if scene.open.sides == [false; 2] {
            return Ok(grid);
        }
        let aligned = align(
            self.flight,
            self.align,
            best.offset_s,
            &mut Warnings::default(),
        )?;
        Ok(scene.around(&aligned.position_m, grid.z_m)?)
    }

    /// The traces cleaned at an offset; `None` where no trace has a position or no surface is seen.
    fn cleaned_at(&self, offset_s: f64) -> Result<Option<CleanedAt>, OffsetError> {
        // Warnings are given once, at the final offset.
        let discarded = &mut Warnings::default();
        let Ok(aligned) = align(self.flight, self.align, offset_s, discarded) else {
            return Ok(None);
        };
        let Ok(cleaned) = clean(
            self.flight.radar,
            &aligned,
            self.flight.scene,
            self.clean,
            discarded,
        ) else {
            return Ok(None);
        };
        Ok(Some(CleanedAt {
            aligned,
            spectrum: cleaned.spectrum,
        }))
    }

    /// Contrasts of the images of the sub-apertures at each offset; empty where a trace of the echoes has no
    /// position at the offset.
    fn contrasts(
        &self,
        (cleaned, places): (&CleanedAt, Option<&TracePlaces<'_>>),
        offsets_s: &[f64],
        grid: PlaneGrid,
    ) -> Result<Vec<Vec<f64>>, OffsetError> {
        let placed: Vec<Option<Vec<[f64; 3]>>> = offsets_s
            .iter()
            .map(|offset_s| self.places_at(cleaned, places, *offset_s))
            .collect::<Result<_, _>>()?;
        let known: Vec<&Vec<[f64; 3]>> = placed.iter().flatten().collect();
        let Some(middle_m) = known.get(known.len() / 2) else {
            return Ok(vec![Vec::new(); offsets_s.len()]);
        };
        let moved_m = farthest_m(&known, middle_m);
        let of_part = |part: &Range<usize>| {
            let spectrum = part_of(&cleaned.spectrum, part.clone());
            let middle_m = &middle_m[part.clone()];
            let searched = Searched::new(middle_m, &spectrum, self.flight.scene.light_speed_m_s);
            let looks = searched.looks(grid, moved_m)?;
            let contrast_at = |places_m: &Option<Vec<[f64; 3]>>| {
                let Some(places_m) = places_m else {
                    return Ok(None);
                };
                let image = looks.image(&TrialImage {
                    position_m: &places_m[part.clone()],
                    beyond_m: 0.0,
                    grid,
                })?;
                Ok(Some(contrast(&image)))
            };
            let of_offsets = placed.par_iter().map(contrast_at);
            of_offsets.collect::<Result<Vec<Option<f64>>, OffsetError>>()
        };
        let of_parts: Vec<Vec<Option<f64>>> = sub_apertures(middle_m.len())
            .par_iter()
            .map(of_part)
            .collect::<Result<_, OffsetError>>()?;
        let mut contrasts = vec![Vec::new(); offsets_s.len()];
        for of_part in of_parts {
            for (all, contrast) in contrasts.iter_mut().zip(of_part) {
                all.extend(contrast);
            }
        }
        Ok(contrasts)
    }
}

impl Trial<'_> {
    /// The estimate, updated by the contrast of images of the whole aperture: a coherent peak against its
    /// surroundings, whose amplitude ratio is used as a likelihood ratio.
    fn by_whole_aperture(
        &self,
        whole: &WholeAperture<'_>,
        estimate: OffsetEstimate,
        control: &Control<'_>,
    ) -> Result<OffsetEstimate, OffsetError> {
        let (cleaned, grid) = (whole.cleaned, whole.grid);
        let light_speed_m_s = self.flight.scene.light_speed_m_s;
        let reach_s = (3.0 * estimate.sigma_s).clamp(WHOLE_STEP_S, WHOLE_REACH_S);
        let steps = (reach_s / WHOLE_STEP_S).ceil();
        #[expect(clippy::cast_possible_truncation, reason = "at most fifty")]
        let steps = steps as i32;
        let Some(middle_m) = self.places_at(cleaned, whole.places, estimate.offset_s)? else {
            return Ok(estimate);
        };
        let mut trials: Vec<(f64, Vec<[f64; 3]>)> = Vec::new();
        for k in -steps..=steps {
            control.check()?;
            let offset_s = estimate.offset_s + f64::from(k) * WHOLE_STEP_S;
            let places_m = self.places_at(cleaned, whole.places, offset_s)?;
            trials.extend(places_m.map(|places_m| (offset_s, places_m)));
        }
        let moved: Vec<&Vec<[f64; 3]>> = trials.iter().map(|(_, places_m)| places_m).collect();
        let moved_m = farthest_m(&moved, &middle_m);
        let searched = Searched::new(&middle_m, &cleaned.spectrum, light_speed_m_s);
        let looks = searched.looks(grid, moved_m)?;
        let score = |(offset_s, places_m): &(f64, Vec<[f64; 3]>)| {
            control.check()?;
            let image = looks.image(&TrialImage {
                position_m: places_m,
                beyond_m: 0.0,
                grid,
            })?;
            Ok::<_, OffsetError>((*offset_s, 2.0 * contrast(&image).ln()))
        };
        let tried: Vec<(f64, f64)> = trials
            .par_iter()
            .map(score)
            .collect::<Result<_, OffsetError>>()?;
        let tried = weighed_by(&estimate, &widened(&tried, whole.common_s));
        let highest = tried.iter().map(|t| t.1).fold(f64::NEG_INFINITY, f64::max);
        if tried.len() < 3 || !highest.is_finite() {
            return Ok(estimate);
        }
        let weighed = |value: fn(f64, f64) -> f64, centre: f64| -> f64 {
            let weight = |log: f64| (log - highest).exp();
            let sum: f64 = tried
                .iter()
                .map(|(t, l)| weight(*l) * value(*t, centre))
                .sum();
            sum / tried.iter().map(|(_, l)| weight(*l)).sum::<f64>()
        };
        let offset_s = weighed(|t, centre| t - centre, estimate.offset_s) + estimate.offset_s;
        let variance_s2 = weighed(|t, centre| (t - centre).powi(2), offset_s);
        Ok(OffsetEstimate {
            offset_s,
            sigma_s: variance_s2.sqrt().max(whole.least_sigma_s),
            ..estimate
        })
    }

    /// Positions of the traces of the echoes at an offset; `None` where a trace has no position.
    fn places_at(
        &self,
        cleaned: &CleanedAt,
        places: Option<&TracePlaces<'_>>,
        offset_s: f64,
    ) -> Result<Option<Vec<[f64; 3]>>, OffsetError> {
        let found = places.and_then(|places| places.at(&cleaned.aligned.traces, offset_s));
        if found.is_some() {
            return Ok(found);
        }
        // The same traces at every offset: only their positions change.
        let everywhere = AlignOptions {
            select: Select::All,
            ..self.align.clone()
        };
        let discarded = &mut Warnings::default();
        let all = align(self.flight, &everywhere, offset_s, discarded)?;
        let position_of = |trace: &usize| {
            let at = all.traces.binary_search(trace).ok()?;
            Some(all.position_m[at])
        };
        Ok(cleaned.aligned.traces.iter().map(position_of).collect())
    }
}

/// An estimate with the deviation by errors of the heights included, in proportion to the weight of height
/// and motion. Heights are usually better than stated: weighted by the stated deviation, the sharpness of
/// images, which unrecorded tilts move, would pull the offset away from a good height.
pub(crate) fn with_heights_error(
    estimate: OffsetEstimate,
    likelihood: &OffsetLikelihood,
) -> OffsetEstimate {
    let Some(height) = &likelihood.height else {
        return estimate;
    };
    let share = nearest(likelihood, estimate.offset_s)
        .map_or(0.0, |c| (estimate.sigma_s / c.sigma_s).powi(2).min(1.0));
    OffsetEstimate {
        sigma_s: estimate.sigma_s.hypot(share * height.stated_sigma_s),
        ..estimate
    }
}

/// The candidate by height and motion nearest to an offset.
fn nearest(likelihood: &OffsetLikelihood, offset_s: f64) -> Option<&Candidate> {
    let away = |candidate: &Candidate| (candidate.offset_s - offset_s).abs();
    let candidates = likelihood.candidates.iter();
    candidates.min_by(|a, b| away(a).total_cmp(&away(b)))
}

/// Deviation of an offset by height and motion combined with images, whose common error is a lower bound (s).
fn least_sigma_s(likelihood: &OffsetLikelihood, found: &OffsetEstimate, common_s: f64) -> f64 {
    let nearest = nearest(likelihood, found.offset_s);
    let known_s = nearest.map_or(f64::INFINITY, |candidate| candidate.sigma_s);
    let together_s = (known_s.powi(-2) + common_s.max(1e-6).powi(-2))
        .sqrt()
        .recip();
    together_s.max(0.5 * WHOLE_STEP_S)
}

/// Log-likelihoods over offsets, widened by a common error: likelihoods are averaged over a normal
/// distribution about each offset.
fn widened(tried: &[(f64, f64)], common_s: f64) -> Vec<(f64, f64)> {
    let highest = tried.iter().map(|t| t.1).fold(f64::NEG_INFINITY, f64::max);
    let at = |offset_s: f64| {
        let weight = |t: f64| (-0.5 * ((t - offset_s) / common_s.max(1e-6)).powi(2)).exp();
        let likelihood: f64 = tried
            .iter()
            .map(|(t, l)| weight(*t) * (l - highest).exp())
            .sum();
        let total: f64 = tried.iter().map(|(t, _)| weight(*t)).sum();
        highest + (likelihood / total).ln()
    };
    tried.iter().map(|(t, _)| (*t, at(*t))).collect()
}

/// Log-likelihoods plus the log-likelihoods of the prior.
fn weighed_by(before: &OffsetEstimate, tried: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let known = |t: f64| -0.5 * ((t - before.offset_s) / before.sigma_s.max(1e-6)).powi(2);
    tried.iter().map(|(t, l)| (*t, l + known(*t))).collect()
}

/// Root mean square of the deviation of the traces' velocity from its mean, along one direction (m/s).
fn velocity_wander_m_s(aligned: &Aligned) -> f64 {
    let pairs = aligned.position_m.windows(2).zip(aligned.time_s.windows(2));
    let velocity: Vec<[f64; 3]> = pairs
        .filter(|(_, t)| t[1] > t[0])
        .map(|(p, t)| [0, 1, 2].map(|i| (p[1][i] - p[0][i]) / (t[1] - t[0])))
        .collect();
    let count = velocity.len().max(1) as f64;
    let mean = [0, 1, 2].map(|i| velocity.iter().map(|v| v[i]).sum::<f64>() / count);
    let square: f64 = velocity
        .iter()
        .map(|v| (0..3).map(|i| (v[i] - mean[i]).powi(2)).sum::<f64>())
        .sum();
    (square / count / 3.0).sqrt()
}

/// Consecutive parts of an aperture.
fn sub_apertures(traces: usize) -> Vec<Range<usize>> {
    let parts = (traces / LEAST_TRACES).clamp(1, SUB_APERTURES);
    (0..parts)
        .map(|k| k * traces / parts..(k + 1) * traces / parts)
        .collect()
}

/// Largest distance of a place from the place of the same trace in `middle_m` (m).
fn farthest_m(placed: &[&Vec<[f64; 3]>], middle_m: &[[f64; 3]]) -> f64 {
    (placed
        .iter()
        .flat_map(|places_m| places_m.iter().zip(middle_m)))
    .map(|(place, middle)| distance_m(*place, *middle))
    .fold(0.0, f64::max)
}

/// The spectra of some of the traces.
fn part_of(spectrum: &Spectrum, part: Range<usize>) -> Spectrum {
    let width = spectrum.frequency_hz.len();
    Spectrum {
        time_s: spectrum.time_s[part.clone()].to_vec(),
        frequency_hz: spectrum.frequency_hz.clone(),
        values: spectrum.values[part.start * width..part.end * width].to_vec(),
    }
}

/// The brightest pixel's modulus over the median modulus; 1 for an image of zeros.
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
    fn contrast_is_the_peak_over_the_median() {
        let mut image = vec![Complex32::new(0.0, 2.0); 101];
        assert!((contrast(&image) - 1.0).abs() < 1e-6);
        image[3] = Complex32::new(-6.0, 8.0);
        assert!((contrast(&image) - 5.0).abs() < 1e-6);
        assert!((contrast(&[]) - 1.0).abs() < f64::EPSILON);
    }

    #[test]
    fn sub_apertures_cover_every_trace_once() {
        for traces in [1, 39, 160, 331] {
            let parts = sub_apertures(traces);
            assert_eq!(parts[0].start, 0);
            assert_eq!(parts[parts.len() - 1].end, traces);
            assert!(parts.windows(2).all(|w| w[0].end == w[1].start));
        }
    }
}
