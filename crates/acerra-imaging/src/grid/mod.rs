//! Pixels: planes, tilted planes, uneven ground, volumes.
//!
//! ```text
//! PlaneGrid ──► TiltedGrid ──┐
//! SurfaceGrid (heights) ─────┴──► ImageGrid ──► ImagingPlan
//! VolumeGrid ──► slices, PlaneGrid each
//! ```

mod axis_weights;
pub(crate) mod image;
pub(crate) mod plane;
pub(crate) mod relief;
pub(crate) mod roughness;
pub(crate) mod surface;
pub(crate) mod terrain;
pub(crate) mod tilted;
pub(crate) mod volume;

pub use image::ImageGrid;
pub use plane::{DEFAULT_IMAGE_LIMIT_BYTES, PlaneGrid};
pub use surface::SurfaceGrid;
pub use tilted::TiltedGrid;
pub use volume::VolumeGrid;
