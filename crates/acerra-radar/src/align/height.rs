//! The height cue: the surface echo's fast time against 2h/c of the trajectory.
//!
//! For an offset τ and a delay d each pick p(t) leaves a residual p(t) − 2h(t+τ)/c − d. Residuals are
//! modelled as a mixture: the surface, with a normal error of standard deviation s, or a stray, with a
//! constant density over the window. The delay is the one at which most residuals agree; s and the share of
//! strays are estimated from the data. The log-likelihood is divided by the correlation length of the
//! residuals, so that lasting errors (GNSS heights, drift) do not count as many independent ones.

use rayon::prelude::*;

use super::curve::LikelihoodCurve;
use super::echo::Ridge;
use super::noise::{correlation_length, spread_correlation_length, variance_inflation};
use super::{AlignError, FlightProfile};
use crate::quality::median;
use acerra_control::Control;

/// Initial model of the residuals: an error of 3 cm, every fifth a stray.
const TYPICAL: Mixture = Mixture {
    sigma_s: 0.2e-9,
    stray_share: 0.2,
};
/// Largest share of strays among the picks of an echo that is seen throughout the flight. For an echo seen in
/// a part of the flight, the largest share among the picks within [`ABOUT_S`] of picks that fit the height
/// (picks that fit by chance are isolated).
const MOST_STRAYS: f64 = 0.5;
/// Largest share of strays within [`ABOUT_S`] of the picks that fit the height, for an echo that follows the
/// height trace after trace; chosen on the random flights 1 to 120 of the validation book.
const FOLLOWED_STRAYS: f64 = 0.08;
/// Largest error of the picks of such an echo, s; chosen on the same flights.
const FOLLOWED_S: f64 = 0.5e-9;
/// Evidence from which an echo is beyond doubt: odds of 400 to 1.
const BEYOND_DOUBT: f64 = 6.0;
/// Evidence beyond doubt for an echo that follows the height only in a part of the flight, which may be a
/// chance choice of the part.
const OF_A_PART: f64 = 2.0 * BEYOND_DOUBT;
/// Distance below which offsets count as one, s.
const ONE_OFFSET_S: f64 = 0.1;
/// Logarithm of the prior odds against an echo being the surface.
const DOUBT: f64 = 4.0;
/// Largest number of re-estimates of the error at the most likely offset.
const REFITS: usize = 2;
/// Iterations of the expectation maximisation at most, and the relative change at which it has converged.
const MOST_ITERATIONS: usize = 20;
const CONVERGED: f64 = 1e-3;
/// Number of picks of a ridge from which excluded offsets are recognised: log-likelihoods of a sample scatter
/// by a few units about those of all picks.
const SAMPLE: usize = 500;
/// Spacing of the coarse grid of offsets, in steps of the fine one.
const COARSE: f64 = 4.0;
/// Log-likelihood below the best of the coarse grid from which an offset is not tried on the fine one: odds of
/// 10⁹ to 1.
const OUT_OF_QUESTION: f64 = 20.0;
/// Number of ridges tried on the whole grid.
const KEPT: usize = 6;
/// Smallest standard deviation of a residual, s (1.5 mm).
const LEAST_S: f64 = 0.01e-9;
/// Largest standard deviation of a residual, s (10 cm of range): ground is smoother.
const MOST_S: f64 = 0.7e-9;
/// Standard deviation of errors of the height that last as long as changes of the height, s (1.5 mm): the
/// lever arm under tilt, and other errors that do not appear in a few independent residuals.
const LASTING_ERROR_S: f64 = 0.01e-9;
/// Width of a cell of the histogram of residuals by which the delay is found, s.
const CELL_S: f64 = 0.1e-9;

