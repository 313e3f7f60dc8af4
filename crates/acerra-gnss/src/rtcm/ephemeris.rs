//! Ephemeris messages: 1019 (GPS), 1020 (GLONASS), 1042 (BeiDou), 1044 (QZSS), 1045 and 1046
//! (Galileo F/NAV and I/NAV) (RTCM 10403.3, section 3.5.11).

use acerra_geo::time::{BDT_BEHIND_GPST_S, GpsTime};

use crate::observations::satellite::{SatelliteId, System};
use crate::orbits::bits::{BitCursor, SEMICIRCLE_RAD};
use crate::orbits::navigation::{Ephemeris, GlonassEphemeris, KeplerEphemeris};
use crate::rinex::{accuracy_of_index_m, galileo_accuracy_of_index_m, moscow_time, nearest_week};

/// RINEX's data source word for F/NAV: E5a pages, clock for E5a and E1.
const GALILEO_FNAV: u32 = 1 << 1 | 1 << 8;
/// RINEX's data source word for I/NAV: E1-B and E5b pages, clock for E5b and E1.
const GALILEO_INAV: u32 = 1 | 1 << 2 | 1 << 9;

/// Reason for which an ephemeris message gives no ephemeris.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Refused {
    /// The message is shorter than its fields.
    Short,
    /// The satellite or the numbers are impossible.
    Impossible,
}

/// Whether this message holds an ephemeris that is read.
pub(super) fn is_ephemeris(number: u16) -> bool {
    matches!(number, 1019 | 1020 | 1042 | 1044..=1046)
}

/// The ephemeris of message `number`. `near` is any time within half a week of the ephemeris (half a day for
/// GLONASS).
pub(super) fn read(number: u16, payload: &[u8], near: GpsTime) -> Result<Ephemeris, Refused> {
    let bits = &mut BitCursor::new(payload);
    bits.skip(12).ok_or(Refused::Short)?;
    if number == 1020 {
        let raw = Glonass::read(bits).ok_or(Refused::Short)?;
        return raw
            .ephemeris(near)
            .map(Ephemeris::Glonass)
            .ok_or(Refused::Impossible);
    }
    let raw = match number {
        1019 => gps(bits),
        1042 => beidou(bits),
        1044 => qzss(bits),
        _ => galileo(bits, number == 1046),
    };
    raw.ok_or(Refused::Short)?
        .ephemeris(near)
        .map(Ephemeris::Kepler)
        .ok_or(Refused::Impossible)
}

/// Keplerian elements in the order of all messages.
struct Elements {
    radius_sine: f64,
    mean_motion: f64,
    mean_anomaly: f64,
    latitude_cosine: f64,
    eccentricity: f64,
    latitude_sine: f64,
    sqrt_semi_major_axis: f64,
    toe_s: f64,
    inclination_cosine: f64,
    node: f64,
    inclination_sine: f64,
    inclination: f64,
    radius_cosine: f64,
    perigee: f64,
    node_rate: f64,
}

/// Differences between the systems' elements.
struct ElementFormat {
    harmonic_bits: usize,
    angle_exponent: i32,
    radius_exponent: i32,
    toe_bits: usize,
    toe_step_s: f64,
}

impl ElementFormat {
    const GPS: Self = Self {
        harmonic_bits: 16,
        angle_exponent: -29,
        radius_exponent: -5,
        toe_bits: 16,
        toe_step_s: 16.0,
    };
    const GALILEO: Self = Self {
        toe_bits: 14,
        toe_step_s: 60.0,
        ..Self::GPS
    };
    const BEIDOU: Self = Self {
        harmonic_bits: 18,
        angle_exponent: -31,
        radius_exponent: -6,
        toe_bits: 17,
        toe_step_s: 8.0,
    };
}

