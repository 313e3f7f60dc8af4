//! Progress and cancellation of a run.

use std::sync::atomic::{AtomicUsize, Ordering};

use acerra_control::{Control, Progress};

use super::workers::{Permit, Permits};
use crate::solution::PpkError;

/// Counts the epochs of a run, and checks for cancellation.
pub(crate) struct Watch<'a> {
    control: Control<'a>,
    done: AtomicUsize,
    total: usize,
    /// Permits shared by parallel passes, where there are fewer threads than passes.
    permits: Option<Permits>,
}

impl<'a> Watch<'a> {
    /// `total` is the number of calls to [`one_more`](Self::one_more) expected.
    pub(crate) fn new(control: Control<'a>, total: usize) -> Self {
        Self {
            control,
            done: AtomicUsize::new(0),
            total: total.max(1),
            permits: None,
        }
    }

    /// This watch with permits for `threads` simultaneous passes.
    pub(crate) fn with_permits(self, threads: usize) -> Self {
        Self {
            permits: Some(Permits::new(threads)),
            ..self
        }
    }

    /// Waits until the caller may work, where threads are shared.
    pub(crate) fn permit(&self) -> Option<Permit<'_>> {
        self.permits.as_ref().map(Permits::take)
    }

    /// Whether other passes run at the same time.
    pub(crate) fn shares_threads(&self) -> bool {
        self.permits.is_some()
    }

    /// Counts one more epoch; fails where the run is cancelled.
    pub(crate) fn one_more(&self) -> Result<(), PpkError> {
        self.control.check()?;
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        // A hundred reports are enough for any display.
        let percent = |n: usize| 100 * n / self.total;
        if percent(done) != percent(done - 1) {
            let (done, total) = (done.min(self.total) as u64, self.total as u64);
            self.control.report(Progress { done, total });
        }
        Ok(())
    }
}
