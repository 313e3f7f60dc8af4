//! Rasters of heights: terrain, and geoid grids as GeoTIFF.

use std::path::Path;

use acerra_geo::terrain::{TerrainError, TerrainFile, TerrainOptions};
use serde_json::json;

use super::description::Description;

/// Largest number of cells whose heights are read.
const MOST_CELLS: usize = 1 << 25;

pub fn describe(path: &Path) -> anyhow::Result<Description> {
    let mut file = TerrainFile::open_path(path, &TerrainOptions::default())?;
    let mut d = Description::new(format!("raster of heights ({})", file.format()));
    let [columns, rows] = file.size();
    d.fact("columns", columns);
    d.fact("rows", rows);
    match file.crs() {
        Ok(crs) => d.fact("coordinates", crs.to_string()),
        Err(error) => d.notes.push(error.to_string()),
    }
    let [first, last] = file.corners();
    for (axis, name) in ["first_coordinate", "second_coordinate"]
        .into_iter()
        .enumerate()
    {
        let ends = [first[axis].min(last[axis]), first[axis].max(last[axis])];
        d.fact(name, json!(ends));
    }
    if let Some(purpose) = file.grid_type().map(str::to_owned) {
        d.fact("purpose", purpose);
    }
    match file.vertical() {
        Some(vertical) => d.fact("heights_above", vertical),
        None => d
            .notes
            .push("the file does not state what its heights count from".to_owned()),
    }
    match file.heights(MOST_CELLS) {
        Ok(heights) => {
            d.fact("heights_m", json!([heights.lowest_m, heights.highest_m]));
            d.fact("mean_height_m", heights.mean_m);
            d.fact("cells_without_data", heights.without_data);
        }
        Err(error @ TerrainError::Limit { .. }) => {
            d.notes.push(format!("heights not read: {error}"))
        }
        Err(error) => return Err(error.into()),
    }
    Ok(d)
}
