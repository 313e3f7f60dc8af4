//! Between NumPy arrays and the slices of the Rust crates.

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// The rows of an array `[n, 3]`.
pub fn rows3<'a>(array: &'a PyReadonlyArray2<'_, f64>) -> PyResult<&'a [[f64; 3]]> {
    let values = array.as_slice()?;
    let (rows, rest) = values.as_chunks::<3>();
    let [_, columns] = shape2(array);
    if columns != 3 || !rest.is_empty() {
        return Err(PyValueError::new_err(format!(
            "expected positions of shape [n, 3], found [{}, {columns}]",
            shape2(array)[0]
        )));
    }
    Ok(rows)
}

/// Rows and columns.
pub fn shape2<T: numpy::Element>(array: &PyReadonlyArray2<'_, T>) -> [usize; 2] {
    let dims = array.as_array();
    [dims.nrows(), dims.ncols()]
}

/// The values of a vector.
pub fn values<'a, T: numpy::Element>(array: &'a PyReadonlyArray1<'_, T>) -> PyResult<&'a [T]> {
    Ok(array.as_slice()?)
}

/// A vector as an array `[rows, columns]` that owns it.
pub fn matrix<T: numpy::Element>(
    py: Python<'_>,
    values: Vec<T>,
    columns: usize,
) -> PyResult<Bound<'_, PyArray2<T>>> {
    let rows = values.len().checked_div(columns).unwrap_or(0);
    PyArray1::from_vec(py, values).reshape([rows, columns])
}

/// Positions as an array `[n, 3]`.
pub fn positions<'py>(
    py: Python<'py>,
    position_m: &[[f64; 3]],
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    matrix(py, position_m.as_flattened().to_vec(), 3)
}
