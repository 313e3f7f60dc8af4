//! Places, frequencies and weights of pulses, and requirements on an operator.

use acerra_imaging::{Complex64, Engine, PlanOptions, PulseArrays, Spreading};
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{rows3, shape2, values};

/// Places of the pulses, their frequencies, and their weights.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Antennas<'py> {
    position_m: PyReadonlyArray2<'py, f64>,
    frequency_hz: PyReadonlyArray1<'py, f64>,
    weight: PyReadonlyArray1<'py, f64>,
}

impl Antennas<'_> {
    /// Phase centres (m).
    pub fn position_m(&self) -> PyResult<&[[f64; 3]]> {
        rows3(&self.position_m)
    }

    /// Frequencies (Hz).
    pub fn frequency_hz(&self) -> PyResult<&[f64]> {
        values(&self.frequency_hz)
    }

    /// Weight of each pulse.
    pub fn weight(&self) -> PyResult<&[f64]> {
        values(&self.weight)
    }

    /// These pulses with measured spectra: a row for each position, a column for each frequency.
    pub fn with_spectrum<'a>(
        &'a self,
        spectrum: &'a PyReadonlyArray2<'_, Complex64>,
        light_speed_m_s: f64,
    ) -> PyResult<PulseArrays<'a>> {
        let arrays = PulseArrays {
            position_m: self.position_m()?,
            frequency_hz: self.frequency_hz()?,
            spectrum: spectrum.as_slice()?,
            weight: self.weight()?,
            light_speed_m_s,
        };
        let expected = [arrays.position_m.len(), arrays.frequency_hz.len()];
        let found = shape2(spectrum);
        if found == expected {
            return Ok(arrays);
        }
        Err(PyValueError::new_err(format!(
            "spectrum: expected shape {expected:?}, a row for each position and a column for each \
             frequency, found {found:?}"
        )))
    }
}

/// Requirements on an operator.
#[pyclass(frozen, from_py_object, module = "acerra._native")]
#[derive(Clone, Copy)]
pub struct Settings {
    /// How the operator is planned.
    pub plan: PlanOptions,
    /// Speed of light (m/s).
    pub light_speed_m_s: f64,
}

#[pymethods]
impl Settings {
    #[new]
    fn new(
        accuracy: f64,
        spreading: &str,
        engine: &str,
        memory_limit_bytes: Option<u64>,
        check_pixels: usize,
        light_speed_m_s: f64,
    ) -> PyResult<Self> {
        let spreading = match spreading {
            "inverse-square" => Spreading::InverseSquare,
            "none" => Spreading::None,
            found => {
                return Err(PyValueError::new_err(format!(
                    "spreading: expected \"inverse-square\" or \"none\", found \"{found}\""
                )));
            }
        };
        let engine = match engine {
            "auto" => Engine::Auto,
            "direct" => Engine::Direct,
            "factorized" => Engine::Factorized,
            "double" => Engine::Double,
            "reference" => Engine::Reference,
            found => {
                return Err(PyValueError::new_err(format!(
                    "engine: expected \"auto\", \"direct\", \"factorized\", \"double\" or \
                     \"reference\", found \"{found}\""
                )));
            }
        };
        let mut plan = PlanOptions::default()
            .with_accuracy(accuracy)
            .with_spreading(spreading)
            .with_engine(engine)
            .with_check_pixels(check_pixels);
        let limit = memory_limit_bytes.or_else(acerra_chain::focus::memory::available_memory_bytes);
        if let Some(limit) = limit {
            plan = plan.with_memory_limit_bytes(limit.into());
        }
        Ok(Self {
            plan,
            light_speed_m_s,
        })
    }
}
