//! Channel from the instruments' threads to the thread that writes the log.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};

use super::progress::{Health, Progress};
use crate::log::Record;

/// Records that wait for a slow disk: 12 MB of scans, 20 s of usual ones.
const QUEUE_RECORDS: usize = 8_192;

/// Messages of the instruments' threads.
pub(super) enum Item {
    Record(Record),
    Progress(Progress),
}

/// State that all threads of a recording share.
#[derive(Default)]
pub(super) struct Shared {
    ended: AtomicBool,
    health: Mutex<Health>,
}

impl Shared {
    /// Signals the instruments' threads to end.
    pub fn end(&self) {
        self.ended.store(true, Ordering::SeqCst);
    }

    /// The state so far.
    pub fn health(&self) -> Health {
        *self.health.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Sender of an instrument's thread.
#[derive(Clone)]
pub(super) struct Outlet {
    send: SyncSender<Item>,
    shared: Arc<Shared>,
}

impl Outlet {
    /// A sender, and the receiver of everything sent by it.
    pub fn new(shared: &Arc<Shared>) -> (Self, Receiver<Item>) {
        let (send, receive) = sync_channel(QUEUE_RECORDS);
        let shared = Arc::clone(shared);
        (Self { send, shared }, receive)
    }

    /// Sends a record; `false` when the recording is over. Waits while the queue is full.
    pub fn record(&self, record: Record) -> bool {
        self.send.send(Item::Record(record)).is_ok()
    }

    /// Reports progress; `false` when the recording is over.
    pub fn say(&self, progress: Progress) -> bool {
        self.send.send(Item::Progress(progress)).is_ok()
    }

    /// Updates the state reported to the follower.
    pub fn update(&self, change: impl FnOnce(&mut Health)) {
        let health = &self.shared.health;
        change(&mut health.lock().unwrap_or_else(PoisonError::into_inner));
    }

    /// Whether the recording is to end.
    pub fn has_ended(&self) -> bool {
        self.shared.ended.load(Ordering::SeqCst)
    }
}
