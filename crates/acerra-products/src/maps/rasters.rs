//! The image as GeoTIFF: levels in dB, linear powers, complex amplitudes.

use std::fs::File;
use std::io::{BufWriter, Write as _};

use acerra_figure::{ImageDb, Palette, PixelValues};
use acerra_maps::geotiff::{Description, write_geotiff};
use acerra_maps::qgis_style::qgis_style;
use acerra_maps::raster::{LevelScale, Raster};
use acerra_maps::world_file::world_file;
use anyhow::Context;
use rayon::prelude::*;

use super::frame::MapFrame;
use crate::display::WINDOW;
use crate::outcome::Outcome;
use crate::provenance;
use crate::staging::Staging;

/// Kinds of values in a GeoTIFF of the image.
#[derive(Clone, Copy, Debug)]
pub(super) enum Content {
    /// Levels below the maximum (dB).
    Level,
    /// Levels of |σ̃|² itself (dB).
    Absolute,
    /// Powers, linear.
    Power,
    /// Complex amplitudes.
    Complex,
}

impl Content {
    const fn file(self) -> &'static str {
        match self {
            Self::Level => "image-db.tif",
            Self::Absolute => "image-absolute-db.tif",
            Self::Power => "image-power.tif",
            Self::Complex => "image-complex.tif",
        }
    }

    const fn unit(self) -> &'static str {
        match self {
            Self::Level | Self::Absolute => "dB",
            Self::Power | Self::Complex => "",
        }
    }
}

/// Writes the image as a GeoTIFF, with a world file where its frame has no place on the Earth.
pub(super) fn write(
    content: Content,
    outcome: &Outcome,
    frame: &MapFrame,
    staging: &Staging,
) -> anyhow::Result<()> {
    let grid = &outcome.focused.pixels.grid;
    let (nx, ny) = (grid.nx, grid.ny);
    let power = match content {
        Content::Level | Content::Absolute | Content::Power => power(outcome),
        Content::Complex => Vec::new(),
    };
    let raster = match content {
        Content::Level => {
            let scale = shown_levels(outcome);
            let steps = (0..COLOURS).map(|k| Palette::Inferno.at(k as f64 / (COLOURS - 1) as f64));
            let style = qgis_style([scale.floor_db, 0.0], &steps.collect::<Vec<_>>(), "dB");
            staging.write("image-db.qml", style)?;
            Raster::level_db(&power, nx, ny, scale)
        }
        Content::Absolute => Raster::level_db(&power, nx, ny, LevelScale::ABSOLUTE),
        Content::Power => Raster::power(&power, nx, ny),
        Content::Complex => Raster::complex(&outcome.focused.image, nx, ny),
    };
    let name = content.file();
    let description = Description {
        title: format!("{}: {}", outcome.name, outcome.focused.pixels.describe()),
        software: format!("Acerra {}", env!("CARGO_PKG_VERSION")),
        unit: content.unit().to_owned(),
        items: provenance::items(outcome),
    };
    let file = File::create(staging.path(name)).with_context(|| format!("{name}: cannot write"))?;
    let mut out = BufWriter::with_capacity(1 << 20, file);
    let (placement, crs) = (&frame.placement, frame.crs());
    write_geotiff(&mut out, &raster, placement, crs, &description).context(name)?;
    out.flush()
        .with_context(|| format!("{name}: cannot write"))?;
    if crs.is_none() {
        let world = name.replace(".tif", ".tfw");
        staging.write(&world, world_file(placement))?;
    }
    Ok(())
}

/// Colours of the style for QGIS, between which it interpolates.
const COLOURS: u32 = 25;

/// The levels of `image.png` without the processing for display: relative to the maximum, down to the
/// picture's floor.
fn shown_levels(outcome: &Outcome) -> LevelScale {
    let grid = &outcome.focused.pixels.grid;
    let values = PixelValues::Complex(&outcome.focused.image);
    let mut image = ImageDb::new("", values, grid.nx, grid.ny);
    image.window = WINDOW;
    let levels = image.levels();
    LevelScale {
        zero_db: levels.reference_db,
        floor_db: levels.floor_db,
    }
}

/// |σ̃|² of Eq. (3), pixel by pixel.
fn power(outcome: &Outcome) -> Vec<f32> {
    let image = outcome.focused.image.par_iter();
    image.map(|pixel| pixel.norm_sqr()).collect()
}