impl Elements {
    fn read(bits: &mut BitCursor<'_>, format: &ElementFormat) -> Option<Self> {
        let f = format;
        let semicircles = |bits: &mut BitCursor<'_>, width, exponent| {
            Some(bits.scaled(width, exponent)? * SEMICIRCLE_RAD)
        };
        let angle = |bits: &mut BitCursor<'_>| bits.scaled(f.harmonic_bits, f.angle_exponent);
        let radius = |bits: &mut BitCursor<'_>| bits.scaled(f.harmonic_bits, f.radius_exponent);
        Some(Self {
            radius_sine: radius(bits)?,
            mean_motion: semicircles(bits, 16, -43)?,
            mean_anomaly: semicircles(bits, 32, -31)?,
            latitude_cosine: angle(bits)?,
            eccentricity: bits.scaled_unsigned(32, -33)?,
            latitude_sine: angle(bits)?,
            sqrt_semi_major_axis: bits.scaled_unsigned(32, -19)?,
            toe_s: bits.unsigned(f.toe_bits)? as f64 * f.toe_step_s,
            inclination_cosine: angle(bits)?,
            node: semicircles(bits, 32, -31)?,
            inclination_sine: angle(bits)?,
            inclination: semicircles(bits, 32, -31)?,
            radius_cosine: radius(bits)?,
            perigee: semicircles(bits, 32, -31)?,
            node_rate: semicircles(bits, 24, -43)?,
        })
    }
}

/// A Keplerian message whose times are seconds of a week.
struct Kepler {
    satellite: Option<SatelliteId>,
    /// Week as broadcast, and the number of weeks after which the count restarts.
    week: (i64, i64),
    iode: u32,
    iodc: u32,
    health: u32,
    data_source: u32,
    accuracy_m: f64,
    toc_s: f64,
    clock: [f64; 3],
    inclination_rate_rad_s: f64,
    group_delay_s: [f64; 2],
    elements: Elements,
}

impl Kepler {
    fn ephemeris(self, near: GpsTime) -> Option<KeplerEphemeris> {
        let satellite = self.satellite?;
        let e = self.elements;
        let ahead_s = match satellite.system() {
            System::Beidou => BDT_BEHIND_GPST_S as f64,
            _ => 0.0,
        };
        let times_s = [e.toe_s, self.toc_s];
        let possible = KeplerEphemeris::can_be(times_s, e.sqrt_semi_major_axis, e.eccentricity);
        let toe = nearest_week(near, e.toe_s + ahead_s);
        // The week may be the week of the reference time or of the transmission, which differ by at most one.
        let (week, modulus) = self.week;
        let weeks_off = ((toe - ahead_s).week() - week + 1).rem_euclid(modulus);
        if !possible || weeks_off > 2 {
            return None;
        }
        Some(KeplerEphemeris {
            satellite,
            iode: self.iode,
            iodc: self.iodc,
            health: self.health,
            data_source: self.data_source,
            accuracy_m: self.accuracy_m,
            toc: nearest_week(toe, self.toc_s + ahead_s),
            toe,
            transmission_time: near,
            toe_seconds_of_week: e.toe_s,
            sqrt_semi_major_axis: e.sqrt_semi_major_axis,
            eccentricity: e.eccentricity,
            inclination_rad: e.inclination,
            ascending_node_rad: e.node,
            perigee_rad: e.perigee,
            mean_anomaly_rad: e.mean_anomaly,
            mean_motion_correction_rad_s: e.mean_motion,
            ascending_node_rate_rad_s: e.node_rate,
            inclination_rate_rad_s: self.inclination_rate_rad_s,
            latitude_correction_rad: [e.latitude_cosine, e.latitude_sine],
            radius_correction_m: [e.radius_cosine, e.radius_sine],
            inclination_correction_rad: [e.inclination_cosine, e.inclination_sine],
            clock: self.clock,
            group_delay_s: self.group_delay_s,
        })
    }
}

/// Rate of inclination (rad/s).
fn inclination_rate(bits: &mut BitCursor<'_>) -> Option<f64> {
    Some(bits.scaled(14, -43)? * SEMICIRCLE_RAD)
}

/// The group delay of GPS and QZSS; −128 steps mean that there is none.
fn gps_group_delay_s(bits: &mut BitCursor<'_>) -> Option<f64> {
    Some(match bits.signed(8)? {
        -128 => 0.0,
        steps => steps as f64 * 2f64.powi(-31),
    })
}

/// A clock polynomial from the highest power down, the order of all messages.
fn clock(bits: &mut BitCursor<'_>, formats: [(usize, i32); 3]) -> Option<[f64; 3]> {
    let [quadratic, linear, constant] = formats;
    let a2 = bits.scaled(quadratic.0, quadratic.1)?;
    let a1 = bits.scaled(linear.0, linear.1)?;
    Some([bits.scaled(constant.0, constant.1)?, a1, a2])
}

