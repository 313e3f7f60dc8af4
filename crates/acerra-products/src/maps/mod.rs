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

use crate::outcome::Outcome;
use crate::staging::Staging;
use frame::MapFrame;
pub(crate) use frame::earth_frame;
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
/// A file that cannot be written, an image that cannot be placed on the map asked for.
pub(crate) fn write(outcome: &Outcome, staging: &Staging) -> anyhow::Result<()> {
    let frame = MapFrame::of(outcome)?;
    let mut done: Vec<ProductFormat> = Vec::new();
    for format in &outcome.campaign.products.formats {
        if done.contains(format) {
            continue;
        }
        done.push(*format);
        match format {
            ProductFormat::Geotiff => rasters::write(Content::Level, outcome, &frame, staging)?,
            ProductFormat::GeotiffPower => {
                rasters::write(Content::Power, outcome, &frame, staging)?
            }
            ProductFormat::GeotiffComplex => {
                rasters::write(Content::Complex, outcome, &frame, staging)?
            }
            ProductFormat::Kmz => {
                if let Some(earth) = frame.earth() {
                    overlay::write(outcome, earth, staging)?;
                }
            }
            ProductFormat::Geojson => {
                if let Some(earth) = frame.earth() {
                    targets::write(outcome, earth, staging)?;
                }
            }
            ProductFormat::Zarr
            | ProductFormat::Hdf5
            | ProductFormat::Vtk
            | ProductFormat::Cphd => {}
        }
    }
    Ok(())
}
