//! A session: settings, checks before the flight, recording, and the campaign made of it.

mod plausibility;
mod settings;

pub use plausibility::{Doubt, doubts, shortest_interval_s};
pub use settings::{FlightSection, GnssSection, RadioSection, Session, SettingsError};
