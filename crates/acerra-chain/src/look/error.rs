//! Errors of the first look.

use acerra_imaging::ImagingError;

use crate::align::AlignError;
use crate::align::delay::DelayError;
use crate::clean::CleanError;
use crate::control::Cancelled;
use crate::scene::SceneError;

/// Reason why nothing can be seen.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LookError {
    /// No trace can be placed.
    #[error(transparent)]
    Align(#[from] AlignError),
    /// The traces cannot be cleaned.
    #[error(transparent)]
    Clean(#[from] CleanError),
    /// They cannot be imaged.
    #[error(transparent)]
    Imaging(#[from] ImagingError),
    /// There is no rectangle about the flight.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The traces of a search over delays cannot be had.
    #[error(transparent)]
    Delay(#[from] DelayError),
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
