//! What the engine answers: an epoch-by-epoch solution and the story behind it.

use crate::baseline::Baseline;
use crate::error_correlation::ErrorCorrelation;
use crate::observation::EventRecord;
use crate::satellite::{SatelliteId, System};
use crate::signal::SignalCode;
use acerra_geo::time::GpsTime;
use std::fmt;

/// Quality of a solution, numbered as RTKLIB numbers it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Quality {
    /// 1: ambiguities fixed to integers.
    Fixed,
    /// 2: carrier phase with float ambiguities.
    Float,
    /// 3: corrected by SBAS.
    Sbas,
    /// 4: differential pseudoranges.
    Dgps,
    /// 5: single-point position.
    Single,
    /// 6: precise point positioning.
    Ppp,
}

impl Quality {
    /// The number `.pos` files use (1–6).
    #[must_use]
    pub const fn number(self) -> u8 {
        self as u8 + 1
    }
}

/// Why an epoch is not fixed.
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
    /// The ratio test passed, with too little to tell the right integers from wrong ones.
    IntegersUncertain {
        /// Probability that they are right, from the float ambiguities' covariance.
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
    /// The fix rests on no more phases than a position takes, and in poor geometry: nothing would
    /// show a wrong one.
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
    /// Short key under which reports count this reason.
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

impl Solution {
    /// The covariance (ECEF, m²) relative to the base: that of the baseline where the base moves.
    #[must_use]
    pub fn relative_covariance_ecef_m2(&self) -> [[f64; 3]; 3] {
        self.baseline
            .map_or(self.covariance_ecef_m2, |b| b.covariance_ecef_m2)
    }
}

/// The solution of one epoch.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// GPS time of the position: receiver tag minus receiver clock offset.
    pub time: GpsTime,
    /// Rover antenna position (ECEF, m).
    pub position_ecef_m: [f64; 3],
    /// Its covariance (ECEF, m²), the base's place taken for known; of a moving base with that of its
    /// place.
    pub covariance_ecef_m2: [[f64; 3]; 3],
    /// The vector from a moving base ([`PositioningMode::MovingBase`]); `None` with one that stands.
    ///
    /// [`PositioningMode::MovingBase`]: crate::PositioningMode::MovingBase
    pub baseline: Option<Baseline>,
    /// Velocity (ECEF, m/s), from Doppler or from the motion model.
    pub velocity_ecef_m_s: Option<[f64; 3]>,
    /// Quality.
    pub quality: Quality,
    /// Satellites used.
    pub satellites: usize,
    /// Age of the base's data (s); negative when the base epoch is later.
    pub age_s: f64,
    /// Ratio of the ambiguity test, capped at 999.9; 0 when none was made.
    pub ratio: f64,
    /// Why the epoch is not fixed; `None` when it is.
    pub not_fixed: Option<NotFixedReason>,
    /// Residuals and state of each satellite used.
    pub residuals: Vec<SatelliteResidual>,
}

/// Residuals of one satellite and frequency after the update.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SatelliteResidual {
    /// The satellite.
    pub satellite: SatelliteId,
    /// Frequency slot.
    pub slot: usize,
    /// Azimuth from north (rad).
    pub azimuth_rad: f64,
    /// Elevation (rad).
    pub elevation_rad: f64,
    /// Double-difference phase residual (m), where the phase was used.
    pub phase_m: Option<f64>,
    /// Double-difference code residual (m), where the code was used.
    pub code_m: Option<f64>,
    /// Whether a cycle slip was flagged at this epoch.
    pub slipped: bool,
    /// Whether the ambiguity took part in a fix.
    pub fixed: bool,
}

/// An epoch that yields no position at all.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LostEpoch {
    /// Receiver tag.
    pub time: GpsTime,
    /// Why.
    pub reason: NotFixedReason,
}

