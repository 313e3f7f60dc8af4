//! The satellites of a track's GNSS log: where they were, and how strongly they were received.

use acerra_chain::Track;
use acerra_chain::campaign::Campaign;
use acerra_chain::position::PositionSource;
use acerra_chain::position::positioning::{PositioningInput, sky};
use acerra_geo::geodesy::EnuFrame;
use acerra_geo::time::GpsTime;
use acerra_gnss::{FREQUENCY_SLOTS, SatelliteInSky, SkySample};
use serde::Serialize;

use crate::engine::work::Current;
use crate::error::{EngineError, RequestError};

/// Shortest time between samples of a satellite (s): a satellite moves by less than 0.01° in it.
const INTERVAL_S: f64 = 1.0;

/// The satellites of a track's log on the radar's clock.
#[derive(Clone, Debug, Serialize)]
pub struct TrackSky {
    satellites: Vec<Satellite>,
}

/// A satellite: one entry a sample in every list.
#[derive(Clone, Debug, Serialize)]
struct Satellite {
    /// As in RINEX: `G05`.
    name: String,
    /// Radar time (s).
    time_s: Vec<f64>,
    /// Azimuth from north over east and elevation (degrees); null without ephemeris.
    direction_deg: Vec<Option<[f64; 2]>>,
    /// C/N₀ (dB-Hz) of the frequency slots L1, L2 and L5.
    cn0_db_hz: Vec<[Option<f64>; FREQUENCY_SLOTS]>,
}

impl TrackSky {
    /// The sky of track `number`.
    ///
    /// # Errors
    /// No such track, or one whose positions are not of a GNSS log; a file that cannot be read.
    pub fn of(current: &Current, number: usize) -> Result<Self, RequestError> {
        let absent = RequestError::Absent { what: "sky" };
        let tracks = &current.prepared.tracks;
        let Some(track) = tracks.get(number) else {
            return Err(absent);
        };
        let Some((input, frame, zero)) = log_of(&current.campaign, track, number) else {
            return Err(absent);
        };
        let middle = (track.range.start + track.range.end) / 2;
        let place_m = current.prepared.aligned.position_m.get(middle);
        let place_ecef_m = frame.ecef_from_enu(*place_m.ok_or(absent)?);
        let satellites = sky(&input, place_ecef_m, INTERVAL_S)
            .map_err(|error| EngineError::Chain(error.to_string()))?;
        let radar_time_s = |time: GpsTime| time - zero - track.time_offset_s;
        Ok(Self {
            satellites: satellites
                .iter()
                .map(|one| Satellite::of(one, radar_time_s))
                .collect(),
        })
    }
}

impl Satellite {
    fn of(one: &SatelliteInSky, radar_time_s: impl Fn(GpsTime) -> f64) -> Self {
        let in_degrees = |sample: &SkySample| {
            let direction_rad = sample.azimuth_elevation_rad?;
            Some(direction_rad.map(f64::to_degrees))
        };
        Self {
            name: one.satellite.to_string(),
            time_s: one.samples.iter().map(|s| radar_time_s(s.time)).collect(),
            direction_deg: one.samples.iter().map(in_degrees).collect(),
            cn0_db_hz: one.samples.iter().map(|s| s.cn0_db_hz).collect(),
        }
    }
}

/// Whether track `number` has a sky to show.
pub fn has_sky(current: &Current, number: usize) -> bool {
    let track = current.prepared.tracks.get(number);
    track.is_some_and(|track| log_of(&current.campaign, track, number).is_some())
}

/// The GNSS files of a track, the frame of its positions and the instant at which their clock is zero; none where the
/// positions come from elsewhere.
fn log_of(
    campaign: &Campaign,
    track: &Track,
    number: usize,
) -> Option<(PositioningInput, EnuFrame, GpsTime)> {
    let survey = campaign.survey();
    let PositionSource::Gnss(logs) = &survey.tracks.get(number)?.positions.source else {
        return None;
    };
    let frame = track.positions.earth_frame()?;
    let zero = track.positions.time_origin().gps_time()?;
    Some((logs.files.clone(), frame, zero))
}
