//! Remarks about a run.

use crate::observations::satellite::{SatelliteId, System};
use crate::observations::signal::SignalCode;
use acerra_geo::time::GpsTime;
use std::fmt;

/// A satellite system, or one satellite, without the necessary navigation data.
#[derive(Debug, Clone, PartialEq)]
pub struct MissingNavigation {
    /// The satellite.
    pub satellite: SatelliteId,
    /// First and last rover epoch at which it was observed without a usable ephemeris.
    pub span: (GpsTime, GpsTime),
    /// Number of epochs.
    pub epochs: usize,
    /// Whether the GLONASS frequency channel is missing rather than an ephemeris.
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
        /// Whether the base's log lacks phases (otherwise the rover's).
        base: bool,
    },
    /// Rover and base hold identical observations.
    IdenticalFiles,
    /// The base's Doppler shifts show motion: perhaps rover and base are swapped.
    BaseMoves {
        /// Median speed (m/s).
        speed_m_s: f64,
    },
    /// Fixing was poor by the settings given; other settings, whose passes agree at more epochs, were used
    /// where they fixed more.
    AlternativeTaken {
        /// The C/N₀ mask used (dB-Hz); `None` where another setting was used.
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
    /// The backward pass starts from a new state instead of the forward pass's state that the options
    /// require.
    PassesStartAnew,
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
            Self::IdenticalFiles => f.write_str("rover and base hold identical observations"),
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
            Self::PassesStartAnew => f.write_str(
                "combined-nophasereset: the backward pass still starts without integers, since a pass that \
                 starts from the forward pass's integers confirms none of them (--unguarded follows RTKLIB)",
            ),
            Self::BasePositionDoubtful { distance_m } => write!(
                f,
                "the base position given is {distance_m:.0} m from the base's own single-point \
                 position"
            ),
        }
    }
}
