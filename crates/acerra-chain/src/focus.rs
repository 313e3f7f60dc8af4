//! Stage `focus`: the adjoint of Eq. (3) on the pixels.

use std::ops::Range;

use acerra_imaging::{Complex32, Plan, PlanOptions, PlaneGrid, Pulses, Spreading};
use acerra_radar::Spectrum;
use anyhow::Context;

use super::align::Aligned;
use super::ground::Ground;
use super::progress::Progress;
use super::stacks::{Multilook, Projections, make_looks, make_volume};
use crate::campaign::{Campaign, Sum, Weight};
use crate::memory::available_memory_bytes;
use crate::staging::Staging;

/// The focused image and how it was made.
#[derive(Clone, Debug)]
pub struct Focused {
    /// The sum of Eq. (3), row-major `[ny, nx]`, row 0 at the smallest y. Of tracks summed by power
    /// its modulus; of a volume the value of greatest modulus along z.
    pub image: Vec<Complex32>,
    /// What its pixels stand on; of a volume the heights of those values.
    pub ground: Ground,
    /// What the planner chose and why, as text.
    pub plan: String,
    /// Bytes that the plan promised to need beside the input.
    pub promised_bytes: u64,
    /// Relative L2 error that the plan's self-check found on random pixels.
    pub checked_error: Option<f64>,
    /// The mean power of the looks, where looks were asked for.
    pub multilook: Option<Multilook>,
    /// Maximum projections of a volume.
    pub projections: Option<Projections>,
}

/// What an image is made from.
#[derive(Clone, Copy, Debug)]
pub struct Echoes<'a> {
    /// Clean spectra.
    pub spectrum: &'a Spectrum,
    /// Where they were measured.
    pub aligned: &'a Aligned,
    /// Which traces are which track's.
    pub parts: &'a [Range<usize>],
}

/// The weight of each trace.
pub fn weights(campaign: &Campaign, aligned: &Aligned) -> Vec<f64> {
    match campaign.image.weight {
        Weight::Trace => vec![1.0; aligned.position_m.len()],
        Weight::Path => aligned.path_m.clone(),
    }
}

/// Makes the image from clean spectra at aligned positions; looks and volumes go straight to their
/// files.
///
/// # Errors
/// Data that the imaging operators refuse, a disk that is full.
pub fn focus(
    campaign: &Campaign,
    echoes: Echoes<'_>,
    ground: Ground,
    staging: &Staging,
    progress: &dyn Progress,
) -> anyhow::Result<Focused> {
    let weight = weights(campaign, echoes.aligned);
    let pulses = Pulses::new(
        &echoes.aligned.position_m,
        &echoes.spectrum.frequency_hz,
        &echoes.spectrum.values,
        &weight,
        campaign.image.light_speed_m_s,
    )
    .context("the spectra cannot be imaged")?;
    let default = PlanOptions::default();
    let options = PlanOptions {
        accuracy: campaign.image.accuracy,
        incidence: campaign.image.incidence(),
        memory_limit_bytes: available_memory_bytes().map_or(default.memory_limit_bytes, |b| {
            default.memory_limit_bytes.min(b.into())
        }),
        ..default
    };
    if let Some(volume) = ground.volume {
        return make_volume(pulses, ground, volume, &options, staging, progress);
    }
    let incoherent = campaign.tracks.sum == Sum::Incoherent && echoes.parts.len() > 1;
    let whole: Vec<_> = std::iter::once(0..pulses.len()).collect();
    let parts = if incoherent { echoes.parts } else { &whole[..] };
    let mut image = vec![Complex32::default(); ground.grid.len()];
    let mut power = vec![0_f32; if incoherent { image.len() } else { 0 }];
    let mut made = Made::default();
    progress.start("focus", image.len() as u64 * pulses.len() as u64);
    let mut before = 0;
    for part in parts {
        let pulses = pulses.slice(part.clone()).context("[[track]]")?;
        let plan = plan_on(&ground, pulses, &options)?;
        made.add(&plan);
        plan.run(&mut image, &|step| progress.at(before + step.done))
            .context("[image]")?;
        before += image.len() as u64 * part.len() as u64;
        if incoherent {
            acerra_imaging::looks::add_power(&mut power, &image)?;
        }
    }
    progress.finish();
    if incoherent {
        for (v, p) in image.iter_mut().zip(&power) {
            *v = Complex32::new(p.sqrt(), 0.0);
        }
    }
    let multilook = match campaign.image.looks {
        Some(count) => {
            let made = make_looks(
                campaign, count, pulses, &ground, &options, staging, progress,
            )?;
            Some(made)
        }
        None => None,
    };
    let relief_bytes = ground.surface.as_ref().map_or(0, |s| s.len() * 4);
    let beside =
        (relief_bytes + 4 * power.len()) as u128 + multilook.as_ref().map_or(0, |m| m.bytes);
    Ok(Focused {
        image,
        ground,
        promised_bytes: u64::try_from(made.bytes + beside).unwrap_or(u64::MAX),
        plan: made.explained,
        checked_error: made.checked_error,
        multilook,
        projections: None,
    })
}

/// A plan on plane or terrain.
pub(super) fn plan_on<'a>(
    ground: &'a Ground,
    pulses: Pulses<'a>,
    options: &PlanOptions,
) -> anyhow::Result<Plan<'a>> {
    match &ground.surface {
        Some(surface) => Plan::on_surface(pulses, surface, options),
        None => Plan::new(pulses, ground.grid, options),
    }
    .context("[image]")
}

/// Contributions from which a look at the clock first costs little beside the image.
const WORTH_FORETELLING: u64 = 2_000_000_000;

/// What one plan, or the most demanding of several, said.
#[derive(Default)]
struct Made {
    explained: String,
    bytes: u128,
    checked_error: Option<f64>,
}

impl Made {
    fn add(&mut self, plan: &Plan<'_>) {
        if !self.explained.is_empty() {
            self.explained.push('\n');
        }
        self.explained.push_str(&plan.explain());
        if plan.contributions() > WORTH_FORETELLING {
            let threads = rayon::current_num_threads();
            let line = format!("\nabout {:.2} s on {threads} threads", plan.estimate_s());
            self.explained.push_str(&line);
        }
        self.bytes = self.bytes.max(plan.memory_bytes());
        if let Some(check) = plan.self_check() {
            self.checked_error = Some(self.checked_error.unwrap_or(0.0).max(check.error));
        }
    }
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
