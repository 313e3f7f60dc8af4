//! Estimates of the delay by surface echo and direct coupling.

use acerra_radar::Radargram;
use acerra_radar::align::OffsetLikelihood;
use acerra_radar::quality;

/// A delay with its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DelayCue {
    /// Fast time at which range is zero (s).
    pub delay_s: f64,
    /// Standard deviation of the delay (s).
    pub sigma_s: f64,
}

/// Log-likelihood over an unrelated echo from which the echo that follows the height is accepted.
const LEAST_EVIDENCE: f64 = 12.0;
/// Roughness of ordinary ground in the surface echo (s): 5 cm.
const GROUND_ROUGHNESS_S: f64 = 0.33e-9;
/// Place of the pick within the echo's pulse (s).
const PICK_S: f64 = 0.3e-9;
/// Least level of the coupling above the rest of the mean trace (dB).
const COUPLING_CONTRAST_DB: f64 = 20.0;
/// Largest wander of the coupling (s).
const COUPLING_SPREAD_S: f64 = 0.1e-9;
/// Travel time between the antennas (s), up to 0.6 m apart.
const COUPLING_S: f64 = 1.0e-9;
/// Standard deviation of this travel time (s).
const COUPLING_SIGMA_S: f64 = 0.6e-9;
/// Logarithm of the prior odds (1 to 20) that an echo was identified wrongly, so that its delay has no
/// relation to range zero.
const UNRELATED: f64 = -3.0;

impl DelayCue {
    /// Log-likelihood of a delay, 0 at best: normal about the delay of the cue, or unrelated to the cue.
    #[must_use]
    pub fn log_likelihood(&self, delay_s: f64) -> f64 {
        let normal = -0.5 * ((delay_s - self.delay_s) / self.sigma_s).powi(2);
        let ceiling = UNRELATED.exp().ln_1p();
        normal.max(UNRELATED) + (-(normal - UNRELATED).abs()).exp().ln_1p() - ceiling
    }
}

/// The delay by the echo that follows the height of the flight; `None` where no echo clearly follows it.
#[must_use]
pub fn surface_delay(likelihood: &OffsetLikelihood) -> Option<DelayCue> {
    let cue = likelihood.height.as_ref()?;
    (cue.evidence >= LEAST_EVIDENCE).then(|| DelayCue {
        delay_s: cue.delay_s,
        sigma_s: cue
            .delay_sigma_s
            .hypot(cue.residual_s)
            .hypot(GROUND_ROUGHNESS_S)
            .hypot(PICK_S),
    })
}

/// The delay by the direct coupling; `None` where the window contains no coupling.
#[must_use]
pub fn coupling_delay(radargram: &Radargram) -> Option<DelayCue> {
    let seen = quality::coupling(radargram)?;
    let is_coupling = seen.contrast_db >= COUPLING_CONTRAST_DB
        && seen.spread_s <= COUPLING_SPREAD_S
        && radargram.fast_time_start_s < seen.fast_time_s - 1e-9;
    is_coupling.then(|| DelayCue {
        delay_s: seen.fast_time_s - COUPLING_S,
        sigma_s: COUPLING_SIGMA_S.hypot(seen.spread_s),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cue_that_may_be_unrelated_never_rules_a_delay_out() {
        let cue = DelayCue {
            delay_s: 10e-9,
            sigma_s: 0.5e-9,
        };
        assert!(cue.log_likelihood(10e-9).abs() < 1e-12);
        assert!((cue.log_likelihood(10.5e-9) + 0.5).abs() < 0.1);
        assert!((cue.log_likelihood(20e-9) - UNRELATED).abs() < 0.1);
    }
}
