//! Options of a plan.

use crate::grid::plane::DEFAULT_IMAGE_LIMIT_BYTES;
use crate::incidence::IncidenceWeight;
use crate::kernel::level::SimdLevel;
use crate::pulses::Spreading;
use serde::Serialize;

/// Algorithm of a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Engine {
    /// The engine that is cheaper by the cost models, planning and one run together.
    #[default]
    Auto,
    /// Every pulse at every pixel, through range tables and SIMD.
    Direct,
    /// Sub-apertures on coarse grids, merged: cost grows slowly with pulses and pixels.
    Factorized,
    /// Every pulse at every pixel, through range tables in double precision: the choice of [`Engine::Auto`]
    /// for accuracies beyond single precision.
    Double,
    /// The double-precision sum over frequencies itself.
    Reference,
}

/// Requirements on a plan.
///
/// ```
/// use acerra_imaging::{Engine, PlanOptions};
/// let options = PlanOptions::default().with_accuracy(1e-4).with_engine(Engine::Direct);
/// assert_eq!((options.accuracy, options.check_pixels), (1e-4, 256));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
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
    /// Limit on the bytes of tables and image together; 64 GiB by default.
    pub memory_limit_bytes: u128,
    /// Most random pixels of the self-check; 256 by default, at least 1. Large tasks check fewer.
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
            memory_limit_bytes: DEFAULT_IMAGE_LIMIT_BYTES,
            check_pixels: 256,
        }
    }
}

impl PlanOptions {
    /// These options with another relative L2 error allowed.
    #[must_use]
    pub fn with_accuracy(self, accuracy: f64) -> Self {
        Self { accuracy, ..self }
    }

    /// These options with another weight by range.
    #[must_use]
    pub fn with_spreading(self, spreading: Spreading) -> Self {
        Self { spreading, ..self }
    }

    /// These options with another weight by incidence, or none.
    #[must_use]
    pub fn with_incidence(self, incidence: Option<IncidenceWeight>) -> Self {
        Self { incidence, ..self }
    }

    /// These options with another instruction set.
    #[must_use]
    pub fn with_level(self, level: SimdLevel) -> Self {
        Self { level, ..self }
    }

    /// These options with another algorithm.
    #[must_use]
    pub fn with_engine(self, engine: Engine) -> Self {
        Self { engine, ..self }
    }

    /// These options with another limit of memory.
    #[must_use]
    pub fn with_memory_limit_bytes(self, memory_limit_bytes: u128) -> Self {
        Self {
            memory_limit_bytes,
            ..self
        }
    }

    /// These options with another number of pixels in the self-check.
    #[must_use]
    pub fn with_check_pixels(self, check_pixels: usize) -> Self {
        Self {
            check_pixels,
            ..self
        }
    }
}

/// Result of a plan's self-check on random pixels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SelfCheck {
    /// Pixels compared with the double-precision sum.
    pub pixels: usize,
    /// Relative L2 error found on these pixels.
    pub error: f64,
    /// The relative error plus twice its standard error: the value by which a plan is accepted.
    pub error_bound: f64,
}
