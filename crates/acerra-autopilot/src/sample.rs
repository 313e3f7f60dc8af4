//! Data of logs of every format: positions, attitudes and clock readings.

use acerra_geo::geodesy::Geodetic;
use acerra_geo::time::GpsTime;
use acerra_geo::trajectory::{Attitude, SolutionStatus};

use crate::format::LogFormat;

/// When a sample was taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stamp {
    /// An instant of GPS time.
    Gps(GpsTime),
    /// Seconds of the autopilot's clock, from its start.
    Boot(f64),
}

/// Datum of a height.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum HeightDatum {
    /// The WGS84 ellipsoid.
    Ellipsoid,
    /// The mean sea level of the receiver's geoid.
    SeaLevel,
}

/// Place of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Place {
    /// On the Earth; with the datum of its height.
    Geodetic(Geodetic, HeightDatum),
    /// In the robot's local axes, z up (m).
    Local([f64; 3]),
}

impl Place {
    /// Latitude and longitude (degrees) and height (m) above `datum`; none where they cannot be, or are
    /// the zeros of a receiver that does not know.
    pub fn on_earth(
        [latitude_deg, longitude_deg, height_m]: [f64; 3],
        datum: HeightDatum,
    ) -> Option<Self> {
        let is_place = latitude_deg.abs() <= 90.0
            && longitude_deg.abs() <= 180.0
            && height_m.abs() < 1e5
            && (latitude_deg, longitude_deg) != (0.0, 0.0);
        let place = Geodetic::from_degrees(latitude_deg, longitude_deg, height_m);
        is_place.then_some(Self::Geodetic(place, datum))
    }
}

/// GPS time of microseconds since 1970 UTC; none of a time before 2005 or after 2100, which is no
/// receiver's.
pub fn gps_time_of_unix_us(micros: i64) -> Option<GpsTime> {
    let is_known = (1_104_537_600_000_000..4_102_444_800_000_000).contains(&micros);
    let (seconds, rest) = (micros.div_euclid(1_000_000), micros.rem_euclid(1_000_000));
    is_known.then(|| GpsTime::from_unix(seconds, rest as f64 * 1e-6))
}

/// One position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PositionSample {
    /// When.
    pub stamp: Stamp,
    /// The autopilot's clock at its arrival (s), where the log states it with GPS time.
    pub arrival_s: Option<f64>,
    /// Where.
    pub place: Place,
    /// Standard deviations east, north, up (m), where the source states them.
    pub sigma_m: Option<[f64; 3]>,
    /// Velocity east, north, up (m/s), where the source states it.
    pub velocity_m_s: Option<[f64; 3]>,
    /// Kind of solution; none where the source does not say.
    pub status: Option<SolutionStatus>,
    /// Satellites used, where the source says.
    pub satellites: Option<u16>,
}

/// One attitude.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AttitudeSample {
    /// When.
    pub stamp: Stamp,
    /// From the body's forward, left, up to east, north, up.
    pub attitude: Attitude,
}

/// Source of positions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SourceKind {
    /// A GNSS receiver.
    Gnss,
    /// The autopilot's estimate from GNSS, inertial sensors and barometer.
    Filter,
}

impl std::fmt::Display for SourceKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            Self::Gnss => "GNSS receiver",
            Self::Filter => "position filter",
        })
    }
}

/// Positions of one source, in the order of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct PositionSource {
    /// Name, unique in the log.
    pub name: String,
    /// Source of the samples.
    pub kind: SourceKind,
    /// Of several of a kind the lowest rank is used; the user chooses among those of one rank.
    pub rank: u8,
    /// The positions.
    pub samples: Vec<PositionSample>,
    /// Records without a position.
    pub without_position: usize,
}

/// Attitudes of one source, in the order of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct AttitudeSource {
    /// Name, unique in the log.
    pub name: String,
    /// As of [`PositionSource::rank`].
    pub rank: u8,
    /// The attitudes.
    pub samples: Vec<AttitudeSample>,
}

/// Reference of an attitude's yaw.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum YawFrom {
    /// North.
    North,
    /// The direction of the vehicle's nose over the ground.
    Nose,
}

/// Who gives a gimbal's attitude.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Teller {
    /// The gimbal, which measures it.
    Gimbal,
    /// The autopilot: the gimbal's measurement, or its own command to servos.
    Autopilot,
    /// The autopilot, on servos without feedback: its commands.
    Servos,
    /// As above, by its version from the horizon or from the vehicle's own axes.
    ServosOfUnknownFrame,
}

/// One attitude of a gimbal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GimbalSample {
    /// When.
    pub stamp: Stamp,
    /// From the gimbal's forward, left, up to east, north, up, as if the vehicle's nose pointed north where yaw
    /// counts from the nose.
    pub attitude: Attitude,
    /// What yaw counts from.
    pub yaw: YawFrom,
    /// The gimbal reports a failure that puts its attitude in doubt.
    pub is_doubted: bool,
    /// Who gives it.
    pub teller: Teller,
}

impl GimbalSample {
    /// An attitude measured by the gimbal without a reason for doubt.
    pub const fn new(stamp: Stamp, attitude: Attitude, yaw: YawFrom) -> Self {
        Self {
            stamp,
            attitude,
            yaw,
            is_doubted: false,
            teller: Teller::Gimbal,
        }
    }
}

/// Attitudes of one gimbal, in the order of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct GimbalSource {
    /// Name, unique in the log.
    pub name: String,
    /// Of several kinds of message the one of lowest rank is taken.
    pub rank: u8,
    /// The attitudes.
    pub samples: Vec<GimbalSample>,
    /// Records without an attitude that can be used.
    pub without_attitude: usize,
}

/// A reading of the autopilot's clock with GPS time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClockPair {
    /// The autopilot's clock (s).
    pub boot_s: f64,
    /// GPS time.
    pub gps: GpsTime,
}

/// Origin of the readings of the clocks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PairKind {
    /// The autopilot's clock at the arrival of a message that the receiver made some time before.
    Arrival,
    /// Both clocks at one instant.
    Simultaneous,
}

/// Bytes that belong to no record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Damage {
    /// Count.
    pub bytes: u64,
    /// Stretches of them.
    pub places: u64,
    /// Where the first is.
    pub first_offset: u64,
}

impl Damage {
    /// Counts a stretch of `bytes` at `offset`.
    pub fn add(&mut self, offset: u64, bytes: u64) {
        if self.places == 0 {
            self.first_offset = offset;
        }
        self.places += 1;
        self.bytes += bytes;
    }
}

/// Everything of a log that matters here.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// The kind of log.
    pub format: LogFormat,
    /// Positions by source, in the order of their first sample.
    pub positions: Vec<PositionSource>,
    /// Attitudes by source, in the order of their first sample.
    pub attitudes: Vec<AttitudeSource>,
    /// Attitudes of gimbals by source, in the order of their first record.
    pub gimbals: Vec<GimbalSource>,
    /// Readings of the autopilot's clock with GPS time.
    pub pairs: Vec<ClockPair>,
    /// Origin of the readings.
    pub pair_kind: PairKind,
    /// Records that give such readings in this format.
    pub pair_source: &'static str,
    /// Times by an unrelated clock suffice: those of positions without a place on the Earth.
    pub allows_own_clock: bool,
    /// Bytes that belong to no record.
    pub damage: Damage,
    /// Bytes read.
    pub bytes: u64,
    /// Remarks of the format's reader, as sentences.
    pub remarks: Vec<String>,
}
