//! Observations of a receiver: epochs of code, phase, Doppler and signal strength.

use super::satellite::SatelliteId;
use super::signal::{FREQUENCY_SLOTS, SignalCode};
use acerra_geo::time::GpsTime;
use std::collections::BTreeMap;

/// Two time tags closer than this (s) are one epoch.
pub const EPOCH_TOLERANCE_S: f64 = 0.025;

/// Loss-of-lock indicator of a phase, as in RINEX.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub struct LossOfLock(pub u8);

impl LossOfLock {
    /// Bit 0: lock was lost since the previous observation (cycle slip).
    pub const SLIP: u8 = 1;
    /// Bit 1: half-cycle ambiguity not resolved.
    pub const HALF_CYCLE: u8 = 2;

    /// Whether lock was lost since the previous observation.
    #[must_use]
    pub const fn slipped(self) -> bool {
        self.0 & Self::SLIP != 0
    }

    /// Whether the half cycle is unresolved.
    #[must_use]
    pub const fn half_cycle_unknown(self) -> bool {
        self.0 & Self::HALF_CYCLE != 0
    }
}

/// The measurements of one signal of one satellite at one epoch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SignalObservation {
    /// The signal tracked, which determines the carrier frequency.
    pub code: SignalCode,
    /// Pseudorange (m).
    pub pseudorange_m: Option<f64>,
    /// Carrier phase (cycles of this carrier), growing with range.
    pub phase_cycles: Option<f64>,
    /// Doppler shift (Hz), positive when approaching.
    pub doppler_hz: Option<f64>,
    /// Carrier-to-noise density (dB-Hz).
    pub cn0_db_hz: Option<f64>,
    /// Loss-of-lock bits of the phase; kept even where the phase itself is missing.
    pub loss_of_lock: LossOfLock,
}

impl SignalObservation {
    /// A signal without any measurement yet.
    #[must_use]
    pub const fn empty(code: SignalCode) -> Self {
        Self {
            code,
            pseudorange_m: None,
            phase_cycles: None,
            doppler_hz: None,
            cn0_db_hz: None,
            loss_of_lock: LossOfLock(0),
        }
    }
}

/// The measurements of one satellite at one epoch.
#[derive(Debug, Clone, PartialEq)]
pub struct SatelliteObservation {
    /// The satellite.
    pub satellite: SatelliteId,
    /// At most one signal per frequency slot (see [`SignalCode::slot`]).
    pub signals: [Option<SignalObservation>; FREQUENCY_SLOTS],
}

impl SatelliteObservation {
    /// A satellite without signals yet.
    #[must_use]
    pub const fn new(satellite: SatelliteId) -> Self {
        Self {
            satellite,
            signals: [None; FREQUENCY_SLOTS],
        }
    }

    /// The first available pseudorange, lowest slot first (m).
    #[must_use]
    pub fn first_pseudorange_m(&self) -> Option<f64> {
        self.signals.iter().flatten().find_map(|s| s.pseudorange_m)
    }
}

/// Everything measured at one time tag.
#[derive(Debug, Clone, PartialEq)]
pub struct ObservationEpoch {
    /// Receiver time tag in GPS time, as read (never rounded).
    pub time: GpsTime,
    /// The satellites in ascending order, each once.
    pub satellites: Vec<SatelliteObservation>,
}

/// Kind of recording of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum EventKind {
    /// RINEX event flag 5.
    External,
    /// Rising edge on the receiver's time-mark input.
    RisingEdge,
    /// Falling edge on the receiver's time-mark input.
    FallingEdge,
}

/// An external event (camera or radar trigger) that the receiver time-tagged.
#[derive(Debug, Clone, PartialEq)]
pub struct EventRecord {
    /// Time of the event in GPS time.
    pub time: GpsTime,
    /// Kind of recording.
    pub kind: EventKind,
    /// The receiver's running count of events, where it gives one.
    pub count: Option<u32>,
    /// The receiver's estimate of the tag's accuracy (s), where it gives one.
    pub accuracy_s: Option<f64>,
}

/// Antenna reference point above the marker, in local axes (m).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AntennaOffset {
    /// Height above the marker (m).
    pub up_m: f64,
    /// Eccentricity to the east (m).
    pub east_m: f64,
    /// Eccentricity to the north (m).
    pub north_m: f64,
}

/// The file's data on the receiver and its place.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StationInfo {
    /// Marker name, empty when not given.
    pub marker: String,
    /// Receiver type, empty when not given.
    pub receiver: String,
    /// Antenna type, empty when not given.
    pub antenna: String,
    /// Approximate position (ECEF, m); `None` when not given or all zero.
    pub position_ecef_m: Option<[f64; 3]>,
    /// Antenna offset from the marker.
    pub antenna_offset: AntennaOffset,
}

/// A receiver's log: station, epochs in time order and events.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ObservationData {
    /// Station description.
    pub station: StationInfo,
    /// GLONASS frequency channels given with the observations, by satellite number.
    pub glonass_channels: BTreeMap<u8, i8>,
    /// Epochs in ascending time order, tags at least [`EPOCH_TOLERANCE_S`] apart.
    pub epochs: Vec<ObservationEpoch>,
    /// Events in ascending time order.
    pub events: Vec<EventRecord>,
}
