//! Stage `measure`: what the image shows.

use acerra_imaging::metrics::{ImageView, MeasureOptions, Measurement, measure_targets};
use acerra_imaging::psf::PointSpread;
use anyhow::Context;

use super::align::Aligned;
use super::focus::Focused;
use crate::campaign::Campaign;

/// Finds and measures the targets of the image.
///
/// # Errors
/// An image that is no image (not finite).
pub fn measure(
    campaign: &Campaign,
    focused: &Focused,
    frequency_hz: &[f64],
    aligned: &Aligned,
) -> anyhow::Result<Measurement> {
    let view = ImageView::new(&focused.image, focused.grid).context("the image")?;
    let weight = match campaign.image.weight {
        crate::campaign::Weight::Trace => None,
        crate::campaign::Weight::Path => Some(aligned.path_m.clone()),
    };
    let spread = PointSpread::new(
        aligned.position_m.clone(),
        weight,
        frequency_hz.to_vec(),
        campaign.image.light_speed_m_s,
    )
    .context("the point spread function")?;
    let options = MeasureOptions {
        threshold_db: campaign.measure.threshold_db,
        max_targets: campaign.measure.max_targets,
        ..MeasureOptions::default()
    };
    measure_targets(&view, &spread, &options).context("[measure]")
}
