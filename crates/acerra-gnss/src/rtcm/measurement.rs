//! Content of an observation message of any kind.

use crate::observations::satellite::{SatelliteId, System};
use crate::observations::signal::SignalCode;

/// The observations of one message.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Measured {
    /// Reference station (DF003).
    pub station: u16,
    /// Epoch time in the system's count.
    pub tag: TimeTag,
    /// Whether more messages of this epoch follow.
    pub more_follow: bool,
    /// The signals, in the message's order.
    pub signals: Vec<MeasuredSignal>,
    /// GLONASS channels by satellite number.
    pub channels: Vec<(u8, i8)>,
    /// Signals that have no RINEX name, or satellites that have no number.
    pub unknown: u64,
}

/// An epoch time within its week or day.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TimeTag {
    /// Milliseconds of the GPS week (Galileo, QZSS and SBAS too).
    GpsWeek(u32),
    /// Milliseconds of the BeiDou week.
    BeidouWeek(u32),
    /// Milliseconds of the GLONASS day (UTC + 3 h).
    GlonassDay(u32),
}

/// One signal of one satellite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MeasuredSignal {
    pub satellite: SatelliteId,
    pub code: SignalCode,
    /// Pseudorange (m).
    pub range_m: Option<f64>,
    /// Carrier phase.
    pub phase: Option<PhaseRange>,
    /// Range rate (m/s).
    pub rate_m_s: Option<f64>,
    /// Carrier-to-noise density (dB-Hz).
    pub cn0_db_hz: Option<f64>,
    /// Least time of continuous tracking (ms).
    pub least_lock_ms: u32,
    /// Whether the half cycle is unresolved.
    pub half_cycle_unknown: bool,
}

/// A carrier phase in units of length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum PhaseRange {
    /// A phase range without ambiguity (m).
    Whole(f64),
    /// Beyond a pseudorange (m), by an excess (m) whose cycles are known modulo 1500.
    Modulo1500 {
        /// The pseudorange of the first frequency (m).
        range_m: f64,
        /// Phase range minus pseudorange (m).
        excess_m: f64,
    },
}

impl PhaseRange {
    /// Whether the phase range is positive.
    pub(super) fn is_positive(&self) -> bool {
        match *self {
            Self::Whole(metres) => metres > 0.0,
            Self::Modulo1500 { range_m, excess_m } => range_m + excess_m > 0.0,
        }
    }
}

/// The satellite of a number in a message of `system`.
pub(super) fn satellite(system: System, number: u8) -> Option<SatelliteId> {
    match system {
        // Bit 1 of the SBAS mask is PRN 120.
        System::Sbas => SatelliteId::new(system, number.checked_add(19)?),
        _ => SatelliteId::new(system, number),
    }
}
