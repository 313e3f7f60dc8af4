//! Geoid grids.

use std::io::Read;

use acerra_geo::geoid::GeoidGrid;

use super::description::Description;

pub fn describe(reader: impl Read) -> anyhow::Result<Description> {
    let grid = GeoidGrid::from_reader(reader)?;
    let mut d = Description::new("geoid grid");
    d.fact("rows", grid.rows());
    d.fact("columns", grid.columns());
    let [south_deg, west_deg] = grid.south_west_deg();
    let [latitude_step_deg, longitude_step_deg] = grid.steps_deg();
    let end = |first: f64, step: f64, count: usize| step.mul_add((count - 1) as f64, first);
    let latitudes_deg = [south_deg, end(south_deg, latitude_step_deg, grid.rows())];
    let longitudes_deg = [west_deg, end(west_deg, longitude_step_deg, grid.columns())];
    d.fact("latitudes_deg", latitudes_deg.to_vec());
    d.fact("longitudes_deg", longitudes_deg.to_vec());
    d.fact("latitude_step_deg", latitude_step_deg);
    d.fact("longitude_step_deg", longitude_step_deg);
    d.fact("geoid_above_ellipsoid_m", grid.range_m().to_vec());
    Ok(d)
}
