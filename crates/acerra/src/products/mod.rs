//! What a run leaves behind: files, and how they get there.

pub mod image_npz;
pub mod inputs;
pub mod stages;
pub mod staging;
