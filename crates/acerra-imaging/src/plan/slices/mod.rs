//! Volumes: neighbouring slices share a plan, and every slice is checked while it is imaged.

pub(crate) mod forward;
pub(crate) mod groups;
pub(crate) mod plan;
mod proof;