/// Likelihood of the offset by the surface echo.
#[derive(Debug, Clone, PartialEq)]
pub struct HeightCue {
    /// Log-likelihood of each offset.
    pub curve: LikelihoodCurve,
    /// Most likely offset by this cue alone, s.
    pub offset_s: f64,
    /// Fast time at which range is zero, s, at the most likely offset: the delay of the echo after 2h/c.
    pub delay_s: f64,
    /// Standard deviation of the delay, s, without the error of the height.
    pub delay_sigma_s: f64,
    /// Standard deviation of the residuals, s.
    pub residual_s: f64,
    /// Share of the picks that do not belong to the surface.
    pub stray_share: f64,
    /// Share of strays among the picks within a second of the surface's picks.
    pub(super) strays_about: f64,
    /// Number of picks used.
    pub picks: usize,
    /// Number of picks that are equivalent to one independent pick.
    pub correlation_length: f64,
    /// Standard deviation of the offset by [stated](FlightProfile::with_stated_error_m) errors of the heights
    /// that do not appear in the scatter about the echo, s; not included in the curve.
    pub stated_sigma_s: f64,
    /// Log-likelihood of the most likely offset over an echo that ignores the height, less the logarithm of
    /// the number of independent offsets that agree with motion, and less [`DOUBT`].
    pub evidence: f64,
    /// The evidence without lasting errors, for choosing among echoes.
    pub(super) preference: f64,
    /// Median envelope of the surface's picks, in units of the samples.
    pub(super) envelope: f64,
}

impl HeightCue {
    /// Whether the echo follows the height trace after trace: few strays are among its picks, and the error of its picks
    /// is that of a surface. An echo that only crosses the height has strays before and after each crossing.
    fn is_followed(&self) -> bool {
        self.strays_about <= FOLLOWED_STRAYS && self.residual_s <= FOLLOWED_S
    }

    fn is_beyond_doubt(&self) -> bool {
        self.evidence >= BEYOND_DOUBT
    }
}

/// Offsets tried and delays allowed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grid {
    pub start_s: f64,
    pub step_s: f64,
    pub count: usize,
    pub delay_s: [f64; 2],
}

/// The cues of the echoes that follow the height best, the best first.
///
/// All ridges are tried on a coarse grid, the best few on the whole one. `likely_s` is the width of the
/// offsets that agree with the other cues.
pub(super) fn height_cues(
    ridges: &[Ridge],
    profile: &FlightProfile,
    grid: Grid,
    likely_s: f64,
    control: Control<'_>,
) -> Result<Vec<HeightCue>, AlignError> {
    let coarse = Grid {
        step_s: COARSE * grid.step_s,
        count: (grid.count as f64 / COARSE).ceil() as usize,
        ..grid
    };
    // Offsets half a second apart count as independent trials, each of which may fit by chance.
    let trials = (likely_s / 0.5).max(1.0);
    let fit = |ridge: &Ridge, grid, rough: Option<&HeightCue>| {
        let start = rough.map_or(TYPICAL, |cue| Mixture {
            sigma_s: cue.residual_s,
            stray_share: cue.stray_share,
        });
        let fit = Fit {
            ridge,
            profile,
            grid,
        };
        let rough = rough.map(|cue| Rough {
            curve: cue.curve.clone(),
            length: cue.correlation_length,
        });
        let cue = fit.cue(start, rough, control)?;
        let evidence = cue.evidence - trials.ln() - DOUBT;
        Ok::<_, AlignError>(HeightCue { evidence, ..cue })
    };
    let mut rough: Vec<(HeightCue, &Ridge)> = ridges
        .par_iter()
        .map(|ridge| Ok((fit(ridge, coarse, None)?, ridge)))
        .collect::<Result<_, AlignError>>()?;
    rough.sort_by(|a, b| b.0.preference.total_cmp(&a.0.preference));
    rough.truncate(KEPT);
    let mut cues: Vec<HeightCue> = rough
        .par_iter()
        .map(|(cue, ridge)| fit(ridge, grid, Some(cue)))
        .collect::<Result<_, AlignError>>()?;
    cues.retain(|cue| cue.evidence > 0.0);
    let mut cues = surfaces(cues);
    cues.sort_by(|a, b| b.preference.total_cmp(&a.preference));
    Ok(cues)
}

/// The echoes that may be the surface. Where an echo beyond doubt is [followed](HeightCue::is_followed) trace after trace,
/// echoes that are not followed do not count.
fn surfaces(cues: Vec<HeightCue>) -> Vec<HeightCue> {
    let mut cues = seen(cues);
    if (cues.iter()).any(|cue| cue.is_followed() && cue.is_beyond_doubt()) {
        cues.retain(HeightCue::is_followed);
    }
    cues
}

