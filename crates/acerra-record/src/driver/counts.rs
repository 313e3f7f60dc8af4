//! Counts of a radio's link: received, incomplete and lost messages.

use std::fmt;

/// Received and lost messages of the radio.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[non_exhaustive]
pub struct LinkCounts {
    /// Messages of every kind that came.
    pub packets: u64,
    /// Bytes.
    pub bytes: u64,
    /// SCAN_INFO messages among them.
    pub scan_messages: u64,
    /// Messages that are none of the MRM interface, or contradict themselves.
    pub undecodable: u64,
    /// Messages that came again.
    pub repeated: u64,
    /// Messages that others overtook.
    pub reordered: u64,
    /// Messages that came after their scan had been given up.
    pub late: u64,
    /// Scans of which every message came.
    pub whole_scans: u64,
    /// Scans with missing messages, none of which is expected any more.
    pub incomplete_scans: u64,
    /// Scans of which no message came, though the radio made them.
    pub lost_scans: u64,
    /// Scans in progress: some of their messages have arrived.
    pub scans_under_way: u64,
    /// Restarts of the radio.
    pub restarts: u64,
    /// Times the radio fell silent while it should scan.
    pub silences: u64,
    /// Requests that had to be sent again.
    pub retries: u64,
}

impl LinkCounts {
    /// Scans that the radio made: whole, incomplete, lost, in progress.
    #[must_use]
    pub fn scans_made(&self) -> u64 {
        self.whole_scans + self.incomplete_scans + self.lost_scans + self.scans_under_way
    }
}

/// `799 whole scans; 1 incomplete, 2 lost`.
impl fmt::Display for LinkCounts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} whole scans", self.whole_scans)?;
        let mut sign = ';';
        for (count, what) in [
            (self.incomplete_scans, "incomplete"),
            (self.lost_scans, "lost"),
            (self.repeated, "messages repeated"),
            (self.reordered, "messages out of order"),
            (self.late, "messages too late"),
            (self.undecodable, "messages that cannot be read"),
            (self.restarts, "restarts of the radio"),
            (self.silences, "silences"),
        ] {
            if count > 0 {
                write!(f, "{sign} {count} {what}")?;
                sign = ',';
            }
        }
        Ok(())
    }
}