/// The rover's position at an event.
#[derive(Debug, Clone, PartialEq)]
pub struct EventPosition {
    /// The event.
    pub event: EventRecord,
    /// Its time in GPS time.
    pub time: GpsTime,
    /// Position (ECEF, m) interpolated between its neighbours; `None` outside the solution or
    /// inside a gap.
    pub position_ecef_m: Option<[f64; 3]>,
    /// The worse covariance of the two neighbours (ECEF, m²).
    pub covariance_ecef_m2: [[f64; 3]; 3],
    /// The worse quality of the two neighbours.
    pub quality: Option<Quality>,
}

/// A satellite system, or one satellite, that could not be used for want of navigation data.
#[derive(Debug, Clone, PartialEq)]
pub struct MissingNavigation {
    /// The satellite.
    pub satellite: SatelliteId,
    /// First and last rover epoch at which it was observed without a usable ephemeris.
    pub span: (GpsTime, GpsTime),
    /// How many epochs.
    pub epochs: usize,
    /// Whether it lacks its GLONASS frequency channel rather than an ephemeris.
    pub channel_missing: bool,
}

/// A hole in the base's log longer than the largest age allowed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BaseGap {
    /// Last epoch before.
    pub from: GpsTime,
    /// First epoch after.
    pub to: GpsTime,
}

/// Remarks that the user should see.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum PpkWarning {
    /// Satellites observed but without navigation data.
    MissingNavigation(MissingNavigation),
    /// No satellite of a selected system has navigation data.
    SystemWithoutNavigation(System),
    /// The base's log has a gap.
    BaseGap(BaseGap),
    /// The base position came from the file header.
    HeaderPositionUsed {
        /// Distance from the base's own single-point position (m), if that worked.
        distance_from_single_m: Option<f64>,
    },
    /// No broadcast ionosphere coefficients: the model's defaults were used.
    DefaultIonosphere,
    /// No phases at all, or none with a resolved half cycle: ambiguities cannot be resolved.
    NoUsablePhases {
        /// Whether it is the base's log that lacks them.
        base: bool,
    },
    /// Rover and base hold the same observations.
    IdenticalFiles,
    /// The base's Doppler shifts say that it moves: perhaps rover and base are swapped.
    BaseMoves {
        /// Median speed (m/s).
        speed_m_s: f64,
    },
    /// Fixing was poor by the settings given; others, whose passes agree at more epochs, were taken
    /// where they fixed more.
    AlternativeTaken {
        /// The C/N₀ mask tried (dB-Hz), if it is that which helped.
        cn0_mask_db_hz: Option<f64>,
        /// Epochs at which forward and backward fixes agree, before and after.
        agreeing: [usize; 2],
        /// Epochs fixed before and after.
        fixed: [usize; 2],
    },
    /// One frequency of one system contradicts the others' integers: its ambiguities stay float.
    SignalsContradict {
        /// The system.
        system: System,
        /// The rover's signal, where its log names one.
        signal: Option<SignalCode>,
    },
    /// The motion model is not used: with a moving base it would predict the base's errors.
    DynamicsNotUsed,
    /// The base position given is far from the base's own single-point position.
    BasePositionDoubtful {
        /// Distance between the two (m).
        distance_m: f64,
    },
}

