//! Stage `measure`: targets, resolution and ghosts of the image.

use acerra_imaging::metrics::{
    ImageView, MeasureOptions as Metrics, Measurement, likeliest_height_m, measure_targets,
    measure_targets_in,
};
use acerra_imaging::psf::PointSpread;
use acerra_imaging::{ImagingError, Pulses, VolumeGrid};

use rayon::prelude::*;

use crate::control::{Cancelled, Control};
use crate::echoes::Echoes;
use crate::focus::Focused;
use crate::focus::rays::Rays;

/// Parameters of the stage `measure`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasureOptions {
    /// Peaks weaker than this relative to the strongest are not listed (dB).
    pub threshold_db: f64,
    /// Largest number of targets listed.
    pub max_targets: usize,
}

/// Reason for which an image cannot be measured.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeasureError {
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// Pixel values that are not finite.
    #[error("the image: {0}")]
    Image(ImagingError),
    /// Echoes that the imaging operators refuse.
    #[error("the spectra: {0}")]
    Spectra(ImagingError),
    /// The targets cannot be measured.
    #[error("[measure]: {0}")]
    Targets(ImagingError),
}

/// View of the image for the metrics.
///
/// # Errors
/// Pixel values that are not finite.
pub fn view_of(focused: &Focused) -> Result<ImageView<'_>, MeasureError> {
    // Values of a volume seen from above come from many heights, so that their phases are unrelated.
    let values = match &focused.projections {
        Some(volume) => &volume.above,
        None => &focused.image,
    };
    match &focused.pixels.surface {
        Some(surface) => ImageView::on_surface(values, surface),
        None => ImageView::new(values, focused.pixels.grid),
    }
    .map_err(MeasureError::Image)
}

/// Finds and measures the targets of an image of these echoes.
///
/// # Errors
/// Pixel values that are not finite, echoes that cannot be imaged, cancellation.
pub fn measure(
    echoes: Echoes<'_>,
    focused: &Focused,
    options: &MeasureOptions,
    control: &Control<'_>,
) -> Result<Measurement, MeasureError> {
    let view = view_of(focused)?;
    let weight = echoes.weights(focused.options.weight);
    let pulses = echoes.pulses(&weight).map_err(MeasureError::Spectra)?;
    let metrics = Metrics::default()
        .with_threshold_db(options.threshold_db)
        .with_max_targets(options.max_targets)
        // Below ground a target is compared with the other echoes at its depth instead.
        .with_clutter(focused.underground.is_some());
    let is_straight =
        focused.underground.is_none() && echoes.aligned.antennas_from_place_m.is_empty();
    let found = if is_straight {
        measure_targets_in(&view, &pulses, &metrics, control.operation())
    } else {
        // Phases along straight rays from one antenna differ from those of these echoes, and would remove
        // targets as ghosts.
        let spread = PointSpread::of(&pulses);
        measure_targets(&view, &spread, &metrics, control.operation())
    };
    let targets_of = |error| match error {
        ImagingError::Cancelled => MeasureError::Cancelled(Cancelled),
        error => MeasureError::Targets(error),
    };
    let mut found = found.map_err(targets_of)?;
    // Weights by incidence are not those of the likelihood; an inversion is no sum of Eq. (3).
    let is_sum = focused.inversion.is_none() && focused.options.incidence.is_none();
    if let Some(volume) = focused.projections.as_ref().filter(|_| is_sum) {
        let rays = Rays::of(echoes, focused.underground.as_ref()).map_err(MeasureError::Spectra)?;
        let pulses = rays.of_pulses(pulses).map_err(MeasureError::Spectra)?;
        place_between_slices(&mut found, &pulses, &volume.volume, control).map_err(targets_of)?;
    }
    Ok(found)
}

/// Replaces the heights of slices by the likeliest heights of the targets.
fn place_between_slices(
    found: &mut Measurement,
    pulses: &Pulses<'_>,
    volume: &VolumeGrid,
    control: &Control<'_>,
) -> Result<(), ImagingError> {
    let last = volume.slice(volume.nz.saturating_sub(1)).z_m;
    let limits_m = [volume.base.z_m.min(last), volume.base.z_m.max(last)];
    let operation = control.operation();
    found.targets.par_iter_mut().try_for_each(|target| {
        operation.check()?;
        let place_m = [target.x_m, target.y_m, target.z_m];
        target.z_m = likeliest_height_m(pulses, place_m, volume.step_m, limits_m)?;
        Ok(())
    })
}
