//! The slices of a volume.

use acerra_imaging::{PlaneGrid, VolumeGrid};
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::plane::Plane;
use crate::errors::Failure;

use super::axes::{Extent, NewArguments, columns, ranges, rows};

/// A plane repeated at even heights.
///
/// Parameters
/// ----------
/// x_m, y_m, z_m : sequence of two floats
///     First and last voxel centre east, north and up, m.
/// pixel_m : float
///     Distance of neighbouring voxel centres within a slice, m.
/// step_m : float, optional
///     Distance of neighbouring slices, m; that of the pixels by default.
#[pyclass(frozen, from_py_object, module = "acerra")]
#[derive(Clone)]
pub struct Volume(pub VolumeGrid);

#[pymethods]
impl Volume {
    #[new]
    #[pyo3(signature = (x_m, y_m, z_m, *, pixel_m, step_m = None))]
    fn new(
        x_m: Extent,
        y_m: Extent,
        z_m: Extent,
        pixel_m: f64,
        step_m: Option<f64>,
    ) -> PyResult<Self> {
        let z_m = z_m.0;
        let step_m = step_m.unwrap_or(pixel_m);
        let base = PlaneGrid::from_ranges(x_m.0, y_m.0, z_m[0], pixel_m).map_err(Failure::from)?;
        let steps = (z_m[1] - z_m[0]) / step_m;
        if !(0.0..1e6).contains(&steps) {
            return Err(PyValueError::new_err(format!(
                "z_m: expected a range upwards of at most a million slices, found {z_m:?} m by {step_m} m"
            )));
        }
        // The end is kept where it falls on a slice, as the ends of columns and rows are.
        let slices = (steps + 1e-6).floor() as usize + 1;
        Ok(Self(
            VolumeGrid::new(base, step_m, slices).map_err(Failure::from)?,
        ))
    }

    /// Centres of the columns, m.
    #[getter]
    fn x_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        columns(py, &self.0.base)
    }

    /// Centres of the rows, m.
    #[getter]
    fn y_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        rows(py, &self.0.base)
    }

    /// Heights of the slices, m.
    #[getter]
    fn z_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, (0..self.0.nz).map(|k| self.0.slice(k).z_m))
    }

    /// Distance of neighbouring pixel centres, m.
    #[getter]
    fn pixel_m(&self) -> f64 {
        self.0.base.pixel_m
    }

    /// Slices, rows and columns.
    #[getter]
    fn shape(&self) -> (usize, usize, usize) {
        (self.0.nz, self.0.base.ny, self.0.base.nx)
    }

    /// The plane of slice `index`.
    fn slice(&self, index: usize) -> PyResult<Plane> {
        if index >= self.0.nz {
            return Err(PyValueError::new_err(format!(
                "slice: expected 0 to {}, found {index}",
                self.0.nz - 1
            )));
        }
        Ok(Plane(self.0.slice(index)))
    }

    /// Arguments for `pickle`.
    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<NewArguments<'py>> {
        let g = &self.0;
        let keywords = PyDict::new(py);
        keywords.set_item("pixel_m", g.base.pixel_m)?;
        keywords.set_item("step_m", g.step_m)?;
        let (x_m, y_m) = ranges(&g.base);
        let z_m = [g.base.z_m, g.slice(g.nz - 1).z_m];
        Ok(((x_m, y_m, z_m).into_pyobject(py)?.into_any(), keywords))
    }

    fn __repr__(&self) -> String {
        let (g, v) = (&self.0.base, &self.0);
        format!(
            "Volume({} × {} × {} voxels of {} m, slices by {} m, from ({}, {}, {}) m)",
            v.nz, g.ny, g.nx, g.pixel_m, v.step_m, g.x0_m, g.y0_m, g.z_m
        )
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }
}
