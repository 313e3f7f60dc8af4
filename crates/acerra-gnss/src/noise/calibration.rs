//! Calibration of the float solution's noise by fixes.
//!
//! Where integers are held and confirmed, the float position's error is known: its difference from the fixed
//! position. The square of this error in units of the stated covariance is one on average, if the codes'
//! errors are as stated. Reflections that last longer than the log, or that delay all satellites on one side
//! equally, appear only in this error. The phases' residuals give the size of the phases' multipath, which
//! lasts for minutes: an ambiguity follows this multipath.

use crate::linear::outliers::median;
use acerra_geo::time::GpsTime;

/// Time (s) over which a satellite's codes are averaged to find their lasting error: three times the largest
/// lag of the semivariogram.
pub(crate) const SPAN_S: f64 = 900.0;
/// Time (s) after which reflections have changed: one float error in each such span counts.
const CORRELATION_S: f64 = 100.0;
/// Correlation time of phases (s), where too few phases are fixed to measure it. A reflection from the ground
/// a height h below the antenna comes 2h·sin ε later, which changes by 2h·cos ε·dε/dt: at 45°, for h = 1 m
/// and satellites that move by 0.12 mrad/s, a radian of phase in 180 s, for 0.5 m in 360 s.
pub(crate) const PHASE_CORRELATION_S: f64 = 300.0;
/// Weight of the noise as measured beforehand, in such spans.
const PRIOR_SPANS: f64 = 2.0;
/// Largest factor on the codes' variance.
const LARGEST_FACTOR: f64 = 100.0;
/// Bounds of the factors on float variances.
const FLOAT_FACTORS: [f64; 2] = [0.1, 10.0];
/// Weight of `PRIOR_PHASE_FACTOR` against the residuals of fixes, in degrees of freedom.
const PRIOR_FREEDOM: f64 = 20.0;
/// Prior ratio of the variance of phases to the model's variance.
const PRIOR_PHASE_FACTOR: f64 = 0.3;
/// Bounds of this ratio.
const PHASE_FACTORS: [f64; 2] = [0.02, 2.0];
/// Variance of a phase difference between receivers by the model at 45° (cycle² of L1):
/// 2·(3² + 3²·2) mm².
const MODEL_VARIANCE_CYCLES2: f64 = 54e-6 / (0.1903 * 0.1903);

/// Squared distance of a float position from the fixed one, in units of its covariance and per
/// dimension.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FloatMisfit {
    /// Mean over all three dimensions.
    pub whole: f64,
    pub horizontal: f64,
    pub vertical: f64,
}

/// Misfit between an epoch's fix and the measurements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Misfit {
    pub time: GpsTime,
    /// Error of the float position, where the fix is by held integers.
    pub float: Option<FloatMisfit>,
    /// Squared phase residuals of a fix in units of their variance, and their degrees of freedom.
    pub phase: Option<[f64; 2]>,
}

/// Ratio of the noise to its earlier estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Calibration {
    /// Factor on the codes' variance.
    pub code_factor: f64,
    /// Growth of an ambiguity's variance by the multipath of its phase (cycle²/s).
    pub phase_walk_cycles2_s: f64,
    /// Factors on the filter's variances of float positions, horizontally and vertically.
    pub float_factors: [f64; 2],
}

impl Calibration {
    /// The calibration before any fix is known.
    pub(crate) fn prior() -> Self {
        Self {
            code_factor: 1.0,
            phase_walk_cycles2_s: phase_walk(PRIOR_PHASE_FACTOR),
            float_factors: [1.0; 2],
        }
    }

