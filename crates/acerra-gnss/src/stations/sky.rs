//! The sky of a log: direction and signal strength of every satellite over time.

use acerra_geo::geodesy::EnuFrame;
use acerra_geo::time::GpsTime;
use std::collections::BTreeMap;

use crate::measurements::constellation::Constellation;
use crate::observations::observation::{EPOCH_TOLERANCE_S, ObservationData, SatelliteObservation};
use crate::observations::satellite::{SatelliteId, SystemSet};
use crate::observations::signal::FREQUENCY_SLOTS;
use crate::options::PpkOptions;
use crate::orbits::geometry::{azimuth_elevation_rad, line_of_sight};
use crate::orbits::navigation::Navigation;

/// A satellite of a receiver's log.
#[derive(Clone, Debug, PartialEq)]
pub struct SatelliteInSky {
    /// The satellite.
    pub satellite: SatelliteId,
    /// In time order, one sample for each epoch that holds the satellite.
    pub samples: Vec<SkySample>,
}

/// Direction and signal strength of a satellite at an epoch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkySample {
    /// The epoch's time tag.
    pub time: GpsTime,
    /// Azimuth from north over east in \[0, 2π) and elevation (rad); `None` without a pseudorange or a usable
    /// ephemeris.
    pub azimuth_elevation_rad: Option<[f64; 2]>,
    /// Carrier-to-noise density of each frequency slot (dB-Hz).
    pub cn0_db_hz: [Option<f64>; FREQUENCY_SLOTS],
}

/// Direction and signal strength of every satellite of a log, at epochs at least `interval_s` apart, seen
/// from a place within some hundred metres of the receiver, where directions differ by less than 0.001°.
///
/// Satellites are in ascending order, of all systems. Ephemerides are chosen as for a position.
#[must_use]
pub fn sky(
    log: &ObservationData,
    navigation: &Navigation,
    place_ecef_m: [f64; 3],
    interval_s: f64,
) -> Vec<SatelliteInSky> {
    let options = PpkOptions::default().with_systems(SystemSet::ALL);
    let constellation = Constellation::new(log, None, navigation, &options);
    let frame = EnuFrame::from_ecef(place_ecef_m);
    let direction = |seen: &SatelliteObservation, time: GpsTime| {
        let index = constellation.index(seen.satellite)?;
        let pseudorange_m = seen.first_pseudorange_m()?;
        let state = constellation
            .state(index, time, time, pseudorange_m, false)
            .ok()?;
        let line = line_of_sight(state.position_ecef_m, place_ecef_m)?;
        let (azimuth_rad, elevation_rad) = azimuth_elevation_rad(&frame, line.unit_ecef);
        Some([azimuth_rad, elevation_rad])
    };
    let mut satellites: BTreeMap<SatelliteId, Vec<SkySample>> = BTreeMap::new();
    let mut last: Option<GpsTime> = None;
    for epoch in &log.epochs {
        if last.is_some_and(|last| epoch.time - last < interval_s - EPOCH_TOLERANCE_S) {
            continue;
        }
        last = Some(epoch.time);
        for seen in &epoch.satellites {
            let sample = SkySample {
                time: epoch.time,
                azimuth_elevation_rad: direction(seen, epoch.time),
                cn0_db_hz: seen.signals.map(|signal| signal?.cn0_db_hz),
            };
            satellites.entry(seen.satellite).or_default().push(sample);
        }
    }
    satellites
        .into_iter()
        .map(|(satellite, samples)| SatelliteInSky { satellite, samples })
        .collect()
}
