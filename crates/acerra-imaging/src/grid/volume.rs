//! Boxes of pixels: horizontal slices at even distances.

use super::plane::PlaneGrid;
use crate::checks::{check_pixel, check_places};
use crate::error::ImagingError;

/// A plane grid repeated at the heights z₀ + k·step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VolumeGrid {
    /// The lowest slice.
    pub base: PlaneGrid,
    /// Distance between neighbouring slices, m.
    pub step_m: f64,
    /// Number of slices.
    pub nz: usize,
}

impl VolumeGrid {
    /// `nz` slices, the first at `base`, `step_m` apart.
    ///
    /// # Errors
    /// No slices, or a step that is not positive.
    pub fn new(base: PlaneGrid, step_m: f64, nz: usize) -> Result<Self, ImagingError> {
        if nz == 0 {
            return Err(ImagingError::Empty { what: "volume" });
        }
        check_pixel("step_m", step_m)?;
        let volume = Self { base, step_m, nz };
        check_places("volume", [&volume.slice(nz - 1).point_m(0)])?;
        Ok(volume)
    }

    /// Slice `k`.
    #[must_use]
    pub fn slice(&self, k: usize) -> PlaneGrid {
        PlaneGrid {
            z_m: self.base.z_m + k as f64 * self.step_m,
            ..self.base
        }
    }
}
