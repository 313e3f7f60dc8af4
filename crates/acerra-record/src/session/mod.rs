//! A session: settings, checks before the flight, recording, and the campaign made of it.

mod campaign;
mod capture;
mod finish;
mod outcome;
mod plausibility;
mod recorder;
mod settings;

pub use capture::{ArrivalTimes, CaptureWriter};
pub use finish::{FinishError, finish};
pub use outcome::{CAMPAIGN_NAME, CAPTURE_NAME, CLOCK_NAME, Finished, LOG_NAME, ROVER_NAME};
pub use plausibility::{Doubt, doubts, shortest_interval_s};
pub use recorder::{Health, Progress, RecordError, Recorder};
pub use settings::{FlightSection, GnssSection, RadioSection, Session, SettingsError, Way};
