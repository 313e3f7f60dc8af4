//! A horizontal plane.

use acerra_imaging::PlaneGrid;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::Failure;

use super::axes::{Extent, NewArguments, columns, ranges, rows};

/// A horizontal rectangle of square pixels.
///
/// Parameters
/// ----------
/// x_m, y_m : sequence of two floats
///     First and last pixel centre east and north, m; the last one is kept where it falls on a pixel.
/// z_m : float
///     Height of the plane, m.
/// pixel_m : float
///     Distance of neighbouring pixel centres, m.
///
/// Raises
/// ------
/// ImagingError
///     Extents that do not increase, or hold too many pixels.
///
/// Examples
/// --------
/// >>> import acerra
/// >>> acerra.Plane([0, 1], [-0.5, 0.5], pixel_m=0.25).shape
/// (5, 5)
#[pyclass(frozen, from_py_object, module = "acerra")]
#[derive(Clone)]
pub struct Plane(pub PlaneGrid);

#[pymethods]
impl Plane {
    #[new]
    #[pyo3(signature = (x_m, y_m, *, z_m = 0.0, pixel_m))]
    fn new(x_m: Extent, y_m: Extent, z_m: f64, pixel_m: f64) -> Result<Self, Failure> {
        Ok(Self(PlaneGrid::from_ranges(x_m.0, y_m.0, z_m, pixel_m)?))
    }

    /// Centres of the columns, m.
    #[getter]
    fn x_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        columns(py, &self.0)
    }

    /// Centres of the rows, m.
    #[getter]
    fn y_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        rows(py, &self.0)
    }

    /// Height of the plane, m.
    #[getter]
    fn z_m(&self) -> f64 {
        self.0.z_m
    }

    /// Distance of neighbouring pixel centres, m.
    #[getter]
    fn pixel_m(&self) -> f64 {
        self.0.pixel_m
    }

    /// Rows and columns.
    #[getter]
    fn shape(&self) -> (usize, usize) {
        (self.0.ny, self.0.nx)
    }

    /// Arguments for `pickle`.
    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<NewArguments<'py>> {
        let g = &self.0;
        let keywords = PyDict::new(py);
        keywords.set_item("z_m", g.z_m)?;
        keywords.set_item("pixel_m", g.pixel_m)?;
        Ok((ranges(g).into_pyobject(py)?.into_any(), keywords))
    }

    fn __repr__(&self) -> String {
        let g = &self.0;
        format!(
            "Plane({} × {} pixels of {} m from ({}, {}) m at z = {} m)",
            g.ny, g.nx, g.pixel_m, g.x0_m, g.y0_m, g.z_m
        )
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }
}
