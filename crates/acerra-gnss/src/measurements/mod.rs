//! Measurements of one epoch in the form for positioning, with their noise and masks.

pub(crate) mod base_zeros;
pub(crate) mod common;
pub(crate) mod constellation;
pub(crate) mod matching;
pub(crate) mod measurement;
pub(crate) mod noise;
pub(crate) mod plausible;
pub(crate) mod signal_group;
pub(crate) mod zero;
