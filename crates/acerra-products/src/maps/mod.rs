//! Files for map programs: GeoTIFF, KMZ, GeoJSON.
//!
//! ```text
//! Outcome ──MapFrame (frame on the Earth, system of coordinates)──► image-db.tif, image.kmz, …
//! ```

mod frame;
mod overlay;
mod rasters;
mod targets;

use acerra_chain::campaign::{Campaign, ProductFormat};
use acerra_maps::crs::MapCrs;
use anyhow::Context;

use crate::display::Shown;
use crate::outcome::Outcome;
use crate::staging::Staging;
use frame::MapFrame;
use rasters::Content;

/// Refuses a system of coordinates that cannot be used, before anything is read.
///
/// # Errors
/// A code that is not known, or whose datum is not related to WGS84.
pub(crate) fn check(campaign: &Campaign) -> anyhow::Result<()> {
    match campaign.products.epsg {
        Some(code) => MapCrs::from_epsg(code).map(drop).context("[products] epsg"),
        None => Ok(()),
    }
}

/// Writes the formats that the campaign asks for; those that need a place on the Earth are left out
/// where the positions have none.
///
/// # Errors
/// A file that cannot be written, an image that cannot be placed on the requested map.
pub(crate) fn write(outcome: &Outcome, shown: &Shown, staging: &Staging) -> anyhow::Result<()> {
    let frame = MapFrame::of(outcome)?;
    let wanted = |format| outcome.campaign.products.formats.contains(&format);
    // One raster after another, as each holds a copy of the image; the other files at the same time.
    let write_rasters = || {
        [
            (ProductFormat::Geotiff, Content::Level),
            (ProductFormat::GeotiffAbsolute, Content::Absolute),
            (ProductFormat::GeotiffPower, Content::Power),
            (ProductFormat::GeotiffComplex, Content::Complex),
        ]
        .into_iter()
        .filter(|(format, _)| wanted(*format))
        .try_for_each(|(_, content)| rasters::write(content, outcome, &frame, staging))
    };
    let write_overlay = || match frame.earth() {
        Some(earth) if wanted(ProductFormat::Kmz) => overlay::write(outcome, shown, earth, staging),
        _ => Ok(()),
    };
    let write_targets = || match frame.earth() {
        Some(earth) if wanted(ProductFormat::Geojson) => targets::write(outcome, earth, staging),
        _ => Ok(()),
    };
    let (rasters, others) =
        rayon::join(write_rasters, || rayon::join(write_overlay, write_targets));
    rasters.and(others.0).and(others.1)
}
