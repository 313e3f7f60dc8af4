//! Readers of radar logs and trajectories.

use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;

use acerra_chain::Warnings;
use acerra_chain::position::trajectory_file::{TrajectoryFileOptions, read_trajectory_file};
use acerra_chain::read::{RadarContent, read_channel};
use acerra_geo::geodesy::Geodetic;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{matrix, positions};
use crate::errors::Failure;
use crate::positions::{origin_deg_m, trajectory_arrays};
use crate::prepared::radargram_arrays;
use crate::work;

/// Adds the readers to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(read_radar, module)?)?;
    module.add_function(wrap_pyfunction!(read_trajectory, module)?)
}

/// A radar log as arrays: a radargram or spectra, with positions where the file brings them.
#[pyfunction]
fn read_radar<'py>(
    py: Python<'py>,
    file: PathBuf,
    channel: Option<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let (data, warnings) = work::run(py, None, |_| {
        let mut warnings = Warnings::default();
        let data =
            read_channel(&file, channel.as_deref(), None, &mut warnings).map_err(Failure::read)?;
        Ok((data, warnings))
    })?;
    let arrays = match &data.content {
        RadarContent::Radargram(radargram) => radargram_arrays(py, radargram)?,
        RadarContent::Spectrum(spectrum) => {
            let arrays = PyDict::new(py);
            let columns = spectrum.frequency_hz.len();
            arrays.set_item("spectrum", matrix(py, spectrum.values.clone(), columns)?)?;
            arrays.set_item("time_s", PyArray1::from_slice(py, &spectrum.time_s))?;
            let frequency_hz = PyArray1::from_slice(py, &spectrum.frequency_hz);
            arrays.set_item("frequency_hz", frequency_hz)?;
            arrays
        }
    };
    if let Some(placed) = &data.positions {
        arrays.set_item("position_m", positions(py, &placed.position_m)?)?;
        arrays.set_item("origin_deg_m", origin_deg_m(&placed.frame))?;
    }
    arrays.set_item("unit", data.label.unit)?;
    arrays.set_item("summary", data.label.summary)?;
    arrays.set_item("warnings", warnings.said().to_vec())?;
    Ok(arrays)
}

/// A trajectory as arrays.
#[pyfunction]
fn read_trajectory<'py>(
    py: Python<'py>,
    file: PathBuf,
    origin_deg_m: Option<[f64; 3]>,
    rigid_body: Option<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let options = TrajectoryFileOptions {
        origin: origin_deg_m.map(|[latitude, longitude, height]| {
            Geodetic::from_degrees(latitude, longitude, height)
        }),
        rigid_body,
        ..TrajectoryFileOptions::default()
    };
    let read = work::run(py, None, |_| {
        let at =
            |error: &dyn std::fmt::Display| Failure::read(format!("{}: {error}", file.display()));
        let opened = File::open(&file).map_err(|error| at(&error))?;
        read_trajectory_file(BufReader::new(opened), &options).map_err(|error| at(&error))
    })?;
    let arrays = trajectory_arrays(py, &read.trajectory)?;
    arrays.set_item("has_local_axes", read.has_local_axes())?;
    Ok(arrays)
}
