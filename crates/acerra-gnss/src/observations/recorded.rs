//! Epochs as recorded, with every signal, before one signal per frequency slot is chosen.

use acerra_geo::time::GpsTime;

use super::observation::SignalObservation;
use super::satellite::SatelliteId;

/// Everything a receiver recorded at one time tag.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedEpoch {
    /// Receiver time tag in GPS time, as read.
    pub time: GpsTime,
    /// Receiver clock offset (s), where the file gives one.
    pub receiver_clock_s: Option<f64>,
    /// The satellites in the file's order, each once.
    pub satellites: Vec<RecordedSatellite>,
}

/// All signals of one satellite at one epoch.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedSatellite {
    /// The satellite.
    pub satellite: SatelliteId,
    /// The signals that have at least one value or indicator, in the file's order.
    pub signals: Vec<SignalObservation>,
}

/// Adds a signal to its satellite; the first of two equal signals of an epoch is kept.
pub(crate) fn add_signal(
    satellites: &mut Vec<RecordedSatellite>,
    satellite: SatelliteId,
    signal: SignalObservation,
) {
    match satellites.iter_mut().find(|s| s.satellite == satellite) {
        Some(known) if known.signals.iter().any(|s| s.code == signal.code) => {}
        Some(known) => known.signals.push(signal),
        None => satellites.push(RecordedSatellite {
            satellite,
            signals: vec![signal],
        }),
    }
}
