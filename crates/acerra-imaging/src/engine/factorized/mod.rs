//! The factorized engine.

pub(crate) mod aperture;
pub(crate) mod cell;
pub(crate) mod coarse;
mod estimate;
mod interpolation;
pub(crate) mod lattice;
pub(crate) mod merged;
pub(crate) mod segments;
pub(crate) mod spec;
