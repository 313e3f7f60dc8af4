//! Broadcast navigation data: ephemerides and ionosphere coefficients.

use super::products::PreciseProducts;
use crate::observations::satellite::{SatelliteId, System};
use acerra_geo::time::GpsTime;

/// Broadcast ephemeris of a satellite on a Keplerian orbit: GPS, Galileo, QZSS, BeiDou, NavIC.
///
/// Angles in radians, lengths in metres, times in seconds, as broadcast; all time tags are GPS
/// time (BeiDou's are converted: GPST = BDT + 14 s).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KeplerEphemeris {
    /// The satellite.
    pub satellite: SatelliteId,
    /// Issue of data, ephemeris (IODE, IODnav, AODE).
    pub iode: u32,
    /// Issue of data, clock (IODC; 0 for Galileo, AODC for BeiDou).
    pub iodc: u32,
    /// Health word; 0 is healthy.
    pub health: u32,
    /// Data source word (Galileo: bit 0 or 2 I/NAV, bit 1 F/NAV, bits 8/9 clock reference).
    pub data_source: u32,
    /// Predicted accuracy, one sigma (m): URA or SISA after quantisation.
    pub accuracy_m: f64,
    /// Time of clock.
    pub toc: GpsTime,
    /// Time of ephemeris.
    pub toe: GpsTime,
    /// Transmission time of the message.
    pub transmission_time: GpsTime,
    /// Time of ephemeris in seconds of the system's own week, as broadcast (BDT for BeiDou).
    pub toe_seconds_of_week: f64,
    /// Square root of the semi-major axis (√m).
    pub sqrt_semi_major_axis: f64,
    /// Eccentricity.
    pub eccentricity: f64,
    /// Inclination at `toe` (rad).
    pub inclination_rad: f64,
    /// Longitude of the ascending node at the week's start (rad).
    pub ascending_node_rad: f64,
    /// Argument of perigee (rad).
    pub perigee_rad: f64,
    /// Mean anomaly at `toe` (rad).
    pub mean_anomaly_rad: f64,
    /// Mean motion correction Δn (rad/s).
    pub mean_motion_correction_rad_s: f64,
    /// Rate of the ascending node Ω̇ (rad/s).
    pub ascending_node_rate_rad_s: f64,
    /// Rate of inclination (rad/s).
    pub inclination_rate_rad_s: f64,
    /// Cosine and sine corrections to the argument of latitude Cuc, Cus (rad).
    pub latitude_correction_rad: [f64; 2],
    /// Cosine and sine corrections to the radius Crc, Crs (m).
    pub radius_correction_m: [f64; 2],
    /// Cosine and sine corrections to the inclination Cic, Cis (rad).
    pub inclination_correction_rad: [f64; 2],
    /// Clock polynomial af0 (s), af1 (s/s), af2 (s/s²).
    pub clock: [f64; 3],
    /// Group delays (s): TGD; Galileo BGD(E5a,E1) and BGD(E5b,E1); BeiDou TGD1 and TGD2.
    pub group_delay_s: [f64; 2],
}

impl KeplerEphemeris {
    /// Whether times of ephemeris and of clock are within a week (s), and the orbit is one of a navigation
    /// satellite.
    pub(crate) fn can_be(times_s: [f64; 2], sqrt_semi_major_axis: f64, eccentricity: f64) -> bool {
        times_s.iter().all(|s| (0.0..604_800.0).contains(s))
            && (1_000.0..10_000.0).contains(&sqrt_semi_major_axis)
            && eccentricity < 0.5
    }
}

/// Broadcast ephemeris of a GLONASS satellite: a state vector to integrate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GlonassEphemeris {
    /// The satellite.
    pub satellite: SatelliteId,
    /// Frequency channel, −7…6.
    pub channel: i8,
    /// Health word; 0 is healthy.
    pub health: u32,
    /// Age of the information (days).
    pub age_days: u32,
    /// Reference time t_b in GPS time.
    pub toe: GpsTime,
    /// Frame time in GPS time.
    pub transmission_time: GpsTime,
    /// Position at `toe` (ECEF PZ-90, m).
    pub position_ecef_m: [f64; 3],
    /// Velocity at `toe` (m/s).
    pub velocity_ecef_m_s: [f64; 3],
    /// Luni-solar acceleration (m/s²).
    pub acceleration_ecef_m_s2: [f64; 3],
    /// Clock offset at `toe` (s) with the sign of "satellite ahead is positive": the broadcast
    /// −τ_N as RINEX prints it.
    pub clock_offset_s: f64,
    /// Relative frequency offset +γ_N.
    pub clock_rate: f64,
}

