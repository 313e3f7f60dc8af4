//! Correlation in time of a pass's errors, from the residuals of its fixes.
//!
//! Residuals of phases and the error of the position are both linear in the phases' errors and therefore have
//! the same correlation time. The correlation time of a float position's error is measured where integers are
//! known, from its difference to the fixed position. Both have zero mean by the model, so that the mean
//! product of two values over the mean square is their correlation, constant parts included.

use crate::filter::epoch_result::EpochResult;
use crate::linear::outliers::median;
use crate::noise::phase_walk::{FixResiduals, NormalisedResidual};
use crate::solution::{ErrorCorrelation, Lasting, Quality};

/// Largest lag (s).
const LARGEST_LAG_S: f64 = 300.0;
/// Largest lag, as a share of the length of the log.
const LARGEST_SHARE_OF_LOG: f64 = 1.0 / 3.0;
/// Time constants (s) of the processes whose sum is fitted; no log is long enough for longer ones.
const TIME_CONSTANTS_S: [f64; 7] = [1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1_000.0];
/// Least number of lags for a fit.
const LEAST_LAGS: usize = 4;
/// Least number of products of a lag.
const LEAST_PRODUCTS: usize = 100;
/// Largest number of fixes from which lags start.
const LARGEST_STARTS: usize = 2_000;
/// Number of rounds of the fit: further rounds change less than the third digit.
const ROUNDS: usize = 2_000;
/// Shares below this are left out.
const LEAST_SHARE: f64 = 0.005;

/// Correlation at a lag (s).
#[derive(Debug, Clone, Copy)]
struct Lagged {
    lag_s: f64,
    correlation: f64,
}

/// The correlation of the errors of `pass`, given in the order of the pass and before any fix is confirmed;
/// `None` where too few epochs are fixed.
pub(crate) fn error_correlation(pass: &[EpochResult]) -> Option<ErrorCorrelation> {
    let fixed = || pass.iter().filter(|r| r.quality == Some(Quality::Fixed));
    let fixes: Vec<FixResiduals<'_>> = fixed().filter_map(EpochResult::fix_residuals).collect();
    let departures: Vec<[f64; 3]> = fixed().map(departure_m).collect();
    let phases = fit(&curve(&fixes, |a, b| {
        products_of_residuals(&fixes[a], &fixes[b])
    }))?;
    let ambiguities = fit(&curve(&fixes, |a, b| {
        let (a, b) = (departures[a], departures[b]);
        (0..3)
            .map(|k| [a[k] * b[k], (a[k] * a[k] + b[k] * b[k]) / 2.0])
            .collect()
    }));
    let variances_m2 = fixed().map(|r| (0..3).map(|k| r.covariance_ecef_m2[k][k]).sum());
    let unknown = ErrorCorrelation::default();
    Some(ErrorCorrelation {
        phases,
        ambiguities: ambiguities.map_or(unknown.ambiguities, whole),
        fixed_variance_m2: median(variances_m2.collect()),
    })
}

/// Float less fixed position (m) of a fix.
fn departure_m(fix: &EpochResult) -> [f64; 3] {
    let float = fix.integers.as_ref().map(|i| i.float.position_ecef_m);
    let float = float.unwrap_or(fix.position_ecef_m);
    std::array::from_fn(|k| float[k] - fix.position_ecef_m[k])
}

/// Product and mean square of the residuals of each satellite of both fixes.
fn products_of_residuals(a: &FixResiduals<'_>, b: &FixResiduals<'_>) -> Vec<[f64; 2]> {
    let found = |r: &NormalisedResidual| {
        let key = (r.slot, r.satellite);
        let k = b
            .residuals
            .binary_search_by_key(&key, |o| (o.slot, o.satellite));
        let other = b.residuals[k.ok()?].normalised;
        Some([
            r.normalised * other,
            (r.normalised.powi(2) + other.powi(2)) / 2.0,
        ])
    };
    a.residuals.iter().filter_map(found).collect()
}

