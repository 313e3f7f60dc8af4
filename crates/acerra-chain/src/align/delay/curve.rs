//! The log-likelihood over the delays tried, and the decision for one delay.

use super::error::DelayError;

/// Log-likelihood over delays.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DelayCurve {
    /// Delays (s), rising.
    pub delay_s: Vec<f64>,
    /// Log-likelihoods, 0 at best.
    pub log_likelihood: Vec<f64>,
}

/// Log-likelihood by which the best delay must surpass every other (odds of 400 to 1).
pub(super) const MARGIN: f64 = 6.0;
/// Largest accepted standard deviation of a delay (s): 8.7 cm of range, the resolution of a band of 1.7 GHz.
pub(super) const MOST_SIGMA_S: f64 = 0.58e-9;
/// Widest interval of delays within the margin that counts as one (s): a normal log-likelihood of that
/// deviation falls by the margin within √(2 MARGIN) deviations to each side.
const WIDEST_S: f64 = 6.93 * MOST_SIGMA_S;

pub(super) fn max_of(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

/// The best delay of a curve: mean and standard deviation of the delays within the margin, weighted by their
/// likelihoods.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Decided {
    pub index: usize,
    pub delay_s: f64,
    pub sigma_s: f64,
}

/// The single interval of delays that agrees with the data, or the reason for which there is none.
pub(super) fn decide(curve: &DelayCurve) -> Result<Decided, DelayError> {
    let log = &curve.log_likelihood;
    let best = best_of(log).unwrap_or_default();
    let ns = |k: usize| 1e9 * curve.delay_s[k];
    let stretch = stretch_about(log, best);
    let (first, last) = (stretch.start, stretch.end - 1);
    if ns(last) - ns(first) > 1e9 * WIDEST_S {
        return Err(DelayError::Vague {
            from_ns: ns(first),
            to_ns: ns(last),
        });
    }
    let rival = outside(log, &stretch);
    if let Some((k, below)) = rival
        && below < MARGIN
    {
        return Err(DelayError::Ambiguous {
            first_ns: ns(best),
            second_ns: ns(k),
            margin: below,
            needed: MARGIN,
        });
    }
    if best == 0 || best + 1 == log.len() {
        return Err(DelayError::AtEnd {
            at_ns: ns(best),
            from_ns: ns(0),
            to_ns: ns(log.len() - 1),
        });
    }
    let likelihood = |k: &usize| log[*k].exp();
    let total: f64 = stretch.clone().map(|k| likelihood(&k)).sum();
    let mean = |of: &dyn Fn(usize) -> f64| {
        stretch.clone().map(|k| likelihood(&k) * of(k)).sum::<f64>() / total
    };
    let delay_s = mean(&|k| curve.delay_s[k]);
    let variance_s2 = mean(&|k| (curve.delay_s[k] - delay_s).powi(2));
    // A delay between two of those tried is uniform over their spacing.
    let spacing_s = step_s(curve) / 12f64.sqrt();
    Ok(Decided {
        index: best,
        delay_s,
        sigma_s: variance_s2.sqrt().hypot(spacing_s),
    })
}

/// Spacing of the delays (s).
fn step_s(curve: &DelayCurve) -> f64 {
    match curve.delay_s.as_slice() {
        [first, second, ..] => second - first,
        _ => 0.0,
    }
}

/// The points about the best point that are within the margin.
fn stretch_about(log: &[f64], best: usize) -> std::ops::Range<usize> {
    let least = log[best] - MARGIN;
    let start = (0..best).rev().take_while(|k| log[*k] >= least).last();
    let end = (best..log.len()).take_while(|k| log[*k] >= least).last();
    start.unwrap_or(best)..end.unwrap_or(best) + 1
}

/// The best point outside an interval, and how far below the global maximum it is.
fn outside(log: &[f64], stretch: &std::ops::Range<usize>) -> Option<(usize, f64)> {
    (0..log.len())
        .filter(|k| !stretch.contains(k))
        .max_by(|a, b| log[*a].total_cmp(&log[*b]))
        .map(|k| (k, max_of(log) - log[k]))
}

/// The most likely other maximum (s), and how far below the best it is.
pub(super) fn second_best(curve: &DelayCurve, best: usize) -> Option<(f64, f64)> {
    let log = &curve.log_likelihood;
    let stretch = stretch_about(log, best);
    let is_maximum = |k: &usize| {
        let (before, after) = (k.checked_sub(1), k + 1);
        before.is_none_or(|b| log[b] <= log[*k]) && log.get(after).is_none_or(|a| *a <= log[*k])
    };
    (0..log.len())
        .filter(|k| !stretch.contains(k))
        .filter(is_maximum)
        .max_by(|a, b| log[*a].total_cmp(&log[*b]))
        .map(|k| (curve.delay_s[k], log[best] - log[k]))
}

pub(super) fn best_of(log: &[f64]) -> Option<usize> {
    (0..log.len()).max_by(|a, b| log[*a].total_cmp(&log[*b]))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A log-likelihood with normal maxima (delay in ns, deviation in ns, depth).
    pub(in super::super) fn curve(maxima: &[[f64; 3]]) -> DelayCurve {
        let delay_s: Vec<f64> = (0..141).map(|k| -1e-9 + f64::from(k) * 0.15e-9).collect();
        let value = |d: &f64| {
            let each = maxima
                .iter()
                .map(|[at, sigma, below]| -0.5 * ((d * 1e9 - at) / sigma).powi(2) - below);
            each.fold(f64::NEG_INFINITY, f64::max)
        };
        let log_likelihood: Vec<f64> = delay_s.iter().map(value).collect();
        let best = max_of(&log_likelihood);
        DelayCurve {
            log_likelihood: log_likelihood.iter().map(|v| v - best).collect(),
            delay_s,
        }
    }

    #[test]
    fn one_maximum_is_taken_with_its_deviation() {
        let decided = decide(&curve(&[[10.0, 0.2, 0.0], [14.0, 0.2, 9.0]])).unwrap();
        assert!((decided.sigma_s - 0.2e-9).abs() < 0.05e-9, "{decided:?}");
    }

    #[test]
    fn two_or_no_maxima_are_refused() {
        let two = curve(&[[10.0, 0.2, 0.0], [14.0, 0.2, 3.0]]);
        assert!(matches!(decide(&two), Err(DelayError::Ambiguous { .. })));
        let flat = curve(&[[10.0, 8.0, 0.0]]);
        assert!(matches!(decide(&flat), Err(DelayError::Vague { .. })));
        let rising = curve(&[[22.0, 1.0, 0.0]]);
        assert!(matches!(decide(&rising), Err(DelayError::AtEnd { .. })));
    }
}
