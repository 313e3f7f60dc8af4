//! The flight: a manually flown straight track with take-off, landing, wind and tilt, or positions
//! from a file.

mod given;
mod model;
mod path;
mod wander;

pub use given::{GivenFlight, GivenFlightError};
pub use model::FlightModel;
pub use path::{Flight, Pose};
pub use wander::{Wander, normal};
