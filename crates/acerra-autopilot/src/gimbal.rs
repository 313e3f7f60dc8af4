//! Attitudes of gimbals: roll and pitch from the horizon, yaw from north or from the vehicle's nose.
//!
//! A gimbal's axes are forward, right, down as its maker defines them: those of the vehicle while all its
//! angles are zero. Logs give the turn from these to north, east, down, or to the same axes turned about the
//! vertical to where the vehicle's nose points ("vehicle frame" of MAVLink's gimbal protocol). The flags of
//! angles held against the horizon (`ROLL_LOCK`, `PITCH_LOCK`) describe how the gimbal is driven, not the
//! reference of its angles.

use acerra_geo::trajectory::Attitude;

use crate::clock::ClockFit;
use crate::sample::{AttitudeSample, AttitudeSource, GimbalSample, GimbalSource, Stamp, YawFrom};
use crate::timeline::{AttitudeTrack, gps_time};

/// Bits of `GIMBAL_DEVICE_FLAGS` with the reference of the yaw.
mod flag {
    pub const YAW_LOCK: i64 = 16;
    pub const YAW_IN_VEHICLE_FRAME: i64 = 32;
    pub const YAW_IN_EARTH_FRAME: i64 = 64;
}

/// Bits of `GIMBAL_DEVICE_ERROR_FLAGS` that put the attitude in doubt: encoders, software, communication,
/// calibration. The bits of limits, power and motors mean that the gimbal does not follow its commands.
const DOUBTED: i64 = 8 | 64 | 128 | 256;

impl From<&AttitudeSource> for GimbalSource {
    fn from(source: &AttitudeSource) -> Self {
        let sample = |s: &AttitudeSample| GimbalSample::new(s.stamp, s.attitude, YawFrom::North);
        Self {
            name: source.name.clone(),
            rank: source.rank,
            samples: source.samples.iter().map(sample).collect(),
            without_attitude: 0,
        }
    }
}

/// Fields of a gimbal device's status, as MAVLink (`GIMBAL_DEVICE_ATTITUDE_STATUS`) and PX4
/// (`gimbal_device_attitude_status`) give them.
#[derive(Debug, Clone, Copy)]
pub struct DeviceStatus {
    /// `GIMBAL_DEVICE_FLAGS`.
    pub flags: i64,
    /// `GIMBAL_DEVICE_ERROR_FLAGS`.
    pub failures: i64,
    /// Quaternion w, x, y, z.
    pub quaternion: [f64; 4],
    /// Heading of the vehicle's nose (rad), by which the attitude from the nose becomes that from north. Zero as
    /// good as absent: senders of older definitions leave it so.
    pub delta_yaw_rad: f64,
}

impl DeviceStatus {
    /// The attitude at `stamp`; none without a quaternion, or with flags that contradict each other.
    pub fn sample(self, stamp: Stamp) -> Option<GimbalSample> {
        let has = |bit| self.flags & bit != 0;
        let (in_vehicle, in_earth) = (
            has(flag::YAW_IN_VEHICLE_FRAME),
            has(flag::YAW_IN_EARTH_FRAME),
        );
        let yaw = match (in_vehicle, in_earth) {
            (true, true) => return None,
            (true, false) => YawFrom::Nose,
            (false, true) => YawFrom::North,
            // Senders older than these two flags.
            (false, false) if has(flag::YAW_LOCK) => YawFrom::North,
            (false, false) => YawFrom::Nose,
        };
        let attitude = Attitude::from_frd_to_ned(self.quaternion)?;
        let is_told = self.delta_yaw_rad.is_finite() && self.delta_yaw_rad != 0.0;
        let (attitude, yaw) = if in_vehicle && is_told {
            (
                turned_clockwise(&attitude, self.delta_yaw_rad),
                YawFrom::North,
            )
        } else {
            (attitude, yaw)
        };
        Some(GimbalSample {
            is_doubted: self.failures & DOUBTED != 0,
            ..GimbalSample::new(stamp, attitude, yaw)
        })
    }
}

