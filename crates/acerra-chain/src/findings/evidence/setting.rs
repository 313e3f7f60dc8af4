//! Settings that findings check.

/// A setting whose value a finding may check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    /// The clock offset between radar and trajectory.
    ClockOffset,
    /// The fast time of range zero.
    Delay,
    /// The heights, lever arm up included: what checks them checks the delay as well, but for the direct
    /// coupling.
    Heights,
    /// The lever arm along the nose of the platform.
    LeverArmForward,
    /// The lever arm across it.
    LeverArmLeft,
    /// The position of the base, as far as its own single-point position does not tell it.
    Base,
    /// The axes of positions that a file gives in a frame of its own: ranges are the same in its mirror
    /// image.
    Axes,
    /// Where the antenna looks, from which its pattern counts.
    AntennaAxis,
}
