//! `image.vti` and `volume.vti`.

use std::fs::File;
use std::io::BufWriter;

use acerra_cubes::{VtiGrid, VtiWriter};
use anyhow::{Context, ensure};

use super::contents::RunContents;
use super::stacks::{Stack, Stacks};
use crate::staging::Staging;

pub(super) fn write(
    run: &RunContents<'_>,
    stacks: &Stacks,
    staging: &Staging,
) -> anyhow::Result<()> {
    write_image(run, staging).context("image.vti")?;
    match stacks.volume() {
        Some(volume) => write_volume(run, volume, staging).context("volume.vti"),
        None => Ok(()),
    }
}

/// Pixels on uneven ground are placed on the plane at their mean height, with their heights as a separate
/// array.
fn write_image(run: &RunContents<'_>, staging: &Staging) -> anyhow::Result<()> {
    let image = &run.image;
    let low = image.z_m.iter().copied().fold(f64::INFINITY, f64::min);
    let high = image.z_m.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let has_heights = image.z_m.len() > 1;
    let grid = grid(run, [0.5 * (low + high), image.pixel_m()], 1, has_heights);
    let mut vti = open("image.vti", grid, run, staging)?;
    if has_heights {
        vti.heights_m(&image.z_m)?;
    }
    vti.slice(&image.values)?;
    Ok(vti.finish()?)
}

fn write_volume(run: &RunContents<'_>, volume: &Stack, staging: &Staging) -> anyhow::Result<()> {
    let z_m = volume.heights_m()?;
    let shape = volume.shape()?;
    ensure!(
        [shape.rows, shape.columns] == [run.image.y_m.len(), run.image.x_m.len()],
        "expected slices of {} × {} pixels, as the image has, found {} × {}",
        run.image.y_m.len(),
        run.image.x_m.len(),
        shape.rows,
        shape.columns
    );
    let step_m = match z_m.as_slice() {
        [first, .., last] => (last - first) / (z_m.len() - 1) as f64,
        _ => run.image.pixel_m(),
    };
    let first_m = z_m.first().copied().unwrap_or_default();
    let mut vti = open(
        "volume.vti",
        grid(run, [first_m, step_m], z_m.len(), false),
        run,
        staging,
    )?;
    volume.each(|image| vti.slice(image))?;
    Ok(vti.finish()?)
}

/// Columns and rows of the image, and `slices` slices from a first height on, a step apart.
fn grid(
    run: &RunContents<'_>,
    [z_m, step_m]: [f64; 2],
    slices: usize,
    has_heights: bool,
) -> VtiGrid {
    let image = &run.image;
    let first = |axis: &[f64]| axis.first().copied().unwrap_or_default();
    let pixel_m = image.pixel_m();
    VtiGrid {
        origin_m: [first(&image.x_m), first(&image.y_m), z_m],
        spacing_m: [pixel_m, pixel_m, step_m],
        points: [image.x_m.len(), image.y_m.len(), slices],
        has_heights,
    }
}

fn open(
    name: &str,
    grid: VtiGrid,
    run: &RunContents<'_>,
    staging: &Staging,
) -> anyhow::Result<VtiWriter<BufWriter<File>>> {
    let file = File::create(staging.path(name)).context("cannot write")?;
    let file = BufWriter::with_capacity(1 << 20, file);
    Ok(VtiWriter::new(file, grid, &run.items)?)
}
