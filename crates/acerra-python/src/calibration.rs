//! Calibration of the instrument on reflectors at known places.

use std::path::PathBuf;

use acerra_chain::Journal;
use acerra_products::calibration::{CalibrationRecord, CampaignFile};
use pyo3::prelude::*;
use serde_json::json;

use crate::work;

/// Adds calibration to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(calibrate, module)?)
}

/// Output of `acerra calibrate --json`, with the keys for a campaign file, as JSON.
#[pyfunction]
fn calibrate(
    py: Python<'_>,
    file: PathBuf,
    reflector_m: Vec<[f64; 3]>,
    survey_sigma_m: f64,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    work::run(py, progress.as_ref(), |control| {
        let file = CampaignFile::read(&file)?;
        let mut journal = Journal::default();
        let outcome = file.calibrate(reflector_m, survey_sigma_m, &mut journal, control)?;
        let keys: Vec<String> = outcome.keys().iter().map(ToString::to_string).collect();
        Ok(json!({ "record": CalibrationRecord::of(&outcome), "keys": keys }).to_string())
    })
}
