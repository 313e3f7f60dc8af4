//! Theoretical resolution of a straight track: Eqs. (6)–(12) and (14) of Catapano et al. (2020).
//!
//! Each equation is a function with its range of validity; [`Prediction`] evaluates the equations for one
//! geometry and lists the equations used outside their range as [`Caveat`]s. [`elevation_m`] covers several
//! tracks.

pub(crate) mod elevation;
pub(crate) mod equations;
pub(crate) mod geometry;
pub(crate) mod map;
pub(crate) mod prediction;

pub use elevation::elevation_m;
pub use equations::{
    SMALL_ANGLE_LIMIT_RAD, across_track_bounds_m, across_track_m, across_track_nadir_m,
    along_track_m, along_track_small_angle_m, displacement_m, half_view_rad, longest_step_m,
    range_m, unambiguous_range_m,
};
pub use geometry::{Aperture, Band};
pub use map::across_track_map_m;
pub use prediction::{Caveat, Prediction};
