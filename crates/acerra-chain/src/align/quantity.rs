//! Quantities of the whole flight or of a track that an autofocus estimates.

use serde::Serialize;

/// Kinds of quantities of the whole flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// Fast time at which range is zero, ns.
    Delay,
    /// Trajectory time minus radar time, s.
    ClockOffset,
    /// Drift of the clock offset about the middle of the track, ppm.
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
    /// Delay of a track's instrument relative to the other tracks, ns.
    TrackDelay,
    /// Phase of a track's instrument relative to the first track, degrees.
    TrackPhase,
    /// Common error of a track's positions, east, m.
    TrackEast,
    /// Common error of a track's positions, north, m.
    TrackNorth,
    /// Common error of a track's positions, up, m.
    TrackUp,
    /// Rate of the positions' error about the middle of the track, east, m/s.
    TrackEastRate,
    /// Rate of the positions' error about the middle of the track, north, m/s.
    TrackNorthRate,
    /// Rate of the positions' error about the middle of the track, up, m/s.
    TrackUpRate,
}

impl Quantity {
    /// Name of the quantity in findings.
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

    /// Unit of the quantity's value.
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

    /// Factor from the unit of the estimate (ranges for delays, radians for phases, shares for speeds) to the
    /// quantity's unit.
    pub(crate) fn per_estimated(self, light_speed_m_s: f64) -> f64 {
        match self {
            Self::Delay | Self::TrackDelay => 2e9 / light_speed_m_s,
            Self::TrackPhase => 1_f64.to_degrees(),
            Self::LightSpeed => light_speed_m_s,
            _ => 1.0,
        }
    }
}

/// An estimated quantity of the whole flight: true less stated value.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GlobalCorrection {
    /// The quantity.
    pub quantity: Quantity,
    /// The track of the quantity, where several tracks have separate values.
    pub track: Option<usize>,
    /// Whether range zero moves with the quantity: the surface echo defined range zero, at the height of the
    /// positions.
    pub moves_zero: bool,
    /// Value in the quantity's unit.
    pub value: f64,
    /// Posterior standard deviation.
    pub sigma: f64,
    /// Prior standard deviation.
    pub prior_sigma: f64,
}
