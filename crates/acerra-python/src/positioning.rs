//! Positions by carrier phase.

use std::path::PathBuf;

use acerra_chain::position::positioning::{AntennaInput, PositioningInput, answer, run};
use acerra_gnss::conf::{ConfInputs, read_conf};
use acerra_gnss::{BasePosition, PpkOptions, RuleSet};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::Failure;
use crate::positions::trajectory_arrays;
use crate::prepared::to_json;
use crate::work;

/// Adds positioning to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(ppk, module)?)
}

/// Settings of `acerra ppk` from RTKLIB's settings, or its defaults; and the settings that are not followed.
fn settled(settings: Option<&str>) -> Result<(PpkOptions, ConfInputs, Vec<String>), Failure> {
    let Some(settings) = settings else {
        return Ok((PpkOptions::default(), ConfInputs::default(), Vec::new()));
    };
    let conf = read_conf(settings.as_bytes(), RuleSet::Rtklib).map_err(Failure::settings)?;
    let not_followed = conf.not_followed.iter().map(ToString::to_string);
    Ok((conf.options.guarded(), conf.inputs, not_followed.collect()))
}

/// The trajectory as arrays, and the output of `acerra ppk --json`.
#[pyfunction]
fn ppk<'py>(
    py: Python<'py>,
    rover: Vec<PathBuf>,
    base: Vec<PathBuf>,
    navigation: Vec<PathBuf>,
    settings: Option<&str>,
    base_ecef_m: Option<[f64; 3]>,
) -> PyResult<(Bound<'py, PyDict>, String)> {
    let (trajectory, said) = work::run(py, None, |_| {
        let (mut options, inputs, not_followed) = settled(settings)?;
        if let Some(place) = base_ecef_m {
            options.base_position = BasePosition::Ecef(place);
        }
        let (mut rover, mut base) = (rover.into_iter(), base.into_iter());
        let input = PositioningInput {
            rover: rover.next().unwrap_or_default(),
            more_rover: rover.collect(),
            base: base.next(),
            more_base: base.collect(),
            navigation,
            needs_precise_orbits: inputs.precise_orbits,
            antennas: AntennaInput::from(&inputs).if_any(),
            ..PositioningInput::default()
        };
        let mut positioning = run(&input, &options).map_err(Failure::position)?;
        positioning.warnings.extend(not_followed);
        let trajectory = positioning
            .solution
            .trajectory()
            .map_err(Failure::position)?;
        Ok((trajectory, to_json(&answer(&positioning, &options))?))
    })?;
    Ok((trajectory_arrays(py, &trajectory)?, said))
}
