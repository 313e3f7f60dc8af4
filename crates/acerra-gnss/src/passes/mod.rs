//! Passes of the filter over all epochs, and the merging of two passes.

pub(crate) mod base_views;
pub(crate) mod combine;
pub(crate) mod float_errors;
pub(crate) mod overlay;
pub(crate) mod pass;
pub(crate) mod precision;
pub(crate) mod time_correlation;
