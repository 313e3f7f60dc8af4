//! Cancellation and progress of long operations.
//!
//! A caller hands a [`Control`] to an operation. The operation calls [`Control::check`] at least every 100 ms of work and
//! [`Control::report`] as the work advances.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};

/// The caller asked an operation to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// Progress of an operation, in its own units: contributions, epochs, iterations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Units done so far.
    pub done: u64,
    /// Units of the whole operation.
    pub total: u64,
}

impl Progress {
    /// Share of the work that is done, 0 to 1; 1 where there is no work.
    ///
    /// ```
    /// use acerra_control::Progress;
    /// assert_eq!(Progress { done: 1, total: 4 }.share(), 0.25);
    /// assert_eq!(Progress { done: 0, total: 0 }.share(), 1.0);
    /// ```
    #[must_use]
    #[expect(
        clippy::cast_precision_loss,
        reason = "a share needs no more than 53 bits"
    )]
    pub fn share(self) -> f64 {
        if self.total == 0 {
            return 1.0;
        }
        (self.done as f64 / self.total as f64).min(1.0)
    }
}

/// How a caller follows and stops a long operation. The default does neither.
///
/// Once the flag is set the operation returns [`Cancelled`] and leaves its output in an undefined state. The progress
/// function is called from the working threads.
///
/// ```
/// use acerra_control::{Cancelled, Control, Progress};
/// use std::sync::atomic::{AtomicBool, Ordering};
/// let stop = AtomicBool::new(false);
/// let show = |p: Progress| println!("{} of {}", p.done, p.total);
/// let control = Control::default().cancelled_by(&stop).reporting_to(&show);
/// assert_eq!(control.check(), Ok(()));
/// stop.store(true, Ordering::Relaxed);
/// assert_eq!(control.check(), Err(Cancelled));
/// ```
#[derive(Clone, Copy, Default)]
pub struct Control<'a> {
    cancel: Option<&'a AtomicBool>,
    progress: Option<&'a (dyn Fn(Progress) + Sync)>,
}

impl<'a> Control<'a> {
    /// This control, cancelled once `flag` is true.
    #[must_use]
    pub const fn cancelled_by(mut self, flag: &'a AtomicBool) -> Self {
        self.cancel = Some(flag);
        self
    }

    /// This control, with `progress` called as the work advances.
    #[must_use]
    pub const fn reporting_to(mut self, progress: &'a (dyn Fn(Progress) + Sync)) -> Self {
        self.progress = Some(progress);
        self
    }

    /// This control without progress, for a part of an operation.
    #[must_use]
    pub const fn silent(mut self) -> Self {
        self.progress = None;
        self
    }

    /// Whether somebody follows the progress.
    #[must_use]
    pub const fn is_followed(&self) -> bool {
        self.progress.is_some()
    }

    /// Whether cancellation was requested.
    #[inline]
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.cancel.is_some_and(|flag| flag.load(Ordering::Relaxed))
    }

    /// Fails once cancellation was requested.
    ///
    /// # Errors
    /// [`Cancelled`].
    #[inline]
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() {
            Err(Cancelled)
        } else {
            Ok(())
        }
    }

    /// Calls the progress function, where there is one.
    pub fn report(&self, progress: Progress) {
        if let Some(report) = self.progress {
            report(progress);
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
