//! The factorized engine.

pub(crate) mod aperture;
pub(crate) mod bandwidth;
pub(crate) mod cell;
pub(crate) mod coarse;
mod coarse_rows;
mod estimate;
mod heights;
mod interpolation;
pub(crate) mod lattice;
pub(crate) mod merged;
mod merging;
pub(crate) mod relief_error;
pub(crate) mod segments;
pub(crate) mod spec;
pub(crate) mod two_stages;
