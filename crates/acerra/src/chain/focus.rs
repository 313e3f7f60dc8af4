//! Stage `focus`: the adjoint of Eq. (3) on the pixel grid.

use acerra_imaging::{Complex32, Plan, PlanOptions, PlaneGrid, Pulses, Spreading};
use anyhow::Context;

use super::align::Aligned;
use super::progress::Progress;
use crate::campaign::{Campaign, Weight};
use acerra_radar::Spectrum;

/// The focused image and how it was made.
#[derive(Clone, Debug)]
pub struct Focused {
    /// The sum of Eq. (3), row-major `[ny, nx]`, row 0 at the smallest y.
    pub image: Vec<Complex32>,
    /// Its grid.
    pub grid: PlaneGrid,
    /// What the planner chose and why, as text.
    pub plan: String,
    /// Bytes that the plan promised to need beside the input.
    pub promised_bytes: u64,
    /// Relative L2 error that the plan's self-check found on random pixels.
    pub checked_error: Option<f64>,
}

/// The grid that a campaign asks for.
///
/// # Errors
/// One that does not fit memory, with the bytes it would need.
pub fn grid_of(campaign: &Campaign) -> anyhow::Result<PlaneGrid> {
    let image = &campaign.image;
    PlaneGrid::from_ranges(image.x_m, image.y_m, image.z_m, image.pixel_m).context("[image]")
}

/// Makes the image from clean spectra at aligned positions.
///
/// # Errors
/// Data that the imaging operators refuse.
pub fn focus(
    campaign: &Campaign,
    spectrum: &Spectrum,
    aligned: &Aligned,
    progress: &dyn Progress,
) -> anyhow::Result<Focused> {
    let grid = grid_of(campaign)?;
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
    let plan = Plan::new(pulses, grid, &options).context("[image]")?;
    let mut image = vec![Complex32::default(); grid.len()];
    progress.start(
        "focus",
        plan.pixels() as u64 * aligned.position_m.len() as u64,
    );
    plan.run(&mut image, &|step| progress.at(step.done))
        .context("[image]")?;
    progress.finish();
    Ok(Focused {
        image,
        grid,
        plan: plan.explain(),
        promised_bytes: u64::try_from(plan.memory_bytes()).unwrap_or(u64::MAX),
        checked_error: plan.self_check().map(|check| check.error),
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
