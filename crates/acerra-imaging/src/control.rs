//! Progress of a run over all its threads.

use std::sync::atomic::{AtomicU64, Ordering};

use acerra_control::{Control, Progress};

/// Counts contributions of one run over all threads and passes them to its [`Control`].
pub(crate) struct Meter<'a> {
    control: Control<'a>,
    done: AtomicU64,
    total: u64,
}

impl<'a> Meter<'a> {
    /// A run of `total` contributions.
    pub fn new(control: Control<'a>, total: u64) -> Self {
        Self {
            control,
            done: AtomicU64::new(0),
            total,
        }
    }

    /// A part of a run without progress that can be cancelled.
    pub fn silent(control: Control<'a>) -> Self {
        Self::new(control.silent(), 0)
    }

    pub fn control(&self) -> Control<'a> {
        self.control
    }

    /// Adds contributions that are done; none count once the run is cancelled.
    pub fn add(&self, contributions: u64) {
        if self.control.is_followed() && !self.is_cancelled() {
            let before = self.done.fetch_add(contributions, Ordering::Relaxed);
            self.control.report(Progress {
                done: before + contributions,
                total: self.total,
            });
        }
    }

    #[inline]
    pub fn is_cancelled(&self) -> bool {
        self.control.is_cancelled()
    }
}
