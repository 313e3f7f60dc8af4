//! Looks and volumes: images that go to their file one by one.

use std::fs::File;
use std::io::{BufWriter, Write};

use acerra_imaging::looks::{LookWindow, add_power, looks};
use acerra_imaging::{
    Complex32, Control, PlanOptions, Pulses, SurfaceGrid, VolumeGrid, image_volume,
};
use anyhow::Context;

use super::focus::{Focused, plan_on};
use super::ground::Ground;
use super::progress::Progress;
use super::space::projections_bytes;
use crate::campaign::{Campaign, LookTaper};
use crate::products::stack_npz;
use crate::products::staging::Staging;

/// The looks of an image.
#[derive(Clone, Debug)]
pub struct Multilook {
    /// Mean power of the looks, `[ny, nx]`.
    pub power: Vec<f32>,
    /// Numbers of the first and last trace of each look, among those imaged.
    pub traces: Vec<[usize; 2]>,
    /// Bytes that looks took beside the image.
    pub bytes: u128,
}

/// A volume seen from three sides: the greatest amplitude along the other axis.
#[derive(Clone, Debug)]
pub struct Projections {
    /// From above, `[ny, nx]`: moduli without phase.
    pub above: Vec<Complex32>,
    /// From the south, `[nz, nx]`.
    pub front: Vec<f32>,
    /// From the west, `[nz, ny]`.
    pub side: Vec<f32>,
    /// The slices.
    pub volume: VolumeGrid,
}

/// Images every look into `looks.npz`, and sums their powers.
///
/// # Errors
/// More looks than the track has, data that cannot be imaged, a disk that is full.
pub(super) fn make_looks(
    campaign: &Campaign,
    count: usize,
    pulses: Pulses<'_>,
    ground: &Ground,
    options: &PlanOptions,
    staging: &Staging,
    progress: &dyn Progress,
) -> anyhow::Result<Multilook> {
    let window = match campaign.image.look_window {
        LookTaper::None => LookWindow::Rectangular,
        LookTaper::Hann => LookWindow::Hann,
    };
    let overlap = campaign.image.look_overlap;
    let cut = looks(pulses.position_m(), count, overlap, window).context("[image] looks")?;
    let grid = &ground.grid;
    let mut power = vec![0_f32; grid.len()];
    let mut image = vec![Complex32::default(); grid.len()];
    let mut table_bytes = 0;
    let contributions: usize = cut.iter().map(|look| look.pulses.len()).sum();
    progress.start("looks", grid.len() as u64 * contributions as u64);
    let mut file = create(staging, "looks.npz")?;
    stack_npz::write(&mut file, "looks", grid, count, |put| {
        let mut before = 0;
        for look in &cut {
            let weight: Vec<f64> = look
                .weight
                .iter()
                .zip(&pulses.weight()[look.pulses.clone()])
                .map(|(window, weight)| window * weight)
                .collect();
            let part = pulses.slice(look.pulses.clone())?.with_weight(&weight)?;
            let plan = plan_on(ground, part, options)?;
            let report = |step: acerra_imaging::Progress| progress.at(before + step.done);
            plan.run(&mut image, Control::default().reporting_to(&report))?;
            before += grid.len() as u64 * part.len() as u64;
            table_bytes = table_bytes.max(plan.memory_bytes() - 8 * grid.len() as u128);
            add_power(&mut power, &image)?;
            put(&image)?;
        }
        #[expect(clippy::cast_precision_loss, reason = "counts of traces and looks")]
        {
            power.iter_mut().for_each(|p| *p /= count as f32);
            let ends = |f: fn(&std::ops::Range<usize>) -> usize| -> Vec<f64> {
                cut.iter().map(|look| f(&look.pulses) as f64).collect()
            };
            let shape = vec![count as u64];
            let middle = |look: &acerra_imaging::looks::Look| {
                let p = &pulses.position_m()[look.pulses.clone()];
                [0, 1, 2].map(|a| p.iter().map(|p| p[a]).sum::<f64>() / p.len() as f64)
            };
            anyhow::Ok(vec![
                ("first_trace", shape.clone(), ends(|r| r.start)),
                ("last_trace", shape, ends(|r| r.end - 1)),
                (
                    "position_m",
                    vec![count as u64, 3],
                    cut.iter().flat_map(middle).collect(),
                ),
                (
                    "multilook",
                    vec![grid.ny as u64, grid.nx as u64],
                    power.iter().map(|p| f64::from(*p)).collect(),
                ),
            ])
        }
    })?;
    file.flush().context("looks.npz: cannot write")?;
    progress.finish();
    Ok(Multilook {
        power,
        traces: cut
            .iter()
            .map(|look| [look.pulses.start, look.pulses.end - 1])
            .collect(),
        bytes: table_bytes + 24 * grid.len() as u128,
    })
}

