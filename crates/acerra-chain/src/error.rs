//! Reasons why a run ends without an image.

use crate::align::AlignError;
use crate::align::calibration::CalibrationError;
use crate::align::clock::ClockError;
use crate::align::delay::DelayError;
use crate::align::offset::OffsetError;
use crate::align::plane::GroundError;
use crate::align::radar_surface::RadarSurfaceError;
use crate::clean::CleanError;
use crate::control::Cancelled;
use crate::focus::permittivity::PermittivityError;
use crate::focus::plan::ImageError;
use crate::measure::MeasureError;
use crate::position::PositionError;
use crate::read::ReadError;
use crate::scene::SceneError;

/// The stage that failed, and why. The message names the file, the place in it, what was expected
/// and what was found.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ChainError {
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(Cancelled),
    /// Stage `read`.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// Stage `position`.
    #[error(transparent)]
    Position(#[from] PositionError),
    /// Stage `position`: the ground and the pixels on the ground.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Stage `align`.
    #[error(transparent)]
    Align(ClockError),
    /// Stage `align`: the height of the ground.
    #[error(transparent)]
    Ground(#[from] GroundError),
    /// Stage `align`: the surface of the ground by the radar.
    #[error(transparent)]
    RadarSurface(#[from] RadarSurfaceError),
    /// Stage `clean`.
    #[error(transparent)]
    Clean(#[from] CleanError),
    /// Stage `clean`: the tracks' calibration against one another.
    #[error(transparent)]
    Calibration(CalibrationError),
    /// No track at all.
    #[error("[[track]]: expected at least one")]
    NoTrack,
    /// Tracks of different frequencies.
    #[error(
        "[[track]] {track}: expected the {expected_count} frequencies of the first track, from \
         {expected_from_hz} Hz, found {found_count} from {found_from_hz} Hz"
    )]
    Frequencies {
        /// The track.
        track: String,
        /// Number of frequencies of the first track.
        expected_count: usize,
        /// Lowest frequency of the first track (Hz).
        expected_from_hz: f64,
        /// Number of frequencies of this track.
        found_count: usize,
        /// Lowest frequency of this track (Hz).
        found_from_hz: f64,
    },
    /// The permittivity of the ground.
    #[error(transparent)]
    Permittivity(#[from] PermittivityError),
    /// Stage `focus`.
    #[error(transparent)]
    Image(ImageError),
    /// Stage `measure`.
    #[error(transparent)]
    Measure(MeasureError),
}

impl From<Cancelled> for ChainError {
    fn from(cancelled: Cancelled) -> Self {
        Self::Cancelled(cancelled)
    }
}

impl From<AlignError> for ChainError {
    fn from(error: AlignError) -> Self {
        Self::Align(error.into())
    }
}

impl From<ClockError> for ChainError {
    fn from(error: ClockError) -> Self {
        match error {
            ClockError::Offset(OffsetError::Cancelled(cancelled))
            | ClockError::Delay(DelayError::Cancelled(cancelled)) => cancelled.into(),
            error => Self::Align(error),
        }
    }
}

impl From<CalibrationError> for ChainError {
    fn from(error: CalibrationError) -> Self {
        match error {
            CalibrationError::Cancelled(cancelled) => cancelled.into(),
            error => Self::Calibration(error),
        }
    }
}

impl From<ImageError> for ChainError {
    fn from(error: ImageError) -> Self {
        match error {
            ImageError::Cancelled(cancelled) => cancelled.into(),
            error => Self::Image(error),
        }
    }
}

impl From<MeasureError> for ChainError {
    fn from(error: MeasureError) -> Self {
        match error {
            MeasureError::Cancelled(cancelled) => cancelled.into(),
            error => Self::Measure(error),
        }
    }
}
