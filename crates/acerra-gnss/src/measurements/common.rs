//! Satellites that rover and base share.

/// A satellite seen by rover and base.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Common {
    pub satellite: usize,
    /// Index among the rover's measurements.
    pub rover: usize,
    /// Index among the base's measurements.
    pub base: usize,
}
