//! Contents of the messages (MAVLink, `common.xml`). Fields are in the order of their length, longest first;
//! later fields ("extensions") come last.

use acerra_geo::trajectory::{Attitude, SolutionStatus};

use crate::bytes::array;
use crate::gimbal::DeviceStatus;
use crate::sample::{
    AttitudeSample, ClockPair, GimbalSample, HeightDatum, Place, PositionSample, Stamp, YawFrom,
    gps_time_of_unix_us,
};

/// A message that matters here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// `SYSTEM_TIME`: the autopilot's clock and UTC.
    SystemTime,
    /// `GPS_RAW_INT`: the first receiver's position.
    GpsRaw,
    /// `GPS2_RAW`: the second one's.
    Gps2Raw,
    /// `ATTITUDE`.
    Attitude,
    /// `GLOBAL_POSITION_INT`: the filter's position.
    GlobalPosition,
    /// `MOUNT_ORIENTATION`: angles of a gimbal.
    MountOrientation,
    /// `GIMBAL_DEVICE_ATTITUDE_STATUS`: attitude of a gimbal, and how it is.
    GimbalDeviceStatus,
}

impl Kind {
    /// The message of that number, with its byte for the checksum.
    pub const fn of(message: u32) -> Option<(Self, u8)> {
        Some(match message {
            2 => (Self::SystemTime, 137),
            24 => (Self::GpsRaw, 24),
            30 => (Self::Attitude, 39),
            33 => (Self::GlobalPosition, 104),
            124 => (Self::Gps2Raw, 87),
            265 => (Self::MountOrientation, 26),
            285 => (Self::GimbalDeviceStatus, 137),
            _ => return None,
        })
    }

    /// Name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::SystemTime => "SYSTEM_TIME",
            Self::GpsRaw => "GPS_RAW_INT",
            Self::Gps2Raw => "GPS2_RAW",
            Self::Attitude => "ATTITUDE",
            Self::GlobalPosition => "GLOBAL_POSITION_INT",
            Self::MountOrientation => "MOUNT_ORIENTATION",
            Self::GimbalDeviceStatus => "GIMBAL_DEVICE_ATTITUDE_STATUS",
        }
    }
}

/// A message's fields; zeros at its end may be left out of the packet.
#[derive(Debug, Clone)]
pub struct Payload {
    bytes: [u8; 256],
}

impl Payload {
    /// The fields of a packet's payload.
    pub fn new(payload: &[u8]) -> Self {
        let mut bytes = [0; 256];
        let length = payload.len().min(bytes.len());
        bytes[..length].copy_from_slice(&payload[..length]);
        Self { bytes }
    }

    fn i32(&self, at: usize) -> i32 {
        array(&self.bytes, at).map_or(0, i32::from_le_bytes)
    }

    fn u32(&self, at: usize) -> u32 {
        array(&self.bytes, at).map_or(0, u32::from_le_bytes)
    }

    fn i64(&self, at: usize) -> i64 {
        array(&self.bytes, at).map_or(0, i64::from_le_bytes)
    }

    fn i16(&self, at: usize) -> i16 {
        array(&self.bytes, at).map_or(0, i16::from_le_bytes)
    }

    fn f32(&self, at: usize) -> f64 {
        array(&self.bytes, at)
            .map_or(0.0, f32::from_le_bytes)
            .into()
    }

    /// The autopilot's clock (s), of whole milliseconds since its start.
    fn boot_s(&self, at: usize) -> f64 {
        f64::from(self.u32(at)) * 1e-3
    }

    /// Both clocks of `SYSTEM_TIME`; none before the autopilot knows UTC.
    pub fn clock_pair(&self) -> Option<ClockPair> {
        Some(ClockPair {
            boot_s: self.boot_s(8),
            gps: gps_time_of_unix_us(self.i64(0))?,
        })
    }

    /// The attitude of `ATTITUDE`.
    pub fn attitude(&self) -> Option<AttitudeSample> {
        Some(AttitudeSample {
            stamp: Stamp::Boot(self.boot_s(0)),
            attitude: Attitude::from_euler([self.f32(4), self.f32(8), self.f32(12)])?,
        })
    }

