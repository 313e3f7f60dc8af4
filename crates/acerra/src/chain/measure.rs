//! Stage `measure`: what the image shows.

use acerra_imaging::metrics::{ImageView, MeasureOptions, Measurement, measure_targets_in};
use acerra_imaging::{Control, PulseArrays, Pulses};
use anyhow::Context;

use super::align::Aligned;
use super::focus::{Focused, weights};
use crate::campaign::Campaign;
use acerra_radar::Spectrum;

/// The image as the metrics see it.
///
/// # Errors
/// An image that is no image (not finite).
pub fn view_of(focused: &Focused) -> anyhow::Result<ImageView<'_>> {
    // Values of a volume seen from above come from many heights, and so in any phase.
    let values = match &focused.projections {
        Some(volume) => &volume.above,
        None => &focused.image,
    };
    match &focused.ground.surface {
        Some(surface) => ImageView::on_surface(values, surface),
        None => ImageView::new(values, focused.ground.grid),
    }
    .context("the image")
}

/// Finds and measures the targets of the image.
///
/// # Errors
/// An image that is no image (not finite).
pub fn measure(
    campaign: &Campaign,
    focused: &Focused,
    spectrum: &Spectrum,
    aligned: &Aligned,
) -> anyhow::Result<Measurement> {
    let view = view_of(focused)?;
    let weight = weights(campaign, aligned);
    let pulses = Pulses::new(PulseArrays {
        position_m: &aligned.position_m,
        frequency_hz: &spectrum.frequency_hz,
        spectrum: &spectrum.values,
        weight: &weight,
        light_speed_m_s: campaign.image.light_speed_m_s,
    })
    .context("the spectra")?;
    let options = MeasureOptions::default()
        .with_threshold_db(campaign.measure.threshold_db)
        .with_max_targets(campaign.measure.max_targets);
    measure_targets_in(&view, &pulses, &options, Control::default()).context("[measure]")
}