    /// The calibration from the misfits of a pass, in the order of the pass.
    ///
    /// `rise_per_s` is the rate of rise of the residuals' semivariance, in units of the model's variance;
    /// `lasting_ratio` is the measured variance of averaged codes over the variance assumed in the pass, and
    /// `expected_share` the expected variance over the guarded variance.
    pub(crate) fn of(
        pass: &[Misfit],
        rise_per_s: Option<f64>,
        lasting_ratio: f64,
        expected_share: f64,
    ) -> Self {
        let misfits: Vec<FloatMisfit> = pass.iter().filter_map(|m| m.float).collect();
        let count = misfits.len() as f64;
        let length_s = median_interval_s(pass) * count;
        let spans = (length_s / CORRELATION_S).max(1.0);
        let factor = |of: fn(&FloatMisfit) -> f64, prior: f64, spans: f64| {
            if misfits.is_empty() {
                return prior;
            }
            let mean = misfits.iter().map(of).sum::<f64>() / count / lasting_ratio;
            (mean * spans + PRIOR_SPANS * prior) / (spans + PRIOR_SPANS)
        };
        let code_factor = factor(|m| m.whole, 1.0, spans).clamp(1.0, LARGEST_FACTOR);
        // The lasting error is drawn once a span: a large error is noticed, but a small error by chance does
        // not imply that other errors are small.
        let draws = (length_s / SPAN_S).max(1.0);
        let float_factor = |of: fn(&FloatMisfit) -> f64| {
            let within = |spans| factor(of, expected_share, spans);
            within(spans).max(within(draws)) / code_factor
        };
        let float_factors = [float_factor(|m| m.horizontal), float_factor(|m| m.vertical)]
            .map(|own: f64| own.clamp(FLOAT_FACTORS[0], FLOAT_FACTORS[1]));
        let fixed = pass.iter().filter_map(|m| m.phase);
        let [squares, freedom] =
            fixed.fold([0.0; 2], |sum, one| [sum[0] + one[0], sum[1] + one[1]]);
        let phase_factor =
            (squares + PRIOR_FREEDOM * PRIOR_PHASE_FACTOR) / (freedom + PRIOR_FREEDOM);
        Self {
            code_factor,
            float_factors,
            phase_walk_cycles2_s: rise_per_s.map_or_else(
                || phase_walk(phase_factor.clamp(PHASE_FACTORS[0], PHASE_FACTORS[1])),
                |rise| 2.0 * MODEL_VARIANCE_CYCLES2 * rise,
            ),
        }
    }
}

/// A first-order Gauss–Markov process of variance σ² changes by 2σ²/τ per second at first.
fn phase_walk(phase_factor: f64) -> f64 {
    2.0 * phase_factor * MODEL_VARIANCE_CYCLES2 / PHASE_CORRELATION_S
}

fn median_interval_s(pass: &[Misfit]) -> f64 {
    let intervals = pass
        .windows(2)
        .map(|w| w[1].time.seconds_since(w[0].time).abs());
    median(intervals.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pass(horizontal: f64, vertical: f64, epochs: u32) -> Vec<Misfit> {
        let one = |second: u32| Misfit {
            time: GpsTime::new(0, 0.0) + f64::from(second),
            float: Some(FloatMisfit {
                whole: (2.0 * horizontal + vertical) / 3.0,
                horizontal,
                vertical,
            }),
            phase: None,
        };
        (0..epochs).map(one).collect()
    }

    #[test]
    fn heights_that_err_more_than_stated_are_stated_worse_and_the_plane_is_not() {
        let found = Calibration::of(&pass(1.0, 16.0, 3_600), None, 1.0, 1.0);
        let [horizontal, vertical] = found.float_factors.map(|f| f * found.code_factor);
        assert!((0.9..1.5).contains(&horizontal), "{horizontal}");
        assert!((14.0..16.0).contains(&vertical), "{vertical}");
    }

    #[test]
    fn small_errors_of_a_short_log_say_little() {
        let found = Calibration::of(&pass(0.01, 0.01, 300), None, 1.0, 1.0);
        assert!((found.code_factor - 1.0).abs() < 1e-12);
        assert!(
            found.float_factors.iter().all(|f| (0.6..1.0).contains(f)),
            "{found:?}"
        );
    }

    #[test]
    fn without_fixes_nothing_changes() {
        let found = Calibration::of(&[], None, 1.0, 1.0);
        assert_eq!((found.code_factor, found.float_factors), (1.0, [1.0; 2]));
    }
}
