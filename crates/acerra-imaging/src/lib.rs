//! Radar imaging by the adjoint of the scattering operator: reference, fast kernels, resolution, metrics.
//!
//! Data enter as [`Pulses`] (antenna positions, frequencies and one spectrum a pulse), an image is
//! asked for on a grid ([`PlaneGrid`] and its relatives), and [`reference`](mod@reference) holds the
//! double-precision sums that everything faster is measured against.
//!
//! Conventions: SI units; `[x, y, z]` = `[east, north, up]` in metres; signals vary as e^{jωt}, so an
//! echo from range R has phase e^{−j4πfR/c}.

mod direct;
pub mod error;
mod factorized;
pub mod forward;
pub mod grid;
pub mod live;
pub mod looks;
pub mod metrics;
pub mod plan;
mod planar;
pub mod psf;
pub mod pulses;
pub mod reference;
pub mod resolution;
pub mod rows;
pub mod sensitivity;
mod simd;
pub mod surface;
mod table;
pub mod tracks;
mod trial;
pub mod volume;
pub mod weights;

pub use error::ImagingError;
pub use forward::Forward;
pub use grid::PlaneGrid;
pub use live::LiveImage;
pub use num_complex::{Complex32, Complex64};
pub use plan::{Engine, Plan, PlanOptions, Progress, SelfCheck, image};
pub use pulses::{Pulses, SPEED_OF_LIGHT_M_S, Spreading};
pub use rows::TiltedGrid;
pub use simd::SimdLevel;
pub use surface::SurfaceGrid;
pub use volume::{VolumeGrid, VolumeRun};
pub use weights::IncidenceWeight;
