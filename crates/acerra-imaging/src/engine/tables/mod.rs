//! Range tables.

pub(crate) mod build;
pub(crate) mod phases;
pub(crate) mod spec;
