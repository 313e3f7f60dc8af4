//! Ephemeris from the numbers of a navigation record.

use acerra_geo::time::{BDT_BEHIND_GPST_S, Calendar, GpsTime, SECONDS_PER_WEEK};

use crate::observations::satellite::{SatelliteId, System};
use crate::orbits::navigation::{Ephemeris, GlonassEphemeris, KeplerEphemeris, SbasEphemeris};

/// One record of the file: satellite, time of clock and the values in order.
#[derive(Debug, Clone)]
pub(super) struct NavigationRecord {
    pub satellite: SatelliteId,
    /// Clock reading in the system's time scale (GLONASS: UTC, BeiDou: BDT).
    pub toc: Calendar,
    /// Slots 0…; blank fields are NaN.
    pub values: Vec<f64>,
}

impl NavigationRecord {
    /// Number of lines of a complete record of `system`.
    pub(super) fn lines_needed(system: System) -> usize {
        match system {
            System::Glonass | System::Sbas => 4,
            _ => 8,
        }
    }

    /// The ephemeris; `None` where the numbers are impossible.
    pub(super) fn ephemeris(&self) -> Option<Ephemeris> {
        match self.satellite.system() {
            System::Glonass => self.glonass().map(Ephemeris::Glonass),
            System::Sbas => self.sbas().map(Ephemeris::Sbas),
            _ => self.kepler().map(Ephemeris::Kepler),
        }
    }

    /// A mandatory value.
    fn value(&self, slot: usize) -> Option<f64> {
        self.values.get(slot).copied().filter(|v| v.is_finite())
    }

    /// A value that counts as 0 where it is blank.
    fn or_zero(&self, slot: usize) -> f64 {
        self.value(slot).unwrap_or(0.0)
    }

    fn unsigned(&self, slot: usize) -> u32 {
        whole(self.or_zero(slot))
    }

    fn kepler(&self) -> Option<KeplerEphemeris> {
        let system = self.satellite.system();
        let v = |slot| self.value(slot);
        let sqrt_semi_major_axis = v(10).filter(|a| (1_000.0..10_000.0).contains(a))?;
        let eccentricity = v(8).filter(|e| (0.0..1.0).contains(e))?;
        let toe_seconds_of_week = v(11).filter(|t| (0.0..=604_800.0).contains(t))?;
        let own_to_gps_s = if system == System::Beidou {
            BDT_BEHIND_GPST_S
        } else {
            0
        };
        let toc = GpsTime::from_calendar(&self.toc) + own_to_gps_s as f64;
        // The week number only selects the week; the tag nearest to the time of clock is used, which also
        // corrects week numbers that wrapped or count from another epoch.
        let near_toc = |sow: f64| nearest_week(toc, sow + own_to_gps_s as f64);
        let toe = near_toc(toe_seconds_of_week);
        let transmission = v(27).filter(|t| (-604_800.0..=1_209_600.0).contains(t));
        let accuracy = self.or_zero(23);
        Some(KeplerEphemeris {
            satellite: self.satellite,
            iode: self.unsigned(3),
            iodc: match system {
                System::Beidou => self.unsigned(28),
                System::Galileo | System::Navic => 0,
                _ => self.unsigned(26),
            },
            health: self.unsigned(24),
            data_source: self.unsigned(20),
            accuracy_m: if system == System::Galileo {
                galileo_accuracy_m(accuracy)
            } else {
                accuracy_m(accuracy)
            },
            toc,
            toe,
            transmission_time: transmission.map_or(toe, near_toc),
            toe_seconds_of_week,
            sqrt_semi_major_axis,
            eccentricity,
            inclination_rad: v(15)?,
            ascending_node_rad: v(13)?,
            perigee_rad: v(17)?,
            mean_anomaly_rad: v(6)?,
            mean_motion_correction_rad_s: v(5)?,
            ascending_node_rate_rad_s: v(18)?,
            inclination_rate_rad_s: v(19)?,
            latitude_correction_rad: [v(7)?, v(9)?],
            radius_correction_m: [v(16)?, v(4)?],
            inclination_correction_rad: [v(12)?, v(14)?],
            clock: [v(0)?, v(1)?, v(2)?],
            group_delay_s: match system {
                System::Galileo | System::Beidou => [self.or_zero(25), self.or_zero(26)],
                _ => [self.or_zero(25), 0.0],
            },
        })
    }

