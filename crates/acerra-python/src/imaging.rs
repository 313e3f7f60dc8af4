//! Imaging of arrays.

use acerra_imaging::{Complex32, Complex64, ImageGrid, ImagingPlan, PlanOptions, Progress, Pulses};
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use serde_json::json;

use crate::errors::Failure;
use crate::grid::{Grid, Plane, Surface, Tilted, Volume};
use crate::pulses::{Antennas, Settings};
use crate::work;

/// Adds imaging to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Settings>()?;
    module.add_function(wrap_pyfunction!(promise, module)?)?;
    module.add_function(wrap_pyfunction!(set_threads, module)?)?;
    module.add_function(wrap_pyfunction!(adjoint, module)?)
}

/// The image `[rows, columns]`, or `[slices, rows, columns]`, and the planner's report, as JSON.
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
        let report = |progress: Progress| control.at(progress.done);
        let outcome = image_on(
            &grid,
            pulses,
            &settings.plan,
            control.operation_reporting(&report),
        );
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
    let planned = |plan: ImagingPlan<'_>| {
        let mut image = vec![Complex32::ZERO; plan.pixels()];
        plan.run(&mut image, control)?;
        let said = plan_json(&plan.report().to_string(), plan.memory_bytes(), {
            plan.self_check().map(|check| check.error)
        });
        Ok((image, grid.shape(), said))
    };
    match grid {
        Grid::Plane(Plane(g)) => planned(ImagingPlan::with_control(pulses, *g, options, control)?),
        Grid::Tilted(Tilted(g)) => {
            planned(ImagingPlan::with_control(pulses, *g, options, control)?)
        }
        Grid::Surface(Surface(g)) => {
            planned(ImagingPlan::with_control(pulses, &**g, options, control)?)
        }
        Grid::Volume(Volume(g)) => {
            let mut voxels = Vec::with_capacity(g.nz * g.base.len());
            let run = acerra_imaging::image_volume(g, pulses, options, control, |_, _, slice| {
                voxels.extend_from_slice(slice);
                Ok::<_, Failure>(())
            })?;
            let said = plan_json(
                &run.report.to_string(),
                run.memory_bytes + 8 * voxels.len() as u128,
                run.checked_error,
            );
            Ok((voxels, grid.shape(), said))
        }
    }
}

/// Memory and time of `adjoint` on a grid, as JSON; for a volume by its lowest slice. The time is that of one
/// run with all threads, estimated from samples.
#[pyfunction]
fn promise<'py>(
    py: Python<'py>,
    grid: Grid,
    antennas: Antennas<'py>,
    spectrum: PyReadonlyArray2<'py, Complex64>,
    settings: Settings,
) -> PyResult<String> {
    let arrays = antennas.with_spectrum(&spectrum, settings.light_speed_m_s)?;
    work::run(py, None, |control| {
        let pulses = Pulses::new(arrays)?;
        let control = control.operation();
        let (pixels, slices, voxel_bytes) = match &grid {
            Grid::Plane(Plane(g)) => (ImageGrid::from(*g), 1, 0),
            Grid::Tilted(Tilted(g)) => (ImageGrid::from(*g), 1, 0),
            Grid::Surface(Surface(g)) => (ImageGrid::from(&**g), 1, 0),
            Grid::Volume(Volume(g)) => (ImageGrid::from(g.base), g.nz, 8 * grid.points()),
        };
        let plan = ImagingPlan::with_control(pulses, pixels, &settings.plan, control)?;
        let bytes = u64::try_from(plan.memory_bytes()).unwrap_or(u64::MAX);
        let seconds = plan.estimate_run_time_s(control) * slices as f64;
        Ok(json!({
            "memory_bytes": bytes.saturating_add(voxel_bytes),
            "seconds": seconds,
            "plan": plan.report().to_string(),
        })
        .to_string())
    })
}

/// Sets the number of threads of all operators of this process; false where they are at work already.
#[pyfunction]
fn set_threads(threads: usize) -> bool {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    pool.build_global().is_ok()
}

fn plan_json(plan: &str, bytes: u128, checked_error: Option<f64>) -> String {
    let bytes = u64::try_from(bytes).unwrap_or(u64::MAX);
    json!({ "plan": plan, "memory_bytes": bytes, "checked_error": checked_error }).to_string()
}
