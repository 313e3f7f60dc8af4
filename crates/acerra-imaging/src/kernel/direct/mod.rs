//! The direct kernel: evenly spaced pixels, level or with separate heights.
//!
//! Work is divided into blocks of N groups of one or two vectors of N pixels of a row. For a pulse and a
//! block the range to the block's centre is computed in double precision. The range to the middle of each
//! group follows as R₀ + (R² − R₀²)/(R + R₀), whose correction is a few decimetres and therefore exact to
//! nanometres in single precision at any distance: R² changes by o(2d + o), o being the group's offset along
//! the row and d the block's offset from the antenna. Within a group the range is a quadratic or cubic in the
//! pixel.
//!
//! Neighbouring pixels see few range bins: a window of N table entries is loaded once and each lane
//! picks its entry inside registers. Where the expansion or the window does not suffice, ranges are
//! exact and entries gathered, for whole blocks. Pixels next to an antenna take the double-precision
//! sum.
//!
//! Groups may also be squares of 4 × 4 pixels ([`square`]), with a polynomial in both directions and windows
//! of one or two registers, as each pulse needs: squares of coarse pixels span fewer range bins than pieces
//! of rows do. Uneven ground always uses squares: the polynomial follows the plane through a square's
//! heights, and heights off the plane enter to third order.
//!
//! Below level ground, antennas apart also take squares: tabulated rays replace the ranges ([`square_rays`]). Below uneven
//! ground rays to the corners of the squares do ([`tile_corners`]).

pub(crate) mod band;
pub(crate) mod corners;
mod evaluator;
mod expansion;
mod followed;
pub(crate) mod job;
pub(crate) mod rays;
pub(crate) mod square;
mod square_corners;
mod square_expansion;
mod square_ground;
mod square_paths;
mod square_rays;
mod square_setup;
mod tile_corners;
mod unwindowed;
