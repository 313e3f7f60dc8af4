//! Imaging of arrays.

use acerra_imaging::{Complex32, Complex64, ImagingPlan, PlanOptions, Progress, Pulses};
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use serde_json::json;

use crate::errors::Failure;
use crate::grid::{Grid, Plane, Surface, Tilted, Volume};
use crate::pulses::{Antennas, Settings};
use crate::work;

/// Adds grids and imaging to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Plane>()?;
    module.add_class::<Tilted>()?;
    module.add_class::<Surface>()?;
    module.add_class::<Volume>()?;
    module.add_class::<Settings>()?;
    module.add_function(wrap_pyfunction!(adjoint, module)?)
}

/// The image `[rows, columns]`, or `[slices, rows, columns]`, and what the planner did, as JSON.
#[pyfunction]
fn adjoint<'py>(
    py: Python<'py>,
    grid: Grid,
    antennas: Antennas<'py>,
    spectrum: PyReadonlyArray2<'py, Complex64>,
    settings: Settings,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyArrayDyn<Complex32>>, String)> {
    let arrays = antennas.with_spectrum(&spectrum, settings.light_speed_m_s)?;
    let (image, shape, said) = work::run(py, progress.as_ref(), |control| {
        let pulses = Pulses::new(arrays)?;
        control.start("image", grid.points() * pulses.len() as u64);
        let tell = |progress: Progress| control.at(progress.done);
        let outcome = image_on(&grid, pulses, &settings.plan, control.for_imaging(&tell));
        control.finish();
        outcome
    })?;
    Ok((PyArray1::from_vec(py, image).reshape(shape)?, said))
}

type Imaged = (Vec<Complex32>, Vec<usize>, String);

fn image_on(
    grid: &Grid,
    pulses: Pulses<'_>,
    options: &PlanOptions,
    control: acerra_imaging::Control<'_>,
) -> Result<Imaged, Failure> {
    let planned = |plan: ImagingPlan<'_>, shape: [usize; 2]| {
        let mut image = vec![Complex32::ZERO; plan.pixels()];
        plan.run(&mut image, control)?;
        let said = said(&plan.report().to_string(), plan.memory_bytes(), {
            plan.self_check().map(|check| check.error)
        });
        Ok((image, shape.to_vec(), said))
    };
    match grid {
        Grid::Plane(Plane(g)) => planned(
            ImagingPlan::with_control(pulses, *g, options, control)?,
            [g.ny, g.nx],
        ),
        Grid::Tilted(Tilted(g)) => planned(
            ImagingPlan::with_control(pulses, *g, options, control)?,
            [g.rows, g.columns],
        ),
        Grid::Surface(Surface(g)) => planned(
            ImagingPlan::with_control(pulses, &**g, options, control)?,
            [g.base().ny, g.base().nx],
        ),
        Grid::Volume(Volume(g)) => {
            let mut voxels = Vec::with_capacity(g.nz * g.base.len());
            let run = acerra_imaging::image_volume(g, pulses, options, control, |_, _, slice| {
                voxels.extend_from_slice(slice);
                Ok::<_, Failure>(())
            })?;
            let said = said(
                &run.report.to_string(),
                run.memory_bytes + 8 * voxels.len() as u128,
                run.checked_error,
            );
            Ok((voxels, vec![g.nz, g.base.ny, g.base.nx], said))
        }
    }
}

fn said(plan: &str, bytes: u128, checked_error: Option<f64>) -> String {
    let bytes = u64::try_from(bytes).unwrap_or(u64::MAX);
    json!({ "plan": plan, "memory_bytes": bytes, "checked_error": checked_error }).to_string()
}
