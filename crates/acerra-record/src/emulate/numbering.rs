//! Numbers and stamps of scans that are sent again.

use acerra_radar::mrm::{HEADER_BYTES, ScanHeader};

/// Numbering and stamping of scans after a restart.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Numbering {
    /// As the source has them; the first stamp sets the clock.
    AsSource,
    /// On from the latest, after a pause.
    GoOn,
    /// From 0 on, after a restart.
    FromZero,
}

/// Offset of numbers and stamps from the source's.
#[derive(Clone, Copy, Default)]
pub(super) struct Renumber {
    pub id: u16,
    pub stamp_ms: u32,
}

impl Renumber {
    /// Changes a message's number and stamp.
    pub fn apply(self, message: &mut [u8]) {
        if (self.id, self.stamp_ms) == (0, 0) {
            return;
        }
        if let Ok(mut header) = ScanHeader::parse(message)
            && let Some(bytes) = message.first_chunk_mut::<HEADER_BYTES>()
        {
            header.message_id = header.message_id.wrapping_add(self.id);
            header.timestamp_ms = header.timestamp_ms.wrapping_add(self.stamp_ms);
            *bytes = header.to_bytes();
        }
    }
}
