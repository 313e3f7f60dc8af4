//! The files of a session's directory, and the outcome of a session.

use acerra_radar::LoggedClock;

use crate::log::LogDamage;

/// Name of the log in a session's directory.
pub const LOG_NAME: &str = "session.log";
/// Name of the capture in a session's directory.
pub const CAPTURE_NAME: &str = "radar.mrm";
/// Name of the receiver's bytes.
pub const ROVER_NAME: &str = "rover.ubx";
/// Name of the clock: that of the capture with another extension.
pub const CLOCK_NAME: &str = "radar.clock.json";
/// Name of the campaign file.
pub const CAMPAIGN_NAME: &str = "campaign.toml";

/// Name of the whole session as one MCAP file.
pub const MCAP_NAME: &str = "session.mcap";

/// What became of a session.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Finished {
    /// Whole scans of the capture.
    pub scans: u64,
    /// Scans of which something is missing.
    pub incomplete_scans: u64,
    /// Bytes of the receiver.
    pub gnss_bytes: u64,
    /// Bytes of the log outside records.
    pub damage: LogDamage,
    /// Whether the recording ended in order.
    pub ended_in_order: bool,
    /// The clock, where it is known.
    pub clock: Option<LoggedClock>,
    /// Data missing for an image, and doubts.
    pub remarks: Vec<String>,
}
