//! What a plan is asked for, and what it tells.

use crate::simd::SimdLevel;
use crate::{IncidenceWeight, Spreading};

/// Which algorithm makes the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Engine {
    /// The cheapest that keeps the accuracy.
    #[default]
    Auto,
    /// Every pulse at every pixel, through range tables and SIMD.
    Direct,
    /// Sub-apertures on coarse grids, merged: cost grows gently with pulses and pixels.
    Factorized,
    /// The double-precision sum over frequencies itself.
    Reference,
}

/// What is asked of a plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanOptions {
    /// Relative L2 error allowed against Eq. (3) in double precision; 10⁻³ by default.
    pub accuracy: f64,
    /// Weight by range; 1/R² by default.
    pub spreading: Spreading,
    /// Weight by incidence and antenna pattern, for level planes; none by default.
    pub incidence: Option<IncidenceWeight>,
    /// Instruction set; the best of this processor by default.
    pub level: SimdLevel,
    /// Algorithm; chosen by cost by default.
    pub engine: Engine,
    /// Most bytes that tables and image may take together; 64 GiB by default.
    pub memory_limit_bytes: u128,
    /// Most random pixels of the self-check; 256 by default, at least 1.
    pub check_pixels: usize,
}

impl Default for PlanOptions {
    fn default() -> Self {
        Self {
            accuracy: 1e-3,
            spreading: Spreading::default(),
            incidence: None,
            level: SimdLevel::detect(),
            engine: Engine::default(),
            memory_limit_bytes: crate::grid::DEFAULT_IMAGE_LIMIT_BYTES,
            check_pixels: 256,
        }
    }
}

/// How far a run has come, in pixel × pulse contributions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Contributions summed so far.
    pub done: u64,
    /// Contributions in the whole image.
    pub total: u64,
}

/// What a self-check of a plan found on random pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SelfCheck {
    /// Pixels compared with the double-precision sum.
    pub pixels: usize,
    /// Relative L2 error found on them.
    pub error: f64,
}
