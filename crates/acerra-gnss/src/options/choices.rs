//! Choices of the settings.

use crate::observations::signal::FREQUENCY_SLOTS;

/// Positioning mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PositioningMode {
    /// Each epoch alone from the rover's pseudoranges; needs no base.
    Single,
    /// Double differences of pseudoranges.
    Dgps,
    /// Carrier phase, moving rover.
    Kinematic,
    /// Carrier phase, rover at rest for the whole file.
    Static,
    /// Carrier phase between two receivers that both move, such as two antennas on one vehicle: the base's
    /// position at each epoch is computed from the base's codes, and the vector from base to rover is
    /// [`Solution::baseline`](crate::Solution::baseline).
    MovingBase,
}

impl PositioningMode {
    /// Whether carrier phases are used.
    #[must_use]
    pub const fn uses_phases(self) -> bool {
        matches!(self, Self::Kinematic | Self::Static | Self::MovingBase)
    }
}

/// Known length of a moving base's baseline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BaselineLength {
    /// Distance between the antennas' phase centres (m).
    pub length_m: f64,
    /// Standard deviation of the length (m).
    pub sigma_m: f64,
}

/// Direction of time in which the filter runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FilterDirection {
    /// First epoch to last.
    Forward,
    /// Last epoch to first.
    Backward,
    /// Both directions, each from a new initial state, then merged.
    Combined,
    /// Both directions, the backward pass starting from the final state of the forward pass, then merged.
    ///
    /// Where fixes must be confirmed ([`min_success_rate`](crate::PpkOptions::min_success_rate)) and
    /// ambiguities are kept between epochs, as [`Combined`](Self::Combined): a pass that starts from another
    /// pass's integers confirms none of these.
    CombinedWithoutReset,
}

impl FilterDirection {
    /// Whether two passes are merged.
    #[must_use]
    pub const fn is_combined(self) -> bool {
        matches!(self, Self::Combined | Self::CombinedWithoutReset)
    }
}

/// Resolution of carrier ambiguities.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum AmbiguityMode {
    /// No resolution: float solution.
    Off,
    /// Integers from the filter's float ambiguities, every epoch.
    Continuous,
    /// Integers from each epoch alone.
    Instantaneous,
    /// As continuous, and after enough consecutive fixes the integers are fed back to the filter.
    FixAndHold,
}

/// Whether GLONASS ambiguities are resolved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum GlonassAmbiguity {
    /// GLONASS phases stay float.
    Off,
    /// Treated as integers (like receivers only).
    On,
    /// Treated as integers after removal of an inter-channel bias linear in the channel number, which is
    /// estimated with the ambiguities (Wanninger 2012, "Carrier-phase inter-frequency biases of GLONASS
    /// receivers"); left float where the phases contradict the other systems.
    Auto,
    /// Inter-channel biases are learnt during the hold, after which GLONASS is included.
    FixAndHold,
}

/// Position of the base antenna's marker.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BasePosition {
    /// A given position (ECEF, m).
    Ecef([f64; 3]),
    /// The approximate position of the base's observation header, plus its antenna offset.
    Header,
    /// Mean of the base's single-point positions.
    AverageSingle,
}

/// Mask of carrier-to-noise density over elevation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cn0Mask {
    /// Least C/N₀ (dB-Hz) at elevations 5°, 15°, …, 85° per frequency slot; linear in between.
    pub min_db_hz: [[f64; 9]; FREQUENCY_SLOTS],
    /// Whether it applies to the rover.
    pub rover: bool,
    /// Whether it applies to the base.
    pub base: bool,
}

impl Cn0Mask {
    /// One least C/N₀ (dB-Hz) at every elevation and frequency, for rover and base.
    #[must_use]
    pub const fn uniform(min_db_hz: f64) -> Self {
        Self {
            min_db_hz: [[min_db_hz; 9]; FREQUENCY_SLOTS],
            rover: true,
            base: true,
        }
    }
}

/// Prediction of the rover's motion from velocity and acceleration states.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dynamics {
    /// Horizontal acceleration noise (m/s²/√s).
    pub horizontal_noise: f64,
    /// Vertical acceleration noise (m/s²/√s).
    pub vertical_noise: f64,
}

impl Dynamics {
    /// The motion of a multicopter, with accelerations of metres per second squared.
    pub const DRONE: Self = Self {
        horizontal_noise: 3.0,
        vertical_noise: 1.0,
    };
}

/// Program whose rules are followed where established programs differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RuleSet {
    /// RTKLIB 2.4.3.
    Rtklib,
    /// The demo5 branch (RTKLIB-EX): made for cheap receivers in motion.
    Demo5,
}

/// Partial ambiguity resolution: leaving satellites out when the ratio test fails.
///
/// With [`RuleSet::Rtklib`] the noisiest satellites are left out one after the other within the
/// epoch, until the test passes or too few remain; with [`RuleSet::Demo5`] one satellite per
/// epoch, in turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PartialAmbiguity {
    /// Put back satellites that join just when the ratio drops.
    pub filter_new_satellites: bool,
    /// Least number of satellites (pairs + 1) for a fix ([`RuleSet::Rtklib`]: once any is left
    /// out).
    pub min_satellites_to_fix: usize,
    /// Least number of pairs for a hold.
    pub min_pairs_to_hold: usize,
    /// Take satellites out one by one after a failure when at least this many pairs were used.
    pub min_pairs_to_drop: usize,
}
