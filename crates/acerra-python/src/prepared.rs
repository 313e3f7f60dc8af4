//! Clean spectra at known places, to be imaged any number of times.

use std::ops::Range;
use std::sync::Arc;

use acerra_chain::choices::{Sum, Weight};
use acerra_chain::findings::Finding;
use acerra_chain::focus::FocusOptions;
use acerra_chain::measure::MeasureOptions;
use acerra_chain::{Control, Focused, ImageRequest, MemorySink};
use acerra_imaging::{Complex32, Complex64};
use acerra_products::Outcome;
use acerra_radar::{Radargram, Samples};
use numpy::{PyArray1, PyArray2, PyArrayDyn, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::json;

use crate::arrays::{matrix, positions};
use crate::errors::Failure;
use crate::grid::{Grid, grid_of};
use crate::metrics::measured_json;
use crate::positions::origin_deg_m;
use crate::work;

/// A prepared survey, alone or as a part of a run.
#[derive(Clone)]
pub enum Held {
    /// Prepared only.
    Alone(Arc<acerra_chain::Prepared>),
    /// Imaged by a run.
    OfRun(Arc<Outcome>),
}

impl Held {
    fn prepared(&self) -> &acerra_chain::Prepared {
        match self {
            Self::Alone(prepared) => prepared,
            Self::OfRun(outcome) => &outcome.prepared,
        }
    }
}

/// Clean spectra of one or more tracks, in one frame.
#[pyclass(frozen, module = "acerra._native")]
pub struct Prepared {
    /// The spectra.
    pub held: Held,
    /// Defaults of its images.
    pub defaults: FocusOptions,
    /// Findings on the settings.
    pub findings: Vec<Finding>,
    /// What the stages noticed.
    pub warnings: Vec<String>,
}

/// How an image of prepared spectra is made, where not as the settings say.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct ImageOptions {
    accuracy: Option<f64>,
    weight: Option<String>,
    sum: Option<String>,
    check_pixels: Option<usize>,
    pulses: Option<(usize, usize)>,
}

impl ImageOptions {
    fn request(
        &self,
        pixels: acerra_chain::Pixels,
        mut options: FocusOptions,
    ) -> Result<ImageRequest, Failure> {
        if let Some(accuracy) = self.accuracy {
            options.accuracy = accuracy;
        }
        if let Some(weight) = &self.weight {
            options.weight = choice::<Weight>("weight", weight)?;
        }
        if let Some(sum) = &self.sum {
            options.sum = choice::<Sum>("sum", sum)?;
        }
        if let Some(check_pixels) = self.check_pixels {
            options.check_pixels = check_pixels;
        }
        Ok(ImageRequest {
            options,
            pulses: self.pulses.map(|(from, to)| Range {
                start: from,
                end: to,
            }),
            ..ImageRequest::on(pixels)
        })
    }
}

/// One of the campaign's choices by its name.
fn choice<T: serde::de::DeserializeOwned>(what: &str, name: &str) -> Result<T, Failure> {
    serde_json::from_value(json!(name))
        .map_err(|error| Failure::settings(format!("{what}: {error}")))
}