/// The echoes seen throughout the flight, with few strays among their picks. Where none of these echoes is
/// beyond doubt and all echoes beyond doubt give one offset, echoes seen for a part of the flight with the
/// evidence [`OF_A_PART`] are included.
fn seen(mut cues: Vec<HeightCue>) -> Vec<HeightCue> {
    let is_seen = |cue: &HeightCue| cue.stray_share <= MOST_STRAYS;
    let admits_parts = !cues.iter().any(|cue| is_seen(cue) && cue.is_beyond_doubt())
        && are_near(cues.iter().filter(|cue| cue.is_beyond_doubt()));
    cues.retain(|cue| {
        let is_seen_in_part = cue.evidence >= OF_A_PART && cue.strays_about <= MOST_STRAYS;
        is_seen(cue) || (admits_parts && is_seen_in_part)
    });
    cues
}

/// Whether cues give [one](ONE_OFFSET_S) offset.
fn are_near<'a>(cues: impl Iterator<Item = &'a HeightCue>) -> bool {
    let (low_s, high_s) = cues.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), cue| {
        (low.min(cue.offset_s), high.max(cue.offset_s))
    });
    high_s - low_s <= ONE_OFFSET_S
}

/// Log-likelihood of every offset where any one of the echoes may be the surface, or none: the mean of their
/// likelihoods over that of an echo that ignores the height, and 1. Echoes [beyond doubt](BEYOND_DOUBT) have
/// equal weight, since their evidence over an echo that ignores the height does not compare them with each
/// other.
pub(super) fn any_of(cues: &[HeightCue], grid: Grid) -> LikelihoodCurve {
    let share = (cues.len().max(1) as f64).ln();
    let strongest = cues.iter().map(|cue| cue.evidence).fold(0.0, f64::max);
    let weight = |cue: &HeightCue| {
        if cue.evidence >= BEYOND_DOUBT {
            strongest
        } else {
            cue.evidence
        }
    };
    let excess: Vec<f64> = cues
        .iter()
        .map(|cue| weight(cue) - cue.curve.best().1 - share)
        .collect();
    let log_likelihood = (0..grid.count)
        .map(|k| {
            let each = || {
                let terms = cues.iter().zip(&excess);
                terms.map(|(cue, excess)| cue.curve.log_likelihood[k] + excess)
            };
            let top = each().fold(0.0, f64::max);
            top + ((-top).exp() + each().map(|x| (x - top).exp()).sum::<f64>()).ln()
        })
        .collect();
    LikelihoodCurve {
        start_s: grid.start_s,
        step_s: grid.step_s,
        log_likelihood,
    }
}

#[derive(Clone, Copy)]
struct Fit<'a> {
    ridge: &'a Ridge,
    profile: &'a FlightProfile,
    grid: Grid,
}

/// A likelihood that excludes some offsets.
struct Rough {
    /// Log-likelihoods over `length`.
    curve: LikelihoodCurve,
    /// Number of picks that are equivalent to one independent pick.
    length: f64,
}

/// The residuals of the surface, and statistics of their correlation.
struct Surface {
    residual_s: Vec<f64>,
    envelope: Vec<f64>,
    /// Changes of the delay over [`RATE_STEP_S`].
    rate: Vec<f64>,
    /// Share of strays among the picks near these residuals in time.
    strays_about: f64,
    /// Number of picks over which residuals are correlated.
    lasting: f64,
    /// Variance of the estimate from few independent residuals, over that from many (Student).
    few: f64,
    /// Number of picks that are equivalent to one independent pick, from the residuals alone.
    own_length: f64,
    length: f64,
}

/// Error of the residuals and share of strays.
#[derive(Debug, Clone, Copy)]
struct Mixture {
    sigma_s: f64,
    stray_share: f64,
}

/// Time between the heights whose difference is the rate, s.
const RATE_STEP_S: f64 = 0.2;

/// Standard deviation of the offset Σ ṙe / Σ ṙ² (ṙ less its mean, from changes of the delay over
/// [`RATE_STEP_S`]) for errors e of the delay of unit standard deviation that last as long as the rate ṙ.
fn per_error(change_s: &[f64], few: f64) -> f64 {
    let mean_s = change_s.iter().sum::<f64>() / change_s.len().max(1) as f64;
    let rates = change_s.iter().map(|c| (c - mean_s) / RATE_STEP_S);
    let squares: f64 = rates.map(|r| r * r).sum();
    if squares > 0.0 {
        (correlation_length(change_s) * few / squares).sqrt()
    } else {
        0.0
    }
}

