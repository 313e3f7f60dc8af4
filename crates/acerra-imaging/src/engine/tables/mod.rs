//! Range tables.

pub(crate) mod build;
pub(crate) mod fit_error;
pub(crate) mod phases;
pub(crate) mod spec;
