//! The motion cue: change of the radargram against the platform's speed.
//!
//! The logarithm of the change from trace to trace is taken to be normal about a level, with a
//! spread, that depend on the class of speed, from rest to fast. While the platform stands the
//! spread is small (noise alone), so one moving trace among standing ones is unlikely. An offset's
//! log-likelihood is what the classes explain, Σ nᵦ ln(σ/σᵦ), over the correlation length of what
//! they leave. Only starts and halts tell one offset from another, so a record without any says
//! nothing, and each is worth a limited amount.

use rayon::prelude::*;

use super::curve::LikelihoodCurve;
use super::height::Grid;
use super::noise::correlation_length;
use super::profile::AT_REST;
use super::{AlignError, FlightProfile};
use acerra_control::Control;

/// Upper ends of the classes of speed, as shares of the speed that is exceeded in one twentieth of
/// the time; the first class is at rest.
const CLASS_ENDS: [f64; 3] = [AT_REST, 0.4, 0.75];
const CLASSES: usize = CLASS_ENDS.len() + 1;
/// Traces' worth of the overall variance that every class is given: small classes prove nothing.
const PRIOR_TRACES: f64 = 3.0;
/// Offsets that far apart count as independent trials, each of which may fit by chance, s.
const INDEPENDENT_S: f64 = 0.5;
/// Log-likelihood that one start or halt is worth at most: what is in view changes the radargram,
/// too, and can look like a start.
const MOST_PER_TRANSITION: f64 = 8.0;

/// What the change from trace to trace says of the offset.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionCue {
    /// Log-likelihood of each offset.
    pub curve: LikelihoodCurve,
    /// Most likely offset by this cue alone, s.
    pub offset_s: f64,
    /// Share of the change's variance that the classes of speed explain there.
    pub explained: f64,
    /// Traces that are worth one independent one.
    pub correlation_length: f64,
    /// Starts and halts within the record, at that offset.
    pub transitions: usize,
    /// Log-likelihood over a change that ignores the speed, less the logarithm of the number of independent
    /// offsets that were tried.
    pub evidence: f64,
}

/// The likelihood of every offset by change and speed; none where the platform never moves, starts
/// or halts, the radargram never changes, or the change falls with the speed at every offset.
pub(super) fn motion_cue(
    (time_s, change): (&[f64], &[f64]),
    profile: &FlightProfile,
    grid: Grid,
    control: Control<'_>,
) -> Result<Option<MotionCue>, AlignError> {
    let Some(fit) = Fit::new(time_s, change, profile) else {
        return Ok(None);
    };
    let log_likelihood = (0..grid.count)
        .into_par_iter()
        .map(|k| {
            if k % 64 == 0 {
                control.check()?;
            }
            Ok(fit.log_likelihood(grid.start_s + k as f64 * grid.step_s))
        })
        .collect::<Result<Vec<f64>, AlignError>>()?;
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
    variance: f64,
    profile: &'a FlightProfile,
    class_ends_m_s: [f64; CLASS_ENDS.len()],
}

/// Level and spread of one class of speed.
#[derive(Clone, Copy, Default)]
struct Class {
    traces: f64,
    mean: f64,
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
        (variance > 0.0).then(|| Self {
            time_s,
            level,
            variance,
            profile,
            class_ends_m_s: CLASS_ENDS.map(|share| share * fast_m_s),
        })
    }

    /// Class of a trace's speed; none without a position.
    fn class(&self, time_s: f64) -> Option<usize> {
        let speed_m_s = self.profile.speed_at(time_s);
        speed_m_s
            .is_finite()
            .then(|| self.class_ends_m_s.partition_point(|end| *end < speed_m_s))
    }

    fn classes(&self, offset_s: f64) -> [Class; CLASSES] {
        let mut sums = [(0.0, 0.0, 0.0); CLASSES];
        for (t, l) in self.time_s.iter().zip(&self.level) {
            if let Some(c) = self.class(t + offset_s) {
                sums[c].0 += 1.0;
                sums[c].1 += l;
                sums[c].2 += l * l;
            }
        }
        sums.map(|(traces, sum, power)| {
            if traces == 0.0 {
                return Class::default();
            }
            let mean = sum / traces;
            let spread = (power - sum * mean).max(0.0);
            Class {
                traces,
                mean,
                variance: (spread + PRIOR_TRACES * self.variance) / (traces + PRIOR_TRACES),
            }
        })
    }

    /// What the classes explain; 0 where the change falls with the speed. Traces without a speed
    /// stay unexplained.
    fn log_likelihood(&self, offset_s: f64) -> f64 {
        let classes = self.classes(offset_s);
        let traces: f64 = classes.iter().map(|c| c.traces).sum();
        let weighted = |of: fn(usize, &Class) -> f64| {
            let terms = classes.iter().enumerate().map(|(i, c)| c.traces * of(i, c));
            terms.sum::<f64>() / traces.max(1.0)
        };
        let rank = weighted(|i, _| i as f64);
        let mean = weighted(|_, c| c.mean);
        let rises: f64 = classes
            .iter()
            .enumerate()
            .map(|(i, c)| c.traces * (i as f64 - rank) * (c.mean - mean))
            .sum();
        if rises <= 0.0 {
            return 0.0;
        }
        classes
            .iter()
            .filter(|c| c.traces > 0.0)
            .map(|c| 0.5 * c.traces * (self.variance / c.variance).ln())
            .sum::<f64>()
            .max(0.0)
    }

    /// What the classes leave, in standard deviations.
    fn residuals(&self, offset_s: f64) -> Vec<f64> {
        let classes = self.classes(offset_s);
        self.time_s
            .iter()
            .zip(&self.level)
            .filter_map(|(t, l)| {
                let class = classes[self.class(t + offset_s)?];
                Some((l - class.mean) / class.variance.sqrt())
            })
            .collect()
    }
}
