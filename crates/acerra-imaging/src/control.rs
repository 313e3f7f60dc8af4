//! Cancellation and progress of long operations.

use crate::error::ImagingError;
use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// How far an operation has come, in pixel × pulse contributions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Contributions computed so far.
    pub done: u64,
    /// Contributions of the whole operation.
    pub total: u64,
}

/// How a caller follows and stops a long operation. The default does neither.
///
/// The flag is read at least every 100 ms; once it is set the operation returns
/// [`ImagingError::Cancelled`] and leaves its output arrays in an undefined state. The progress
/// function is called from the working threads.
///
/// ```
/// use acerra_imaging::Control;
/// use std::sync::atomic::{AtomicBool, Ordering};
/// let stop = AtomicBool::new(false);
/// let show = |p: acerra_imaging::Progress| println!("{} of {}", p.done, p.total);
/// let control = Control::default().cancelled_by(&stop).reporting_to(&show);
/// assert!(control.check().is_ok());
/// stop.store(true, Ordering::Relaxed);
/// assert!(control.check().is_err());
/// ```
#[derive(Clone, Copy, Default)]
pub struct Control<'a> {
    cancel: Option<&'a AtomicBool>,
    progress: Option<&'a (dyn Fn(Progress) + Sync)>,
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

    /// The same, with `progress` called as the work advances.
    #[must_use]
    pub fn reporting_to(self, progress: &'a (dyn Fn(Progress) + Sync)) -> Self {
        Self {
            progress: Some(progress),
            ..self
        }
    }

    /// The same without progress, for a part of an operation.
    #[must_use]
    pub fn silent(self) -> Self {
        Self {
            progress: None,
            ..self
        }
    }

    /// Whether cancellation was requested.
    #[inline]
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.cancel.is_some_and(|flag| flag.load(Ordering::Relaxed))
    }

    /// An error once cancellation was requested.
    ///
    /// # Errors
    /// [`ImagingError::Cancelled`].
    pub fn check(&self) -> Result<(), ImagingError> {
        if self.is_cancelled() {
            Err(ImagingError::Cancelled)
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

    /// A part of a run that reports nothing but can be cancelled.
    pub fn silent(control: Control<'a>) -> Self {
        Self::new(control.silent(), 0)
    }

    pub fn control(&self) -> Control<'a> {
        self.control
    }

    /// Adds contributions that are done; none count once the run is cancelled.
    pub fn add(&self, contributions: u64) {
        if self.control.progress.is_some() && !self.is_cancelled() {
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
