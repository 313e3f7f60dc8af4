//! The processing chain: one module for each stage from raw logs to a measured image.

pub mod align;
pub mod campaign;
pub mod clean;
mod elevation;
pub mod focus;
pub mod ground;
pub mod inputs;
pub mod measure;
pub mod memory;
pub mod offset;
mod outcome;
mod path_text;
pub mod position;
pub mod positioning;
pub mod progress;
pub mod read;
mod space;
pub mod stack_npz;
pub mod stacks;
pub mod stages;
pub mod staging;
pub mod tracks;
mod warnings;

pub use outcome::{Outcome, run};
pub use progress::{Progress, Silent};
pub use warnings::Warnings;