const GPS_CLOCK: [(usize, i32); 3] = [(8, -55), (16, -43), (22, -31)];
const GALILEO_CLOCK: [(usize, i32); 3] = [(6, -59), (21, -46), (31, -34)];
const BEIDOU_CLOCK: [(usize, i32); 3] = [(11, -66), (22, -50), (24, -33)];

// The literals below are evaluated field by field in the order written, the order of the message.

fn gps(bits: &mut BitCursor<'_>) -> Option<Kepler> {
    let kepler = Kepler {
        satellite: SatelliteId::new(System::Gps, bits.byte(6)?),
        week: (bits.unsigned(10)?.cast_signed(), 1024),
        accuracy_m: accuracy_of_index_m(bits.unsigned32(4)?),
        data_source: bits.unsigned32(2)?,
        inclination_rate_rad_s: inclination_rate(bits)?,
        iode: bits.unsigned32(8)?,
        toc_s: bits.unsigned(16)? as f64 * 16.0,
        clock: clock(bits, GPS_CLOCK)?,
        iodc: bits.unsigned32(10)?,
        elements: Elements::read(bits, &ElementFormat::GPS)?,
        group_delay_s: [gps_group_delay_s(bits)?, 0.0],
        health: bits.unsigned32(6)?,
    };
    // L2 P data flag and fit interval.
    bits.skip(2)?;
    Some(kepler)
}

fn qzss(bits: &mut BitCursor<'_>) -> Option<Kepler> {
    let kepler = Kepler {
        satellite: SatelliteId::new(System::Qzss, bits.byte(4)?),
        toc_s: bits.unsigned(16)? as f64 * 16.0,
        clock: clock(bits, GPS_CLOCK)?,
        iode: bits.unsigned32(8)?,
        elements: Elements::read(bits, &ElementFormat::GPS)?,
        inclination_rate_rad_s: inclination_rate(bits)?,
        data_source: bits.unsigned32(2)?,
        week: (bits.unsigned(10)?.cast_signed(), 1024),
        accuracy_m: accuracy_of_index_m(bits.unsigned32(4)?),
        health: bits.unsigned32(6)?,
        group_delay_s: [gps_group_delay_s(bits)?, 0.0],
        iodc: bits.unsigned32(10)?,
    };
    // Fit interval.
    bits.skip(1)?;
    Some(kepler)
}

fn galileo(bits: &mut BitCursor<'_>, inav: bool) -> Option<Kepler> {
    let mut kepler = Kepler {
        satellite: SatelliteId::new(System::Galileo, bits.byte(6)?),
        // Galileo's weeks began with the GPS week 1024.
        week: (bits.unsigned(12)?.cast_signed() + 1024, 4096),
        iode: bits.unsigned32(10)?,
        iodc: 0,
        accuracy_m: galileo_accuracy_of_index_m(bits.unsigned32(8)?),
        inclination_rate_rad_s: inclination_rate(bits)?,
        toc_s: bits.unsigned(14)? as f64 * 60.0,
        clock: clock(bits, GALILEO_CLOCK)?,
        elements: Elements::read(bits, &ElementFormat::GALILEO)?,
        group_delay_s: [bits.scaled(10, -32)?, 0.0],
        data_source: GALILEO_FNAV,
        health: 0,
    };
    if inav {
        kepler.data_source = GALILEO_INAV;
        kepler.group_delay_s[1] = bits.scaled(10, -32)?;
        let (e5b, e5b_invalid) = (bits.unsigned32(2)?, bits.unsigned32(1)?);
        let (e1, e1_invalid) = (bits.unsigned32(2)?, bits.unsigned32(1)?);
        // Order of the bits as in RINEX: E1-B in bits 0–2, E5b in bits 6–8.
        kepler.health = e1_invalid | e1 << 1 | e5b_invalid << 6 | e5b << 7;
    } else {
        let (e5a, e5a_invalid) = (bits.unsigned32(2)?, bits.unsigned32(1)?);
        kepler.health = e5a_invalid << 3 | e5a << 4;
    }
    Some(kepler)
}