/// Time about a pick of the surface within which other picks are counted, s.
const ABOUT_S: f64 = 1.0;

/// Share of strays among the neighbours, within [`ABOUT_S`], of the surface's picks; 1 where the surface has no pick
/// with a neighbour.
fn strays_about(time_s: &[f64], is_surface: impl Fn(usize) -> bool) -> f64 {
    let (mut first, mut end, mut within, mut among) = (0, 0, 0, 0);
    let (mut others, mut strays) = (0, 0);
    for (k, t) in time_s.iter().enumerate() {
        while end < time_s.len() && time_s[end] <= t + ABOUT_S {
            among += usize::from(is_surface(end));
            end += 1;
            within += 1;
        }
        while time_s[first] < t - ABOUT_S {
            among -= usize::from(is_surface(first));
            first += 1;
            within -= 1;
        }
        if is_surface(k) {
            others += within - 1;
            strays += within - among;
        }
    }
    if others == 0 {
        1.0
    } else {
        strays as f64 / others as f64
    }
}

impl Fit<'_> {
    /// The cue with the error of the residuals re-estimated at the most likely offset, from an initial error.
    fn cue(
        &self,
        start: Mixture,
        rough: Option<Rough>,
        control: Control<'_>,
    ) -> Result<HeightCue, AlignError> {
        let mut mixture = start;
        let rough = match rough {
            Some(rough) => rough,
            None => self.rough(mixture, control)?,
        };
        let mut curve = self.curve(mixture, &rough, control)?;
        for _ in 0..REFITS {
            let peak = curve.peak();
            let residuals = self.residuals_s(curve.offset_s(peak));
            mixture = self.fitted(&residuals, self.grid.delay_s, mixture);
            curve = self.curve(mixture, &rough, control)?;
            if curve.peak() == peak {
                break;
            }
        }
        Ok(self.judged(curve, mixture))
    }

    /// Density of a stray, constant over twice the window of delays.
    fn stray_density(&self) -> f64 {
        let [from, to] = self.grid.delay_s;
        0.5 / (to - from)
    }

    fn residuals_s(&self, offset_s: f64) -> Vec<f64> {
        self.ridge
            .time_s
            .iter()
            .zip(&self.ridge.fast_time_s)
            .map(|(t, p)| p - self.profile.echo_delay_s(t + offset_s))
            .collect()
    }

    /// The likelihood from a sample of the picks.
    fn rough(&self, mixture: Mixture, control: Control<'_>) -> Result<Rough, AlignError> {
        let stride = self.ridge.time_s.len().div_ceil(SAMPLE).max(1);
        let sample = self.ridge.every(stride);
        let sampled = Fit {
            ridge: &sample,
            ..*self
        };
        let found = sampled.curve_where(|_| true, mixture, control)?;
        let mut curve = LikelihoodCurve {
            start_s: self.grid.start_s,
            step_s: self.grid.step_s,
            log_likelihood: found.into_iter().flatten().collect(),
        };
        let offset_s = curve.offset_s(curve.peak());
        let residuals = self.residuals_s(offset_s);
        let mixture = self.fitted(&residuals, self.grid.delay_s, mixture);
        let (_, delay_s) = self.log_likelihood(&residuals, self.grid.delay_s, mixture);
        let length = self
            .surface(&residuals, [offset_s, delay_s], mixture)
            .length;
        for l in &mut curve.log_likelihood {
            *l *= stride as f64 / length;
        }
        Ok(Rough { curve, length })
    }

    /// Log-likelihoods of the offsets that a rough likelihood does not exclude; the rough values for the
    /// other offsets.
    fn curve(
        &self,
        mixture: Mixture,
        rough: &Rough,
        control: Control<'_>,
    ) -> Result<LikelihoodCurve, AlignError> {
        let below = self.below_best_of(&rough.curve);
        let found = self.curve_where(|k| below[k] <= OUT_OF_QUESTION, mixture, control)?;
        let best = (found.iter().flatten().copied()).fold(f64::NEG_INFINITY, f64::max);
        let as_rough = |k: usize| best - rough.length * below[k];
        let log_likelihood = (found.into_iter().enumerate())
            .map(|(k, found)| found.unwrap_or_else(|| as_rough(k)))
            .collect();
        Ok(LikelihoodCurve {
            start_s: self.grid.start_s,
            step_s: self.grid.step_s,
            log_likelihood,
        })
    }

    /// Log-likelihoods of the offsets that are not excluded.
    fn curve_where(
        &self,
        is_in_question: impl Fn(usize) -> bool + Sync,
        mixture: Mixture,
        control: Control<'_>,
    ) -> Result<Vec<Option<f64>>, AlignError> {
        (0..self.grid.count)
            .into_par_iter()
            .map(|k| {
                if k % 64 == 0 {
                    control.check()?;
                }
                if !is_in_question(k) {
                    return Ok(None);
                }
                let offset_s = self.grid.start_s + k as f64 * self.grid.step_s;
                let residuals = self.residuals_s(offset_s);
                let found = self.log_likelihood(&residuals, self.grid.delay_s, mixture);
                Ok(Some(found.0))
            })
            .collect()
    }

    /// Depth of a likelihood below its best on both sides of each offset.
    fn below_best_of(&self, curve: &LikelihoodCurve) -> Vec<f64> {
        let log_likelihood = &curve.log_likelihood;
        let best = log_likelihood[curve.peak()];
        let at = |k: usize| log_likelihood[k.min(log_likelihood.len() - 1)];
        let below = |k: usize| {
            let before = (k as f64 * self.grid.step_s / curve.step_s) as usize;
            best - at(before).max(at(before + 1))
        };
        (0..self.grid.count).map(below).collect()
    }

    /// Log-likelihood of residuals at the delay at which most residuals agree, and this delay. Unknown
    /// residuals (no position) are strays.
    fn log_likelihood(
        &self,
        residuals: &[f64],
        delays_s: [f64; 2],
        mixture: Mixture,
    ) -> (f64, f64) {
        let mut delay_s = commonest_s(residuals, delays_s, mixture.sigma_s);
        let stray = mixture.stray_share * self.stray_density();
        let height = (1.0 - mixture.stray_share) / (mixture.sigma_s * std::f64::consts::TAU.sqrt());
        let density = |r: f64, d: f64| height * bell((r - d) / mixture.sigma_s);
        // Beyond the reach of the bell a residual is a stray. Each of two estimates of the delay is a mean of
        // the residuals within the reach of the previous estimate.
        let reach_s = 3.0 * BELL_REACH * mixture.sigma_s;
        let near: Vec<f64> = residuals
            .iter()
            .copied()
            .filter(|r| (r - delay_s).abs() <= reach_s)
            .collect();
        for _ in 0..2 {
            let (mut sum, mut weight) = (0.0, 0.0);
            for &r in &near {
                let surface = density(r, delay_s);
                let w = surface / (surface + stray);
                sum += w * r;
                weight += w;
            }
            if weight > 0.0 {
                delay_s = (sum / weight).clamp(delays_s[0], delays_s[1]);
            }
        }
        // Likelihood ratios to a stray, multiplied a few at a time before the logarithm.
        let over: f64 = near
            .chunks(8)
            .map(|few| {
                let ratio = |r: &f64| density(*r, delay_s) / stray + 1.0;
                few.iter().map(ratio).product::<f64>().ln()
            })
            .sum();
        let total = over + residuals.len() as f64 * stray.ln();
        (total, delay_s)
    }

    /// The mixture with error and share of strays re-estimated (expectation maximisation).
    fn fitted(&self, residuals: &[f64], delays_s: [f64; 2], mut mixture: Mixture) -> Mixture {
        for _ in 0..MOST_ITERATIONS {
            let (_, delay_s) = self.log_likelihood(residuals, delays_s, mixture);
            let (mut power, mut weight) = (0.0, 0.0);
            for r in residuals.iter().filter(|r| r.is_finite()) {
                let w = self.surface_weight(r - delay_s, mixture);
                power += w * (r - delay_s).powi(2);
                weight += w;
            }
            if weight < 3.0 {
                return mixture;
            }
            let before = mixture;
            mixture.sigma_s = (power / weight).sqrt().clamp(LEAST_S, MOST_S);
            mixture.stray_share = (1.0 - weight / residuals.len() as f64).clamp(0.01, 0.95);
            let is_near = |now: f64, before: f64| (now - before).abs() <= CONVERGED * before;
            if is_near(mixture.sigma_s, before.sigma_s)
                && is_near(mixture.stray_share, before.stray_share)
            {
                break;
            }
        }
        mixture
    }

    /// Probability that a residual belongs to the surface.
    fn surface_weight(&self, residual_s: f64, mixture: Mixture) -> f64 {
        let x = residual_s / mixture.sigma_s;
        let surface = (1.0 - mixture.stray_share) * bell(x)
            / (mixture.sigma_s * std::f64::consts::TAU.sqrt());
        surface / (surface + mixture.stray_share * self.stray_density())
    }

    /// The residuals of the surface at an offset and a delay (s).
    fn surface(
        &self,
        residuals: &[f64],
        [offset_s, delay_s]: [f64; 2],
        mixture: Mixture,
    ) -> Surface {
        let (mut residual_s, mut envelope, mut rate) = (Vec::new(), Vec::new(), Vec::new());
        let is_surface = |r: &f64| r.is_finite() && self.surface_weight(r - delay_s, mixture) > 0.5;
        let strays_about = strays_about(&self.ridge.time_s, |k| is_surface(&residuals[k]));
        let picks = self.ridge.time_s.iter().zip(&self.ridge.envelope);
        for ((t, level), r) in picks.zip(residuals) {
            if is_surface(r) {
                residual_s.push(*r);
                envelope.push(*level);
                let [before, after] = [-0.5, 0.5]
                    .map(|k| k * RATE_STEP_S)
                    .map(|dt| self.profile.echo_delay_s(t + offset_s + dt));
                rate.push(if (after - before).is_finite() {
                    after - before
                } else {
                    0.0
                });
            }
        }
        let lasting = correlation_length(&residual_s);
        let independent = residual_s.len() as f64 / spread_correlation_length(&residual_s);
        let independent = independent.max(1.0);
        let few = (independent / (independent - 3.0).max(0.5)).max(1.0);
        let slow = |error_s: f64| (error_s / mixture.sigma_s).powi(2) * correlation_length(&rate);
        // Errors that last longer than the rate are constant while the rate lasts: their duration is limited
        // to the rate's.
        let scatter =
            (lasting.min(correlation_length(&rate))).max(variance_inflation(&residual_s, &rate));
        let length_with = |error_s: f64| (scatter + slow(error_s)) * few;
        // Lasting errors of the heights do not prevent the identification of the surface, but widen the
        // offset.
        let own_length = length_with(LASTING_ERROR_S);
        let length = length_with(LASTING_ERROR_S.hypot(self.profile.lasting_error_s()));
        Surface {
            residual_s,
            envelope,
            rate,
            strays_about,
            lasting,
            few,
            own_length,
            length,
        }
    }

    /// Scales the curve by the correlation of the residuals at its peak, and summarises it.
    fn judged(&self, mut curve: LikelihoodCurve, mixture: Mixture) -> HeightCue {
        let (offset_s, _) = curve.best();
        let residuals = self.residuals_s(offset_s);
        let (top, delay_s) = self.log_likelihood(&residuals, self.grid.delay_s, mixture);
        let surface = self.surface(&residuals, [offset_s, delay_s], mixture);
        // An echo that ignores the height: the picks are compared with a constant.
        let ignorant = self.without_height();
        for l in &mut curve.log_likelihood {
            *l /= surface.length;
        }
        let count = surface.residual_s.len().max(1) as f64;
        HeightCue {
            offset_s,
            delay_s,
            delay_sigma_s: mixture.sigma_s * (surface.lasting / count).sqrt(),
            residual_s: mixture.sigma_s,
            stray_share: mixture.stray_share,
            strays_about: surface.strays_about,
            picks: self.ridge.time_s.len(),
            correlation_length: surface.length,
            stated_sigma_s: self.profile.stated_error_s() * per_error(&surface.rate, surface.few),
            evidence: (top - ignorant) / surface.own_length,
            preference: (top - ignorant) / surface.lasting,
            envelope: median(&surface.envelope).max(0.0),
            curve,
        }
    }

    /// Log-likelihood of the picks about a fitted constant, with fitted spread and share of strays.
    fn without_height(&self) -> f64 {
        let picks = &self.ridge.fast_time_s;
        let low = picks.iter().copied().fold(f64::INFINITY, f64::min);
        let high = picks.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut top = f64::NEG_INFINITY;
        for sigma_s in [0.05e-9, 0.2e-9, 0.8e-9] {
            let start = Mixture {
                sigma_s,
                stray_share: 0.2,
            };
            let mixture = self.fitted(picks, [low, high], start);
            top = top.max(self.log_likelihood(picks, [low, high], mixture).0);
        }
        top
    }
}

