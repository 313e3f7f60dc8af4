//! Place of a GNSS receiver by its own single-point positions, and whether it moved.

use std::path::Path;

use acerra_geo::geodesy::EnuFrame;
use acerra_geo::time::GpsTime;
use acerra_gnss::{
    Navigation, ObservationData, PositioningMode, PpkOptions, SatelliteObservation, Solution,
    process,
};

use super::logs::Receiver;

/// Epochs of a log that are positioned: enough for the mean of a place and the path of a flight.
const MOST_EPOCHS: usize = 240;

/// Data of a receiver's log on its place.
#[derive(Clone, Debug)]
pub(super) struct Place<'a> {
    pub path: &'a Path,
    /// First and last epoch.
    pub span: [GpsTime; 2],
    pub epochs: usize,
    /// Position in the log's header (ECEF, m).
    pub header_ecef_m: Option<[f64; 3]>,
    /// Result of single-point positions; none without navigation data.
    pub single: Option<SinglePoint>,
}

/// Single-point positions in short.
#[derive(Clone, Copy, Debug)]
pub(super) struct SinglePoint {
    /// Median position (ECEF, m).
    pub middle_ecef_m: [f64; 3],
    /// Lowest and highest coordinates to the east, north and up of it (m), gross errors left out.
    pub bounds_m: [[f64; 3]; 2],
    /// Positions in all.
    pub count: usize,
    /// Ninth decile of the horizontal distances from it (m).
    pub spread_m: f64,
    /// Ninth decile of the speeds (m/s), where the log has Doppler.
    pub speed_m_s: Option<f64>,
}

impl<'a> Place<'a> {
    pub(super) fn of(receiver: &'a Receiver, navigation: &Navigation) -> Option<Self> {
        let epochs = &receiver.observations.epochs;
        Some(Self {
            path: &receiver.path,
            span: [epochs.first()?.time, epochs.last()?.time],
            epochs: epochs.len(),
            header_ecef_m: receiver.observations.station.position_ecef_m,
            single: single_point(&receiver.observations, navigation),
        })
    }

    /// Time that two logs share (s).
    pub(super) fn overlap_s(&self, other: &Self) -> f64 {
        let latest = |a: GpsTime, b: GpsTime| if a - b > 0.0 { a } else { b };
        let earliest = |a: GpsTime, b: GpsTime| if a - b > 0.0 { b } else { a };
        let overlap_s = earliest(self.span[1], other.span[1]) - latest(self.span[0], other.span[0]);
        overlap_s.max(0.0)
    }
}

fn single_point(data: &ObservationData, navigation: &Navigation) -> Option<SinglePoint> {
    let step = data.epochs.len().div_ceil(MOST_EPOCHS).max(1);
    let some = ObservationData {
        station: data.station.clone(),
        glonass_channels: data.glonass_channels.clone(),
        epochs: data.epochs.iter().step_by(step).cloned().collect(),
        events: Vec::new(),
    };
    let options = PpkOptions::default().with_mode(PositioningMode::Single);
    let solution = process(&some, &ObservationData::default(), navigation, &options).ok()?;
    summary(&solution.epochs)
}

fn summary(epochs: &[Solution]) -> Option<SinglePoint> {
    let axis = |k: usize| quantile(epochs.iter().map(|e| e.position_ecef_m[k]).collect(), 0.5);
    let middle_ecef_m = [axis(0)?, axis(1)?, axis(2)?];
    let frame = EnuFrame::from_ecef(middle_ecef_m);
    let places: Vec<[f64; 3]> = epochs
        .iter()
        .map(|e| frame.enu_from_ecef(e.position_ecef_m))
        .collect();
    let end = |share: f64| -> Option<[f64; 3]> {
        let along = |k: usize| quantile(places.iter().map(|p| p[k]).collect(), share);
        Some([along(0)?, along(1)?, along(2)?])
    };
    let away = places.iter().map(|[east, north, _]| east.hypot(*north));
    let speeds = epochs
        .iter()
        .filter_map(|e| e.velocity_ecef_m_s)
        .map(|[x, y, z]| x.hypot(y).hypot(z));
    Some(SinglePoint {
        middle_ecef_m,
        bounds_m: [end(0.02)?, end(0.98)?],
        count: places.len(),
        spread_m: quantile(away.collect(), 0.9)?,
        speed_m_s: quantile(speeds.collect(), 0.9),
    })
}

fn quantile(mut values: Vec<f64>, share: f64) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a share of a count"
    )]
    let index = (share * values.len().saturating_sub(1) as f64).round() as usize;
    values.get(index).copied()
}

/// Largest difference of one epoch's tags in two formats (s).
const SAME_TAG_S: f64 = 1e-6;
/// Largest difference of one satellite's ranges in two formats (m): RINEX has whole millimetres.
const SAME_RANGE_M: f64 = 0.01;
/// Number of equal ranges that excludes chance.
const ENOUGH_RANGES: usize = 12;

/// Whether two logs are of one receiver in two formats: at common epochs equal satellites and ranges, up to
/// rounding.
pub(super) fn is_same(a: &ObservationData, b: &ObservationData) -> bool {
    let mut others = b.epochs.iter().peekable();
    let mut equal = 0;
    for epoch in &a.epochs {
        while others
            .next_if(|other| other.time - epoch.time < -SAME_TAG_S)
            .is_some()
        {}
        let Some(other) = others.peek().filter(|o| o.time - epoch.time < SAME_TAG_S) else {
            continue;
        };
        for satellite in &epoch.satellites {
            let same = other
                .satellites
                .iter()
                .find(|s| s.satellite == satellite.satellite);
            match (first_range_m(satellite), same.and_then(first_range_m)) {
                (Some(range), Some(other)) if (range - other).abs() > SAME_RANGE_M => return false,
                (Some(_), Some(_)) => equal += 1,
                _ => {}
            }
        }
        if equal >= ENOUGH_RANGES {
            return true;
        }
    }
    false
}

fn first_range_m(satellite: &SatelliteObservation) -> Option<f64> {
    let signals = satellite.signals.iter().flatten();
    signals.into_iter().find_map(|signal| signal.pseudorange_m)
}