    /// The angles of `MOUNT_ORIENTATION` (degrees): roll and pitch from the horizon, yaw from the nose, and in
    /// later definitions also from north, where a zero means absent. The stamp is the sender's clock.
    pub fn mount_orientation(&self) -> Option<GimbalSample> {
        let [roll, pitch, from_nose, from_north] =
            [4, 8, 12, 16].map(|at| self.f32(at).to_radians());
        let (yaw_rad, yaw) = if from_north.is_finite() && from_north != 0.0 {
            (from_north, YawFrom::North)
        } else {
            (from_nose, YawFrom::Nose)
        };
        let attitude = Attitude::from_euler([roll, pitch, yaw_rad])?;
        Some(GimbalSample::new(
            Stamp::Boot(self.boot_s(0)),
            attitude,
            yaw,
        ))
    }

    /// The attitude of `GIMBAL_DEVICE_ATTITUDE_STATUS`. The stamp is the sender's clock.
    pub fn gimbal_status(&self) -> Option<GimbalSample> {
        let flags = array(&self.bytes, 36).map_or(0, u16::from_le_bytes);
        DeviceStatus {
            flags: flags.into(),
            failures: self.u32(32).into(),
            quaternion: [4, 8, 12, 16].map(|at| self.f32(at)),
            delta_yaw_rad: self.f32(40),
        }
        .sample(Stamp::Boot(self.boot_s(0)))
    }

    /// Number of the gimbal of `GIMBAL_DEVICE_ATTITUDE_STATUS` among those of its sender, from 1; 0 where it is
    /// the sender itself.
    pub const fn gimbal_device(&self) -> u8 {
        self.bytes[48]
    }

    /// The position of `GLOBAL_POSITION_INT`, its height above the sea.
    pub fn filter_position(&self) -> Option<PositionSample> {
        let degrees = |at| f64::from(self.i32(at)) * 1e-7;
        let height_m = f64::from(self.i32(12)) * 1e-3;
        let speed = |at| f64::from(self.i16(at)) * 1e-2;
        Some(PositionSample {
            stamp: Stamp::Boot(self.boot_s(0)),
            arrival_s: None,
            place: Place::on_earth([degrees(4), degrees(8), height_m], HeightDatum::SeaLevel)?,
            sigma_m: None,
            velocity_m_s: Some([speed(22), speed(20), -speed(24)]),
            status: None,
            satellites: None,
        })
    }

    /// The position of a receiver; none without a fix in three dimensions.
    pub fn gnss_position(&self, kind: Kind) -> Option<PositionSample> {
        let at = match kind {
            Kind::Gps2Raw => Receiver::SECOND,
            _ => Receiver::FIRST,
        };
        let status = match self.bytes[at.fix_type] {
            3 => SolutionStatus::Single,
            4 => SolutionStatus::Dgps,
            5 => SolutionStatus::Float,
            6 => SolutionStatus::Fixed,
            8 => SolutionStatus::Ppp,
            _ => return None,
        };
        // Time since 1970 or since the autopilot's start: the message leaves it to the size.
        let micros = self.i64(0);
        let stamp = match gps_time_of_unix_us(micros) {
            Some(time) => Stamp::Gps(time),
            None => Stamp::Boot(micros as f64 * 1e-6),
        };
        let degrees = |at| f64::from(self.i32(at)) * 1e-7;
        let metres = |at| f64::from(self.i32(at)) * 1e-3;
        // Zero where the autopilot does not know it.
        let above_ellipsoid_m = Some(metres(at.above_ellipsoid)).filter(|m| *m != 0.0);
        let (height_m, datum) = match above_ellipsoid_m {
            Some(height_m) => (height_m, HeightDatum::Ellipsoid),
            None => (metres(16), HeightDatum::SeaLevel),
        };
        let deviation = |at| f64::from(self.u32(at)) * 1e-3;
        let [across_m, up_m] = at.deviations.map(deviation);
        Some(PositionSample {
            stamp,
            arrival_s: None,
            place: Place::on_earth([degrees(8), degrees(12), height_m], datum)?,
            sigma_m: (across_m > 0.0 && up_m > 0.0).then_some([across_m, across_m, up_m]),
            velocity_m_s: None,
            status: Some(status),
            satellites: match self.bytes[at.fix_type + 1] {
                u8::MAX => None,
                count => Some(count.into()),
            },
        })
    }
}

