//! The flight: a manually flown straight track with take-off, landing, wind and tilt.

mod model;
mod path;
mod wander;

pub use model::{FlightError, FlightModel};
pub use path::{Flight, Pose};
pub use wander::{Wander, normal};
