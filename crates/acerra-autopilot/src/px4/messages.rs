//! Contents of the messages (PX4, `msg/SensorGps.msg`, `msg/VehicleGlobalPosition.msg`,
//! `msg/VehicleAttitude.msg`, `msg/GimbalDeviceAttitudeStatus.msg`; before version 1.14 latitudes are whole
//! 1e-7 degrees, heights whole mm).

use acerra_geo::time::GpsTime;
use acerra_geo::trajectory::{Attitude, SolutionStatus};

use super::definitions::Fields;
use crate::gimbal::DeviceStatus;
use crate::sample::{
    AttitudeSample, ClockPair, GimbalSample, HeightDatum, Place, PositionSample, Stamp, Teller,
    gps_time_of_unix_us,
};

/// A message with the places of its fields.
#[derive(Debug, Clone, Copy)]
pub struct Message<'a> {
    /// Offsets of the fields.
    pub fields: &'a Fields,
    /// Bytes.
    pub bytes: &'a [u8],
}

impl Message<'_> {
    fn number(&self, name: &str) -> Option<f64> {
        self.fields.number(self.bytes, name)
    }

    fn integer(&self, name: &str) -> Option<i64> {
        self.fields.integer(self.bytes, name)
    }

    /// The autopilot's clock (s) when the message was made.
    fn boot_s(&self) -> Option<f64> {
        self.integer("timestamp").map(|us| us as f64 * 1e-6)
    }

    /// The autopilot's clock (s) at the instant the message is about.
    fn sample_s(&self) -> Option<f64> {
        let sample = self.integer("timestamp_sample").filter(|us| *us > 0);
        sample.map(|us| us as f64 * 1e-6).or_else(|| self.boot_s())
    }

    fn gps_time(&self) -> Option<GpsTime> {
        gps_time_of_unix_us(self.integer("time_utc_usec")?)
    }

    /// The field `name`, or where the log is older `scale` times the whole number `old`.
    fn scaled(&self, name: &str, old: &str, scale: f64) -> Option<f64> {
        let value = self.number(name);
        value.or_else(|| self.integer(old).map(|v| v as f64 * scale))
    }

    /// The position of a receiver; none without a fix in three dimensions or its time.
    pub fn gnss_position(&self) -> Option<PositionSample> {
        let status = match self.integer("fix_type")? {
            3 => SolutionStatus::Single,
            4 => SolutionStatus::Dgps,
            5 => SolutionStatus::Float,
            6 => SolutionStatus::Fixed,
            8 => SolutionStatus::Unknown,
            _ => return None,
        };
        let latitude_deg = self.scaled("latitude_deg", "lat", 1e-7)?;
        let longitude_deg = self.scaled("longitude_deg", "lon", 1e-7)?;
        let above_sea_m = self.scaled("altitude_msl_m", "alt", 1e-3)?;
        // Drivers that do not know it leave zero.
        let above_ellipsoid_m = self.scaled("altitude_ellipsoid_m", "alt_ellipsoid", 1e-3);
        let place = place(
            [latitude_deg, longitude_deg],
            above_sea_m,
            above_ellipsoid_m.filter(|m| *m != 0.0),
        )?;
        Some(PositionSample {
            stamp: Stamp::Gps(self.gps_time()?),
            arrival_s: self.boot_s(),
            place,
            sigma_m: self.sigma_m(),
            velocity_m_s: self.velocity_m_s(),
            status: Some(status),
            satellites: self
                .integer("satellites_used")
                .and_then(|n| u16::try_from(n).ok()),
        })
    }

    /// `eph` is used for each horizontal axis, of which it is an upper bound.
    fn sigma_m(&self) -> Option<[f64; 3]> {
        let (across_m, up_m) = (self.number("eph")?, self.number("epv")?);
        (across_m > 0.0 && up_m > 0.0).then_some([across_m, across_m, up_m])
    }

    fn velocity_m_s(&self) -> Option<[f64; 3]> {
        if self.integer("vel_ned_valid") == Some(0) {
            return None;
        }
        let [north, east, down] = ["vel_n_m_s", "vel_e_m_s", "vel_d_m_s"].map(|n| self.number(n));
        Some([east?, north?, -down?])
    }

    /// The autopilot's clock and GPS time.
    pub fn clock_pair(&self) -> Option<ClockPair> {
        let has_fix = self.integer("fix_type")? >= 3;
        Some(ClockPair {
            boot_s: self.boot_s().filter(|_| has_fix)?,
            gps: self.gps_time()?,
        })
    }

    /// The position of the autopilot's filter.
    pub fn filter_position(&self) -> Option<PositionSample> {
        let is_valid = |name| self.integer(name) != Some(0);
        if !(is_valid("lat_lon_valid") && is_valid("alt_valid")) {
            return None;
        }
        let above_ellipsoid_m = self.number("alt_ellipsoid").filter(|m| *m != 0.0);
        Some(PositionSample {
            stamp: Stamp::Boot(self.sample_s()?),
            arrival_s: None,
            place: place(
                [self.number("lat")?, self.number("lon")?],
                self.number("alt")?,
                above_ellipsoid_m,
            )?,
            sigma_m: self.sigma_m(),
            velocity_m_s: None,
            status: None,
            satellites: None,
        })
    }

    fn quaternion(&self) -> Option<[f64; 4]> {
        let [w, x, y, z] = ["q[0]", "q[1]", "q[2]", "q[3]"].map(|name| self.number(name));
        Some([w?, x?, y?, z?])
    }

    /// The attitude: the quaternion takes forward, right, down to north, east, down.
    pub fn attitude(&self) -> Option<AttitudeSample> {
        Some(AttitudeSample {
            stamp: Stamp::Boot(self.sample_s()?),
            attitude: Attitude::from_frd_to_ned(self.quaternion()?)?,
        })
    }

    /// Number of the gimbal among those of one sender, from 1; 0 where it is the sender itself.
    pub fn gimbal_device(&self) -> i64 {
        self.integer("gimbal_device_id").unwrap_or(0)
    }

    /// The attitude of a gimbal. An attitude that did not come from a gimbal over MAVLink is the autopilot's
    /// command to servos.
    pub fn gimbal_attitude(&self) -> Option<GimbalSample> {
        let status = DeviceStatus {
            flags: self.integer("device_flags")?,
            failures: self.integer("failure_flags").unwrap_or(0),
            quaternion: self.quaternion()?,
            delta_yaw_rad: self.number("delta_yaw").unwrap_or(f64::NAN),
        };
        let sample = status.sample(Stamp::Boot(self.boot_s()?))?;
        let teller = match self.integer("received_from_mavlink") {
            Some(0) => Teller::Servos,
            _ => Teller::Gimbal,
        };
        Some(GimbalSample { teller, ..sample })
    }
}

fn place(
    [latitude_deg, longitude_deg]: [f64; 2],
    above_sea_m: f64,
    above_ellipsoid_m: Option<f64>,
) -> Option<Place> {
    let (height_m, datum) = match above_ellipsoid_m {
        Some(height_m) => (height_m, HeightDatum::Ellipsoid),
        None => (above_sea_m, HeightDatum::SeaLevel),
    };
    Place::on_earth([latitude_deg, longitude_deg, height_m], datum)
}
