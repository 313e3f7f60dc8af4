//! Stage `measure`: targets, resolution and ghosts of the image.

use acerra_imaging::ImagingError;
use acerra_imaging::metrics::{
    ImageView, MeasureOptions as Metrics, Measurement, measure_targets, measure_targets_in,
};
use acerra_imaging::psf::PointSpread;

use crate::control::{Cancelled, Control};
use crate::echoes::Echoes;
use crate::focus::Focused;

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
    found.map_err(|error| match error {
        ImagingError::Cancelled => MeasureError::Cancelled(Cancelled),
        error => MeasureError::Targets(error),
    })
}
