//! The motion cue: change of the radargram compared with the platform's speed.
//!
//! The logarithm of the change from trace to trace is modelled as normal, with a level and a spread that
//! depend on the class of speed, from rest to fast; or as a stray, distributed as all traces are: close to
//! the ground a slow platform can change the radargram much. At rest the spread is small (noise alone), so
//! that many moving traces among traces at rest are unlikely. An offset's log-likelihood is the gain by the
//! classes over one class for all, over the correlation length of the residuals. Only starts and halts
//! distinguish offsets, so that a record without them gives no likelihood, and the contribution of each is
//! limited.

use rayon::prelude::*;

use super::curve::LikelihoodCurve;
use super::height_cue::Grid;
use super::noise::correlation_length;
use super::profile::AT_REST;
use super::{AlignError, FlightProfile};
use crate::quality::{median_of_sorted, robust_deviation_of_sorted};
use acerra_control::Control;

/// Upper ends of the classes of speed, as shares of the speed that is exceeded in one twentieth of
/// the time; the first class is at rest.
const CLASS_ENDS: [f64; 3] = [AT_REST, 0.4, 0.75];
const CLASSES: usize = CLASS_ENDS.len() + 1;
/// Number of traces with the overall variance added to every class, so that small classes have little weight.
const PRIOR_TRACES: f64 = 3.0;
/// Share of the traces whose change does not follow their class.
const STRAY_SHARE: f64 = 0.2;
/// Standard deviations at which residuals are clipped.
const CLIPPED: f64 = 3.0;
/// Distance at which offsets count as independent trials, each of which may fit by chance, s.
const INDEPENDENT_S: f64 = 0.5;
/// Largest log-likelihood by one start or halt: changes of the scenery in view change the radargram too, and
/// can resemble a start.
const MOST_PER_TRANSITION: f64 = 8.0;

/// Spacing of the coarse grid of offsets, in steps of the fine one: closer than traces are to one another.
const COARSE: usize = 4;
/// Share of the largest log-likelihood by which an offset of the coarse grid may be below it without being
/// excluded.
const IN_QUESTION: f64 = 0.4;
/// Largest likelihood ratio of a trace, so that the product of four is finite.
const LARGEST_RATIO: f64 = 1e70;

/// Likelihood of the offset by the change from trace to trace.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionCue {
    /// Log-likelihood of each offset.
    pub curve: LikelihoodCurve,
    /// Most likely offset by this cue alone, s.
    pub offset_s: f64,
    /// Share of the change's variance explained by the classes of speed at this offset.
    pub explained: f64,
    /// Number of traces that are equivalent to one independent trace.
    pub correlation_length: f64,
    /// Number of starts and halts within the record at this offset.
    pub transitions: usize,
    /// Log-likelihood over a change that ignores the speed, less the logarithm of the number of independent
    /// offsets that were tried.
    pub evidence: f64,
}

/// The likelihood of every offset by change and speed; `None` where the platform never moves, starts or
/// halts, the radargram never changes, or the change falls with the speed at every offset.
pub(super) fn motion_cue(
    (time_s, change): (&[f64], &[f64]),
    profile: &FlightProfile,
    grid: Grid,
    control: Control<'_>,
) -> Result<Option<MotionCue>, AlignError> {
    let Some(fit) = Fit::new(time_s, change, profile) else {
        return Ok(None);
    };
    let log_likelihood = fit.over(grid, control)?;
    let mut curve = LikelihoodCurve {
        start_s: grid.start_s,
        step_s: grid.step_s,
        log_likelihood,
    };
    let (offset_s, best) = curve.best();
    let transitions = profile.starts_and_halts(time_s.iter().map(|t| t + offset_s));
    if best <= 0.0 || transitions == 0 {
        return Ok(None);
    }
    let length = correlation_length(&fit.residuals(offset_s));
    let most = (best / length).min(MOST_PER_TRANSITION * transitions as f64);
    let scale = most / best;
    // Any start or halt of the flight may fit a change by chance.
    let evidence = most
        - (grid.count as f64 * grid.step_s / INDEPENDENT_S)
            .max(1.0)
            .ln();
    curve.log_likelihood.iter_mut().for_each(|l| *l *= scale);
    Ok(Some(MotionCue {
        offset_s,
        explained: 1.0 - (-2.0 * best / time_s.len() as f64).exp(),
        correlation_length: length,
        transitions,
        evidence,
        curve,
    }))
}

struct Fit<'a> {
    time_s: &'a [f64],
    /// Logarithm of the change, less its mean.
    level: Vec<f64>,
    /// Traces by rising level, so that every class's levels rise as they are collected.
    by_level: Vec<usize>,
    variance: f64,
    /// Density of each level where all traces are one class.
    stray_density: Vec<f64>,
    profile: &'a FlightProfile,
    class_ends_m_s: [f64; CLASS_ENDS.len()],
}

