//! Decision of a run about GLONASS ambiguities.

use std::fmt;

/// Decision of `--glonass-ar auto`, with its evidence.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum GlonassDecision {
    /// Ambiguities resolved without an inter-channel bias: none is significant.
    WithoutBias {
        /// Standard deviation of the slope (m per channel).
        sigma_m_per_channel: f64,
    },
    /// Ambiguities resolved after an inter-channel bias.
    WithBias {
        /// Slope of the bias (m per channel).
        slope_m_per_channel: f64,
        /// Standard deviation of the slope (m per channel).
        sigma_m_per_channel: f64,
    },
    /// Ambiguities left float: too few fixes accept them.
    Float {
        /// Number of fixes with GLONASS in the trial pass.
        fixes: usize,
    },
}

impl fmt::Display for GlonassDecision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::WithoutBias {
                sigma_m_per_channel,
            } => write!(
                f,
                "ambiguities resolved; no inter-channel bias (0 ± {:.1} mm per channel)",
                sigma_m_per_channel * 1e3
            ),
            Self::WithBias {
                slope_m_per_channel,
                sigma_m_per_channel,
            } => write!(
                f,
                "ambiguities resolved; inter-channel bias of {:.1} ± {:.1} mm per channel taken off",
                slope_m_per_channel * 1e3,
                sigma_m_per_channel * 1e3
            ),
            Self::Float { fixes } => write!(
                f,
                "ambiguities left float: only {fixes} fixes with them in a trial pass"
            ),
        }
    }
}
