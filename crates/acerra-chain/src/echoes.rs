//! Clean spectra with the places where they were measured, as the imaging operators take them.

use std::ops::Range;

use acerra_imaging::{Complex32, Plan, PlanOptions, PlaneGrid, Pulses, Spreading};
use acerra_radar::Spectrum;

use crate::align::Aligned;
use crate::choices::Weight;
use crate::control::{Cancelled, Control};
use crate::pixels::Pixels;
use crate::sink::SinkError;
use acerra_imaging::ImagingError;

/// Clean spectra of one or more tracks, and where they were measured.
#[derive(Clone, Copy, Debug)]
pub struct Echoes<'a> {
    /// Clean spectra, track after track.
    pub spectrum: &'a Spectrum,
    /// Where they were measured.
    pub aligned: &'a Aligned,
    /// Propagation speed (m/s).
    pub light_speed_m_s: f64,
}

/// Why no image can be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// Spectra or positions that the imaging operators refuse.
    #[error("the spectra cannot be imaged: {0}")]
    Spectra(ImagingError),
    /// A grid or an accuracy that they refuse.
    #[error("[image]: {0}")]
    Plan(ImagingError),
    /// Tracks that they refuse.
    #[error("[[track]]: {0}")]
    Tracks(ImagingError),
    /// The aperture cannot be partitioned into these looks.
    #[error("[image] looks: {0}")]
    Looks(ImagingError),
    /// Looks are wanted of several tracks.
    #[error("[image] looks: expected a single track, found {tracks}")]
    LooksOfTracks {
        /// How many there are.
        tracks: usize,
    },
    /// Anything else that the imaging operators refuse.
    #[error(transparent)]
    Imaging(#[from] ImagingError),
    /// The sink does not take an image.
    #[error(transparent)]
    Sink(#[from] SinkError),
}

impl<'a> Echoes<'a> {
    /// The weight of each trace.
    #[must_use]
    pub fn weights(&self, weight: Weight) -> Vec<f64> {
        match weight {
            Weight::Trace => vec![1.0; self.aligned.position_m.len()],
            Weight::Path => self.aligned.path_m.clone(),
        }
    }

    /// The traces with their weights as pulses.
    ///
    /// # Errors
    /// Spectra, positions and weights of different numbers, or values that are not finite.
    pub fn pulses(&self, weight: &'a [f64]) -> Result<Pulses<'a>, ImagingError> {
        Pulses::new(
            &self.aligned.position_m,
            &self.spectrum.frequency_hz,
            &self.spectrum.values,
            weight,
            self.light_speed_m_s,
        )
    }
}

/// A plan on plane or uneven ground.
pub(crate) fn plan_on<'a>(
    pixels: &'a Pixels,
    pulses: Pulses<'a>,
    options: &PlanOptions,
) -> Result<Plan<'a>, ImageError> {
    match &pixels.surface {
        Some(surface) => Plan::on_surface(pulses, surface, options),
        None => Plan::new(pulses, pixels.grid, options),
    }
    .map_err(ImageError::Plan)
}

/// Runs a plan; `before` contributions of the step were computed by earlier ones.
pub(crate) fn run_plan(
    plan: &Plan<'_>,
    image: &mut [Complex32],
    before: u64,
    control: &Control<'_>,
) -> Result<(), ImageError> {
    control.check()?;
    plan.run(image, &|step| control.at(before + step.done))
        .map_err(ImageError::Plan)?;
    control.check()?;
    Ok(())
}

/// A quick, unweighted image of modest accuracy, for its sharpness alone: `position_m` takes the
/// place of the positions that the echoes are aligned to.
///
/// # Errors
/// Data that the imaging operators refuse.
pub(crate) fn quick_look(
    position_m: &[[f64; 3]],
    spectrum: &Spectrum,
    grid: PlaneGrid,
    light_speed_m_s: f64,
) -> Result<Vec<Complex32>, ImagingError> {
    let weight = vec![1.0; position_m.len()];
    let pulses = Pulses::new(
        position_m,
        &spectrum.frequency_hz,
        &spectrum.values,
        &weight,
        light_speed_m_s,
    )?;
    // Without 1/R², which would let what is nearest decide.
    let options = PlanOptions {
        accuracy: 1e-2,
        spreading: Spreading::None,
        check_pixels: 4,
        ..PlanOptions::default()
    };
    let plan = Plan::new(pulses, grid, &options)?;
    let mut image = vec![Complex32::default(); grid.len()];
    plan.run(&mut image, &|_| ())?;
    Ok(image)
}

/// Number of contributions of pulses to pixels.
pub(crate) fn contributions(pixels: usize, pulses: &Range<usize>) -> u64 {
    pixels as u64 * pulses.len() as u64
}
