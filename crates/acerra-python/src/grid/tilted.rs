//! A tilted plane.

use acerra_imaging::TiltedGrid;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::Failure;

use super::axes::NewArguments;

/// A parallelogram of pixels in space.
///
/// Parameters
/// ----------
/// origin_m : sequence of three floats
///     Centre of pixel (0, 0): east, north, up, m.
/// u_m, v_m : sequence of three floats
///     Step from one column and from one row to the next, m.
/// shape : tuple of int
///     Rows and columns.
#[pyclass(frozen, from_py_object, module = "acerra")]
#[derive(Clone)]
pub struct Tilted(pub TiltedGrid);

#[pymethods]
impl Tilted {
    #[new]
    #[pyo3(signature = (origin_m, u_m, v_m, *, shape))]
    fn new(
        origin_m: [f64; 3],
        u_m: [f64; 3],
        v_m: [f64; 3],
        shape: (usize, usize),
    ) -> Result<Self, Failure> {
        let (rows, columns) = shape;
        Ok(Self(TiltedGrid::new(origin_m, u_m, v_m, columns, rows)?))
    }

    /// Centre of pixel (0, 0), m.
    #[getter]
    fn origin_m(&self) -> [f64; 3] {
        self.0.origin_m
    }

    /// Step from one column to the next, m.
    #[getter]
    fn u_m(&self) -> [f64; 3] {
        self.0.u_m
    }

    /// Step from one row to the next, m.
    #[getter]
    fn v_m(&self) -> [f64; 3] {
        self.0.v_m
    }

    /// Rows and columns.
    #[getter]
    fn shape(&self) -> (usize, usize) {
        (self.0.rows, self.0.columns)
    }

    /// Arguments for `pickle`.
    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<NewArguments<'py>> {
        let g = &self.0;
        let keywords = PyDict::new(py);
        keywords.set_item("shape", (g.rows, g.columns))?;
        Ok((
            (g.origin_m, g.u_m, g.v_m).into_pyobject(py)?.into_any(),
            keywords,
        ))
    }

    fn __repr__(&self) -> String {
        let g = &self.0;
        format!(
            "Tilted({} × {} pixels from {:?} m, columns by {:?} m, rows by {:?} m)",
            g.rows, g.columns, g.origin_m, g.u_m, g.v_m
        )
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }
}
