//! Inversion for the scene instead of backprojection: `[image] method`.
//!
//! ```text
//! Echoes ──► Flight ──► noise level ──► solver ──► scene ──► Focused
//!                           │             ▲           │
//!                        λ, δ, thresholds ┘           └──► unit points ──► resolution ──► InversionRecord
//! ```

pub mod image;
pub mod noise;
pub mod options;
pub mod record;
mod resolution;
mod solve;

pub use options::{InversionOptions, InversionSection, Method};
pub use record::InversionRecord;
