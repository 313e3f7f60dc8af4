//! Likelihood of the clock offset by the fast time of one echo against 2h/c of the trajectory.
//!
//! For an offset τ and a delay d each pick p(t) leaves a residual p(t) − 2h(t+τ)/c − d, which belongs to the
//! surface or to a stray (see [`mixture`](super::mixture)). The log-likelihood is divided by the correlation
//! length of the residuals, so that lasting errors (GNSS heights, drift) do not count as many independent ones.

use rayon::prelude::*;

use super::curve::LikelihoodCurve;
use super::echo::{APART_S, Ridge};
use super::height_cue::{Grid, HeightCue};
use super::mixture::{Agreement, Mixture, Scratch};
use super::noise::{Autocorrelation, correlation_length, variance_inflation};
use super::surface::RIVAL;
use super::{AlignError, FlightProfile};
use crate::quality::median;
use acerra_control::Control;

/// Largest number of re-estimates of the error at the most likely offset.
const REFITS: usize = 2;
/// Number of picks of a ridge from which excluded offsets are recognised: log-likelihoods of a sample scatter
/// by a few units about those of all picks.
const SAMPLE: usize = 500;
/// Log-likelihood below the best of the coarse grid from which an offset is not tried on the fine one: odds of
/// 10⁵ to 1. A sample of the picks with a wider error separates offsets less than all picks do.
const IN_QUESTION: f64 = 12.0;
/// Log-likelihood below others of an offset that is excluded: odds of 10⁹ to 1.
const OUT_OF_QUESTION: f64 = 20.0;
/// Standard deviation of errors of the height that last as long as changes of the height, s (1.5 mm): the
/// lever arm under tilt, and other errors that do not appear in a few independent residuals.
const LASTING_ERROR_S: f64 = 0.01e-9;
/// Spacing of the offsets at which a sample of the picks is compared, in steps of the grid.
const COARSE: usize = 4;

/// An echo whose delays are compared with the heights at every offset of a grid.
#[derive(Clone, Copy)]
pub(super) struct Fit<'a> {
    ridge: &'a Ridge,
    profile: &'a FlightProfile,
    grid: Grid,
    /// Model of the residuals.
    agreement: Agreement,
}

/// A likelihood that excludes some offsets.
struct Rough {
    /// Log-likelihood of each offset below the best, over `length`: with widened errors, which exclude offsets safely.
    below_wide: Vec<f64>,
    /// The same with the errors as they are: the values of excluded offsets.
    below: Vec<f64>,
    /// Number of picks that are equivalent to one independent pick.
    length: f64,
    /// The most likely offset, as an index of the grid, and the mixture at it.
    peak: usize,
    mixture: Mixture,
}

/// The residuals of the surface, and statistics of their correlation.
struct Surface {
    residual_s: Vec<f64>,
    envelope: Vec<f64>,
    /// Changes of the delay over [`RATE_STEP_S`], and their correlation length.
    rate: Vec<f64>,
    rate_length: f64,
    /// Number of picks over which residuals are correlated.
    lasting: f64,
    /// Number of picks over which belonging to the surface is correlated.
    run_length: f64,
    /// Variance of the estimate from few independent residuals, over that from many (Student).
    few: f64,
    /// Number of picks that are equivalent to one independent pick.
    length: f64,
}

/// Time between the heights whose difference is the rate, s.
const RATE_STEP_S: f64 = 0.2;

/// Standard deviation of the offset Σ ṙe / Σ ṙ² (ṙ less its mean, from changes of the delay over
/// [`RATE_STEP_S`]) for errors e of the delay of unit standard deviation that last as long as the rate ṙ.
fn per_error(change_s: &[f64], length: f64, few: f64) -> f64 {
    let mean_s = change_s.iter().sum::<f64>() / change_s.len().max(1) as f64;
    let rates = change_s.iter().map(|c| (c - mean_s) / RATE_STEP_S);
    let squares: f64 = rates.map(|r| r * r).sum();
    if squares > 0.0 {
        (length * few / squares).sqrt()
    } else {
        0.0
    }
}

/// Time for which an echo that has nothing to do with the height stays near the fast time that a changing height
/// gives, s.
const UNRELATED_S: f64 = 1.0;

impl<'a> Fit<'a> {
    /// A ridge that was followed without knowledge of the height: strays lie anywhere within twice the window of
    /// delays.
    pub fn new(ridge: &'a Ridge, profile: &'a FlightProfile, grid: Grid) -> Self {
        let [from_s, to_s] = grid.delay_s;
        Self::with_chance(ridge, profile, grid, 0.5 / (to_s - from_s))
    }

