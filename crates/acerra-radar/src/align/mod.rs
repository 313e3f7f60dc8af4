//! Finding the offset between the radar's and the trajectory's clock from the data alone.
//!
//! When the platform moves the radargram changes from trace to trace; when it stands it does not.
//! The course of that change is correlated with the platform's speed.

mod activity;
mod offset;

pub use activity::activity;
pub use offset::{AlignError, CoarseOffset, OffsetSearch, coarse_offset};