impl fmt::Display for PpkWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let time = |t: GpsTime| t.format_calendar(0);
        match self {
            Self::MissingNavigation(missing) => write!(
                f,
                "{} was observed in {} epochs from {} to {} without {}",
                missing.satellite,
                missing.epochs,
                time(missing.span.0),
                time(missing.span.1),
                if missing.channel_missing {
                    "its frequency channel"
                } else {
                    "a usable ephemeris"
                }
            ),
            Self::SystemWithoutNavigation(system) => write!(
                f,
                "no navigation data of {system} at all: its satellites are not used"
            ),
            Self::BaseGap(gap) => write!(
                f,
                "the base's log has a gap from {} to {}",
                time(gap.from),
                time(gap.to)
            ),
            Self::HeaderPositionUsed {
                distance_from_single_m,
            } => {
                f.write_str("the base position was taken from its file's header")?;
                match distance_from_single_m {
                    Some(m) => write!(f, ", {m:.1} m from its own single-point position"),
                    None => Ok(()),
                }
            }
            Self::DefaultIonosphere => {
                f.write_str("no broadcast ionosphere coefficients: the model's defaults were used")
            }
            Self::NoUsablePhases { base } => write!(
                f,
                "the {}'s log has no usable carrier phases: ambiguities cannot be resolved",
                if *base { "base" } else { "rover" }
            ),
            Self::IdenticalFiles => f.write_str("rover and base hold the same observations"),
            Self::BaseMoves { speed_m_s } => write!(
                f,
                "the base moves at {speed_m_s:.1} m/s by its Doppler shifts: are rover and base \
                 swapped?"
            ),
            Self::AlternativeTaken {
                cn0_mask_db_hz,
                agreeing,
                fixed,
            } => {
                f.write_str("few epochs were fixed by the settings given; ")?;
                if let Some(mask) = cn0_mask_db_hz {
                    write!(f, "a carrier-to-noise mask of {mask:.0} dB-Hz and ")?;
                }
                write!(
                    f,
                    "integers fed back into the filter fixed {} instead of {}, forward and backward \
                     passes agreeing at {} instead of {}",
                    fixed[1], fixed[0], agreeing[1], agreeing[0]
                )
            }
            Self::SignalsContradict { system, signal } => {
                write!(f, "phases of {system}")?;
                if let Some(signal) = signal {
                    write!(f, " {signal}")?;
                }
                f.write_str(
                    " contradict the other signals' integers: their ambiguities were left float",
                )
            }
            Self::DynamicsNotUsed => f.write_str(
                "the motion model is not used with a moving base: it would predict the errors of \
                 the base's own positions",
            ),
            Self::BasePositionDoubtful { distance_m } => write!(
                f,
                "the base position given is {distance_m:.0} m from the base's own single-point \
                 position"
            ),
        }
    }
}

/// What `--glonass-ar auto` decided, and on what evidence.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum GlonassDecision {
    /// Ambiguities resolved: no inter-channel bias is to be seen.
    WithoutBias {
        /// Standard deviation of the slope (m per channel).
        sigma_m_per_channel: f64,
    },
    /// Ambiguities resolved after an inter-channel bias.
    WithBias {
        /// Its slope (m per channel).
        slope_m_per_channel: f64,
        /// Its standard deviation (m per channel).
        sigma_m_per_channel: f64,
    },
    /// Ambiguities left float: too few fixes would take them.
    Float {
        /// Fixes with GLONASS in the pass that tried.
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

/// Counts and remarks about a whole run.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PpkSummary {
    /// Rover epochs in the time window.
    pub rover_epochs: usize,
    /// Epochs fixed.
    pub fixed: usize,
    /// Epochs float.
    pub float: usize,
    /// Epochs of other quality.
    pub other: usize,
    /// Reason (see [`NotFixedReason::key`]) and number of epochs not fixed for it, most frequent
    /// first; epochs without any position included.
    pub not_fixed: Vec<(&'static str, usize)>,
    /// Smallest, mean and largest age of the base's data (s), where any was used.
    pub age_s: Option<[f64; 3]>,
    /// What was decided about GLONASS ambiguities, where that was left to the run.
    pub glonass: Option<GlonassDecision>,
    /// Distance of the base position given from the base's own single-point position (m), where the
    /// base has one.
    pub base_from_single_m: Option<f64>,
    /// How the errors of the positions hang together in time, where fixes tell.
    pub error_correlation: Option<ErrorCorrelation>,
    /// Remarks.
    pub warnings: Vec<PpkWarning>,
}

/// The result of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct PpkSolution {
    /// Position used for the base antenna (ECEF, m); `None` in single mode and with a moving base.
    pub base_position_ecef_m: Option<[f64; 3]>,
    /// Solutions in ascending time order.
    pub epochs: Vec<Solution>,
    /// Epochs without a position.
    pub lost: Vec<LostEpoch>,
    /// Events with their positions.
    pub events: Vec<EventPosition>,
    /// Counts and remarks.
    pub summary: PpkSummary,
}
