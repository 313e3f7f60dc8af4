//! Cancellation and progress of a run.

use std::fmt;
use std::sync::atomic::AtomicBool;

pub use acerra_control::Cancelled;
use acerra_control::Control as OperationControl;

/// Receives the progress of a long step. Calls come from several threads.
pub trait Progress: Sync {
    /// A step of `total` units begins.
    fn start(&self, name: &str, total: u64);
    /// So many of them are done.
    fn at(&self, done: u64);
    /// The step is over.
    fn finish(&self);
}

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
    /// Cancels the operations of every step; their progress is reported by the step.
    operation: OperationControl<'a>,
    progress: Option<&'a dyn Progress>,
}

impl<'a> Control<'a> {
    /// This control, cancelled once `flag` is true.
    #[must_use]
    pub fn cancelled_by(self, flag: &'a AtomicBool) -> Self {
        Self {
            operation: self.operation.cancelled_by(flag),
            ..self
        }
    }

    /// This control, with long steps reported to `progress`.
    #[must_use]
    pub fn reporting_to(self, progress: &'a dyn Progress) -> Self {
        Self {
            progress: Some(progress),
            ..self
        }
    }

    /// Fails once cancellation was requested.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn check(&self) -> Result<(), Cancelled> {
        self.operation.check()
    }

    /// The cancellation of this run for one operation, without progress.
    #[must_use]
    pub fn operation(&self) -> OperationControl<'a> {
        self.operation
    }

    /// The cancellation of this run for one operation, with `progress` called as the operation advances.
    #[must_use]
    pub fn operation_reporting<'b>(
        &self,
        progress: &'b (dyn Fn(acerra_control::Progress) + Sync),
    ) -> OperationControl<'b>
    where
        'a: 'b,
    {
        let operation: OperationControl<'b> = self.operation;
        operation.reporting_to(progress)
    }

    /// This control without progress, for steps that run beside one another.
    #[must_use]
    pub fn silent(self) -> Self {
        Self {
            progress: None,
            ..self
        }
    }

    /// A step of `total` units begins.
    pub fn start(&self, name: &str, total: u64) {
        if let Some(progress) = self.progress {
            progress.start(name, total);
        }
    }

    /// Number of its units that are done.
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
            .field("operation", &self.operation)
            .field("progress", &self.progress.map(|_| ..))
            .finish()
    }
}
