//! Volumes: horizontal slices imaged one after another, so that memory stays that of one slice.

use crate::grid::PlaneGrid;
use crate::{ImagingError, Plan, PlanOptions, Pulses};
use num_complex::Complex32;

/// A box of pixels: a plane grid repeated at heights z₀ + k·step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VolumeGrid {
    /// The lowest slice.
    pub base: PlaneGrid,
    /// Distance of the slices, m.
    pub step_m: f64,
    /// Number of slices.
    pub nz: usize,
}

impl VolumeGrid {
    /// `nz` slices above `base`, `step_m` apart.
    ///
    /// # Errors
    /// No slices, or a step that is not positive.
    pub fn new(base: PlaneGrid, step_m: f64, nz: usize) -> Result<Self, ImagingError> {
        if nz == 0 {
            return Err(ImagingError::Empty { what: "volume" });
        }
        if !(step_m.is_finite() && step_m > 0.0) {
            return Err(ImagingError::OutOfRange {
                what: "step_m",
                expected: "above 0 m",
                found: step_m,
            });
        }
        Ok(Self { base, step_m, nz })
    }

    /// Slice `k`.
    #[must_use]
    pub fn slice(&self, k: usize) -> PlaneGrid {
        PlaneGrid {
            z_m: self.base.z_m + k as f64 * self.step_m,
            ..self.base
        }
    }

    /// Images slice after slice and hands each to `take` (index, grid, `[ny, nx]` image); the same
    /// memory serves all.
    ///
    /// # Errors
    /// As [`Plan::new`], and whatever `take` returns.
    pub fn image<E: From<ImagingError>>(
        &self,
        pulses: Pulses,
        options: &PlanOptions,
        mut take: impl FnMut(usize, &PlaneGrid, &[Complex32]) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut image = vec![Complex32::ZERO; self.base.len()];
        for k in 0..self.nz {
            let slice = self.slice(k);
            Plan::new(pulses, slice, options)?.run(&mut image, &|_| ())?;
            take(k, &slice, &image)?;
        }
        Ok(())
    }
}
