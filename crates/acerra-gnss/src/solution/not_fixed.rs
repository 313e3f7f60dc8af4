//! Reasons for which an epoch is not fixed.

use std::fmt;

/// Reasons for which an epoch is not fixed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum NotFixedReason {
    /// The single-point position found too few usable satellites.
    TooFewSatellitesForSingle {
        /// Satellites used.
        used: usize,
    },
    /// The single-point position failed its residual test or did not converge.
    SinglePointFailed,
    /// The satellites' geometry is too weak.
    PoorGeometry {
        /// Geometric dilution of precision.
        gdop: f64,
    },
    /// No base epoch near enough in time.
    BaseTooOld {
        /// Age of the nearest base epoch used (s); `None` when there is none at all.
        age_s: Option<f64>,
    },
    /// Rover and base share too few usable satellites.
    TooFewCommonSatellites {
        /// Satellites in common with valid phases.
        common: usize,
    },
    /// Too few satellites whose ambiguity may be resolved (slips, unresolved half cycles, new
    /// satellites).
    TooFewAmbiguities {
        /// Ambiguity pairs available.
        pairs: usize,
        /// Satellites that slipped at this epoch.
        slipped: usize,
        /// Satellites with an unresolved half cycle.
        half_cycle: usize,
    },
    /// The ratio test failed.
    RatioTooLow {
        /// The ratio found.
        ratio: f64,
        /// The ratio needed.
        needed: f64,
        /// Satellites that slipped at this epoch.
        slipped: usize,
    },
    /// The ratio test passed, with too few data to distinguish right integers from wrong ones.
    IntegersUncertain {
        /// Probability that the integers are right, from the float ambiguities' covariance.
        success_rate: f64,
        /// The probability needed.
        needed: f64,
    },
    /// The phases contradict each other once the integers are imposed (multipath, a slip that was
    /// not flagged, or wrong integers).
    PhasesInconsistent {
        /// Worst residual over its standard deviation.
        normalised: f64,
    },
    /// The integer search failed (covariance not positive definite).
    SearchFailed,
    /// The fix uses no more phases than determine a position, and in poor geometry: a wrong fix would not be
    /// noticed.
    NothingChecksFix,
    /// The float position was too uncertain for an attempt.
    FloatTooUncertain {
        /// Mean position variance (m²).
        variance_m2: f64,
    },
    /// Forward and backward passes both fixed, at different places.
    PassesDisagree {
        /// Distance between the two fixed positions (m).
        distance_m: f64,
    },
    /// The fixed baseline has another length than the known one.
    BaselineLength {
        /// Length of the fix (m).
        found_m: f64,
        /// The known length (m).
        expected_m: f64,
    },
    /// Ambiguity resolution is switched off.
    AmbiguityResolutionOff,
}

impl NotFixedReason {
    /// Short key of this reason in reports.
    #[must_use]
    pub const fn key(&self) -> &'static str {
        match self {
            Self::TooFewSatellitesForSingle { .. } => "too few satellites",
            Self::SinglePointFailed => "single-point position rejected",
            Self::PoorGeometry { .. } => "poor satellite geometry",
            Self::BaseTooOld { .. } => "no base data near enough",
            Self::TooFewCommonSatellites { .. } => "too few satellites in common with the base",
            Self::TooFewAmbiguities { .. } => "too few ambiguities to resolve",
            Self::RatioTooLow { .. } => "ratio test failed",
            Self::IntegersUncertain { .. } => "integers not certain enough",
            Self::PhasesInconsistent { .. } => "phases contradict each other",
            Self::SearchFailed => "integer search failed",
            Self::NothingChecksFix => "too few phases to check a fix",
            Self::FloatTooUncertain { .. } => "float position too uncertain",
            Self::PassesDisagree { .. } => "forward and backward passes disagree",
            Self::BaselineLength { .. } => "baseline of another length",
            Self::AmbiguityResolutionOff => "ambiguity resolution off",
        }
    }
}

impl fmt::Display for NotFixedReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFewSatellitesForSingle { used } => {
                write!(f, "single-point position needs 4 satellites, has {used}")
            }
            Self::PoorGeometry { gdop } => write!(f, "GDOP {gdop:.1}"),
            Self::BaseTooOld { age_s: Some(age) } => {
                write!(f, "nearest base epoch is {age:.1} s away")
            }
            Self::BaseTooOld { age_s: None } => f.write_str("no base epoch"),
            Self::TooFewCommonSatellites { common } => {
                write!(f, "{common} satellites with phase in common with the base")
            }
            Self::TooFewAmbiguities {
                pairs,
                slipped,
                half_cycle,
            } => write!(
                f,
                "{pairs} ambiguity pairs ({slipped} satellites slipped, {half_cycle} with \
                 unresolved half cycle)"
            ),
            Self::RatioTooLow {
                ratio,
                needed,
                slipped,
            } => {
                write!(
                    f,
                    "ratio {ratio:.1} below {needed:.1} ({slipped} satellites slipped)"
                )
            }
            Self::IntegersUncertain {
                success_rate,
                needed,
            } => write!(
                f,
                "integers right with a probability of {success_rate:.3}, needed {needed:.3}"
            ),
            Self::PhasesInconsistent { normalised } => {
                write!(f, "phase residual of {normalised:.1} standard deviations")
            }
            Self::FloatTooUncertain { variance_m2 } => {
                write!(f, "float position variance {variance_m2:.3} m²")
            }
            Self::PassesDisagree { distance_m } => {
                write!(f, "forward and backward fixes are {distance_m:.3} m apart")
            }
            Self::BaselineLength {
                found_m,
                expected_m,
            } => write!(
                f,
                "fixed baseline of {found_m:.3} m, known to be {expected_m:.3} m"
            ),
            other => f.write_str(other.key()),
        }
    }
}
