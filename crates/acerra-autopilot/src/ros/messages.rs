//! Contents of the messages `sensor_msgs/NavSatFix`, `sensor_msgs/Imu`, `nav_msgs/Odometry` and
//! `geometry_msgs/QuaternionStamped` of ROS 2 (common_interfaces), in the frames of REP 103 and REP 145.

use acerra_geo::trajectory::{Attitude, SolutionStatus};

use super::cdr::Cdr;
use crate::sample::{
    AttitudeSample, HeightDatum, Place, PositionSample, Stamp, gps_time_of_unix_us,
};

/// A message that matters here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// `sensor_msgs/msg/NavSatFix`.
    NavSatFix,
    /// `nav_msgs/msg/Odometry`.
    Odometry,
    /// `sensor_msgs/msg/Imu`.
    Imu,
    /// `geometry_msgs/msg/QuaternionStamped`.
    Quaternion,
}

impl Kind {
    /// The message whose schema has that name.
    pub fn named(schema: &str) -> Option<Self> {
        Some(match schema {
            "sensor_msgs/msg/NavSatFix" => Self::NavSatFix,
            "nav_msgs/msg/Odometry" => Self::Odometry,
            "sensor_msgs/msg/Imu" => Self::Imu,
            "geometry_msgs/msg/QuaternionStamped" => Self::Quaternion,
            _ => return None,
        })
    }
}

/// The stamp of a header. A stamp that counts from 1970 is UTC; any other counts from an unknown start
/// (simulated time).
fn stamp(cdr: &mut Cdr<'_>) -> Option<Stamp> {
    let (seconds, nanos) = (cdr.i32()?, cdr.u32()?);
    cdr.skip_text()?;
    if nanos >= 1_000_000_000 {
        return None;
    }
    let micros = i64::from(seconds) * 1_000_000;
    Some(match gps_time_of_unix_us(micros) {
        Some(time) => Stamp::Gps(time + f64::from(nanos) * 1e-9),
        None => Stamp::Boot(f64::from(seconds) + f64::from(nanos) * 1e-9),
    })
}

/// Outcome of a message: none where the message is cut short or of an unknown encoding.
pub type Read<T> = Option<Option<T>>;

/// The position of a `NavSatFix`, whose height counts from the ellipsoid.
///
/// Its status 2 is any solution with a base on the ground: fixed, float and code are one.
pub fn fix(message: &[u8]) -> Read<PositionSample> {
    let mut cdr = Cdr::new(message)?;
    let stamp = stamp(&mut cdr)?;
    let status = cdr.u8()?.cast_signed();
    cdr.u16()?;
    let [latitude_deg, longitude_deg, height_m] = cdr.f64s()?;
    let covariance: [f64; 9] = cdr.f64s()?;
    let is_known = cdr.u8()? > 0;
    let status = match status {
        0 => SolutionStatus::Single,
        1 => SolutionStatus::Sbas,
        2 => SolutionStatus::Dgps,
        _ => return Some(None),
    };
    let place = Place::on_earth(
        [latitude_deg, longitude_deg, height_m],
        HeightDatum::Ellipsoid,
    );
    Some(place.map(|place| PositionSample {
        stamp,
        arrival_s: None,
        place,
        sigma_m: deviations(&covariance, [0, 4, 8]).filter(|_| is_known),
        velocity_m_s: None,
        status: Some(status),
        satellites: None,
    }))
}

/// Position and attitude of an `Odometry`, in its local frame: x forward, y left, z up at its start, or east,
/// north, up.
pub fn odometry(message: &[u8]) -> Read<(PositionSample, Option<AttitudeSample>)> {
    let mut cdr = Cdr::new(message)?;
    let stamp = stamp(&mut cdr)?;
    cdr.skip_text()?;
    let position_m: [f64; 3] = cdr.f64s()?;
    let quaternion = cdr.f64s()?;
    let covariance: [f64; 36] = cdr.f64s()?;
    if !position_m.iter().all(|v| v.is_finite()) {
        return Some(None);
    }
    let position = PositionSample {
        stamp,
        arrival_s: None,
        place: Place::Local(position_m),
        sigma_m: deviations(&covariance, [0, 7, 14]),
        velocity_m_s: None,
        status: None,
        satellites: None,
    };
    Some(Some((position, attitude(stamp, quaternion))))
}

/// The attitude of an `Imu`; none where the message declares it absent.
pub fn imu(message: &[u8]) -> Read<AttitudeSample> {
    let mut cdr = Cdr::new(message)?;
    let stamp = stamp(&mut cdr)?;
    let quaternion = cdr.f64s()?;
    let first_covariance = cdr.f64()?;
    let has_orientation = first_covariance >= 0.0;
    Some(attitude(stamp, quaternion).filter(|_| has_orientation))
}

/// The attitude of a `QuaternionStamped`.
pub fn quaternion(message: &[u8]) -> Read<AttitudeSample> {
    let mut cdr = Cdr::new(message)?;
    let stamp = stamp(&mut cdr)?;
    let quaternion = cdr.f64s()?;
    Some(attitude(stamp, quaternion))
}

/// From x, y, z, w: it takes forward, left, up to east, north, up, as ours does.
fn attitude(stamp: Stamp, [x, y, z, w]: [f64; 4]) -> Option<AttitudeSample> {
    let attitude = Attitude::from_quaternion(w, x, y, z)?;
    Some(AttitudeSample { stamp, attitude })
}

fn deviations(covariance: &[f64], diagonal: [usize; 3]) -> Option<[f64; 3]> {
    let variances = diagonal.map(|k| covariance.get(k).copied().unwrap_or(0.0));
    let is_told = variances.iter().all(|v| v.is_finite() && *v > 0.0);
    is_told.then(|| variances.map(f64::sqrt))
}
