//! Uneven ground.

use std::sync::Arc;

use acerra_imaging::{PlaneGrid, SurfaceGrid};
use numpy::{PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{matrix, shape2};
use crate::errors::Failure;

use super::axes::{Extent, NewArguments, columns, ranges, rows};

/// Pixels on uneven ground over a horizontal rectangle.
///
/// Parameters
/// ----------
/// x_m, y_m : sequence of two floats
///     First and last pixel centre east and north, m.
/// heights_m : numpy.ndarray of float64, shape (rows, columns)
///     Height of each pixel, m; row 0 is at the smallest y.
/// pixel_m : float
///     Distance of neighbouring pixel centres, m.
#[pyclass(frozen, from_py_object, module = "acerra")]
#[derive(Clone)]
pub struct Surface(pub Arc<SurfaceGrid>);

#[pymethods]
impl Surface {
    #[new]
    #[pyo3(signature = (x_m, y_m, heights_m, *, pixel_m))]
    fn new(
        x_m: Extent,
        y_m: Extent,
        heights_m: PyReadonlyArray2<'_, f64>,
        pixel_m: f64,
    ) -> PyResult<Self> {
        let base = PlaneGrid::from_ranges(x_m.0, y_m.0, 0.0, pixel_m).map_err(Failure::from)?;
        let found = shape2(&heights_m);
        if found != [base.ny, base.nx] {
            return Err(PyValueError::new_err(format!(
                "heights_m: expected shape [{}, {}], found {found:?}",
                base.ny, base.nx
            )));
        }
        let surface = SurfaceGrid::new(base, heights_m.as_slice()?).map_err(Failure::from)?;
        Ok(Self(Arc::new(surface)))
    }

    /// Centres of the columns, m.
    #[getter]
    fn x_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        columns(py, self.0.base())
    }

    /// Centres of the rows, m.
    #[getter]
    fn y_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        rows(py, self.0.base())
    }

    /// Heights of the pixels `[rows, columns]`, m.
    #[getter]
    fn z_m<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let heights = (0..self.0.len()).map(|k| self.0.z_m(k)).collect();
        matrix(py, heights, self.0.base().nx)
    }

    /// Distance of neighbouring pixel centres, m.
    #[getter]
    fn pixel_m(&self) -> f64 {
        self.0.base().pixel_m
    }

    /// Rows and columns.
    #[getter]
    fn shape(&self) -> (usize, usize) {
        (self.0.base().ny, self.0.base().nx)
    }

    /// Arguments for `pickle`.
    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<NewArguments<'py>> {
        let keywords = PyDict::new(py);
        keywords.set_item("pixel_m", self.0.base().pixel_m)?;
        let (x_m, y_m) = ranges(self.0.base());
        Ok((
            (x_m, y_m, self.z_m(py)?).into_pyobject(py)?.into_any(),
            keywords,
        ))
    }

    fn __repr__(&self) -> String {
        let (g, [low, high]) = (self.0.base(), self.0.span_m());
        format!(
            "Surface({} × {} pixels of {} m from ({}, {}) m, z = {low} to {high} m)",
            g.ny, g.nx, g.pixel_m, g.x0_m, g.y0_m
        )
    }
}