/// Places of the fields of a receiver's message that differ between the two.
struct Receiver {
    fix_type: usize,
    above_ellipsoid: usize,
    deviations: [usize; 2],
}

impl Receiver {
    const FIRST: Self = Self {
        fix_type: 28,
        above_ellipsoid: 30,
        deviations: [34, 38],
    };
    const SECOND: Self = Self {
        fix_type: 32,
        above_ellipsoid: 37,
        deviations: [41, 45],
    };
}

#[cfg(test)]
mod tests {
    use super::super::frame::accumulate;
    use super::*;

    /// Types and names of fields.
    type Declared = Vec<(&'static str, &'static str)>;

    /// The byte that a definition adds to the checksum: name, and type and name of each field in the order of
    /// the packet without extensions (MAVLink Developer Guide, "CRC_EXTRA Calculation").
    fn crc_extra(name: &str, fields: &[(&str, &str)]) -> u8 {
        let mut text = format!("{name} ");
        for (kind, field) in fields {
            text += &format!("{kind} {field} ");
            if *field == "q" {
                // An array's length follows its name.
                text.push('\u{4}');
            }
        }
        let crc = text.bytes().fold(0xffff, accumulate);
        (crc & 0xff) as u8 ^ (crc >> 8) as u8
    }

    #[test]
    fn the_checksums_bytes_are_those_of_the_definitions() {
        let receiver = |more: &[(&'static str, &'static str)]| {
            let mut fields = vec![
                ("uint64_t", "time_usec"),
                ("int32_t", "lat"),
                ("int32_t", "lon"),
                ("int32_t", "alt"),
            ];
            let (before, after): (Declared, Declared) =
                more.iter().copied().partition(|f| f.0 == "uint32_t");
            fields.extend(before);
            fields.extend(["eph", "epv", "vel", "cog"].map(|name| ("uint16_t", name)));
            fields.extend([("uint8_t", "fix_type"), ("uint8_t", "satellites_visible")]);
            fields.extend(after);
            fields
        };
        let floats = [
            "roll",
            "pitch",
            "yaw",
            "rollspeed",
            "pitchspeed",
            "yawspeed",
        ];
        let mut attitude = vec![("uint32_t", "time_boot_ms")];
        attitude.extend(floats.map(|name| ("float", name)));
        let mut global = vec![("uint32_t", "time_boot_ms")];
        global.extend(["lat", "lon", "alt", "relative_alt"].map(|name| ("int32_t", name)));
        global.extend(["vx", "vy", "vz"].map(|name| ("int16_t", name)));
        global.push(("uint16_t", "hdg"));
        let time = [("uint64_t", "time_unix_usec"), ("uint32_t", "time_boot_ms")];
        let mut mount = vec![("uint32_t", "time_boot_ms")];
        mount.extend(["roll", "pitch", "yaw"].map(|name| ("float", name)));
        let mut gimbal = vec![("uint32_t", "time_boot_ms"), ("float", "q")];
        let rates = [
            "angular_velocity_x",
            "angular_velocity_y",
            "angular_velocity_z",
        ];
        gimbal.extend(rates.map(|name| ("float", name)));
        gimbal.extend([("uint32_t", "failure_flags"), ("uint16_t", "flags")]);
        gimbal.extend(["target_system", "target_component"].map(|name| ("uint8_t", name)));
        let second = receiver(&[("uint32_t", "dgps_age"), ("uint8_t", "dgps_numch")]);
        for (message, fields) in [
            (2, time.to_vec()),
            (24, receiver(&[])),
            (30, attitude),
            (33, global),
            (124, second),
            (265, mount),
            (285, gimbal),
        ] {
            let (kind, byte) = Kind::of(message).unwrap();
            assert_eq!(crc_extra(kind.name(), &fields), byte, "{}", kind.name());
        }
    }
}
