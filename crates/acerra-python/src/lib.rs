//! The native module of the Python package `acerra`.
//!
//! ```text
//! acerra (Python: xarray, checks, plots) ──NumPy arrays, JSON──► _native ──► acerra-chain, -imaging, …
//! ```
//!
//! Functions accept contiguous arrays of the right type, which the Python side makes, and return arrays or
//! JSON. Long work runs without the interpreter's lock (module `work`), is cancelled by Ctrl-C and reports
//! progress.

mod arrays;
mod calibration;
mod campaign;
mod errors;
mod grid;
mod imaging;
mod metrics;
mod modelling;
mod positioning;
mod positions;
mod prepared;
mod pulses;
mod readers;
mod run;
mod simulation;
mod theory;
mod work;

use pyo3::prelude::*;

/// Native module of the package acerra; its Python modules are the interface.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("SPEED_OF_LIGHT_M_S", acerra_imaging::SPEED_OF_LIGHT_M_S)?;
    errors::register(module)?;
    grid::register(module)?;
    imaging::register(module)?;
    modelling::register(module)?;
    metrics::register(module)?;
    campaign::register(module)?;
    calibration::register(module)?;
    readers::register(module)?;
    positioning::register(module)?;
    simulation::register(module)?;
    theory::register(module)
}
