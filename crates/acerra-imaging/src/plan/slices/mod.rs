//! Volumes: neighbouring slices that share a plan, and the proof of every slice while it is imaged.

pub(crate) mod forward;
pub(crate) mod groups;
pub(crate) mod plan;
mod proof;
