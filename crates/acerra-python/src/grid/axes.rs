//! Axes of level grids, and their arguments.

use acerra_imaging::PlaneGrid;
use numpy::PyArray1;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// First and last pixel centre along an axis (m), as an argument.
pub struct Extent(pub [f64; 2]);

impl<'py> FromPyObject<'_, 'py> for Extent {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        given.extract().map(Self).map_err(|_| {
            PyTypeError::new_err(format!(
                "expected two numbers, the first and the last pixel centre in m, found {}",
                given
                    .repr()
                    .map_or_else(|_| "something else".to_owned(), |r| r.to_string())
            ))
        })
    }
}

/// Positional and named arguments of a constructor.
pub type NewArguments<'py> = (Bound<'py, PyAny>, Bound<'py, PyDict>);

/// First and last centre of the columns and of the rows (m).
pub fn ranges(grid: &PlaneGrid) -> ([f64; 2], [f64; 2]) {
    (
        [grid.x0_m, grid.x_m(grid.nx - 1)],
        [grid.y0_m, grid.y_m(grid.ny - 1)],
    )
}

/// Centres of the columns (m).
pub fn columns<'py>(py: Python<'py>, grid: &PlaneGrid) -> Bound<'py, PyArray1<f64>> {
    PyArray1::from_iter(py, (0..grid.nx).map(|i| grid.x_m(i)))
}

/// Centres of the rows (m).
pub fn rows<'py>(py: Python<'py>, grid: &PlaneGrid) -> Bound<'py, PyArray1<f64>> {
    PyArray1::from_iter(py, (0..grid.ny).map(|j| grid.y_m(j)))
}
