//! Campaigns: from a file or a table of settings to prepared spectra and finished runs.

use std::path::PathBuf;
use std::sync::Arc;

use acerra_chain::findings::{weigh_autofocus, weigh_prepared};
use acerra_chain::position::{Positions, placed};
use acerra_chain::read::RadarContent;
use acerra_chain::{Control, Journal, MemorySink, Recording, Scene, prepare};
use acerra_products::{NamedCampaign, RunError, process, run_campaign};
use acerra_radar::{Radargram, Samples};
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{shape2, values};
use crate::errors::Failure;
use crate::positions::PositionArrays;
use crate::prepared::{Held, Prepared};
use crate::run::Run;
use crate::work;

/// Adds campaigns, prepared spectra and runs to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Campaign>()?;
    module.add_class::<Prepared>()?;
    module.add_class::<Run>()?;
    module.add_function(wrap_pyfunction!(focus, module)?)?;
    module.add_function(wrap_pyfunction!(prepare_arrays, module)?)
}

/// A campaign: its logs, how they belong together, and the image to make.
#[pyclass(frozen, module = "acerra._native")]
pub struct Campaign {
    name: String,
    campaign: acerra_chain::campaign::Campaign,
}

#[pymethods]
impl Campaign {
    /// A campaign from the text of its file, with paths relative to `folder`.
    #[staticmethod]
    fn parse(text: &str, folder: PathBuf, name: &str) -> Result<Self, Failure> {
        Ok(Self {
            name: name.to_owned(),
            campaign: acerra_chain::campaign::Campaign::parse(text)?.resolved_in(&folder),
        })
    }

    /// A campaign from its tables as JSON, with paths relative to `folder`.
    #[staticmethod]
    fn from_tables(tables: &str, folder: PathBuf, name: &str) -> Result<Self, Failure> {
        Self::parse(&toml_of(tables)?, folder, name)
    }

    /// Name of the campaign.
    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    /// The campaign with every default filled in, as JSON.
    fn tables(&self) -> PyResult<String> {
        crate::prepared::to_json(&self.campaign)
    }

    /// Reads, positions, aligns and cleans; corrects the positions where `[autofocus]` enables it.
    fn prepare(&self, py: Python<'_>, progress: Option<Py<PyAny>>) -> PyResult<Prepared> {
        work::run(py, progress.as_ref(), |control| {
            let mut journal = Journal::default();
            let prepared = self.campaign.survey().prepare(&mut journal, control)?;
            weighed(prepared, &self.campaign, journal, control)
        })
    }

    /// Prepares, images, measures and judges; writes no file.
    fn run(&self, py: Python<'_>, progress: Option<Py<PyAny>>) -> PyResult<Run> {
        work::run(py, progress.as_ref(), |control| {
            let (mut journal, mut sink) = (Journal::default(), MemorySink::default());
            let named = NamedCampaign {
                name: self.name.clone(),
                campaign: self.campaign.clone(),
            };
            let outcome = process(named, &mut sink, &mut journal, control)?;
            Ok(Run::new(outcome, Some(sink), &journal))
        })
    }
}

/// As `acerra focus`: runs a campaign file and writes its products.
#[pyfunction]
fn focus(
    py: Python<'_>,
    file: PathBuf,
    directory: PathBuf,
    progress: Option<Py<PyAny>>,
) -> PyResult<Run> {
    work::run(py, progress.as_ref(), |control| {
        let mut journal = Journal::default();
        let outcome = run_campaign(&file, &directory, &mut journal, control)?;
        Ok(Run::new(outcome, None, &journal))
    })
}

/// Real or complex samples of a radargram.
#[derive(FromPyObject)]
enum SampleArray<'py> {
    Real(PyReadonlyArray2<'py, f32>),
    Complex(PyReadonlyArray2<'py, acerra_imaging::Complex32>),
}

impl SampleArray<'_> {
    /// The samples, and the number of traces in them.
    fn samples(&self) -> PyResult<(Samples, usize)> {
        Ok(match self {
            Self::Real(v) => (Samples::Real(v.as_slice()?.to_vec()), shape2(v)[0]),
            Self::Complex(v) => (Samples::Complex(v.as_slice()?.to_vec()), shape2(v)[0]),
        })
    }
}

/// A radargram as Python gives it.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct RadargramArrays<'py> {
    samples: SampleArray<'py>,
    time_s: PyReadonlyArray1<'py, f64>,
    fast_time_start_s: f64,
    fast_time_step_s: f64,
}

