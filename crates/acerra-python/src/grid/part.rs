//! A part of a grid, as a grid.

use std::ops::Range;
use std::sync::Arc;

use acerra_imaging::{PlaneGrid, SurfaceGrid, TiltedGrid, VolumeGrid};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::any::Grid;
use super::plane::Plane;
use super::surface::Surface;
use super::tilted::Tilted;
use super::volume::Volume;
use crate::errors::Failure;

/// The part of a grid from index `start` to before `stop`, in the order of its shape.
#[pyfunction]
pub fn part_of<'py>(
    py: Python<'py>,
    grid: Grid,
    start: Vec<usize>,
    stop: Vec<usize>,
) -> PyResult<Bound<'py, PyAny>> {
    let shape = grid.shape();
    let is_within = start.len() == shape.len()
        && stop.len() == shape.len()
        && (0..shape.len()).all(|axis| start[axis] < stop[axis] && stop[axis] <= shape[axis]);
    if !is_within {
        return Err(PyValueError::new_err(format!(
            "part: expected a part of shape {shape:?}, found {start:?} to {stop:?}"
        )));
    }
    let axes = shape.len();
    let [rows, columns] = [axes - 2, axes - 1].map(|axis| start[axis]..stop[axis]);
    Ok(match grid {
        Grid::Plane(Plane(g)) => Bound::new(py, Plane(rectangle(&g, &rows, &columns)?))?.into_any(),
        Grid::Volume(Volume(g)) => {
            let base = rectangle(&g.slice(start[0]), &rows, &columns)?;
            let part = VolumeGrid::new(base, g.step_m, stop[0] - start[0]);
            Bound::new(py, Volume(part.map_err(Failure::from)?))?.into_any()
        }
        Grid::Surface(Surface(g)) => {
            let base = rectangle(g.base(), &rows, &columns)?;
            let nx = g.base().nx;
            let heights: Vec<f64> = rows
                .flat_map(|j| columns.clone().map(move |i| j * nx + i))
                .map(|k| g.z_m(k))
                .collect();
            let part = SurfaceGrid::new(base, &heights).map_err(Failure::from)?;
            Bound::new(py, Surface(Arc::new(part)))?.into_any()
        }
        Grid::Tilted(Tilted(g)) => {
            let origin_m = g.point_m(columns.start as f64, rows.start as f64);
            let part = TiltedGrid::new(origin_m, g.u_m, g.v_m, columns.len(), rows.len());
            Bound::new(py, Tilted(part.map_err(Failure::from)?))?.into_any()
        }
    })
}

/// Some rows and columns of a plane.
fn rectangle(
    grid: &PlaneGrid,
    rows: &Range<usize>,
    columns: &Range<usize>,
) -> Result<PlaneGrid, Failure> {
    let origin_m = [grid.x_m(columns.start), grid.y_m(rows.start), grid.z_m];
    Ok(PlaneGrid::new(
        origin_m,
        grid.pixel_m,
        [columns.len(), rows.len()],
    )?)
}
