//! Simulation of whole campaigns: the logs that the instruments would have written.

pub mod flight;
pub mod gnss;
pub mod radar;
pub mod scene;
pub mod write;
