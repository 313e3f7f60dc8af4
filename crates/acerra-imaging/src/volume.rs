//! Volumes: horizontal slices imaged one after another, so that memory stays that of one slice.

use crate::grid::PlaneGrid;
use crate::{ImagingError, Plan, PlanOptions, Pulses};
use num_complex::Complex32;

/// What imaging a volume took.
#[derive(Debug, Clone, PartialEq)]
pub struct VolumeRun {
    /// The plan of the slice that needed most, in words.
    pub explained: String,
    /// Most bytes that a slice and its tables took together.
    pub memory_bytes: u128,
    /// Largest relative error that a slice's self-check found.
    pub checked_error: Option<f64>,
}

/// Least pixels of a slice's self-check.
const LEAST_CHECK: usize = 8;

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
    /// memory serves all. The pixels of the self-check are shared out among the slices.
    ///
    /// # Errors
    /// As [`Plan::new`], and whatever `take` returns.
    pub fn image<E: From<ImagingError>>(
        &self,
        pulses: Pulses,
        options: &PlanOptions,
        mut take: impl FnMut(usize, &PlaneGrid, &[Complex32]) -> Result<(), E>,
    ) -> Result<VolumeRun, E> {
        let mut image = vec![Complex32::ZERO; self.base.len()];
        let mut run = VolumeRun {
            explained: String::new(),
            memory_bytes: 0,
            checked_error: None,
        };
        let options = PlanOptions {
            check_pixels: (options.check_pixels / self.nz).max(LEAST_CHECK),
            ..*options
        };
        for k in 0..self.nz {
            let slice = self.slice(k);
            let plan = Plan::new(pulses, slice, &options)?;
            plan.run(&mut image, &|_| ())?;
            if plan.memory_bytes() > run.memory_bytes {
                run.memory_bytes = plan.memory_bytes();
                run.explained = plan.explain();
            }
            if let Some(check) = plan.self_check() {
                run.checked_error = Some(run.checked_error.unwrap_or(0.0).max(check.error));
            }
            drop(plan);
            take(k, &slice, &image)?;
        }
        Ok(run)
    }
}
