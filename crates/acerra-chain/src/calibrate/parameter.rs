//! Unknowns of a calibration: names, units, and the accuracy from which a value counts as observed.

/// An unknown of the calibration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// Fast time at which range is zero (s).
    Delay,
    /// Apparent over true range, less one: the stated propagation speed over the true one.
    RangeScale,
    /// Phase centre ahead of the positioned point (m).
    Forward,
    /// Phase centre left of the positioned point (m).
    Left,
    /// Phase centre above it (m).
    Up,
    /// Trajectory time minus radar time of a track, by its number from 0 (s).
    ClockOffset(usize),
}

/// Unknowns that all tracks share.
const SHARED: [Parameter; 5] = [
    Parameter::Delay,
    Parameter::RangeScale,
    Parameter::Forward,
    Parameter::Left,
    Parameter::Up,
];

impl Parameter {
    /// The unknowns for a number of tracks.
    #[must_use]
    pub fn all(tracks: usize) -> Vec<Self> {
        let offsets = (0..tracks).map(Self::ClockOffset);
        SHARED.into_iter().chain(offsets).collect()
    }

    /// Name.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::Delay => "delay".to_owned(),
            Self::RangeScale => "range scale".to_owned(),
            Self::Forward => "lever arm forward".to_owned(),
            Self::Left => "lever arm left".to_owned(),
            Self::Up => "lever arm up".to_owned(),
            Self::ClockOffset(0) => "clock offset".to_owned(),
            Self::ClockOffset(track) => format!("clock offset of track {}", track + 1),
        }
    }

    /// The unit in which values are shown, and the number of such units in an SI unit.
    #[must_use]
    pub const fn unit(self) -> (&'static str, f64) {
        match self {
            Self::Delay => ("ns", 1e9),
            Self::RangeScale => ("ppm", 1e6),
            Self::Forward | Self::Left | Self::Up => ("m", 1.0),
            Self::ClockOffset(_) => ("s", 1.0),
        }
    }

    /// Largest standard deviation of a value that counts as observed (SI units). A calibration is made for
    /// delay and offsets: they are held only where the data hardly depend on them. A tape measure gives a
    /// lever arm better from 1 cm on, the propagation speed in air from 5·10⁻⁴ on. A lever arm ahead trades
    /// with the clock offset: 6 mm of it at 2 m/s are 3 ms. A clock offset is known from elsewhere to half a second, the
    /// deviation of a second to either side.
    #[must_use]
    pub const fn sigma_limit(self) -> f64 {
        match self {
            Self::Delay => 0.5e-9,
            Self::RangeScale => 5e-4,
            Self::Forward => 0.006,
            Self::Left | Self::Up => 0.01,
            Self::ClockOffset(_) => 0.5,
        }
    }

    /// Order in which unobserved unknowns are held: first the unknown known best from elsewhere.
    pub(super) const fn hold_rank(self) -> usize {
        match self {
            Self::RangeScale => 0,
            Self::Up => 1,
            Self::Left => 2,
            Self::Forward => 3,
            Self::ClockOffset(_) => 4,
            Self::Delay => 5,
        }
    }
}

/// Values of all unknowns.
#[derive(Clone, Debug, PartialEq)]
pub struct Values {
    /// Fast time at which range is zero (s).
    pub delay_s: f64,
    /// Apparent over true range, less one.
    pub range_scale: f64,
    /// Phase centre from the positioned point: forward, left, up (m).
    pub lever_arm_m: [f64; 3],
    /// Trajectory time minus radar time, one for each track (s).
    pub time_offset_s: Vec<f64>,
}

impl Values {
    /// The value of one unknown (SI units).
    #[must_use]
    pub fn get(&self, parameter: Parameter) -> f64 {
        match parameter {
            Parameter::Delay => self.delay_s,
            Parameter::RangeScale => self.range_scale,
            Parameter::Forward => self.lever_arm_m[0],
            Parameter::Left => self.lever_arm_m[1],
            Parameter::Up => self.lever_arm_m[2],
            Parameter::ClockOffset(track) => self.time_offset_s[track],
        }
    }

    pub(super) fn add(&mut self, parameter: Parameter, step: f64) {
        let value = match parameter {
            Parameter::Delay => &mut self.delay_s,
            Parameter::RangeScale => &mut self.range_scale,
            Parameter::Forward => &mut self.lever_arm_m[0],
            Parameter::Left => &mut self.lever_arm_m[1],
            Parameter::Up => &mut self.lever_arm_m[2],
            Parameter::ClockOffset(track) => &mut self.time_offset_s[track],
        };
        *value += step;
    }

    /// All unknowns.
    #[must_use]
    pub fn parameters(&self) -> Vec<Parameter> {
        Parameter::all(self.time_offset_s.len())
    }
}
