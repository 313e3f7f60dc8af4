//! From a place to its echoes in the radargram, and from an echo to the places that may have made it.
//!
//! The delay convention is the chain's: after cleaning, the echo of a place at range R lies at fast time
//! 2R/c, later by the delay of its track's instrument (`[[track]] delay_ns` and the delay by the common
//! target), which is removed from the spectra alone.

use acerra_chain::{Prepared, Track};
use serde::Serialize;

use super::work::Current;
use crate::error::RequestError;
use crate::run::{Seen, range_and_incidence};

/// The echoes of a place, pulse by pulse.
#[derive(Clone, Debug, Serialize)]
pub struct Hyperbola {
    /// The place: east, north, up (m).
    pub place_m: [f64; 3],
    /// Fast time at each pulse of all tracks (ns).
    pub fast_time_ns: Vec<f64>,
    /// Angle of incidence on level ground at each pulse (degrees).
    pub incidence_deg: Vec<f64>,
    /// The pulse nearest to the place.
    pub apex: Option<usize>,
}

/// The places on the ground whose echo arrives with a given one.
#[derive(Clone, Debug, Serialize)]
pub struct Ring {
    /// The pulse.
    pub pulse: usize,
    /// Range (m).
    pub range_m: f64,
    /// Angle of incidence on level ground there (degrees); none where the ring is empty.
    pub incidence_deg: Option<f64>,
    /// Places on the ground at that range: east, north, up (m), a closed line; empty where the ground
    /// is farther than the range.
    pub places_m: Vec<[f64; 3]>,
}

/// Delay of a track's echoes after 2R/c (s).
fn delay_s(track: &Track) -> f64 {
    let calibration = &track.calibration;
    let found_ns = calibration.found.map_or(0.0, |found| found.delay_ns);
    1e-9 * (calibration.given_delay_ns + found_ns)
}

/// The track of a pulse.
fn track_of(prepared: &Prepared, pulse: usize) -> Option<&Track> {
    let mut tracks = prepared.tracks.iter();
    tracks.find(|track| track.range.contains(&pulse))
}

/// The echoes of a place: refracted below the ground of the run, along both ways where antennas are apart.
///
/// # Errors
/// A ground that no ray can be traced through.
pub fn hyperbola(current: &Current, place_m: [f64; 3]) -> Result<Hyperbola, RequestError> {
    let prepared = &current.prepared;
    let pixels = prepared.scene.pixels.clone();
    let request = current.campaign.image_request(pixels);
    let half_m = prepared
        .half_ways_m(&request, place_m)
        .map_err(|error| RequestError::Image(error.into()))?;
    let mut fast_time_ns = Vec::with_capacity(half_m.len());
    for track in &prepared.tracks {
        let delay_s = delay_s(track);
        let own = half_m[track.range.clone()].iter();
        let speed_m_s = prepared.scene.light_speed_m_s;
        fast_time_ns.extend(own.map(|half_m| 1e9 * (2.0 * half_m / speed_m_s + delay_s)));
    }
    let nearest = (half_m.iter().enumerate()).min_by(|(_, a), (_, b)| a.total_cmp(b));
    let incidence = |position_m: &[f64; 3]| range_and_incidence(*position_m, place_m)[1];
    Ok(Hyperbola {
        place_m,
        fast_time_ns,
        apex: nearest.map(|(pulse, _)| pulse),
        incidence_deg: prepared.aligned.position_m.iter().map(incidence).collect(),
    })
}

/// A place as a pulse sees it.
///
/// # Errors
/// No such pulse.
pub fn seen_from(
    prepared: &Prepared,
    pulse: usize,
    place_m: [f64; 3],
) -> Result<Seen, RequestError> {
    let aligned = &prepared.aligned;
    match (aligned.position_m.get(pulse), aligned.traces.get(pulse)) {
        (Some(position_m), Some(trace)) => Ok(Seen::from(*position_m, *trace as f64, place_m)),
        _ => Err(RequestError::Absent { what: "pulse" }),
    }
}

/// Corners of a ring.
const CORNERS: u32 = 360;
/// Steps by which a corner finds its range on uneven ground.
const STEPS: usize = 40;

/// The places on the ground whose echo arrives at a pulse at a fast time.
///
/// # Errors
/// No such pulse.
pub fn ring(prepared: &Prepared, pulse: usize, fast_time_ns: f64) -> Result<Ring, RequestError> {
    let absent = RequestError::Absent { what: "pulse" };
    let (Some(position_m), Some(track)) = (
        prepared.aligned.position_m.get(pulse),
        track_of(prepared, pulse),
    ) else {
        return Err(absent);
    };
    let range_m = 0.5 * prepared.scene.light_speed_m_s * (1e-9 * fast_time_ns - delay_s(track));
    let corners = 0..=CORNERS;
    let places_m: Option<Vec<[f64; 3]>> = corners
        .map(|k| {
            let azimuth_rad = f64::from(k % CORNERS).to_radians() * (360.0 / f64::from(CORNERS));
            corner(prepared, *position_m, range_m, azimuth_rad)
        })
        .collect();
    let places_m = places_m.unwrap_or_default();
    Ok(Ring {
        pulse,
        range_m,
        incidence_deg: places_m
            .first()
            .map(|place_m| range_and_incidence(*position_m, *place_m)[1]),
        places_m,
    })
}

/// The outermost place on the ground at a range in a direction, found by bisection of the distance
/// across; none where the ground below the antenna is farther than the range.
fn corner(
    prepared: &Prepared,
    position_m: [f64; 3],
    range_m: f64,
    azimuth_rad: f64,
) -> Option<[f64; 3]> {
    let (sin, cos) = azimuth_rad.sin_cos();
    let place = |across_m: f64| {
        let (x_m, y_m) = (
            position_m[0] + across_m * cos,
            position_m[1] + across_m * sin,
        );
        [x_m, y_m, prepared.scene.ground.below_m(x_m, y_m)]
    };
    let beyond = |across_m: f64| range_and_incidence(position_m, place(across_m))[0] - range_m;
    // At this distance the range is reached at the latest.
    let (mut near_m, mut far_m) = (0.0, range_m);
    if !range_m.is_finite() || beyond(near_m) > 0.0 {
        return None;
    }
    for _ in 0..STEPS {
        let middle_m = 0.5 * (near_m + far_m);
        if beyond(middle_m) > 0.0 {
            far_m = middle_m;
        } else {
            near_m = middle_m;
        }
    }
    Some(place(0.5 * (near_m + far_m)))
}
