//! Resolution of a flight, and effects of position errors.

use acerra_imaging::Complex32;
use acerra_imaging::psf::{Analysis, PointSpread, psf_image};
use acerra_imaging::resolution::{Aperture, Band, Prediction};
use acerra_imaging::sensitivity::{ErrorModel, predict};
use numpy::{PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use serde_json::json;

use crate::arrays::{matrix, rows3, values};
use crate::errors::Failure;
use crate::grid::Plane;
use crate::prepared::to_json;
use crate::work;

/// Adds the theory to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Spread>()?;
    module.add_function(wrap_pyfunction!(resolution, module)?)
}

/// Eqs. (6) to (12) for a straight track, as JSON.
#[pyfunction]
fn resolution(
    height_m: f64,
    offset_m: f64,
    band_hz: [f64; 2],
    half_aperture_m: Option<f64>,
    light_speed_m_s: f64,
) -> PyResult<String> {
    let band = Band {
        low_hz: band_hz[0],
        high_hz: band_hz[1],
        light_speed_m_s,
    };
    let aperture = Aperture::new(height_m, offset_m).map_err(Failure::from)?;
    let prediction = Prediction::of(aperture, band, half_aperture_m).map_err(Failure::from)?;
    to_json(&prediction)
}

/// The point spread function of a flight.
#[pyclass(frozen, module = "acerra._native")]
pub struct Spread(PointSpread);

#[pymethods]
impl Spread {
    #[new]
    fn new(
        position_m: PyReadonlyArray2<'_, f64>,
        weight: PyReadonlyArray1<'_, f64>,
        frequency_hz: PyReadonlyArray1<'_, f64>,
        light_speed_m_s: f64,
    ) -> PyResult<Self> {
        let spread = PointSpread::new(
            rows3(&position_m)?.to_vec(),
            Some(values(&weight)?.to_vec()),
            values(&frequency_hz)?.to_vec(),
            light_speed_m_s,
        );
        Ok(Self(spread.map_err(Failure::from)?))
    }

    /// The image of unit points, `[rows, columns]`.
    fn image<'py>(
        &self,
        py: Python<'py>,
        target_m: PyReadonlyArray2<'py, f64>,
        grid: Plane,
    ) -> PyResult<Bound<'py, PyArray2<Complex32>>> {
        let target_m = rows3(&target_m)?;
        let image = work::run(py, None, |control| {
            Ok(psf_image(&self.0, target_m, grid.0, control.operation())?)
        })?;
        matrix(py, image, grid.0.nx)
    }

    /// Widths, sidelobes and ghost of the image of a unit point, as JSON.
    fn analyse(&self, py: Python<'_>, target_m: [f64; 3], plane_z_m: f64) -> PyResult<String> {
        work::run(py, None, |_| {
            let found = Analysis::of(&self.0, target_m, plane_z_m)?;
            Ok(json!({
                "peak_m": found.peak_m,
                "expected_m": found.expected_m,
                "along": found.along,
                "across": found.across,
                "pslr_db": found.pslr_db,
                "islr_db": found.islr_db,
                "ghost": found.ghost,
                "theory": found.theory,
            })
            .to_string())
        })
    }

    /// Effect of position errors of `sigma_m` (one row a pulse) on the image of a unit point, as JSON; errors
    /// are correlated over `correlation_m` of the path, or independent at every pulse.
    fn blur(
        &self,
        py: Python<'_>,
        target_m: [f64; 3],
        sigma_m: PyReadonlyArray2<'_, f64>,
        path_m: PyReadonlyArray1<'_, f64>,
        correlation_m: Option<f64>,
    ) -> PyResult<String> {
        let sigma_m = rows3(&sigma_m)?.to_vec();
        let path_m = values(&path_m)?.to_vec();
        work::run(py, None, |_| {
            let none = vec![[0.0; 3]; sigma_m.len()];
            let model = match correlation_m {
                Some(length_m) => ErrorModel::new(none, sigma_m, path_m, length_m)?,
                None => ErrorModel::new(sigma_m, none, path_m, 1.0)?,
            };
            Ok(to_json(&predict(&self.0, target_m, &model)?)?)
        })
    }
}
