//! Options of the measurement of targets.

use crate::error::ImagingError;

/// Criteria for a target.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct MeasureOptions {
    /// Lowest level relative to the image's maximum, dB (negative).
    pub threshold_db: f64,
    /// A local maximum is a separate target only above this multiple of the level that Eq. (5) predicts there
    /// from the targets already found, for sidelobes and ghosts.
    pub sidelobe_margin: f64,
    /// Most targets.
    pub max_targets: usize,
    /// Whether maxima at the level of the clutter about them are targets too.
    pub clutter: bool,
}

impl Default for MeasureOptions {
    fn default() -> Self {
        Self {
            threshold_db: -15.0,
            sidelobe_margin: 2.0,
            max_targets: 32,
            clutter: false,
        }
    }
}

impl MeasureOptions {
    /// These options with another lowest level, dB.
    #[must_use]
    pub fn with_threshold_db(self, threshold_db: f64) -> Self {
        Self {
            threshold_db,
            ..self
        }
    }

    /// These options with another largest number of targets.
    #[must_use]
    pub fn with_max_targets(self, max_targets: usize) -> Self {
        Self {
            max_targets,
            ..self
        }
    }

    /// These options with maxima at the level of the clutter about them, for a caller who judges these.
    #[must_use]
    pub fn with_clutter(self, clutter: bool) -> Self {
        Self { clutter, ..self }
    }

    /// Refuses values out of range.
    pub(super) fn check(&self) -> Result<(), ImagingError> {
        if !(self.threshold_db < 0.0 && self.threshold_db.is_finite()) {
            return Err(ImagingError::OutOfRange {
                what: "threshold_db",
                expected: "negative (dB relative to the maximum)",
                found: self.threshold_db,
            });
        }
        if !(self.sidelobe_margin >= 1.0 && self.sidelobe_margin.is_finite()) {
            return Err(ImagingError::OutOfRange {
                what: "sidelobe_margin",
                expected: "at least 1",
                found: self.sidelobe_margin,
            });
        }
        Ok(())
    }
}