    fn glonass(&self) -> Option<GlonassEphemeris> {
        // t_b is the time of clock (UTC) to the nearest quarter of an hour.
        let utc = GpsTime::from_calendar(&self.toc);
        let quarter = utc.seconds().saturating_add(450).div_euclid(900) * 900;
        let toe = utc_to_gps(GpsTime::new(quarter, 0.0))?;
        // The frame time is given in seconds of the day (version 2) or of the week; only its time
        // of day matters, on the day nearest to the time of clock.
        let frame = self
            .value(2)
            .filter(|t| (-86_400.0..=1_209_600.0).contains(t));
        let day_s = 86_400.0;
        let transmission = frame.map(|frame| {
            let midnight = GpsTime::new(utc.seconds().div_euclid(86_400) * 86_400, 0.0);
            let t = midnight + frame.rem_euclid(day_s);
            match t - utc {
                late if late > day_s / 2.0 => t - day_s,
                early if early < -day_s / 2.0 => t + day_s,
                _ => t,
            }
        });
        let transmission_time = match transmission {
            Some(t) => utc_to_gps(t)?,
            None => toe,
        };
        let channel = self.value(10)?;
        let channel = if channel > 128.0 {
            channel - 256.0
        } else {
            channel
        };
        if !(-7.0..=13.0).contains(&channel) {
            return None;
        }
        let [position_ecef_m, velocity_ecef_m_s, acceleration_ecef_m_s2] = self.state_vector()?;
        Some(GlonassEphemeris {
            satellite: self.satellite,
            #[expect(clippy::cast_possible_truncation, reason = "range checked")]
            channel: channel as i8,
            health: self.unsigned(6),
            age_days: self.unsigned(14),
            toe,
            transmission_time,
            position_ecef_m,
            velocity_ecef_m_s,
            acceleration_ecef_m_s2,
            clock_offset_s: self.value(0)?,
            clock_rate: self.value(1)?,
        })
    }

    fn sbas(&self) -> Option<SbasEphemeris> {
        let toe = GpsTime::from_calendar(&self.toc);
        let transmission = self
            .value(2)
            .filter(|t| (-604_800.0..=1_209_600.0).contains(t));
        let [position_ecef_m, velocity_ecef_m_s, acceleration_ecef_m_s2] = self.state_vector()?;
        Some(SbasEphemeris {
            satellite: self.satellite,
            health: self.unsigned(6),
            accuracy_m: accuracy_m(self.or_zero(10)),
            toe,
            transmission_time: transmission.map_or(toe, |sow| nearest_week(toe, sow)),
            position_ecef_m,
            velocity_ecef_m_s,
            acceleration_ecef_m_s2,
            clock_offset_s: self.value(0)?,
            clock_rate: self.value(1)?,
        })
    }

    /// Position, velocity and acceleration in metres from the kilometres of the file.
    fn state_vector(&self) -> Option<[[f64; 3]; 3]> {
        let mut out = [[0.0; 3]; 3];
        for (derivative, vector) in out.iter_mut().enumerate() {
            for (axis, component) in vector.iter_mut().enumerate() {
                *component = 1e3 * self.value(3 + derivative + 4 * axis)?;
            }
        }
        // Outside any orbit of these systems (6 400 to 50 000 km).
        let radius = out[0].iter().map(|x| x * x).sum::<f64>().sqrt();
        (6.4e6..5e7).contains(&radius).then_some(out)
    }
}

/// The tag with the given seconds of week that is nearest to `near`.
pub(crate) fn nearest_week(near: GpsTime, seconds_of_week: f64) -> GpsTime {
    let t = GpsTime::from_week_tow(near.week(), seconds_of_week);
    let weeks = ((near - t) / SECONDS_PER_WEEK as f64).round();
    t + weeks * SECONDS_PER_WEEK as f64
}

/// GPS time of a tag whose seconds were counted on the UTC clock.
pub(crate) fn utc_to_gps(utc: GpsTime) -> Option<GpsTime> {
    GpsTime::from_utc(&utc.to_calendar()).ok()
}

/// The instant nearest to `near` at which Moscow's clocks (UTC + 3 h) show a time of day.
pub(crate) fn moscow_time(near: GpsTime, of_day_s: f64) -> Option<GpsTime> {
    let now = near.to_glonass();
    let day_s = now.seconds_from_1970().div_euclid(86_400) * 86_400;
    let mut seconds = day_s + of_day_s.floor() as i64;
    let ahead = seconds - now.seconds_from_1970();
    if ahead > 43_200 {
        seconds -= 86_400;
    } else if ahead < -43_200 {
        seconds += 86_400;
    }
    let moscow = Calendar::from_seconds_since_1970(seconds, of_day_s - of_day_s.floor());
    GpsTime::from_glonass(&moscow).ok()
}

/// Upper bounds of the user range accuracy indices 0 to 14 (m).
const ACCURACY_STEPS_M: [f64; 15] = [
    2.4, 3.4, 4.85, 6.85, 9.65, 13.65, 24.0, 48.0, 96.0, 192.0, 384.0, 768.0, 1536.0, 3072.0,
    6144.0,
];

