//! A second receiver of a recording's records, for observers during the recording.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Instant;

use crate::host::HostClock;
use crate::log::Record;

/// A record of the log, and when it came.
#[derive(Clone, Debug)]
pub struct Tapped {
    /// The record.
    pub record: Record,
    /// The instant of its host stamp.
    pub came: Instant,
}

/// Passes on the records of a recording. A slow receiver loses records, which are counted; the recording
/// never waits.
#[derive(Clone, Debug)]
pub struct Tap {
    send: SyncSender<Tapped>,
    missed: Arc<AtomicU64>,
}

impl Tap {
    /// A tap that buffers this number of records for the receiver returned with it.
    #[must_use]
    pub fn new(records: usize) -> (Self, Receiver<Tapped>) {
        let (send, receive) = sync_channel(records);
        let missed = Arc::default();
        (Self { send, missed }, receive)
    }

    /// Number of records lost so far because the receiver was slow.
    #[must_use]
    pub fn missed(&self) -> Arc<AtomicU64> {
        Arc::clone(&self.missed)
    }

    /// Offers a record stamped by `clock`; without room for it, it is counted and dropped.
    pub fn offer(&self, record: Record, clock: HostClock) {
        let came = clock.instant(record.at_ns);
        if self.send.try_send(Tapped { record, came }).is_err() {
            self.missed.fetch_add(1, Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::RecordKind;

    #[test]
    fn a_tap_that_nobody_empties_holds_nobody_up() {
        let (tap, receive) = Tap::new(2);
        let clock = HostClock::start();
        for at_ns in 0..5 {
            let record = Record {
                kind: RecordKind::Gnss,
                at_ns,
                payload: vec![1],
            };
            tap.offer(record, clock);
        }
        assert_eq!(tap.missed().load(Ordering::Relaxed), 3);
        let held: Vec<u64> = receive.try_iter().map(|t| t.record.at_ns).collect();
        assert_eq!(held, [0, 1]);
    }
}