/// Broadcast position of an SBAS satellite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SbasEphemeris {
    /// The satellite.
    pub satellite: SatelliteId,
    /// Health word; 0 is healthy.
    pub health: u32,
    /// Predicted accuracy, one sigma (m).
    pub accuracy_m: f64,
    /// Reference time t0 in GPS time.
    pub toe: GpsTime,
    /// Transmission time of the message.
    pub transmission_time: GpsTime,
    /// Position at `toe` (ECEF, m).
    pub position_ecef_m: [f64; 3],
    /// Velocity at `toe` (m/s).
    pub velocity_ecef_m_s: [f64; 3],
    /// Acceleration at `toe` (m/s²).
    pub acceleration_ecef_m_s2: [f64; 3],
    /// Clock offset a_f0 (s).
    pub clock_offset_s: f64,
    /// Clock rate a_f1 (s/s).
    pub clock_rate: f64,
}

/// A broadcast ephemeris.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Ephemeris {
    /// Keplerian orbit.
    Kepler(KeplerEphemeris),
    /// GLONASS state vector.
    Glonass(GlonassEphemeris),
    /// SBAS state vector.
    Sbas(SbasEphemeris),
}

impl Ephemeris {
    /// The satellite of the ephemeris.
    #[must_use]
    pub const fn satellite(&self) -> SatelliteId {
        match self {
            Self::Kepler(e) => e.satellite,
            Self::Glonass(e) => e.satellite,
            Self::Sbas(e) => e.satellite,
        }
    }

    /// Time of ephemeris (reference time).
    #[must_use]
    pub const fn toe(&self) -> GpsTime {
        match self {
            Self::Kepler(e) => e.toe,
            Self::Glonass(e) => e.toe,
            Self::Sbas(e) => e.toe,
        }
    }

    /// Transmission time.
    #[must_use]
    pub const fn transmission_time(&self) -> GpsTime {
        match self {
            Self::Kepler(e) => e.transmission_time,
            Self::Glonass(e) => e.transmission_time,
            Self::Sbas(e) => e.transmission_time,
        }
    }

    /// Whether the satellite declares itself usable (QZSS: the LEX bit is ignored).
    #[must_use]
    pub const fn is_healthy(&self) -> bool {
        match self {
            Self::Kepler(e) => {
                let ignored = if matches!(e.satellite.system(), System::Qzss) {
                    1
                } else {
                    0
                };
                e.health & !ignored == 0
            }
            Self::Glonass(e) => e.health == 0,
            Self::Sbas(e) => e.health == 0,
        }
    }

    /// Predicted accuracy, one sigma (m); 5 m for GLONASS, whose broadcast accuracy is not used.
    #[must_use]
    pub const fn accuracy_m(&self) -> f64 {
        match self {
            Self::Kepler(e) => e.accuracy_m,
            Self::Glonass(_) => 5.0,
            Self::Sbas(e) => e.accuracy_m,
        }
    }
}

/// Broadcast ionosphere coefficients of GPS (Klobuchar).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Klobuchar {
    /// Amplitude coefficients α0…α3 (s, s/sc, s/sc², s/sc³).
    pub alpha: [f64; 4],
    /// Period coefficients β0…β3 (s, s/sc, s/sc², s/sc³).
    pub beta: [f64; 4],
}

/// Broadcast navigation data, from one or several files.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Navigation {
    /// Ephemerides in any order; [`normalise`](Self::normalise) puts them into selection order.
    pub ephemerides: Vec<Ephemeris>,
    /// Ionosphere coefficients read last; `None` when absent or all zero.
    pub klobuchar: Option<Klobuchar>,
    /// Precise orbits and clocks, used exclusively for the satellites that they contain.
    pub precise: PreciseProducts,
}

impl Navigation {
    /// Whether there is no orbit of any satellite.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.ephemerides.is_empty() && self.precise.is_empty()
    }

    /// Adds the data of another file, whose ionosphere coefficients, if any, replace the earlier ones.
    pub fn merge(&mut self, other: Self) {
        self.precise.merge(other.precise);
        self.ephemerides.extend(other.ephemerides);
        self.klobuchar = other.klobuchar.or(self.klobuchar);
        self.normalise();
    }

    /// Sorts by transmission time, reference time and satellite, and keeps the first of neighbours of one
    /// issue and satellite.
    pub fn normalise(&mut self) {
        self.ephemerides
            .sort_by_key(|e| (e.transmission_time(), e.toe(), e.satellite()));
        self.ephemerides
            .dedup_by(|later, first| match (&*first, &*later) {
                (Ephemeris::Kepler(a), Ephemeris::Kepler(b)) => {
                    // Galileo sends several message types with one issue: both are kept.
                    a.satellite == b.satellite
                        && a.iode == b.iode
                        && a.toe == b.toe
                        && a.data_source == b.data_source
                }
                (Ephemeris::Glonass(a), Ephemeris::Glonass(b)) => {
                    a.satellite == b.satellite && a.toe == b.toe
                }
                (Ephemeris::Sbas(a), Ephemeris::Sbas(b)) => {
                    a.satellite == b.satellite && a.toe == b.toe
                }
                _ => false,
            });
    }
}
