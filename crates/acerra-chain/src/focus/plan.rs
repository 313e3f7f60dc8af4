//! Plans of the imaging operators, and their errors.

use std::ops::Range;

use acerra_imaging::{Complex32, ImagingError, ImagingPlan, PlanOptions, Pulses};
use acerra_invert::InvertError;

use crate::control::{Cancelled, Control};
use crate::focus::sink::SinkError;
use crate::scene::pixels::Pixels;

/// Reason for which no image can be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// Spectra or positions that the imaging operators refuse.
    #[error("the spectra cannot be imaged: {0}")]
    Spectra(ImagingError),
    /// A ground that the operators refuse, or a ground with antennas inside.
    #[error("[ground]: {0}")]
    Ground(ImagingError),
    /// A grid or an accuracy that the operators refuse.
    #[error("[image]: {0}")]
    Plan(ImagingError),
    /// Tracks that the operators refuse.
    #[error("[[track]]: {0}")]
    Tracks(ImagingError),
    /// The aperture cannot be partitioned into these looks.
    #[error("[image] looks: {0}")]
    Looks(ImagingError),
    /// The antenna is on a gimbal whose attitude is not known.
    #[error(
        "[image] antenna_axis = \"{axis}\": expected the attitude of a gimbal with the positions of every \
         track, found none ([trajectory] file with the log of an autopilot or a robot that records it)"
    )]
    NoGimbal {
        /// The axis asked for.
        axis: &'static str,
    },
    /// Looks are requested of several tracks.
    #[error("[image] looks: expected a single track, found {tracks}")]
    LooksOfTracks {
        /// Number of tracks.
        tracks: usize,
    },
    /// The inversion failed.
    #[error("[image] method: {0}")]
    Inversion(InvertError),
    /// A method that excludes another requested product.
    #[error("[image] method = \"{method}\": expected {expected}, found {found}")]
    Method {
        /// The method.
        method: &'static str,
        /// Requirement of the method.
        expected: &'static str,
        /// Product requested in addition.
        found: &'static str,
    },
    /// Any other error of the imaging operators.
    #[error(transparent)]
    Imaging(ImagingError),
    /// The sink does not take an image.
    #[error(transparent)]
    Sink(#[from] SinkError),
}

/// A plan on plane or uneven ground.
pub(crate) fn plan_on<'a>(
    pixels: &'a Pixels,
    pulses: Pulses<'a>,
    options: &PlanOptions,
    control: &Control<'_>,
) -> Result<ImagingPlan<'a>, ImageError> {
    let control = control.operation();
    match &pixels.surface {
        Some(surface) => ImagingPlan::with_control(pulses, &**surface, options, control),
        None => ImagingPlan::with_control(pulses, pixels.grid, options, control),
    }
    .map_err(refused)
}

/// Runs a plan; earlier plans computed `before` contributions of the step.
pub(crate) fn run_plan(
    plan: &ImagingPlan<'_>,
    image: &mut [Complex32],
    before: u64,
    control: &Control<'_>,
) -> Result<(), ImageError> {
    let progress = |step: acerra_imaging::Progress| control.at(before + step.done);
    plan.run(image, control.operation_reporting(&progress))
        .map_err(refused)
}

/// The error of a plan that was cancelled or refused.
fn refused(error: ImagingError) -> ImageError {
    match error {
        ImagingError::Cancelled => ImageError::Cancelled(Cancelled),
        error => ImageError::Plan(error),
    }
}

impl From<ImagingError> for ImageError {
    fn from(error: ImagingError) -> Self {
        match error {
            ImagingError::Cancelled => Self::Cancelled(Cancelled),
            error => Self::Imaging(error),
        }
    }
}

impl From<InvertError> for ImageError {
    fn from(error: InvertError) -> Self {
        if error.is_cancelled() {
            Self::Cancelled(Cancelled)
        } else {
            Self::Inversion(error)
        }
    }
}

/// Number of contributions of pulses to pixels.
pub(crate) fn contributions(pixels: usize, pulses: &Range<usize>) -> u64 {
    pixels as u64 * pulses.len() as u64
}