    /// A ridge of the strongest echoes within [`APART_S`] of the fast times that a cue gives.
    pub const fn about(ridge: &'a Ridge, profile: &'a FlightProfile, grid: Grid) -> Self {
        Self::with_chance(ridge, profile, grid, 0.5 / APART_S)
    }

    const fn with_chance(
        ridge: &'a Ridge,
        profile: &'a FlightProfile,
        grid: Grid,
        chance: f64,
    ) -> Self {
        Self {
            ridge,
            profile,
            grid,
            agreement: Agreement {
                chance,
                delay_s: grid.delay_s,
            },
        }
    }

    /// Log-likelihood of the picks at an offset over picks by chance, as if all were independent.
    pub fn over_chance_at(&self, offset_s: f64, start: Mixture) -> f64 {
        let residuals = self.residuals_s(offset_s);
        let mixture = self.agreement.fitted(&residuals, start);
        self.over_chance(self.agreement.at_commonest(&residuals, mixture).0)
    }

    /// Mean number of picks within a time, 1 at least.
    fn picks_within(&self, duration_s: f64) -> f64 {
        let time_s = &self.ridge.time_s;
        let ends = time_s.first().zip(time_s.last());
        let whole_s = ends.map_or(0.0, |(first, last)| last - first);
        (time_s.len() as f64 * duration_s / whole_s.max(duration_s)).max(1.0)
    }

    fn over_chance(&self, log_likelihood: f64) -> f64 {
        log_likelihood - self.ridge.time_s.len() as f64 * self.agreement.chance.ln()
    }

    /// The cue with the error of the residuals re-estimated at the most likely offset, from an initial error.
    pub fn cue(&self, start: Mixture, control: Control<'_>) -> Result<HeightCue, AlignError> {
        let rough = self.rough(start, control)?;
        let (mut peak, mut mixture) = (rough.peak, rough.mixture);
        let mut curve = self.curve(mixture, &rough, control)?;
        for _ in 0..REFITS {
            if curve.peak() == peak {
                break;
            }
            (peak, mixture) = self.settled(curve.peak(), mixture);
            curve = self.curve(mixture, &rough, control)?;
        }
        Ok(self.judged(curve, mixture))
    }

