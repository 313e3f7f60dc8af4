//! Stage `focus`: the adjoint of Eq. (3) on the pixel grid.

use acerra_imaging::{Complex32, Plan, PlanOptions, PlaneGrid, Pulses, Spreading};
use anyhow::Context;

use super::align::Aligned;
use super::ground::Ground;
use super::progress::Progress;
use crate::campaign::{Campaign, Weight};
use acerra_radar::Spectrum;

/// The focused image and how it was made.
#[derive(Clone, Debug)]
pub struct Focused {
    /// The sum of Eq. (3), row-major `[ny, nx]`, row 0 at the smallest y.
    pub image: Vec<Complex32>,
    /// What its pixels stand on.
    pub ground: Ground,
    /// What the planner chose and why, as text.
    pub plan: String,
    /// Bytes that the plan promised to need beside the input.
    pub promised_bytes: u64,
    /// Relative L2 error that the plan's self-check found on random pixels.
    pub checked_error: Option<f64>,
}

/// Makes the image from clean spectra at aligned positions.
///
/// # Errors
/// Data that the imaging operators refuse.
pub fn focus(
    campaign: &Campaign,
    spectrum: &Spectrum,
    aligned: &Aligned,
    ground: Ground,
    progress: &dyn Progress,
) -> anyhow::Result<Focused> {
    let weight = match campaign.image.weight {
        Weight::Trace => vec![1.0; aligned.position_m.len()],
        Weight::Path => aligned.path_m.clone(),
    };
    let pulses = Pulses::new(
        &aligned.position_m,
        &spectrum.frequency_hz,
        &spectrum.values,
        &weight,
        campaign.image.light_speed_m_s,
    )
    .context("the spectra cannot be imaged")?;
    let options = PlanOptions {
        accuracy: campaign.image.accuracy,
        ..PlanOptions::default()
    };
    let plan = match &ground.surface {
        Some(surface) => Plan::on_surface(pulses, surface, &options),
        None => Plan::new(pulses, ground.grid, &options),
    }
    .context("[image]")?;
    let mut image = vec![Complex32::default(); ground.grid.len()];
    progress.start(
        "focus",
        plan.pixels() as u64 * aligned.position_m.len() as u64,
    );
    plan.run(&mut image, &|step| progress.at(step.done))
        .context("[image]")?;
    progress.finish();
    let relief_bytes = ground
        .surface
        .as_ref()
        .map_or(0, |s| s.len() * size_of::<f32>());
    let (explained, bytes) = (plan.explain(), plan.memory_bytes() + relief_bytes as u128);
    let checked_error = plan.self_check().map(|check| check.error);
    drop(plan);
    Ok(Focused {
        image,
        ground,
        plan: explained,
        promised_bytes: u64::try_from(bytes).unwrap_or(u64::MAX),
        checked_error,
    })
}

/// A quick, unweighted image of modest accuracy, for sharpness alone.
///
/// # Errors
/// Data that the imaging operators refuse.
pub fn quick_look(
    position_m: &[[f64; 3]],
    spectrum: &Spectrum,
    grid: PlaneGrid,
    light_speed_m_s: f64,
) -> anyhow::Result<Vec<Complex32>> {
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
