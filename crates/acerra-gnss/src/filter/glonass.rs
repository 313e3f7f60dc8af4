//! Decision from the data whether GLONASS ambiguities are resolved, and with which inter-channel bias.
//!
//! Receivers of different makes delay GLONASS carriers differently, in proportion to the channel number
//! (Wanninger 2012). A first pass estimates this slope together with the other unknowns. A free slope would
//! let wrong integers fit, so the main run uses the slope of the first pass.

use super::epoch_result::EpochResult;
use crate::linear::outliers::median;
use crate::solution::{GlonassDecision, Quality};

/// Least number of fixes with GLONASS for a slope.
const LEAST_FIXES: usize = 20;
/// A slope that is not larger than this many of its standard deviations counts as zero.
const SIGNIFICANT_SIGMA: f64 = 3.0;
/// Least standard deviation of a slope (m per channel): biases deviate from linearity by this much.
const LEAST_SIGMA_M: f64 = 0.000_5;

/// GLONASS ambiguities in the run proper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum GlonassPlan {
    /// Estimate the slope from scratch.
    Estimate,
    /// Start from this slope and standard deviation (m per channel).
    Slope([f64; 2]),
    /// Leave the ambiguities float.
    Float,
}

impl From<GlonassDecision> for GlonassPlan {
    fn from(decision: GlonassDecision) -> Self {
        match decision {
            GlonassDecision::WithoutBias { .. } => Self::Slope([0.0, LEAST_SIGMA_M]),
            GlonassDecision::WithBias {
                slope_m_per_channel,
                sigma_m_per_channel,
            } => Self::Slope([slope_m_per_channel, sigma_m_per_channel.max(LEAST_SIGMA_M)]),
            GlonassDecision::Float { .. } => Self::Float,
        }
    }
}

/// Decides from the fixes of a pass that estimated the slope.
pub(crate) fn decide(results: &[EpochResult]) -> GlonassDecision {
    let fixed = results.iter().filter(|r| r.quality == Some(Quality::Fixed));
    let slopes: Vec<[f64; 2]> = fixed.filter_map(|r| r.channel_slope_m).collect();
    if slopes.len() < LEAST_FIXES {
        return GlonassDecision::Float {
            fixes: slopes.len(),
        };
    }
    let slope = median(slopes.iter().map(|s| s[0]).collect());
    let formal = median(slopes.iter().map(|s| s[1]).collect());
    // 1.4826 median absolute deviations are a standard deviation.
    let spread = 1.4826 * median(slopes.iter().map(|s| (s[0] - slope).abs()).collect());
    let sigma = formal.max(spread);
    if slope.abs() <= (SIGNIFICANT_SIGMA * sigma).max(2.0 * LEAST_SIGMA_M) {
        GlonassDecision::WithoutBias {
            sigma_m_per_channel: sigma,
        }
    } else {
        GlonassDecision::WithBias {
            slope_m_per_channel: slope,
            sigma_m_per_channel: sigma,
        }
    }
}
