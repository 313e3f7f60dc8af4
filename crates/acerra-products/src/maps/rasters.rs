//! The image as GeoTIFF: levels in dB, linear powers, complex amplitudes.

use std::fs::File;
use std::io::{BufWriter, Write as _};

use acerra_maps::geotiff::{Description, write_geotiff};
use acerra_maps::raster::Raster;
use acerra_maps::world_file::world_file;
use anyhow::Context;
use rayon::prelude::*;

use super::frame::MapFrame;
use crate::outcome::Outcome;
use crate::provenance;
use crate::staging::Staging;

pub(super) fn write_level(
    outcome: &Outcome,
    frame: &MapFrame,
    staging: &Staging,
) -> anyhow::Result<()> {
    let power = power(outcome);
    let grid = &outcome.focused.pixels.grid;
    let raster = Raster::level_db(&power, grid.nx, grid.ny);
    write("image-db.tif", "dB", &raster, outcome, frame, staging)
}

pub(super) fn write_power(
    outcome: &Outcome,
    frame: &MapFrame,
    staging: &Staging,
) -> anyhow::Result<()> {
    let power = power(outcome);
    let grid = &outcome.focused.pixels.grid;
    let raster = Raster::power(&power, grid.nx, grid.ny);
    write("image-power.tif", "", &raster, outcome, frame, staging)
}

pub(super) fn write_complex(
    outcome: &Outcome,
    frame: &MapFrame,
    staging: &Staging,
) -> anyhow::Result<()> {
    let grid = &outcome.focused.pixels.grid;
    let raster = Raster::complex(&outcome.focused.image, grid.nx, grid.ny);
    write("image-complex.tif", "", &raster, outcome, frame, staging)
}

/// |σ̃|² of Eq. (3), pixel by pixel.
fn power(outcome: &Outcome) -> Vec<f32> {
    let image = outcome.focused.image.par_iter();
    image.map(|pixel| pixel.norm_sqr()).collect()
}

fn write(
    name: &'static str,
    unit: &str,
    raster: &Raster<'_>,
    outcome: &Outcome,
    frame: &MapFrame,
    staging: &Staging,
) -> anyhow::Result<()> {
    let description = Description {
        title: format!("{}: {}", outcome.name, outcome.focused.pixels.describe()),
        software: format!("Acerra {}", env!("CARGO_PKG_VERSION")),
        unit: unit.to_owned(),
        items: provenance::items(outcome),
    };
    let file = File::create(staging.path(name)).with_context(|| format!("{name}: cannot write"))?;
    let mut out = BufWriter::with_capacity(1 << 20, file);
    write_geotiff(
        &mut out,
        raster,
        &frame.placement,
        frame.crs(),
        &description,
    )
    .context(name)?;
    out.flush()
        .with_context(|| format!("{name}: cannot write"))?;
    if frame.crs().is_none() {
        let world = name.replace(".tif", ".tfw");
        staging.write(&world, world_file(&frame.placement))?;
    }
    Ok(())
}
