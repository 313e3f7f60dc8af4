//! Rate of the random walk of phases by multipath, measured from the residuals of fixes.
//!
//! The residuals of a fix are free of geometry, clocks and ambiguities. Half the mean square of their change
//! over a lag is their semivariance: the semivariance starts at the white noise and rises by the lasting
//! multipath. A float ambiguity follows the multipath as a random walk with the mean rate of this rise over
//! the time for which codes are averaged: for longer-lasting multipath the initial rate, 2σ²/τ of a
//! Gauss–Markov process; for quicker multipath only σ² matters.

use crate::linear::outliers::{Standardised, median};
use crate::measurements::common::Common;
use acerra_geo::time::GpsTime;

/// Longest lag (s) over which the rise is measured: beyond it reflections have changed.
const LARGEST_LAG_S: f64 = 100.0;
/// Least number of changes of a lag.
const LEAST_CHANGES: usize = 100;
/// Changes beyond this many robust standard deviations are clipped.
const LARGEST_SIGMA: f64 = 4.0;

/// Residual of one satellite's phase or code after a fix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NormalisedResidual {
    pub satellite: usize,
    pub slot: usize,
    /// Residual about the block's weighted mean, over the model's standard deviation.
    pub normalised: f64,
}

/// The residuals of a fix by satellite, in ascending order of slot and satellite.
pub(crate) fn of_satellites(
    residuals: Vec<Standardised>,
    common: &[Common],
) -> Vec<NormalisedResidual> {
    let of_one = |r: Standardised| NormalisedResidual {
        satellite: common[r.common].satellite,
        slot: r.slot,
        normalised: r.normalised,
    };
    let mut own: Vec<NormalisedResidual> = residuals.into_iter().map(of_one).collect();
    own.sort_unstable_by_key(|r| (r.slot, r.satellite));
    own
}

/// The residuals of one fix, in ascending order of slot and satellite.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FixResiduals<'a> {
    pub time: GpsTime,
    pub residuals: &'a [NormalisedResidual],
}

/// Rise of the residuals' semivariance per second, in units of the model's variance; `None` where
/// the fixes are too few, or span too little.
pub(crate) fn rise_per_s(fixes: &[FixResiduals<'_>]) -> Option<f64> {
    let intervals = fixes
        .windows(2)
        .map(|w| w[1].time.seconds_since(w[0].time).abs());
    let interval_s = median(intervals.collect());
    if interval_s <= 0.0 || interval_s > LARGEST_LAG_S / 2.0 {
        return None;
    }
    let largest = (LARGEST_LAG_S / interval_s) as usize;
    let nearest = semivariance(fixes, 1, interval_s)?;
    let furthest = semivariance(fixes, largest, largest as f64 * interval_s)?;
    Some((furthest - nearest).max(0.0) / ((largest - 1) as f64 * interval_s))
}

/// Mean over all pairs of fixes this many apart, `lag_s` in time, of half the squared change of a
/// satellite's residual; `None` where they are too few.
fn semivariance(fixes: &[FixResiduals<'_>], lag: usize, lag_s: f64) -> Option<f64> {
    let mut squares = Vec::new();
    for (early, late) in fixes.iter().zip(fixes.iter().skip(lag)) {
        if (late.time.seconds_since(early.time).abs() - lag_s).abs() > 0.1 * lag_s {
            continue;
        }
        for a in early.residuals {
            let key = |r: &NormalisedResidual| (r.slot, r.satellite);
            if let Ok(k) = late.residuals.binary_search_by_key(&key(a), key) {
                let change = late.residuals[k].normalised - a.normalised;
                squares.push(change * change / 2.0);
            }
        }
    }
    if squares.len() < LEAST_CHANGES {
        return None;
    }
    // 0.455 is the median of χ² with one degree of freedom.
    let limit = LARGEST_SIGMA.powi(2) * median(squares.clone()) / 0.455;
    let sum: f64 = squares.iter().map(|s| s.min(limit)).sum();
    Some(sum / squares.len() as f64)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// Residuals of 20 satellites over `epochs` seconds: white noise of variance 1 and a
    /// Gauss–Markov process of variance 4.
    fn rise(correlation_s: f64, epochs: usize) -> Option<f64> {
        let mut seed = 1u64;
        let mut normal = || {
            let mut sum = -6.0;
            for _ in 0..12 {
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                sum += (seed >> 11) as f64 / (1u64 << 53) as f64;
            }
            sum
        };
        let kept = (-1.0 / correlation_s).exp();
        let mut states: Vec<f64> = (0..20).map(|_| 2.0 * normal()).collect();
        let rows: Vec<Vec<NormalisedResidual>> = (0..epochs)
            .map(|_| {
                let of_one = |(satellite, state): (usize, &mut f64)| {
                    *state = kept * *state + 2.0 * (1.0 - kept * kept).sqrt() * normal();
                    NormalisedResidual {
                        satellite,
                        slot: 0,
                        normalised: *state + normal(),
                    }
                };
                states.iter_mut().enumerate().map(of_one).collect()
            })
            .collect();
        let start = GpsTime::new(0, 0.0);
        let fixes: Vec<FixResiduals<'_>> = rows
            .iter()
            .enumerate()
            .map(|(k, residuals)| FixResiduals {
                time: start + k as f64,
                residuals,
            })
            .collect();
        rise_per_s(&fixes)
    }

    #[test]
    fn slow_multipath_rises_at_its_initial_rate() {
        let found = rise(500.0, 3000).unwrap();
        let expected = 4.0 * (1.0 - (-99.0f64 / 500.0).exp()) / 99.0;
        assert!((found / expected - 1.0).abs() < 0.25, "{found} {expected}");
    }

    #[test]
    fn quick_multipath_counts_once() {
        let found = rise(3.0, 1500).unwrap();
        let expected = 4.0 * (-1.0f64 / 3.0).exp() / 99.0;
        assert!((found / expected - 1.0).abs() < 0.25, "{found} {expected}");
    }

    #[test]
    fn too_few_fixes_say_nothing() {
        assert_eq!(rise(100.0, 90), None);
        assert_eq!(rise_per_s(&[]), None);
    }
}
