//! What the sharpness of the image says of the delay.

use super::finding::{Finding, Verdict};
use super::setting::Setting;
use crate::align::delay::DelayCheck;

/// Speed of light in vacuum (m/s), for delays that settings are judged by.
const LIGHT_SPEED_M_S: f64 = 299_792_458.0;
/// Log-likelihood below the sharpest delay from which the one in force is doubted (odds of 160 000
/// to 1), and how far it must be from the nearest that agrees (ns): 7.5 cm of range.
const DOUBTFUL_BELOW: f64 = 12.0;
const DOUBTFUL_NS: f64 = 0.5;

/// A deviation up to which a delay counts as told (ns).
const TELLING_NS: f64 = 0.5;

/// How far before the radar's own time zero range zero may stand (ns): what a calibration of the
/// instrument may leave.
const BEFORE_ZERO_NS: f64 = 1.0;

/// Judges the fast time taken for range zero, where it comes before the radar's own time zero: no
/// instrument receives before it transmits.
#[must_use]
pub fn delay_before_zero(delay_ns: f64) -> Option<Finding> {
    (delay_ns < -BEFORE_ZERO_NS).then(|| {
        Finding::judged("delay_before_zero", delay_ns, "ns", Verdict::Doubtful)
            .expecting(0.0)
            .because(format!(
                "range zero is taken {:.2} ns before the radar's own time zero, when nothing has been \
                 transmitted yet ([radar] delay_ns, [preprocess] zero_timing)",
                -delay_ns
            ))
    })
}

/// Judges the delay in force by the sharpness of images about it. Targets above or below the image
/// plane are sharp at another delay than its own, so that it is doubted at most.
#[must_use]
pub fn delay_sharpness(seen: &DelayCheck) -> Finding {
    let off_ns = -1e9 * seen.later_s;
    let is_off = 1e9 * seen.outside_s > DOUBTFUL_NS && seen.below_best >= DOUBTFUL_BELOW;
    let verdict = if is_off {
        Verdict::Doubtful
    } else {
        Verdict::Agrees
    };
    Finding {
        checks: (1e9 * seen.sigma_s <= TELLING_NS).then_some(Setting::Heights),
        sigma: Some(1e9 * seen.sigma_s),
        ..Finding::judged("delay_sharpness", off_ns, "ns", verdict)
    }
    .expecting(0.0)
    .because(format!(
        "the image is sharpest with range zero {:+.2} ns from the delay in force: {:+.2} m of range \
         ([radar] delay_ns, [preprocess] zero_timing, [image] z_m, heights)",
        -off_ns,
        -0.5e-9 * off_ns * LIGHT_SPEED_M_S
    ))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test that cannot go on has failed
mod tests {
    use super::*;

    #[test]
    fn range_zero_before_transmission_is_doubted() {
        assert!(delay_before_zero(0.0).is_none() && delay_before_zero(-0.9).is_none());
        let found = delay_before_zero(-8.5).unwrap();
        assert_eq!(found.verdict, Verdict::Doubtful);
    }

    #[test]
    fn a_delay_a_metre_off_is_doubted() {
        let verdict = |later_s: f64, below_best| {
            delay_sharpness(&DelayCheck {
                later_s,
                sigma_s: 0.1e-9,
                outside_s: later_s.abs(),
                below_best,
            })
            .verdict
        };
        assert_eq!(verdict(0.0, 0.0), Verdict::Agrees);
        assert_eq!(verdict(7.3e-9, 80.0), Verdict::Doubtful);
        // Hardly sharper elsewhere.
        assert_eq!(verdict(7.3e-9, 7.0), Verdict::Agrees);
    }
}
