//! Stopping long operations and following their progress.

use std::sync::atomic::{AtomicBool, Ordering};

use thiserror::Error;

/// The caller asked an operation to stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("cancelled")]
pub struct Cancelled;

/// What a caller hands to a long operation: a flag that stops it, and who hears of its progress.
///
/// The flag is looked at at least every 100 ms of work. Both parts are optional.
///
/// ```
/// use acerra_radar::{Cancelled, Control};
/// use std::sync::atomic::AtomicBool;
/// let stop = AtomicBool::new(true);
/// assert_eq!(Control::new().cancelled_by(&stop).check(), Err(Cancelled));
/// assert_eq!(Control::new().check(), Ok(()));
/// ```
#[derive(Clone, Copy, Default)]
pub struct Control<'a> {
    cancel: Option<&'a AtomicBool>,
    progress: Option<&'a (dyn Fn(f64) + Sync)>,
}

impl<'a> Control<'a> {
    /// Runs to the end, silently.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            cancel: None,
            progress: None,
        }
    }

    /// The same, stopped once `flag` is true.
    #[must_use]
    pub const fn cancelled_by(mut self, flag: &'a AtomicBool) -> Self {
        self.cancel = Some(flag);
        self
    }

    /// The same, with `progress` called with the share of the work that is done, 0 to 1. Calls may
    /// come from any thread.
    #[must_use]
    pub const fn reporting_to(mut self, progress: &'a (dyn Fn(f64) + Sync)) -> Self {
        self.progress = Some(progress);
        self
    }

    /// An error once the flag is set.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn check(&self) -> Result<(), Cancelled> {
        match self.cancel {
            Some(flag) if flag.load(Ordering::Relaxed) => Err(Cancelled),
            _ => Ok(()),
        }
    }

    /// Tells that `share` of the work is done.
    pub fn report(&self, share: f64) {
        if let Some(progress) = self.progress {
            progress(share);
        }
    }
}

impl std::fmt::Debug for Control<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Control")
            .field("cancel", &self.cancel)
            .field("progress", &self.progress.is_some())
            .finish()
    }
}
