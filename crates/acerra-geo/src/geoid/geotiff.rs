//! GeoTIFF grids, such as PROJ's `us_nga_egm96_15.tif`.

use std::io::Cursor;

use super::GeoidError;
use super::grid::{GeoidGrid, Layout};
use crate::terrain::GeographicRaster;

const FORMAT: &str = "GeoTIFF";

/// Reads a raster of geoid heights (m) in longitude and latitude.
pub(super) fn read(bytes: &[u8]) -> Result<GeoidGrid, GeoidError> {
    let raster = GeographicRaster::read(Cursor::new(bytes))?;
    if raster.heights_m.iter().any(|h| h.is_nan()) {
        return Err(GeoidError::Format {
            format: FORMAT,
            expected: "a height in every cell".to_owned(),
            found: "cells without data".to_owned(),
        });
    }
    let layout = Layout {
        south: raster.south_deg,
        west: raster.west_deg,
        steps: raster.steps_deg,
        rows: raster.heights_m.len() / raster.columns.max(1),
        columns: raster.columns,
    };
    GeoidGrid::new(&layout, raster.heights_m, FORMAT)
}
