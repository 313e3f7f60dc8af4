//! A finished run: image, measurements, evidence.

use std::sync::Arc;

use acerra_chain::journal::stages::Stage;
use acerra_chain::{Journal, MemorySink};
use acerra_imaging::Complex32;
use acerra_products::display::Shown;
use acerra_products::run_record::{RunRecord, TargetsRecord};
use acerra_products::{Outcome, pictures};
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::errors::Failure;
use crate::grid::grid_of;
use crate::positions::origin_deg_m;
use crate::prepared::{Held, Prepared, to_json};

/// Everything that a run found.
#[pyclass(frozen, module = "acerra._native")]
pub struct Run {
    outcome: Arc<Outcome>,
    stages: Vec<Stage>,
    /// The slices of a volume, where they were kept in memory.
    voxels: Option<Vec<Complex32>>,
}

impl Run {
    /// A run with the stacks that its sink kept.
    pub fn new(outcome: Outcome, sink: Option<MemorySink>, journal: &Journal) -> Self {
        Self {
            outcome: Arc::new(outcome),
            stages: journal.stages.done().to_vec(),
            voxels: sink.and_then(crate::prepared::voxels_of),
        }
    }
}

#[pymethods]
impl Run {
    /// What the run is called.
    #[getter]
    fn name(&self) -> &str {
        &self.outcome.name
    }

    /// The image `[rows, columns]`; of a volume seen from above.
    #[getter]
    fn image<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<Complex32>>> {
        let (image, grid) = (
            &self.outcome.focused.image,
            self.outcome.focused.pixels.grid,
        );
        PyArray1::from_slice(py, image).reshape(vec![grid.ny, grid.nx])
    }

    /// The voxels `[slices, rows, columns]` of a volume; none of a plane, or where the products'
    /// directory holds them.
    #[getter]
    fn volume<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArrayDyn<Complex32>>>> {
        let grid = self.outcome.focused.pixels.grid;
        let shaped = |voxels: &Vec<Complex32>| {
            let shape = vec![voxels.len() / grid.len(), grid.ny, grid.nx];
            PyArray1::from_slice(py, voxels).reshape(shape)
        };
        self.voxels.as_ref().map(shaped).transpose()
    }

    /// The pixels of the image.
    #[getter]
    fn grid<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let mut pixels = self.outcome.focused.pixels.clone();
        if pixels.volume.is_some() {
            // The heights of the strongest values are those of the image seen from above.
            pixels.surface = None;
        }
        grid_of(py, &pixels)
    }

    /// `run.json`.
    fn record(&self) -> PyResult<String> {
        to_json(&RunRecord::of(&self.outcome, &self.stages))
    }

    /// `targets.json`.
    fn targets(&self) -> PyResult<String> {
        to_json(&TargetsRecord::of(&self.outcome))
    }

    /// The spectra that the image was made of.
    fn prepared(&self) -> Prepared {
        Prepared {
            held: Held::OfRun(Arc::clone(&self.outcome)),
            defaults: self.outcome.focused.options,
            findings: self.outcome.evidence.findings().to_vec(),
            warnings: self.outcome.warnings.clone(),
        }
    }

    /// Latitude, longitude (degrees) and ellipsoidal height (m) of the frame's origin.
    #[getter]
    fn origin_deg_m(&self) -> Option<[f64; 3]> {
        origin_deg_m(self.outcome.prepared.first().positions.frame())
    }

    /// Findings on the settings, as JSON.
    #[getter]
    fn findings(&self) -> PyResult<String> {
        to_json(&self.outcome.evidence.findings())
    }

    /// What the stages noticed.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.outcome.warnings.clone()
    }

    /// A picture as PNG: "image", "radargram_raw" or "radargram_clean"; none where there are no
    /// traces.
    fn picture<'py>(&self, py: Python<'py>, kind: &str) -> PyResult<Option<Bound<'py, PyBytes>>> {
        let traces = self.outcome.prepared.cleaned();
        let drawn = match kind {
            "image" => Some(pictures::image(&self.outcome, &Shown::of(&self.outcome))),
            "radargram_raw" => traces.map(|t| pictures::radargram_raw(&self.outcome, t)),
            "radargram_clean" => traces.map(|t| pictures::radargram_clean(&self.outcome, t)),
            found => {
                return Err(PyValueError::new_err(format!(
                    "kind: expected \"image\", \"radargram_raw\" or \"radargram_clean\", found \
                     \"{found}\""
                )));
            }
        };
        let picture = drawn
            .transpose()
            .map_err(|error| Failure::from(anyhow::Error::from(error)))?;
        Ok(picture.map(|picture| PyBytes::new(py, &picture.png)))
    }
}