/// Standard deviations beyond which the bell is zero: there the bell is below 2·10⁻²² of its maximum, and
/// exponentials would take most of the search's time.
const BELL_REACH: f64 = 10.0;

/// exp(−x²/2), and zero beyond [`BELL_REACH`].
fn bell(x: f64) -> f64 {
    let square = x * x;
    if square > BELL_REACH * BELL_REACH {
        0.0
    } else {
        (-0.5 * square).exp()
    }
}

/// The delay about which most residuals lie, s.
fn commonest_s(residuals: &[f64], [from, to]: [f64; 2], sigma_s: f64) -> f64 {
    let cell = CELL_S.max(sigma_s);
    let cells = ((to - from) / cell).ceil().max(1.0) as usize;
    let mut counts = vec![0u32; cells + 2];
    for r in residuals {
        let x = (r - from) / cell;
        if x >= 0.0 && x < cells as f64 {
            counts[x as usize + 1] += 1;
        }
    }
    let best = (1..=cells)
        .max_by_key(|&i| counts[i - 1] + 2 * counts[i] + counts[i + 1])
        .unwrap_or(1);
    from + (best as f64 - 0.5) * cell
}

#[cfg(test)]
mod tests {
    use super::super::curve::LikelihoodCurve;
    use super::*;

    /// An echo at an offset (s): share of strays, share of strays about its picks, error (ns), evidence.
    fn cue(
        offset_s: f64,
        [stray_share, strays_about, residual_ns, evidence]: [f64; 4],
    ) -> HeightCue {
        let curve = LikelihoodCurve {
            start_s: offset_s,
            step_s: 0.01,
            log_likelihood: vec![0.0],
        };
        HeightCue {
            curve,
            offset_s,
            delay_s: 10e-9,
            delay_sigma_s: 1e-11,
            residual_s: 1e-9 * residual_ns,
            stray_share,
            strays_about,
            picks: 400,
            correlation_length: 10.0,
            stated_sigma_s: 0.0,
            evidence,
            preference: evidence,
            envelope: 100.0,
        }
    }