fn beidou(bits: &mut BitCursor<'_>) -> Option<Kepler> {
    Some(Kepler {
        satellite: SatelliteId::new(System::Beidou, bits.byte(6)?),
        // Thirteen bits of BeiDou's week; GPS weeks are ahead by 1356.
        week: (bits.unsigned(13)?.cast_signed() + 1356, 8192),
        accuracy_m: accuracy_of_index_m(bits.unsigned32(4)?),
        inclination_rate_rad_s: inclination_rate(bits)?,
        iode: bits.unsigned32(5)?,
        toc_s: bits.unsigned(17)? as f64 * 8.0,
        clock: clock(bits, BEIDOU_CLOCK)?,
        iodc: bits.unsigned32(5)?,
        elements: Elements::read(bits, &ElementFormat::BEIDOU)?,
        group_delay_s: [
            bits.signed(10)? as f64 * 1e-10,
            bits.signed(10)? as f64 * 1e-10,
        ],
        health: bits.unsigned32(1)?,
        data_source: 0,
    })
}

/// Message 1020.
struct Glonass {
    satellite: Option<SatelliteId>,
    channel: i8,
    frame_s: u32,
    unhealthy: u32,
    reference_s: u32,
    /// Velocity (km/s), position (km) and acceleration (km/s²) along each axis.
    axes: [[f64; 3]; 3],
    clock_rate: f64,
    tau_s: f64,
    age_days: u32,
}

impl Glonass {
    fn read(bits: &mut BitCursor<'_>) -> Option<Self> {
        let satellite = SatelliteId::new(System::Glonass, bits.byte(6)?);
        let channel = bits.byte(5)?.cast_signed() - 7;
        // Almanac health and whether it is given, P1.
        bits.skip(4)?;
        let frame_s =
            bits.unsigned32(5)? * 3600 + bits.unsigned32(6)? * 60 + bits.unsigned32(1)? * 30;
        let unhealthy = bits.unsigned32(1)?;
        bits.skip(1)?;
        let reference_s = bits.unsigned32(7)? * 900;
        let mut axes = [[0.0; 3]; 3];
        for axis in &mut axes {
            for (value, (width, exponent)) in axis.iter_mut().zip([(24, -20), (27, -11), (5, -30)])
            {
                *value = bits.sign_magnitude(width)? as f64 * 2f64.powi(exponent);
            }
        }
        bits.skip(1)?;
        let clock_rate = bits.sign_magnitude(11)? as f64 * 2f64.powi(-40);
        bits.skip(2)?;
        let third_string_unhealthy = bits.unsigned32(1)?;
        let tau_s = bits.sign_magnitude(22)? as f64 * 2f64.powi(-30);
        bits.skip(5)?;
        let age_days = bits.unsigned32(5)?;
        Some(Self {
            satellite,
            channel,
            frame_s,
            // RINEX's health word: the most significant bit of B_n, and l_n.
            unhealthy: unhealthy | third_string_unhealthy,
            reference_s,
            axes,
            clock_rate,
            tau_s,
            age_days,
        })
    }

    fn ephemeris(self, near: GpsTime) -> Option<GlonassEphemeris> {
        let satellite = self.satellite?;
        if !(-7..=6).contains(&self.channel) || self.frame_s >= 86_400 || self.reference_s >= 86_400
        {
            return None;
        }
        let metres = |k: usize| self.axes.map(|axis| axis[k] * 1e3);
        let position_ecef_m = metres(1);
        let radius = position_ecef_m.iter().map(|x| x * x).sum::<f64>().sqrt();
        if !(2e7..3e7).contains(&radius) {
            return None;
        }
        let of_day = |seconds: u32| moscow_time(near, f64::from(seconds));
        Some(GlonassEphemeris {
            satellite,
            channel: self.channel,
            health: self.unhealthy,
            age_days: self.age_days,
            toe: of_day(self.reference_s)?,
            transmission_time: of_day(self.frame_s)?,
            position_ecef_m,
            velocity_ecef_m_s: metres(0),
            acceleration_ecef_m_s2: metres(2),
            clock_offset_s: -self.tau_s,
            clock_rate: self.clock_rate,
        })
    }
}
