//! Quantities of the whole flight, and what an autofocus says of them.

use serde::Serialize;

/// What a quantity of the whole flight is.
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
        }
    }

    /// The unit of its value.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Delay => "ns",
            Self::ClockOffset => "s",
            Self::ClockDrift => "ppm",
            Self::LightSpeed => "m/s",
            Self::LeverForward | Self::LeverLeft | Self::LeverUp | Self::Height => "m",
        }
    }

    /// Its unit over that of the estimate: ranges for delays, shares for speeds.
    pub(crate) fn per_estimated(self, light_speed_m_s: f64) -> f64 {
        match self {
            Self::Delay => 2e9 / light_speed_m_s,
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
    /// The track whose it is, where there are several and each has its own.
    pub track: Option<usize>,
    /// Its value, in the quantity's unit.
    pub value: f64,
    /// Its posterior standard deviation.
    pub sigma: f64,
    /// Its prior standard deviation.
    pub prior_sigma: f64,
}
