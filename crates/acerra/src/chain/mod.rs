//! The chain: one module for each stage from raw logs to products.

pub mod align;
mod moving;
pub mod position;
pub mod progress;
pub mod read;
mod warnings;

pub use progress::{Progress, Silent};
pub use warnings::Warnings;