#[pymethods]
impl Prepared {
    /// Places of the phase centre, `[traces, 3]`: east, north, up (m).
    #[getter]
    fn position_m<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        positions(py, &self.held.prepared().aligned.position_m)
    }

    /// Standard deviations of the places, `[traces, 3]` (m); none where they are unknown.
    #[getter]
    fn sigma_m<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let sigma_m = &self.held.prepared().aligned.sigma_m;
        (!sigma_m.is_empty())
            .then(|| positions(py, sigma_m))
            .transpose()
    }

    /// Radar time of the traces (s).
    #[getter]
    fn time_s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.held.prepared().aligned.time_s)
    }

    /// Numbers of the traces in their log.
    #[getter]
    fn trace<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        let traces = &self.held.prepared().aligned.traces;
        PyArray1::from_iter(py, traces.iter().map(|k| *k as u64))
    }

    /// Frequencies of the spectra (Hz).
    #[getter]
    fn frequency_hz<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.held.prepared().spectrum.frequency_hz)
    }

    /// Clean, calibrated spectra, `[traces, frequencies]`.
    #[getter]
    fn spectrum<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<Complex64>>> {
        let spectrum = &self.held.prepared().spectrum;
        matrix(py, spectrum.values.clone(), spectrum.frequency_hz.len())
    }

    /// Weight of each trace in the sum, by the name of the choice; by default the settings'.
    fn weights<'py>(
        &self,
        py: Python<'py>,
        weight: Option<&str>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let weight = match weight {
            Some(weight) => choice::<Weight>("weight", weight)?,
            None => self.defaults.weight,
        };
        let weights = self.held.prepared().echoes().weights(weight);
        Ok(PyArray1::from_vec(py, weights))
    }

    /// Defaults of images, as JSON.
    #[getter]
    fn defaults(&self) -> String {
        let options = &self.defaults;
        json!({
            "accuracy": options.accuracy,
            "weight": options.weight,
            "sum": options.sum,
            "weighs_incidence": options.incidence.is_some(),
            "method": options.inversion.method,
        })
        .to_string()
    }

    /// Speed of light of the scene (m/s).
    #[getter]
    fn light_speed_m_s(&self) -> f64 {
        self.held.prepared().scene.light_speed_m_s
    }

    /// Latitude, longitude (degrees) and ellipsoidal height (m) of the frame's origin.
    #[getter]
    fn origin_deg_m(&self) -> Option<[f64; 3]> {
        origin_deg_m(self.held.prepared().first().positions.frame())
    }

    /// The pixels that the preparation took for the image's.
    #[getter]
    fn grid<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        grid_of(py, &self.held.prepared().scene.pixels)
    }

    /// Names of the tracks, and the range of traces of each.
    #[getter]
    fn tracks(&self) -> Vec<(String, usize, usize)> {
        let tracks = &self.held.prepared().tracks;
        let entry =
            |track: &acerra_chain::Track| (track.name.clone(), track.range.start, track.range.end);
        tracks.iter().map(entry).collect()
    }

    /// Time offset (s) and delay and gate (ns) of a track as they were used, as JSON.
    fn settled(&self, track: usize) -> PyResult<String> {
        let track = self.track(track)?;
        Ok(json!({
            "time_offset_s": track.time_offset_s,
            "gate_ns": track.gate_ns,
            "fast_time_shift_ns": track.cleaned.as_ref().map(|c| 1e9 * c.shift_s),
            "delay_ns": track.delay.as_ref().map(|found| 1e9 * found.delay_s),
        })
        .to_string())
    }

    /// The radargram of a track before (`"raw"`) or after (`"clean"`) cleaning; none where the log
    /// holds spectra.
    fn radargram<'py>(
        &self,
        py: Python<'py>,
        track: usize,
        kind: &str,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(traces) = &self.track(track)?.cleaned else {
            return Ok(None);
        };
        let radargram = match kind {
            "raw" => &traces.raw,
            "clean" => &traces.clean,
            found => {
                return Err(PyValueError::new_err(format!(
                    "kind: expected \"raw\" or \"clean\", found \"{found}\""
                )));
            }
        };
        radargram_arrays(py, radargram).map(Some)
    }

    /// Findings on the settings, as JSON.
    #[getter]
    fn findings(&self) -> PyResult<String> {
        to_json(&self.findings)
    }

    /// What the stages noticed.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// The image on a grid, and how it was made, as JSON.
    fn image<'py>(
        &self,
        py: Python<'py>,
        grid: Grid,
        options: ImageOptions,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<(Bound<'py, PyArrayDyn<Complex32>>, String)> {
        let prepared = self.held.prepared();
        let request = options.request(grid.pixels()?, self.defaults)?;
        let (focused, voxels) = work::run(py, progress.as_ref(), |control| {
            let mut sink = MemorySink::default();
            let focused = prepared.image(&request, &mut sink, control)?;
            Ok((focused, voxels_of(sink)))
        })?;
        let said = json!({
            "plan": focused.plan,
            "memory_bytes": focused.promised_bytes,
            "checked_error": focused.checked_error,
        });
        Ok((image_array(py, focused, voxels)?, said.to_string()))
    }

    /// Targets of the image on a grid, as JSON.
    fn measure(
        &self,
        py: Python<'_>,
        grid: Grid,
        options: ImageOptions,
        limits: (f64, usize),
        progress: Option<Py<PyAny>>,
    ) -> PyResult<String> {
        let prepared = self.held.prepared();
        let request = options.request(grid.pixels()?, self.defaults)?;
        let measure = MeasureOptions {
            threshold_db: limits.0,
            max_targets: limits.1,
        };
        work::run(py, progress.as_ref(), |control: &Control<'_>| {
            let focused = prepared.image(&request, &mut MemorySink::default(), control)?;
            let found = prepared.measure(&focused, &measure, control)?;
            Ok(measured_json(&found).to_string())
        })
    }
}

impl Prepared {
    fn track(&self, track: usize) -> PyResult<&acerra_chain::Track> {
        let tracks = &self.held.prepared().tracks;
        tracks.get(track).ok_or_else(|| {
            let last = tracks.len() - 1;
            PyValueError::new_err(format!("track: expected 0 to {last}, found {track}"))
        })
    }
}

/// A value as JSON.
pub fn to_json(value: &impl serde::Serialize) -> PyResult<String> {
    Ok(serde_json::to_string(value)
        .map_err(anyhow::Error::from)
        .map_err(Failure::from)?)
}

/// The slices of a volume, where the sink holds one.
pub fn voxels_of(sink: MemorySink) -> Option<Vec<Complex32>> {
    let mut stacks = sink.stacks.into_iter();
    let stack =
        stacks.find(|stack| stack.header.kind == acerra_chain::focus::sink::StackKind::Volume)?;
    Some(stack.images.concat())
}

/// An image, or the voxels of a volume, as an array of the grid's shape.
pub fn image_array<'py>(
    py: Python<'py>,
    focused: Focused,
    voxels: Option<Vec<Complex32>>,
) -> PyResult<Bound<'py, PyArrayDyn<Complex32>>> {
    let grid = focused.pixels.grid;
    let (values, shape) = match voxels {
        Some(voxels) => {
            let slices = voxels.len() / grid.len();
            (voxels, vec![slices, grid.ny, grid.nx])
        }
        None => (focused.image, vec![grid.ny, grid.nx]),
    };
    PyArray1::from_vec(py, values).reshape(shape)
}

/// A radargram as arrays: samples `[traces, samples]`, slow and fast time (s).
pub fn radargram_arrays<'py>(
    py: Python<'py>,
    radargram: &Radargram,
) -> PyResult<Bound<'py, PyDict>> {
    let arrays = PyDict::new(py);
    let columns = radargram.samples_per_trace;
    match &radargram.samples {
        Samples::Real(v) => arrays.set_item("samples", matrix(py, v.clone(), columns)?)?,
        Samples::Complex(v) => arrays.set_item("samples", matrix(py, v.clone(), columns)?)?,
    }
    arrays.set_item("time_s", PyArray1::from_slice(py, &radargram.time_s))?;
    arrays.set_item("fast_time_start_s", radargram.fast_time_start_s)?;
    arrays.set_item("fast_time_step_s", radargram.fast_time_step_s)?;
    Ok(arrays)
}
