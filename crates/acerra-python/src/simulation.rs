//! Simulated flights, and plans of real ones.

use std::path::PathBuf;

use acerra_flightplan::{FlightPlan, PlanFile, to_geojson, to_kml, to_qgroundcontrol};
use acerra_products::staging::Staging;
use acerra_simulate::demo;
use acerra_simulate::scene::Scene;
use acerra_simulate::write::simulate_campaign;
use pyo3::prelude::*;
use serde_json::json;

use crate::campaign::toml_of;
use crate::errors::Failure;
use crate::work;

/// Adds simulation and planning to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("DEMO_SCENES", (demo::TRACK_1, demo::TRACK_2))?;
    module.add_function(wrap_pyfunction!(simulate, module)?)?;
    module.add_function(wrap_pyfunction!(plan_flight, module)?)
}

/// Writes the logs of a simulated flight and its campaign into `directory`; returns a summary as JSON. The
/// scene is the text of its file, or its tables as JSON.
#[pyfunction]
fn simulate(
    py: Python<'_>,
    scene: &str,
    is_tables: bool,
    folder: PathBuf,
    directory: PathBuf,
    seed: Option<u64>,
) -> PyResult<String> {
    let text = settings_text(scene, is_tables)?;
    work::run(py, None, |_| {
        let mut scene = Scene::parse(&text)
            .map_err(Failure::settings)?
            .resolved_in(&folder);
        if let Some(seed) = seed {
            scene.seed = seed;
        }
        let campaign =
            simulate_campaign(&scene).map_err(|e| Failure::settings(format!("{e:#}")))?;
        let staging = Staging::new(&directory)?;
        for file in &campaign.files {
            staging.write(&file.name, &file.bytes)?;
        }
        staging.publish()?;
        Ok(json!({
            "scans": campaign.summary.scans,
            "lost_messages": campaign.summary.lost_messages,
            "gnss_epochs": campaign.summary.gnss_epochs,
        })
        .to_string())
    })
}

/// A flight plan: its figures, GeoJSON and missions as JSON, and KML.
#[pyfunction]
fn plan_flight(
    py: Python<'_>,
    plan: &str,
    is_tables: bool,
    folder: PathBuf,
) -> PyResult<(String, String)> {
    let text = settings_text(plan, is_tables)?;
    work::run(py, None, |_| {
        let file = PlanFile::parse(&text).map_err(Failure::settings)?;
        let plan = FlightPlan::make(file.resolved_in(&folder)).map_err(Failure::settings)?;
        let missions = plan
            .flights
            .iter()
            .map(|flight| to_qgroundcontrol(&plan, flight))
            .collect::<Result<Vec<_>, _>>()
            .map_err(Failure::settings)?;
        let said = json!({
            "summary": plan.summary,
            "geojson": to_geojson(&plan),
            "missions": missions,
        });
        Ok((said.to_string(), to_kml(&plan)))
    })
}

fn settings_text(text: &str, is_tables: bool) -> Result<String, Failure> {
    if is_tables {
        toml_of(text)
    } else {
        Ok(text.to_owned())
    }
}