    #[test]
    fn an_echo_that_follows_the_height_outweighs_those_that_cross_it() {
        let offsets = |cues: &[HeightCue]| {
            let of = surfaces(cues.to_vec());
            of.iter().map(|cue| cue.offset_s).collect::<Vec<_>>()
        };
        let followed = cue(0.0, [0.45, 0.05, 0.05, 14.0]);
        let crossing = cue(-0.14, [0.81, 0.18, 0.05, 21.7]);
        let loose = cue(-0.17, [0.38, 0.12, 0.7, 22.5]);
        assert_eq!(offsets(&[crossing.clone(), followed.clone()]), [0.0]);
        assert_eq!(offsets(&[loose.clone(), followed]), [0.0]);
        // None is followed.
        assert_eq!(offsets(&[crossing, loose.clone()]), [-0.17]);
        // An echo that is followed in a part of the flight does not count where another is seen throughout it.
        let in_part = cue(0.0, [0.55, 0.05, 0.05, 14.0]);
        assert_eq!(offsets(&[in_part, loose]), [-0.17]);
    }

    #[test]
    fn strays_are_few_about_an_echo_that_is_followed_and_many_about_chance_picks() {
        let time_s: Vec<f64> = (0..600).map(|k| 0.1 * f64::from(k)).collect();
        // A quarter of the picks each: 15 s of the flight, or every fourth.
        let followed = strays_about(&time_s, |k| (200..350).contains(&k));
        let by_chance = strays_about(&time_s, |k| k % 4 == 0);
        assert!(followed < 0.05, "{followed}");
        assert!((0.7..0.85).contains(&by_chance), "{by_chance}");
        assert!((strays_about(&time_s, |k| k == 7) - 1.0).abs() < f64::EPSILON);
        assert!((strays_about(&time_s, |_| false) - 1.0).abs() < f64::EPSILON);
    }
}
