//! Cancellation and progress of a run.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};

/// Receives how far a long step has come. Calls come from several threads.
pub trait Progress: Sync {
    /// A step of `total` units begins.
    fn start(&self, name: &str, total: u64);
    /// So many of them are done.
    fn at(&self, done: u64);
    /// The step is over.
    fn finish(&self);
}

/// The caller asked to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// How a caller follows and stops a run. The default does neither.
///
/// ```
/// use std::sync::atomic::{AtomicBool, Ordering};
/// let stop = AtomicBool::new(false);
/// let control = acerra_chain::Control::default().cancelled_by(&stop);
/// assert!(control.check().is_ok());
/// stop.store(true, Ordering::Relaxed);
/// assert!(control.check().is_err());
/// ```
#[derive(Clone, Copy, Default)]
pub struct Control<'a> {
    cancel: Option<&'a AtomicBool>,
    progress: Option<&'a dyn Progress>,
}

impl<'a> Control<'a> {
    /// The same, cancelled once `flag` is true.
    #[must_use]
    pub fn cancelled_by(self, flag: &'a AtomicBool) -> Self {
        Self {
            cancel: Some(flag),
            ..self
        }
    }

    /// The same, with `progress` told about long steps.
    #[must_use]
    pub fn reporting_to(self, progress: &'a dyn Progress) -> Self {
        Self {
            progress: Some(progress),
            ..self
        }
    }

    /// The flag that cancels, where there is one.
    #[must_use]
    pub fn cancel_flag(&self) -> Option<&'a AtomicBool> {
        self.cancel
    }

    /// Fails once cancellation was requested.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn check(&self) -> Result<(), Cancelled> {
        match self.cancel {
            Some(flag) if flag.load(Ordering::Relaxed) => Err(Cancelled),
            _ => Ok(()),
        }
    }

    /// The same cancellation for an operation on a radargram.
    pub(crate) fn for_radar(&self) -> acerra_radar::Control<'a> {
        let control = acerra_radar::Control::new();
        match self.cancel {
            Some(flag) => control.cancelled_by(flag),
            None => control,
        }
    }

    /// The same cancellation for an imaging operator, with `progress` called as it advances.
    #[must_use]
    pub fn for_imaging<'b>(
        &self,
        progress: &'b (dyn Fn(acerra_imaging::Progress) + Sync),
    ) -> acerra_imaging::Control<'b>
    where
        'a: 'b,
    {
        self.silent_imaging().reporting_to(progress)
    }

    /// The same cancellation for an imaging operator that reports nothing.
    #[must_use]
    pub fn silent_imaging<'b>(&self) -> acerra_imaging::Control<'b>
    where
        'a: 'b,
    {
        let control = acerra_imaging::Control::default();
        match self.cancel {
            Some(flag) => control.cancelled_by(flag),
            None => control,
        }
    }

    /// A step of `total` units begins.
    pub fn start(&self, name: &str, total: u64) {
        if let Some(progress) = self.progress {
            progress.start(name, total);
        }
    }

    /// So many of its units are done.
    pub fn at(&self, done: u64) {
        if let Some(progress) = self.progress {
            progress.at(done);
        }
    }

    /// The step is over.
    pub fn finish(&self) {
        if let Some(progress) = self.progress {
            progress.finish();
        }
    }
}

impl fmt::Debug for Control<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Control")
            .field("cancel", &self.cancel)
            .field("progress", &self.progress.map(|_| ..))
            .finish()
    }
}
