//! The point spread function of a flight: Eqs. (4) and (5) of Catapano et al. (2020).
//!
//! [`PointSpread`] evaluates the image of a point exactly, in double precision, wherever it is
//! wanted; with evenly spaced frequencies their sum has a closed form, so a value costs one term
//! per pulse.

mod cell;
mod field;
mod spread;

pub use cell::Cell;
pub use field::PsfField;
pub use spread::PointSpread;
