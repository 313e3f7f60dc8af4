//! Following a run from outside: cancellation and progress.

use super::workers::{Permit, Permits};
use crate::solution::PpkError;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// How a caller follows a run and stops it; the default does neither.
///
/// ```
/// use acerra_gnss::{Control, Navigation, ObservationData, PpkOptions, process_with};
/// use std::sync::atomic::AtomicBool;
/// let stop = AtomicBool::new(false);
/// let control = Control::default().cancelled_by(&stop);
/// let empty = ObservationData::default();
/// let navigation = Navigation::default();
/// assert!(process_with(&empty, &empty, &navigation, &PpkOptions::default(), control).is_err());
/// ```
#[derive(Clone, Copy, Default)]
pub struct Control<'a> {
    cancel: Option<&'a AtomicBool>,
    progress: Option<&'a (dyn Fn(f64) + Sync)>,
}

impl<'a> Control<'a> {
    /// The run ends with [`PpkError::Cancelled`] soon after `flag` is set.
    #[must_use]
    pub fn cancelled_by(self, flag: &'a AtomicBool) -> Self {
        Self {
            cancel: Some(flag),
            ..self
        }
    }

    /// `report` is called with the share of the work done, 0 to 1, from whichever thread does it.
    #[must_use]
    pub fn reporting_to(self, report: &'a (dyn Fn(f64) + Sync)) -> Self {
        Self {
            progress: Some(report),
            ..self
        }
    }
}

impl Control<'_> {
    /// As this one, without reports of progress.
    pub(crate) fn silent(self) -> Self {
        Self {
            progress: None,
            ..self
        }
    }

    /// An error where the run is to end.
    pub(crate) fn check(self) -> Result<(), PpkError> {
        match self.cancel {
            Some(flag) if flag.load(Ordering::Relaxed) => Err(PpkError::Cancelled),
            _ => Ok(()),
        }
    }
}

impl std::fmt::Debug for Control<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Control")
            .field("cancel", &self.cancel)
            .field("progress", &self.progress.map(|_| ..))
            .finish()
    }
}

/// Counts the epochs of a run and asks whether it is to go on.
pub(crate) struct Watch<'a> {
    control: Control<'a>,
    done: AtomicUsize,
    total: usize,
    /// Permits to work that passes side by side share, where there are fewer threads than passes.
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

    /// This one, for passes of which so many run at once.
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

    /// One more epoch is about to be processed.
    pub(crate) fn one_more(&self) -> Result<(), PpkError> {
        let cancelled = |flag: &AtomicBool| flag.load(Ordering::Relaxed);
        if self.control.cancel.is_some_and(cancelled) {
            return Err(PpkError::Cancelled);
        }
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        // A hundred reports are enough for any display.
        let percent = |n: usize| 100 * n / self.total;
        if let Some(report) = self.control.progress
            && percent(done) != percent(done - 1)
        {
            report((done as f64 / self.total as f64).min(1.0));
        }
        Ok(())
    }
}
