//! Targets of an image.

use acerra_imaging::metrics::{ImageView, MeasureOptions, Measurement, measure_targets_in};
use acerra_imaging::{Complex32, Complex64, Pulses};
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use serde_json::json;

use crate::grid::Plane;
use crate::pulses::Antennas;
use crate::work;

/// Adds the metrics to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(measure, module)?)
}

/// Targets, levels and the fate of the maxima of an image on a plane, as JSON.
#[pyfunction]
fn measure<'py>(
    py: Python<'py>,
    grid: Plane,
    image: PyReadonlyArray2<'py, Complex32>,
    antennas: Antennas<'py>,
    spectrum: PyReadonlyArray2<'py, Complex64>,
    limits: (f64, usize, f64),
) -> PyResult<String> {
    let (threshold_db, max_targets, light_speed_m_s) = limits;
    let arrays = antennas.with_spectrum(&spectrum, light_speed_m_s)?;
    let image = image.as_slice()?;
    let options = MeasureOptions::default()
        .with_threshold_db(threshold_db)
        .with_max_targets(max_targets);
    work::run(py, None, |control| {
        let view = ImageView::new(image, grid.0)?;
        let pulses = Pulses::new(arrays)?;
        let control = control.operation();
        Ok(measured_json(&measure_targets_in(&view, &pulses, &options, control)?).to_string())
    })
}

/// A measurement as JSON.
pub fn measured_json(found: &Measurement) -> serde_json::Value {
    json!({
        "targets": found.targets,
        "statistics": found.statistics,
        "maxima": found.maxima,
        "clutter": found.clutter,
        "sidelobes": found.sidelobes,
        "ghosts": found.ghosts,
        "not_examined": found.skipped,
    })
}