/// Correlations at lags that grow by half, up to the largest; `products` gives the products and
/// mean squares of two fixes.
fn curve(
    fixes: &[FixResiduals<'_>],
    products: impl Fn(usize, usize) -> Vec<[f64; 2]>,
) -> Vec<Lagged> {
    let apart_s = |a: usize, b: usize| fixes[b].time.seconds_since(fixes[a].time).abs();
    let n = fixes.len();
    let interval_s = median((1..n).map(|k| apart_s(k - 1, k)).collect());
    let mut points = Vec::new();
    if interval_s <= 0.0 {
        return points;
    }
    let largest_s = LARGEST_LAG_S.min(LARGEST_SHARE_OF_LOG * apart_s(0, n - 1));
    let step = n.div_ceil(LARGEST_STARTS);
    let mut lag = 1;
    while lag as f64 * interval_s <= largest_s {
        let lag_s = lag as f64 * interval_s;
        let (mut sums, mut count) = ([0.0; 2], 0);
        for k in (0..n.saturating_sub(lag)).step_by(step) {
            if (apart_s(k, k + lag) - lag_s).abs() > 0.1 * lag_s {
                continue;
            }
            for [product, square] in products(k, k + lag) {
                sums = [sums[0] + product, sums[1] + square];
                count += 1;
            }
        }
        if count >= LEAST_PRODUCTS && sums[1] > 0.0 {
            points.push(Lagged {
                lag_s,
                correlation: sums[0] / sums[1],
            });
        }
        lag = (lag + 1).max(lag * 3 / 2);
    }
    points
}

/// The sum of Gauss–Markov processes whose correlation fits best, by least squares with shares of zero or
/// more (coordinate descent); the remaining share, up to one, is white.
fn fit(points: &[Lagged]) -> Option<Vec<Lasting>> {
    if points.len() < LEAST_LAGS {
        return None;
    }
    let basis = TIME_CONSTANTS_S
        .map(|constant_s| points.iter().map(move |p| (-p.lag_s / constant_s).exp()))
        .map(Iterator::collect::<Vec<f64>>);
    let mut shares = [0.0f64; TIME_CONSTANTS_S.len()];
    let mut left: Vec<f64> = points.iter().map(|p| p.correlation).collect();
    for _ in 0..ROUNDS {
        for (own, share) in basis.iter().zip(&mut shares) {
            let square: f64 = own.iter().map(|b| b * b).sum();
            let slope: f64 = own.iter().zip(&left).map(|(b, l)| b * l).sum();
            let next = (*share + slope / square.max(f64::MIN_POSITIVE)).max(0.0);
            for (l, b) in left.iter_mut().zip(own) {
                *l -= (next - *share) * b;
            }
            *share = next;
        }
    }
    let total: f64 = shares.iter().sum::<f64>().max(1.0);
    let of_one = |(share, time_constant_s): (f64, f64)| Lasting {
        share: share / total,
        time_constant_s,
    };
    let all = shares.into_iter().zip(TIME_CONSTANTS_S).map(of_one);
    Some(all.filter(|l| l.share >= LEAST_SHARE).collect())
}

/// The shares normalised to a sum of one, for a process without a white part.
fn whole(mut lasting: Vec<Lasting>) -> Vec<Lasting> {
    let total: f64 = lasting.iter().map(|l| l.share).sum();
    for l in &mut lasting {
        l.share /= total;
    }
    lasting
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn points(correlation: impl Fn(f64) -> f64) -> Vec<Lagged> {
        let lags = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 300.0];
        let at = |lag_s: f64| Lagged {
            lag_s,
            correlation: correlation(lag_s),
        };
        lags.map(at).to_vec()
    }

    #[test]
    fn processes_in_white_noise_are_recognised() {
        for (fast, slow) in [(5.0, 200.0), (20.0, 800.0)] {
            let truth = |lag_s: f64| 0.4 * (-lag_s / fast).exp() + 0.35 * (-lag_s / slow).exp();
            let found = fit(&points(truth)).unwrap();
            for lag_s in [1.0, 3.0, 15.0, 70.0, 250.0] {
                let model: f64 = found
                    .iter()
                    .map(|l| l.share * (-lag_s / l.time_constant_s).exp())
                    .sum();
                assert!((model - truth(lag_s)).abs() < 0.03, "{lag_s}: {found:?}");
            }
        }
    }

    #[test]
    fn few_fixes_over_a_long_time_are_no_reason_to_panic() {
        let start = acerra_geo::time::GpsTime::new(0, 0.0);
        let fixes: Vec<FixResiduals<'_>> = [0.0, 1.0, 2.0, 3.0, 1_000.0, 1_001.0]
            .map(|after_s| FixResiduals {
                time: start + after_s,
                residuals: &[],
            })
            .to_vec();
        assert!(curve(&fixes, |_, _| vec![[1.0; 2]; 100]).len() <= fixes.len());
        assert!(curve(&[], |_, _| Vec::new()).is_empty());
    }

    #[test]
    fn white_noise_has_nothing_that_lasts() {
        let found = fit(&points(|_| 0.0)).unwrap();
        assert!(found.is_empty(), "{found:?}");
        assert!(fit(&points(|_| 0.0)[..3]).is_none());
    }
}
