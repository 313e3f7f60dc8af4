//! Single-point positioning from pseudoranges, its validation, and velocity from Doppler.

mod context;
mod equations;
mod solve;
mod velocity;

pub(crate) use context::{SingleContext, SinglePoint};
