//! A session: settings, checks before the flight, recording, and the campaign of the recording.

mod aside;
mod campaign;
mod capture;
mod finish;
mod finish_error;
mod fix_source;
mod fix_spans;
mod fix_watch;
mod live_section;
mod log_content;
mod mcap_file;
mod outcome;
mod outlet;
mod plausibility;
mod progress;
mod pulse_loop;
mod radio_loop;
mod receiver_loop;
mod record_error;
mod recorder;
mod reminder;
mod session_clock;
mod settings;
mod silence;
mod tap;
mod window_watch;

pub use capture::{ArrivalTimes, CaptureWriter};
pub use finish::finish;
pub use finish_error::FinishError;
pub use fix_source::FixSource;
pub use live_section::LiveSection;
pub use mcap_file::write_mcap;
pub use outcome::{
    CAMPAIGN_NAME, CAPTURE_NAME, CLOCK_NAME, Finished, LOG_NAME, MCAP_NAME, ROVER_NAME,
};
pub use plausibility::{Doubt, doubts, shortest_interval_s};
pub use progress::{Fix, Health, Progress};
pub use record_error::RecordError;
pub use recorder::Recorder;
pub use settings::{FlightSection, GnssSection, RadioSection, Session, SettingsError, Way};
pub use silence::{LEAST_SILENCE, Silence, SilenceWatch};
pub use tap::{Tap, Tapped};
