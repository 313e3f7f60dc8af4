//! The point spread function of a flight: Eqs. (4) and (5) of Catapano et al. (2020).
//!
//! [`PointSpread`] evaluates the image of a point exactly, in double precision, wherever it is
//! wanted; with evenly spaced frequencies their sum has a closed form, so a value costs one term
//! per pulse. [`Analysis`] measures it by the definitions of [`metrics`](crate::metrics),
//! [`psf_image`] fills a grid, [`retrieve`] finds several targets again on a plane that need not be
//! theirs.

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