/// Level and spread of one class of speed, by medians.
#[derive(Clone, Copy, Default)]
struct Class {
    traces: f64,
    middle: f64,
    variance: f64,
}

impl<'a> Fit<'a> {
    fn new(time_s: &'a [f64], change: &[f64], profile: &'a FlightProfile) -> Option<Self> {
        let fast_m_s = profile.fast_speed_m_s()?;
        let largest = change.iter().copied().fold(0.0, f64::max);
        if fast_m_s <= 0.0 || largest <= 0.0 {
            return None;
        }
        let logs: Vec<f64> = change.iter().map(|c| c.max(1e-6 * largest).ln()).collect();
        let n = logs.len() as f64;
        let mean = logs.iter().sum::<f64>() / n;
        let level: Vec<f64> = logs.iter().map(|l| l - mean).collect();
        let variance = level.iter().map(|l| l * l).sum::<f64>() / n;
        let mut by_level: Vec<usize> = (0..level.len()).collect();
        by_level.sort_by(|a, b| level[*a].total_cmp(&level[*b]));
        (variance > 0.0).then(|| Self {
            time_s,
            by_level,
            stray_density: level.iter().map(|l| normal(*l, variance)).collect(),
            level,
            variance,
            profile,
            class_ends_m_s: CLASS_ENDS.map(|share| share * fast_m_s),
        })
    }

    /// Class of a trace's speed; `None` without a position.
    fn class(&self, time_s: f64) -> Option<usize> {
        let speed_m_s = self.profile.speed_at(time_s);
        speed_m_s
            .is_finite()
            .then(|| self.class_ends_m_s.partition_point(|end| *end < speed_m_s))
    }

    /// Class of every trace at an offset; `None` without a position.
    fn class_of_traces(&self, offset_s: f64) -> Vec<Option<usize>> {
        self.time_s
            .iter()
            .map(|t| self.class(t + offset_s))
            .collect()
    }

    fn classes(&self, class_of: &[Option<usize>]) -> [Class; CLASSES] {
        let mut levels: [Vec<f64>; CLASSES] = std::array::from_fn(|_| Vec::new());
        for &trace in &self.by_level {
            if let Some(c) = class_of[trace] {
                levels[c].push(self.level[trace]);
            }
        }
        levels.map(|levels| {
            if levels.is_empty() {
                return Class::default();
            }
            let traces = levels.len() as f64;
            let spread = robust_deviation_of_sorted(&levels).powi(2);
            Class {
                traces,
                middle: median_of_sorted(&levels),
                variance: (traces * spread + PRIOR_TRACES * self.variance)
                    / (traces + PRIOR_TRACES),
            }
        })
    }

    /// Explained change at every offset; where a coarse grid excludes the offset, interpolated linearly
    /// between the grid's values.
    fn over(&self, grid: Grid, control: Control<'_>) -> Result<Vec<f64>, AlignError> {
        let at = |offsets: Vec<usize>| {
            let each = offsets.into_par_iter().map(|k| {
                if k % 64 == 0 {
                    control.check()?;
                }
                Ok(self.log_likelihood(grid.start_s + k as f64 * grid.step_s))
            });
            each.collect::<Result<Vec<f64>, AlignError>>()
        };
        let coarse: Vec<usize> = (0..grid.count + COARSE - 1).step_by(COARSE).collect();
        let of_coarse = at(coarse)?;
        let best = of_coarse.iter().copied().fold(0.0, f64::max);
        let between = |k: usize| {
            let before = of_coarse[k / COARSE];
            let after = *of_coarse.get(k / COARSE + 1).unwrap_or(&before);
            before + (after - before) * (k % COARSE) as f64 / COARSE as f64
        };
        let is_open =
            |k: &usize| !k.is_multiple_of(COARSE) && between(*k) >= (1.0 - IN_QUESTION) * best;
        let open: Vec<usize> = (0..grid.count).filter(is_open).collect();
        let of_open = at(open.clone())?;
        let mut all: Vec<f64> = (0..grid.count).map(between).collect();
        for (k, value) in open.into_iter().zip(of_open) {
            all[k] = value;
        }
        Ok(all)
    }