/// Images every slice into `volume.npz`, and keeps what is greatest along each axis.
///
/// # Errors
/// Data that cannot be imaged, a disk that is full.
pub(super) fn make_volume(
    pulses: Pulses<'_>,
    mut ground: Ground,
    volume: VolumeGrid,
    options: &PlanOptions,
    staging: &Staging,
    progress: &dyn Progress,
) -> anyhow::Result<Focused> {
    let grid = ground.grid;
    let (nx, ny, nz) = (grid.nx, grid.ny, volume.nz);
    let mut image = vec![Complex32::default(); grid.len()];
    let mut height = vec![0_f32; grid.len()];
    let mut front = vec![0_f32; nz * nx];
    let mut side = vec![0_f32; nz * ny];
    let mut file = create(staging, "volume.npz")?;
    let per_slice = grid.len() as u64 * pulses.len() as u64;
    progress.start("focus", per_slice * nz as u64);
    let mut run = None;
    stack_npz::write(&mut file, "volume", &grid, nz, |put| {
        let made = image_volume(
            &volume,
            pulses,
            options,
            Control::default(),
            |k, _, slice| {
                #[expect(clippy::cast_possible_truncation, reason = "heights in a picture")]
                let above_m = (k as f64 * volume.step_m) as f32;
                for (at, v) in slice.iter().enumerate() {
                    let power = v.norm_sqr();
                    if power > image[at].norm_sqr() {
                        image[at] = *v;
                        height[at] = above_m;
                    }
                    let (i, j) = (at % nx, at / nx);
                    front[k * nx + i] = front[k * nx + i].max(power);
                    side[k * ny + j] = side[k * ny + j].max(power);
                }
                progress.at(per_slice * (k as u64 + 1));
                put(slice).context("volume.npz: cannot write")
            },
        )?;
        run = Some(made);
        let z_m = (0..nz).map(|k| volume.slice(k).z_m).collect();
        anyhow::Ok(vec![("z_m", vec![nz as u64], z_m)])
    })?;
    file.flush().context("volume.npz: cannot write")?;
    progress.finish();
    front
        .iter_mut()
        .chain(&mut side)
        .for_each(|p| *p = p.sqrt());
    let surface = SurfaceGrid::from_fn(grid, {
        let mut heights = height.iter();
        move |_, _| {
            let above_m = heights.next().copied().unwrap_or(0.0);
            anyhow::Ok(grid.z_m + f64::from(above_m))
        }
    })?;
    drop(height);
    let level = |v: &Complex32| Complex32::new(v.norm(), 0.0);
    let above = image.iter().map(level).collect();
    ground.surface = Some(surface);
    let run = run.context("a volume has slices")?;
    let bytes = run.memory_bytes + projections_bytes(nx, ny, nz) + 4 * grid.len() as u128;
    Ok(Focused {
        image,
        ground,
        plan: run.report.to_string(),
        promised_bytes: u64::try_from(bytes).unwrap_or(u64::MAX),
        checked_error: run.checked_error,
        multilook: None,
        projections: Some(Projections {
            above,
            front,
            side,
            volume,
        }),
    })
}

fn create(staging: &Staging, name: &str) -> anyhow::Result<BufWriter<File>> {
    let file = File::create(staging.path(name)).with_context(|| format!("{name}: cannot write"))?;
    Ok(BufWriter::with_capacity(1 << 20, file))
}
