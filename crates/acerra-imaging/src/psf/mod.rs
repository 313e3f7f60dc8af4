//! The point spread function of a flight: Eqs. (4) and (5) of Catapano et al. (2020).
//!
//! [`PointSpread`] evaluates the image of a point exactly, in double precision, at any place; the sum over
//! evenly spaced frequencies has a closed form, so that a value costs one term per pulse. [`Analysis`]
//! measures this image by the definitions of [`metrics`](crate::metrics), [`psf_image`] fills a grid, and
//! [`retrieve`] finds the images of several targets on a plane that need not contain them.

pub(crate) mod analysis;
pub(crate) mod cell;
pub(crate) mod elevation;
pub(crate) mod field;
pub(crate) mod image;
pub(crate) mod spread;
pub(crate) mod trajectory;

pub use analysis::{Analysis, Theory, expected_place_m};
pub use cell::Cell;
pub use elevation::{ABSENT_DB, Retrieved, retrieve};
pub use field::PsfField;
pub use image::psf_image;
pub use spread::PointSpread;
pub use trajectory::{TrackShape, synthetic_track};