    /// The most likely offset of the grid near a given one, and the mixture re-estimated at it.
    fn settled(&self, mut peak: usize, mut mixture: Mixture) -> (usize, Mixture) {
        let scratch = &mut Scratch::default();
        for pass in 0..=REFITS {
            let mut likelihood = |k: usize| {
                let residuals = self.each_residual_s(self.grid.offset_s(k));
                self.agreement.log_likelihood(residuals, mixture, scratch).0
            };
            let near = peak.saturating_sub(COARSE)..(peak + COARSE + 1).min(self.grid.count);
            let likely = near.map(|k| (k, likelihood(k)));
            let best = likely.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(k, _)| k);
            if best == Some(peak) && pass > 0 {
                break;
            }
            peak = best.unwrap_or(peak);
            let residuals = self.residuals_s(self.grid.offset_s(peak));
            mixture = self.agreement.fitted(&residuals, mixture);
        }
        (peak, mixture)
    }

    fn residuals_s(&self, offset_s: f64) -> Vec<f64> {
        self.each_residual_s(offset_s).collect()
    }

    fn each_residual_s(&self, offset_s: f64) -> impl Iterator<Item = f64> {
        let picks = self.ridge.time_s.iter().zip(&self.ridge.fast_time_s);
        picks.map(move |(t, p)| p - self.profile.echo_delay_s(t + offset_s))
    }

    /// The likelihoods from a sample of the picks on a coarse grid of offsets: with the error of the residuals widened
    /// by their change within the grid's spacing, which excludes offsets, and as it is, which gives their values.
    fn rough(&self, start: Mixture, control: Control<'_>) -> Result<Rough, AlignError> {
        let stride = self.ridge.time_s.len().div_ceil(SAMPLE).max(1);
        let sample = self.ridge.every(stride);
        let sampled = Fit {
            ridge: &sample,
            grid: self.grid.every(COARSE),
            ..*self
        };
        let change_s = 0.5 * sampled.grid.step_s * self.profile.fast_echo_rate();
        let widened = Mixture {
            sigma_s: start.sigma_s.hypot(change_s),
            ..start
        };
        let [wide, narrow] =
            [widened, start].map(|mixture| sampled.curve_where(|_| true, mixture, control));
        let [wide, narrow] =
            [wide?, narrow?].map(|l| l.into_iter().flatten().collect::<Vec<f64>>());
        let widest = |a: &usize, b: &usize| wide[*a].total_cmp(&wide[*b]);
        let peak = (0..wide.len()).max_by(widest).unwrap_or(0) * COARSE;
        let (peak, mixture) = self.settled(peak.min(self.grid.count - 1), start);
        let offset_s = self.grid.offset_s(peak);
        let residuals = self.residuals_s(offset_s);
        let (_, delay_s) = self.agreement.at_commonest(&residuals, mixture);
        let length = self
            .surface(&residuals, [offset_s, delay_s], mixture)
            .length;
        let at_peak = sampled
            .agreement
            .at_commonest(&sampled.residuals_s(offset_s), start);
        let scale = stride as f64 / length;
        Ok(Rough {
            below_wide: self.below(&wide, f64::NEG_INFINITY, scale),
            below: self.below(&narrow, at_peak.0, scale),
            length,
            peak,
            mixture,
        })
    }

    /// Depth of log-likelihoods on the coarse grid below their best, at each offset the smaller one of both sides.
    fn below(&self, coarse: &[f64], least_best: f64, scale: f64) -> Vec<f64> {
        let best = coarse.iter().copied().fold(least_best, f64::max);
        let at = |k: usize| coarse[k.min(coarse.len() - 1)];
        let below = |k: usize| scale * (best - at(k / COARSE).max(at(k / COARSE + 1)));
        (0..self.grid.count).map(below).collect()
    }

    /// Log-likelihoods of the offsets that a rough likelihood does not exclude; the rough values for the
    /// other offsets.
    fn curve(
        &self,
        mixture: Mixture,
        rough: &Rough,
        control: Control<'_>,
    ) -> Result<LikelihoodCurve, AlignError> {
        let is_in_question = |k: usize| rough.below_wide[k] <= IN_QUESTION;
        let found = self.curve_where(is_in_question, mixture, control)?;
        let best = (found.iter().flatten().copied()).fold(f64::NEG_INFINITY, f64::max);
        let as_rough = |k: usize| best - rough.length * rough.below[k].max(IN_QUESTION);
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
            .map_init(Scratch::default, |scratch, k| {
                if k % 64 == 0 {
                    control.check()?;
                }
                if !is_in_question(k) {
                    return Ok(None);
                }
                let residuals = self.each_residual_s(self.grid.offset_s(k));
                let found = self.agreement.log_likelihood(residuals, mixture, scratch);
                Ok(Some(found.0))
            })
            .collect()
    }

    /// The residuals of the surface at an offset and a delay (s).
    fn surface(
        &self,
        residuals: &[f64],
        [offset_s, delay_s]: [f64; 2],
        mixture: Mixture,
    ) -> Surface {
        let (mut residual_s, mut envelope, mut rate) = (Vec::new(), Vec::new(), Vec::new());
        let is_surface =
            |r: &f64| r.is_finite() && self.agreement.surface_weight(r - delay_s, mixture) > 0.5;
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
        let membership: Vec<f64> = residuals.iter().map(|r| f64::from(is_surface(r))).collect();
        let of_residual = Autocorrelation::of(&residual_s);
        let (lasting, rate_length) = (of_residual.length(), correlation_length(&rate));
        let independent = (residual_s.len() as f64 / of_residual.spread_length()).max(1.0);
        let few = (independent / (independent - 3.0).max(0.5)).max(1.0);
        let slow = |error_s: f64| (error_s / mixture.sigma_s).powi(2) * rate_length;
        // Errors that last longer than the rate are constant while the rate lasts: their duration is limited
        // to the rate's.
        let inflation = variance_inflation(&residual_s, rate_length);
        let scatter = lasting.min(rate_length).max(inflation);
        let error_s = LASTING_ERROR_S.hypot(self.profile.lasting_error_s());
        let length = (scatter + slow(error_s)) * few;
        Surface {
            residual_s,
            envelope,
            rate,
            rate_length,
            lasting,
            run_length: correlation_length(&membership),
            few,
            length,
        }
    }

    /// Scales the curve by the correlation of the residuals at its peak, and summarises it.
    fn judged(&self, mut curve: LikelihoodCurve, mixture: Mixture) -> HeightCue {
        let (offset_s, _) = curve.best();
        let residuals = self.residuals_s(offset_s);
        let (top, delay_s) = self.agreement.at_commonest(&residuals, mixture);
        let surface = self.surface(&residuals, [offset_s, delay_s], mixture);
        // An echo that ignores the height: the picks are compared with a constant.
        let ignorant = self.without_height();
        let explained = (top - ignorant).min(self.over_chance(top));
        // Lasting errors of the heights shift the residuals by their size, but turn few picks of the surface into strays:
        // an offset at which most picks are strays is excluded, however long errors last.
        let least = RIVAL * self.over_chance(top);
        for l in &mut curve.log_likelihood {
            let is_lost = self.over_chance(*l) < least;
            *l /= surface.length;
            if is_lost {
                *l -= OUT_OF_QUESTION;
            }
        }
        let count = surface.residual_s.len().max(1) as f64;
        HeightCue {
            offset_s,
            delay_s,
            delay_sigma_s: mixture.sigma_s * (surface.lasting / count).sqrt(),
            residual_s: mixture.sigma_s,
            stray_share: mixture.stray_share,
            picks: self.ridge.time_s.len(),
            correlation_length: surface.length,
            stated_sigma_s: self.profile.stated_error_s()
                * per_error(&surface.rate, surface.rate_length, surface.few),
            // While an unrelated echo stays near the expected fast time, its picks are not independent.
            evidence: explained
                / (surface.lasting.max(surface.run_length)).min(self.picks_within(UNRELATED_S)),
            preference: (top - ignorant) / surface.lasting,
            explained,
            envelope: median(&surface.envelope).max(0.0),
            curve,
        }
    }

    /// Log-likelihood of the picks about a fitted constant, with fitted spread and share of strays.
    fn without_height(&self) -> f64 {
        let picks = &self.ridge.fast_time_s;
        let low = picks.iter().copied().fold(f64::INFINITY, f64::min);
        let high = picks.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let anywhere = Agreement {
            delay_s: [low, high],
            ..self.agreement
        };
        let mut top = f64::NEG_INFINITY;
        for sigma_s in [0.05e-9, 0.2e-9, 0.8e-9] {
            let start = Mixture {
                sigma_s,
                stray_share: 0.2,
            };
            let mixture = anywhere.fitted(picks, start);
            top = top.max(anywhere.at_commonest(picks, mixture).0);
        }
        top
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test that cannot go on has failed
mod tests {
    use super::super::FlightState;
    use super::super::profile::STEP_S;
    use super::*;

    #[test]
    fn an_echo_near_the_expected_fast_time_for_one_stretch_is_little_evidence() {
        let state = |t: f64| {
            Some(FlightState {
                height_m: 5.0 + 2.0 * (0.5 * t).sin(),
                speed_m_s: 1.0,
            })
        };
        let profile = FlightProfile::sample([0.0, 80.0], state).unwrap();
        let grid = Grid {
            start_s: -5.0,
            step_s: STEP_S,
            count: 500,
            delay_s: [-1e-9, 20e-9],
        };
        let start = Mixture {
            sigma_s: 0.2e-9,
            stray_share: 0.2,
        };
        let evidence = |agrees: &dyn Fn(usize) -> bool| {
            let mut state = 3_u64;
            let mut uniform = move || {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
            };
            let mut ridge = Ridge::default();
            for k in 0..800 {
                let t = 10.0 + 0.07 * k as f64;
                let off_s = if agrees(k) { 0.05e-9 } else { 2.0 * APART_S } * uniform();
                ridge.time_s.push(t);
                let fast_time_s = profile.echo_delay_s(t) + 10e-9 + off_s;
                ridge.fast_time_s.push(fast_time_s);
                ridge.envelope.push(1.0);
            }
            let cue = Fit::about(&ridge, &profile, grid).cue(start, Control::default());
            let cue = cue.unwrap();
            assert!((cue.stray_share - 0.75).abs() < 0.1, "{cue:?}");
            cue.evidence
        };
        // A quarter of the picks: every fourth, or those of 14 s.
        let (spread, stretch) = (evidence(&|k| k % 4 == 0), evidence(&|k| k / 200 == 1));
        assert!(
            spread > 100.0 && stretch < 0.2 * spread,
            "{spread} {stretch}"
        );
    }
}