/// One sigma of an accuracy given in metres: the upper bound of the corresponding index.
pub(crate) fn accuracy_m(value_m: f64) -> f64 {
    *ACCURACY_STEPS_M
        .iter()
        .find(|&&step| step >= value_m)
        .unwrap_or(&6144.0)
}

/// One sigma of a broadcast accuracy index.
pub(crate) fn accuracy_of_index_m(index: u32) -> f64 {
    ACCURACY_STEPS_M
        .get(index as usize)
        .copied()
        .unwrap_or(6144.0)
}

/// One sigma of Galileo's signal-in-space accuracy: quantised as broadcast; 500 m where there is
/// no prediction.
pub(crate) fn galileo_accuracy_m(value_m: f64) -> f64 {
    let index = if !(0.0..=6.0).contains(&value_m) {
        255
    } else if value_m <= 0.5 {
        whole(value_m / 0.01)
    } else if value_m <= 1.0 {
        whole((value_m - 0.5) / 0.02) + 50
    } else if value_m <= 2.0 {
        whole((value_m - 1.0) / 0.04) + 75
    } else {
        // Quantised as in RTKLIB: the metres are truncated before the division.
        whole(f64::from(whole(value_m - 2.0)) / 0.16 + 100.0)
    };
    galileo_accuracy_of_index_m(index)
}

/// One sigma of a Galileo SISA index.
pub(crate) fn galileo_accuracy_of_index_m(index: u32) -> f64 {
    let i = f64::from(index);
    match index {
        0..=49 => 0.01 * i,
        50..=74 => 0.5 + 0.02 * (i - 50.0),
        75..=99 => 1.0 + 0.04 * (i - 75.0),
        100..=125 => 2.0 + 0.16 * (i - 100.0),
        _ => 500.0,
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "saturates, wanted"
)]
fn whole(value: f64) -> u32 {
    value as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn accuracies_are_quantised() {
        assert_eq!(
            (accuracy_m(2.0), accuracy_m(2.4), accuracy_m(2.5)),
            (2.4, 2.4, 3.4)
        );
        assert_eq!(accuracy_m(9999.0), 6144.0);
        // The SISA rows: 3.12 m is index 106.
        assert!((galileo_accuracy_m(3.12) - (2.0 + 0.16 * 6.0)).abs() < 1e-12);
        assert!((galileo_accuracy_m(0.32) - 0.32).abs() < 0.0101);
        assert_eq!(
            (galileo_accuracy_m(-1.0), galileo_accuracy_m(7.0)),
            (500.0, 500.0)
        );
    }

    #[test]
    fn the_nearest_week_is_found_across_the_boundary() {
        let toc = GpsTime::from_week_tow(2000, 604_784.0);
        assert_eq!(nearest_week(toc, 0.0), GpsTime::from_week_tow(2001, 0.0));
        let toc = GpsTime::from_week_tow(2001, 16.0);
        assert_eq!(
            nearest_week(toc, 604_784.0),
            GpsTime::from_week_tow(2000, 604_784.0)
        );
    }

    fn glonass(toc: (u8, u8, f64), frame: f64) -> GlonassEphemeris {
        let mut values = vec![0.0; 15];
        (values[0], values[1], values[2]) = (1e-5, 1e-12, frame);
        (values[3], values[7], values[11]) = (7164.9, 9075.9, 22776.0);
        (values[4], values[5], values[10]) = (-1.5, 2e-9, 251.0);
        let record = NavigationRecord {
            satellite: "R04".parse().unwrap(),
            toc: Calendar::new(2018, 10, 9, toc.0, toc.1, toc.2).unwrap(),
            values,
        };
        match record.ephemeris() {
            Some(Ephemeris::Glonass(e)) => e,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn glonass_times_are_rounded_and_brought_to_gps_time() {
        let e = glonass((11, 45, 14.0), 42_300.0 + 2.0 * 86_400.0);
        let t = |h, m, s| GpsTime::from_utc(&Calendar::new(2018, 10, 9, h, m, s).unwrap()).unwrap();
        assert_eq!(e.toe, t(11, 45, 0.0));
        assert_eq!(e.transmission_time, t(11, 45, 0.0));
        assert_eq!(e.channel, -5);
        assert_eq!(e.position_ecef_m[0], 7_164_900.0);
        assert_eq!(e.velocity_ecef_m_s[0], -1500.0);
        assert!((e.acceleration_ecef_m_s2[0] - 2e-6).abs() < 1e-20);
        // For a record just after midnight, a frame just before midnight belongs to the day before.
        let e = glonass((0, 15, 0.0), 86_370.0);
        assert_eq!(t(0, 15, 0.0) - e.transmission_time, 930.0);
    }
}
