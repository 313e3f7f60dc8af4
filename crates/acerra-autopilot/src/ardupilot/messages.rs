//! Contents of the records `GPS`, `GPA`, `POS`, `ATT`, `MNT` and `PARM` (ArduPilot, `AP_GPS/LogStructure.h`,
//! `AP_AHRS/LogStructure.h` and `AP_Mount/LogStructure.h`).

use acerra_geo::geodesy::Geodetic;
use acerra_geo::time::GpsTime;
use acerra_geo::trajectory::{Attitude, SolutionStatus};

use super::layout::Layout;
use crate::sample::{
    AttitudeSample, ClockPair, GimbalSample, HeightDatum, Place, PositionSample, Stamp, Teller,
    YawFrom,
};

/// A record with the layout of its type.
#[derive(Debug, Clone, Copy)]
pub struct Record<'a> {
    /// Type.
    pub layout: &'a Layout,
    /// Bytes, mark and all.
    pub bytes: &'a [u8],
}

impl Record<'_> {
    fn number(&self, names: &[&str]) -> Option<f64> {
        let value = self.layout.number(self.bytes, names)?;
        value.is_finite().then_some(value)
    }

    fn integer(&self, name: &str) -> Option<i64> {
        self.layout.integer(self.bytes, name)
    }

    /// The autopilot's clock (s).
    pub fn boot_s(&self) -> Option<f64> {
        let micros = self.integer("TimeUS").map(|us| us as f64 * 1e-6);
        micros.or_else(|| self.integer("TimeMS").map(|ms| ms as f64 * 1e-3))
    }

    /// Name of the receiver: `GPS[1]`; in logs before 2020 the second one has the type `GPS2`.
    pub fn receiver(&self) -> String {
        let digits = self
            .layout
            .name
            .trim_start_matches(|c: char| !c.is_ascii_digit());
        let of_type = digits.parse::<i64>().map_or(0, |n| n - 1);
        format!("GPS[{}]", self.integer("I").unwrap_or(of_type))
    }

    /// GPS time of a record `GPS`; none before the receiver knows it.
    fn gps_time(&self) -> Option<GpsTime> {
        let (week, millis) = (self.integer("GWk")?, self.integer("GMS")?);
        let is_known = week > 0 && (0..604_800_000).contains(&millis);
        is_known.then(|| GpsTime::from_week_tow(week, 0.0) + millis as f64 * 1e-3)
    }

    fn place(&self, datum: HeightDatum) -> Option<Place> {
        let latitude_deg = self.number(&["Lat"])?;
        let longitude_deg = self.number(&["Lng"])?;
        let height_m = self.number(&["Alt"])?;
        Place::on_earth([latitude_deg, longitude_deg, height_m], datum)
    }

    /// The position of a record `GPS`; none without a fix in three dimensions or without GPS time.
    pub fn gnss_position(&self) -> Option<PositionSample> {
        let status = match self.integer("Status")? {
            3 => SolutionStatus::Single,
            4 => SolutionStatus::Dgps,
            5 => SolutionStatus::Float,
            6 => SolutionStatus::Fixed,
            7 | 8 => SolutionStatus::Ppp,
            _ => return None,
        };
        Some(PositionSample {
            stamp: Stamp::Gps(self.gps_time()?),
            arrival_s: self.boot_s(),
            place: self.place(HeightDatum::SeaLevel)?,
            sigma_m: None,
            velocity_m_s: self.velocity_m_s(),
            status: Some(status),
            satellites: self.integer("NSats").and_then(|n| u16::try_from(n).ok()),
        })
    }

    fn velocity_m_s(&self) -> Option<[f64; 3]> {
        let speed = self.number(&["Spd"])?;
        let (east, north) = self.number(&["GCrs"])?.to_radians().sin_cos();
        let down = self.number(&["VZ"])?;
        Some([speed * east, speed * north, -down])
    }

    /// The autopilot's clock and GPS time, by a record `GPS`.
    pub fn clock_pair(&self) -> Option<ClockPair> {
        let has_fix = self.integer("Status")? >= 3;
        Some(ClockPair {
            boot_s: self.boot_s().filter(|_| has_fix)?,
            gps: self.gps_time()?,
        })
    }

    /// Adds the content of a record `GPA` to the position just before it: its accuracy and the height above
    /// the ellipsoid.
    ///
    /// `HAcc` is used for each horizontal axis, of which it is an upper bound. `Und` is the height above the
    /// sea less that above the ellipsoid, the negative of the usual convention
    /// (`AP_GPS::send_mavlink_gps_raw`); newer logs have the height above the ellipsoid itself, `AEl`.
    pub fn complete(&self, position: &mut PositionSample) {
        if let (Some(across_m), Some(up_m)) = (self.number(&["HAcc"]), self.number(&["VAcc"]))
            && across_m > 0.0
            && up_m > 0.0
        {
            position.sigma_m = Some([across_m, across_m, up_m]);
        }
        let Place::Geodetic(place, HeightDatum::SeaLevel) = position.place else {
            return;
        };
        // A receiver that does not know leaves zero, or the least number there is.
        let is_known = |m: &f64| *m != 0.0 && m.abs() < 1e5;
        let undulation_m = self.number(&["Und"]).filter(is_known);
        let height_m = self.number(&["AEl"]).filter(is_known);
        let height_m = height_m.or(undulation_m.map(|m| place.height_m - m));
        if let Some(height_m) = height_m {
            position.place =
                Place::Geodetic(Geodetic { height_m, ..place }, HeightDatum::Ellipsoid);
        }
    }

    /// The position of a record `POS`: the filter's, its height above the sea.
    pub fn filter_position(&self) -> Option<PositionSample> {
        Some(PositionSample {
            stamp: Stamp::Boot(self.boot_s()?),
            arrival_s: None,
            place: self.place(HeightDatum::SeaLevel)?,
            sigma_m: None,
            velocity_m_s: None,
            status: None,
            satellites: None,
        })
    }

    /// The attitude of a record `ATT`, degrees.
    pub fn attitude(&self) -> Option<AttitudeSample> {
        let angle = |name| self.number(&[name]).map(f64::to_radians);
        let angles = [angle("Roll")?, angle("Pitch")?, angle("Yaw")?];
        Some(AttitudeSample {
            stamp: Stamp::Boot(self.boot_s()?),
            attitude: Attitude::from_euler(angles)?,
        })
    }

    /// The gimbal whose kind a record `PARM` gives (`MNT1_TYPE` for the first), and the reference of its
    /// angles by that kind.
    ///
    /// Servos (1) have no feedback: older versions of ArduPilot log the commanded angles from the horizon,
    /// newer ones those in the vehicle's axes (`AP_Mount_Servo::get_attitude_quaternion`). A self-stabilised
    /// gimbal driven by servo signals (7) is commanded with angles from the horizon. None for no gimbal (0).
    pub fn gimbal_kind(&self) -> Option<(String, Teller)> {
        let name = self.layout.text(self.bytes, "Name")?;
        let number = name.strip_prefix("MNT")?.strip_suffix("_TYPE")?;
        let instance = number.parse::<u8>().ok()?.checked_sub(1)?;
        let kind = self.number(&["Value"])?.round();
        let teller = match kind as i64 {
            ..=0 => return None,
            1 => Teller::ServosOfUnknownFrame,
            7 => Teller::Servos,
            _ => Teller::Gimbal,
        };
        Some((format!("MNT[{instance}]"), teller))
    }

    /// Name of the gimbal of a record `MNT`.
    pub fn gimbal(&self) -> String {
        format!("MNT[{}]", self.integer("I").unwrap_or(0))
    }

    /// The attitude of a record `MNT`, degrees: roll and pitch from the horizon, yaw from north, or where only
    /// that is known from the nose. None of a gimbal that does not give its angles.
    pub fn gimbal_attitude(&self) -> Option<GimbalSample> {
        let angle = |name| self.number(&[name]).map(f64::to_radians);
        let (yaw_rad, yaw) = match angle("YawE") {
            Some(yaw_rad) => (yaw_rad, YawFrom::North),
            None => (angle("YawB")?, YawFrom::Nose),
        };
        let attitude = Attitude::from_euler([angle("Roll")?, angle("Pitch")?, yaw_rad])?;
        Some(GimbalSample {
            teller: Teller::Autopilot,
            ..GimbalSample::new(Stamp::Boot(self.boot_s()?), attitude, yaw)
        })
    }
}
