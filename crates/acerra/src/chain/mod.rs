//! The chain: one module for each stage from raw logs to products.

pub mod align;
pub mod clean;
mod elevation;
pub mod focus;
pub mod ground;
pub mod measure;
pub mod offset;
mod outcome;
pub mod position;
pub mod progress;
pub mod read;
mod space;
pub mod stacks;
pub mod tracks;
mod warnings;

pub use outcome::{Outcome, run};
pub use progress::{Progress, Silent};
pub use warnings::Warnings;