/// The attitude turned about the vertical, clockwise seen from above.
fn turned_clockwise(attitude: &Attitude, angle_rad: f64) -> Attitude {
    let (sine, cosine) = angle_rad.sin_cos();
    attitude.turned_by(&[[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
}

/// Attitudes of a gimbal on GPS time, against north.
#[derive(Debug, Clone, Default)]
pub struct GimbalTrack {
    /// The attitudes.
    pub track: AttitudeTrack,
    /// Attitudes of a yaw from the nose at times where no attitude of the vehicle shows where it pointed.
    pub without_heading: usize,
}

impl GimbalTrack {
    /// The samples on GPS time, those from the nose turned by the vehicle's heading, of its attitudes `body`.
    pub fn new(
        samples: &[GimbalSample],
        clock: Option<&ClockFit>,
        body: Option<&AttitudeTrack>,
    ) -> Self {
        let mut without_heading = 0;
        let mut resolved = Vec::with_capacity(samples.len());
        for sample in samples {
            let Some(time) = gps_time(sample.stamp, clock) else {
                continue;
            };
            let attitude = match sample.yaw {
                YawFrom::North => Some(sample.attitude),
                YawFrom::Nose => body
                    .and_then(|body| body.at(time))
                    .map(|vehicle| turned_clockwise(&sample.attitude, heading_rad(&vehicle))),
            };
            match attitude {
                Some(attitude) => resolved.push(AttitudeSample {
                    stamp: Stamp::Gps(time),
                    attitude,
                }),
                None => without_heading += 1,
            }
        }
        Self {
            track: AttitudeTrack::new(&resolved, clock),
            without_heading,
        }
    }
}

/// Where the nose points over the ground (rad), clockwise from north.
fn heading_rad(attitude: &Attitude) -> f64 {
    let [east, north, _] = attitude.rotate([1.0, 0.0, 0.0]);
    east.atan2(north)
}

#[cfg(test)]
mod tests {
    use super::*;

    const STATUS: DeviceStatus = DeviceStatus {
        flags: 0,
        failures: 0,
        quaternion: [1.0, 0.0, 0.0, 0.0],
        delta_yaw_rad: f64::NAN,
    };

    fn found(status: DeviceStatus) -> Option<(YawFrom, f64)> {
        let sample = status.sample(Stamp::Boot(0.0))?;
        Some((sample.yaw, heading_rad(&sample.attitude)))
    }

    #[test]
    fn flags_say_what_yaw_counts_from_and_contradictions_are_refused() {
        // Locks of roll and pitch (4, 8) have no effect.
        for (flags, yaw) in [
            (0, YawFrom::Nose),
            (4 | 8, YawFrom::Nose),
            (16, YawFrom::North),
            (4 | 8 | 16, YawFrom::North),
            (32, YawFrom::Nose),
            // Held against north, stated against the nose.
            (16 | 32, YawFrom::Nose),
            (64, YawFrom::North),
        ] {
            let (yaw_found, heading_rad) = found(DeviceStatus { flags, ..STATUS }).unwrap();
            assert_eq!(
                (yaw_found, heading_rad.abs() < 1e-12),
                (yaw, true),
                "{flags}"
            );
        }
        assert_eq!(
            found(DeviceStatus {
                flags: 32 | 64,
                ..STATUS
            }),
            None
        );
        let quaternion = [f64::NAN, 0.0, 0.0, 0.0];
        assert_eq!(
            found(DeviceStatus {
                quaternion,
                ..STATUS
            }),
            None
        );
    }

    #[test]
    fn the_sender_s_heading_counts_only_beside_the_flag_that_gives_it_a_meaning() {
        let yaw_of = |flags, delta_yaw_rad| {
            found(DeviceStatus {
                flags,
                delta_yaw_rad,
                ..STATUS
            })
            .unwrap()
        };
        let (yaw, heading_rad) = yaw_of(32, 0.7);
        assert!(yaw == YawFrom::North && (heading_rad - 0.7).abs() < 1e-12);
        assert_eq!(yaw_of(32, 0.0).0, YawFrom::Nose);
        let (yaw, heading_rad) = yaw_of(0, 0.7);
        assert!(yaw == YawFrom::Nose && heading_rad.abs() < 1e-12);
    }

    #[test]
    fn only_failures_of_the_sensing_put_the_attitude_in_doubt() {
        for (failures, is_doubted) in [(0, false), (2, false), (32, false), (8, true), (129, true)]
        {
            let status = DeviceStatus { failures, ..STATUS };
            let sample = status.sample(Stamp::Boot(0.0)).unwrap();
            assert_eq!(sample.is_doubted, is_doubted, "{failures}");
        }
    }

    #[test]
    fn a_yaw_from_the_nose_is_turned_by_the_heading_and_keeps_its_tilt() {
        let body = AttitudeSample {
            stamp: Stamp::Boot(1.0),
            attitude: Attitude::from_euler([0.3, -0.2, 1.1]).unwrap(),
        };
        let clock = ClockFit::own();
        let body = AttitudeTrack::new(&[body], Some(&clock));
        let level = Attitude::from_euler([0.1, 0.2, 0.4]).unwrap();
        let samples = [1.0, 9.0].map(|s| GimbalSample::new(Stamp::Boot(s), level, YawFrom::Nose));
        let found = GimbalTrack::new(&samples, Some(&clock), Some(&body));
        assert_eq!(found.without_heading, 1);
        let time = clock.gps_at(1.0);
        let expected = Attitude::from_euler([0.1, 0.2, 1.5]).unwrap();
        assert!(found.track.at(time).unwrap().angle_to(&expected) < 1e-7);
        assert_eq!(
            GimbalTrack::new(&samples, Some(&clock), None).without_heading,
            2
        );
    }
}