    /// Explained change; 0 where the change falls with the speed. Traces without a speed stay unexplained.
    fn log_likelihood(&self, offset_s: f64) -> f64 {
        let class_of = self.class_of_traces(offset_s);
        let classes = self.classes(&class_of);
        let traces: f64 = classes.iter().map(|c| c.traces).sum();
        let weighted = |of: fn(usize, &Class) -> f64| {
            let terms = classes.iter().enumerate().map(|(i, c)| c.traces * of(i, c));
            terms.sum::<f64>() / traces.max(1.0)
        };
        let rank = weighted(|i, _| i as f64);
        let mean = weighted(|_, c| c.middle);
        let rises: f64 = classes
            .iter()
            .enumerate()
            .map(|(i, c)| c.traces * (i as f64 - rank) * (c.middle - mean))
            .sum();
        if rises <= 0.0 {
            return 0.0;
        }
        let over_stray = |trace: usize| {
            let class = classes[class_of[trace]?];
            let density = normal(self.level[trace] - class.middle, class.variance);
            let ratio = density / self.stray_density[trace].max(f64::MIN_POSITIVE);
            Some(STRAY_SHARE + (1.0 - STRAY_SHARE) * ratio.min(LARGEST_RATIO))
        };
        let ratios: Vec<f64> = (0..self.level.len()).filter_map(over_stray).collect();
        // Multiplied a few at a time before the logarithm: no factor is below the share of strays.
        let sum: f64 = ratios
            .chunks(4)
            .map(|few| few.iter().product::<f64>().ln())
            .sum();
        sum.max(0.0)
    }

    /// Residuals of the classes, in standard deviations, [clipped](CLIPPED) for strays.
    fn residuals(&self, offset_s: f64) -> Vec<f64> {
        let class_of = self.class_of_traces(offset_s);
        let classes = self.classes(&class_of);
        (class_of.iter().zip(&self.level))
            .filter_map(|(class, l)| {
                let class = classes[(*class)?];
                let residual = (l - class.middle) / class.variance.sqrt();
                Some(residual.clamp(-CLIPPED, CLIPPED))
            })
            .collect()
    }
}

/// Normal density about zero, without its constant.
fn normal(x: f64, variance: f64) -> f64 {
    (-0.5 * x * x / variance).exp() / variance.sqrt()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test that cannot go on has failed
mod tests {
    use super::super::FlightState;
    use super::*;

    /// At rest until 20 s, climbs, hovers from 26 to 30 s, flies until 48 s, hovers, descends, at rest from
    /// 58 s to 76 s.
    fn speed_m_s(t: f64) -> f64 {
        match t {
            t if (20.0..26.0).contains(&t) || (52.0..58.0).contains(&t) => 2.0,
            t if (30.0..48.0).contains(&t) => 1.5,
            t if (26.0..52.0).contains(&t) => 0.1,
            _ => 0.02,
        }
    }

    #[test]
    fn a_start_close_to_the_ground_and_unknown_speeds_do_not_mislead() {
        // No positions until 17 s. The craft moves slowly for half a second before it climbs, close to ground that echoes
        // most.
        let state = |t: f64| {
            (t > 17.0).then(|| FlightState {
                height_m: 5.0,
                speed_m_s: speed_m_s(t),
            })
        };
        let profile = FlightProfile::sample([0.0, 76.0], state).unwrap();
        let time_s: Vec<f64> = (0..1500).map(|k| 0.05 * f64::from(k)).collect();
        let noise = |k: usize| (12.9898 * k as f64 * k as f64).sin();
        let change: Vec<f64> = time_s
            .iter()
            .enumerate()
            .map(|(k, t)| {
                let near_ground = (19.5..21.0).contains(t) || (57.0..58.5).contains(t);
                let moves = if near_ground {
                    2.0
                } else {
                    0.4 * (speed_m_s(*t) - 0.05).max(0.0)
                };
                (moves + 0.02 * noise(k)).exp()
            })
            .collect();
        let grid = Grid {
            start_s: -37.0,
            step_s: 0.02,
            count: 3700,
            delay_s: [-1e-9, 20e-9],
        };
        let change = (time_s.as_slice(), change.as_slice());
        let found = motion_cue(change, &profile, grid, Control::default());
        let found = found.unwrap().unwrap();
        assert!(found.offset_s.abs() < 0.3, "{}", found.offset_s);
        // Likely offsets have their own value, and linear interpolation of the coarse grid makes no other
        // offset likely.
        let fit = Fit::new(change.0, change.1, &profile).unwrap();
        let over = fit.over(grid, Control::default()).unwrap();
        let likely = 0.7 * over.iter().copied().fold(0.0, f64::max);
        for (k, value) in over.iter().enumerate() {
            let own = fit.log_likelihood(grid.start_s + k as f64 * grid.step_s);
            let is_same = (value - own).abs() < 1e-9;
            assert!(own.max(*value) < likely || is_same, "{k}: {value} {own}");
        }
        // Any other offset is excluded.
        let far = (0..grid.count)
            .filter(|k| found.curve.offset_s(*k).abs() > 4.0)
            .map(|k| found.curve.log_likelihood[k]);
        let below = found.curve.best().1 - far.fold(f64::NEG_INFINITY, f64::max);
        assert!(
            below > 10.0 && found.explained > 0.8,
            "{below} {}",
            found.explained
        );
    }
}