impl RadargramArrays<'_> {
    fn radargram(&self) -> PyResult<Radargram> {
        let (samples, traces) = self.samples.samples()?;
        let time_s = values(&self.time_s)?;
        if traces != time_s.len() {
            return Err(PyValueError::new_err(format!(
                "time_s: expected {traces} values, one for each trace, found {}",
                time_s.len()
            )));
        }
        let (start_s, step_s) = (self.fast_time_start_s, self.fast_time_step_s);
        Ok(Radargram::new(time_s.to_vec(), start_s, step_s, samples).map_err(Failure::read)?)
    }
}

/// Aligns and cleans a radargram and positions in memory, with the settings of a campaign.
#[pyfunction]
fn prepare_arrays(
    py: Python<'_>,
    radargram: RadargramArrays<'_>,
    positions: PositionArrays<'_>,
    tables: &str,
    progress: Option<Py<PyAny>>,
) -> PyResult<Prepared> {
    let content = RadarContent::from(radargram.radargram()?);
    let positions = positions.positions()?;
    let campaign = Campaign::from_tables(tables, PathBuf::new(), "arrays")?.campaign;
    work::run(py, progress.as_ref(), |control| {
        prepare_in_memory(content, positions, &campaign, control)
    })
}

fn prepare_in_memory(
    content: RadarContent,
    positions: Positions,
    campaign: &acerra_chain::campaign::Campaign,
    control: &Control<'_>,
) -> Result<Prepared, Failure> {
    refuse_files(campaign)?;
    let survey = campaign.survey();
    let Some(track) = survey.tracks.into_iter().next() else {
        return Err(Failure::settings("expected the settings of one track"));
    };
    let mut journal = Journal::default();
    let placed = placed(positions, &track.positions).map_err(Failure::position)?;
    let mut recording = Recording::new(track.name, content, placed.positions);
    recording.has_local_axes = placed.has_local_axes;
    recording.resolution_m = placed.resolution_m;
    recording.options = track.options;
    let scene = Scene::find(
        &survey.scene,
        &[&recording.positions],
        &mut journal.warnings,
    )
    .map_err(Failure::settings)?;
    let prepared = prepare(
        vec![recording],
        scene,
        &survey.calibration,
        &mut journal,
        control,
    )?;
    weighed(prepared, campaign, journal, control)
}

/// Files that a campaign of arrays would not read are left out.
fn refuse_files(campaign: &acerra_chain::campaign::Campaign) -> Result<(), Failure> {
    let named = [
        ("gnss", campaign.gnss.is_some()),
        ("track", !campaign.track.is_empty()),
        ("trajectory file", campaign.trajectory.file.is_some()),
        (
            "trajectory attitude_file",
            campaign.trajectory.attitude_file.is_some(),
        ),
        ("radar channel", campaign.radar.channel.is_some()),
    ];
    match named.iter().find(|(_, is_there)| *is_there) {
        Some((what, _)) => Err(Failure::settings(format!(
            "{what}: expected none, the radargram and the positions are in memory; read files with \
             acerra.Campaign"
        ))),
        None => Ok(()),
    }
}

/// Prepared spectra, with the findings on the settings.
fn weighed(
    mut prepared: acerra_chain::Prepared,
    campaign: &acerra_chain::campaign::Campaign,
    journal: Journal,
    control: &Control<'_>,
) -> Result<Prepared, Failure> {
    let request = campaign.image_request(prepared.scene.pixels.clone());
    let mut findings = journal.evidence.findings().to_vec();
    let found = weigh_prepared(&prepared, &request, control).map_err(|_| Failure::Cancelled)?;
    findings.extend(found);
    if campaign.autofocus.enabled {
        let options = campaign.autofocus_options();
        let correction = prepared.autofocus(&options, control);
        findings.extend(weigh_autofocus(correction.map_err(RunError::from)?));
    }
    Ok(Prepared {
        held: Held::Alone(Arc::new(prepared)),
        defaults: request.options,
        findings,
        warnings: journal.warnings.said().to_vec(),
    })
}

/// Tables given as JSON, as the text of a settings file; keys without a value are left out.
pub fn toml_of(tables: &str) -> Result<String, Failure> {
    let mut tables: serde_json::Value = serde_json::from_str(tables).map_err(Failure::settings)?;
    leave_out_nulls(&mut tables);
    toml::to_string(&tables).map_err(Failure::settings)
}

fn leave_out_nulls(value: &mut serde_json::Value) {
    if let Some(table) = value.as_object_mut() {
        table.retain(|_, value| !value.is_null());
        table.values_mut().for_each(leave_out_nulls);
    }
    if let Some(list) = value.as_array_mut() {
        list.iter_mut().for_each(leave_out_nulls);
    }
}
