//! Radar imaging by the adjoint of the scattering operator.
pub mod error;

mod checks;
mod control;
mod engine;
pub mod grid;
mod incidence;
mod kernel;
pub mod live;
pub mod looks;
pub mod metrics;
pub mod plan;
pub mod psf;
pub mod pulses;
pub mod resolution;
mod sampling;
pub mod sensitivity;
pub mod tracks;
mod vector;
pub mod volume;

pub use control::{Control, Progress};
pub use engine::reference;
pub use error::ImagingError;
pub use grid::{ImageGrid, PlaneGrid, SurfaceGrid, TiltedGrid, VolumeGrid};
pub use incidence::IncidenceWeight;
pub use kernel::level::SimdLevel;
pub use live::LiveImage;
pub use num_complex::{Complex32, Complex64};
pub use plan::{Engine, Forward, ImagingPlan, PlanOptions, PlanReport, SelfCheck, image};
pub use pulses::{PulseArrays, Pulses, SPEED_OF_LIGHT_M_S, Spreading};
pub use volume::{VolumeRun, image_volume};
