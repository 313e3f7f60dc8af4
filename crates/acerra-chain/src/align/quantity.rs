//! Quantities of the whole flight or of a track, and their estimates by an autofocus.

use serde::Serialize;

/// Kinds of quantities of the whole flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// Fast time at which range is zero, ns.
    Delay,
    /// Trajectory time minus radar time, s.
    ClockOffset,
    /// Its drift about the middle of the track, ppm.
    ClockDrift,
    /// Lever arm forward, m.
    LeverForward,
    /// Lever arm to the left, m.
    LeverLeft,
    /// Lever arm up, m.
    LeverUp,
    /// Height of all traces above the scene, m.
    Height,
    /// Propagation speed, m/s.
    LightSpeed,
    /// Delay of a track's instrument relative to the other tracks', ns.
    TrackDelay,
    /// Phase of a track's instrument against the first track's, degrees.
    TrackPhase,
    /// Error that a track's positions have in common, east, m.
    TrackEast,
    /// The same, north, m.
    TrackNorth,
    /// The same, up, m.
    TrackUp,
    /// Its change about the middle of the track, east, m/s.
    TrackEastRate,
    /// The same, north, m/s.
    TrackNorthRate,
    /// The same, up, m/s.
    TrackUpRate,
}

impl Quantity {
    /// Its name in findings.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Delay => "delay",
            Self::ClockOffset => "clock_offset",
            Self::ClockDrift => "clock_drift",
            Self::LeverForward => "lever_forward",
            Self::LeverLeft => "lever_left",
            Self::LeverUp => "lever_up",
            Self::Height => "height",
            Self::LightSpeed => "light_speed",
            Self::TrackDelay => "track_delay",
            Self::TrackPhase => "track_phase",
            Self::TrackEast => "track_east",
            Self::TrackNorth => "track_north",
            Self::TrackUp => "track_up",
            Self::TrackEastRate => "track_east_rate",
            Self::TrackNorthRate => "track_north_rate",
            Self::TrackUpRate => "track_up_rate",
        }
    }

    /// The unit of its value.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Delay | Self::TrackDelay => "ns",
            Self::TrackPhase => "°",
            Self::ClockOffset => "s",
            Self::ClockDrift => "ppm",
            Self::LightSpeed => "m/s",
            Self::TrackEastRate | Self::TrackNorthRate | Self::TrackUpRate => "m/s",
            Self::LeverForward | Self::LeverLeft | Self::LeverUp | Self::Height => "m",
            Self::TrackEast | Self::TrackNorth | Self::TrackUp => "m",
        }
    }

    /// Its unit over that of the estimate: ranges for delays, radians for phases, shares for speeds.
    pub(crate) fn per_estimated(self, light_speed_m_s: f64) -> f64 {
        match self {
            Self::Delay | Self::TrackDelay => 2e9 / light_speed_m_s,
            Self::TrackPhase => 1_f64.to_degrees(),
            Self::LightSpeed => light_speed_m_s,
            _ => 1.0,
        }
    }
}

/// A quantity of the whole flight that was left free: true less stated.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GlobalCorrection {
    /// Which.
    pub quantity: Quantity,
    /// The track that the quantity belongs to, where there are several tracks with a value each.
    pub track: Option<usize>,
    /// Whether range zero moves with the quantity: the surface echo defined range zero, at the height of the
    /// positions.
    pub moves_zero: bool,
    /// Its value, in the quantity's unit.
    pub value: f64,
    /// Its posterior standard deviation.
    pub sigma: f64,
    /// Its prior standard deviation.
    pub prior_sigma: f64,
}
