//! Positions as arrays.

use acerra_chain::TracePositions;
use acerra_chain::position::Positions;
use acerra_geo::geodesy::{EnuFrame, Geodetic};
use acerra_geo::time::GpsTime;
use acerra_geo::trajectory::{Fix, Frame, SolutionStatus, TimeOrigin, Trajectory};
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{positions, rows3, values};
use crate::errors::Failure;

/// Positions from Python: one for each trace, or a trajectory with separate times.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct PositionArrays<'py> {
    position_m: PyReadonlyArray2<'py, f64>,
    time_s: Option<PyReadonlyArray1<'py, f64>>,
    sigma_m: Option<PyReadonlyArray2<'py, f64>>,
    /// Latitude, longitude (degrees) and ellipsoidal height (m) of the frame's origin.
    origin_deg_m: Option<[f64; 3]>,
    /// Solution status of each position, by name.
    status: Option<Vec<String>>,
    /// GPS week and second of week at which `time_s` is zero.
    gps_start: Option<(i64, f64)>,
}

impl PositionArrays<'_> {
    /// The positions that the chain takes.
    pub fn positions(&self) -> PyResult<Positions> {
        let position_m = rows3(&self.position_m)?;
        let frame = match self.origin_deg_m {
            Some([latitude, longitude, height]) => Frame::Enu(EnuFrame::new(
                Geodetic::from_degrees(latitude, longitude, height),
            )),
            None => Frame::Local,
        };
        let time_origin = match self.gps_start {
            Some((week, second)) => TimeOrigin::Gps(GpsTime::from_week_tow(week, second)),
            None => TimeOrigin::Relative,
        };
        let Some(time_s) = &self.time_s else {
            return Ok(Positions::PerTrace(TracePositions {
                position_m: position_m.to_vec(),
                antennas_m: None,
                line_starts: Vec::new(),
                is_by_line_ends: false,
                frame,
                time_origin,
            }));
        };
        let time_s = values(time_s)?;
        expect_length("time_s", position_m.len(), time_s.len())?;
        let mut fixes: Vec<Fix> = time_s
            .iter()
            .zip(position_m)
            .map(|(time_s, position_m)| Fix::new(*time_s, *position_m))
            .collect();
        if let Some(sigma_m) = &self.sigma_m {
            let sigma_m = rows3(sigma_m)?;
            expect_length("sigma_m", fixes.len(), sigma_m.len())?;
            for (fix, sigma_m) in fixes.iter_mut().zip(sigma_m) {
                let mut covariance_m2 = [[0.0; 3]; 3];
                for (axis, row) in covariance_m2.iter_mut().enumerate() {
                    row[axis] = sigma_m[axis].powi(2);
                }
                fix.covariance_m2 = Some(covariance_m2);
            }
        }
        if let Some(status) = &self.status {
            expect_length("status", fixes.len(), status.len())?;
            for (fix, name) in fixes.iter_mut().zip(status) {
                fix.status = SolutionStatus::from_name(name).ok_or_else(|| unknown_status(name))?;
            }
        }
        let trajectory = Trajectory::new(frame, time_origin, fixes).map_err(Failure::position)?;
        Ok(trajectory.into())
    }
}

fn expect_length(what: &str, expected: usize, found: usize) -> PyResult<()> {
    if expected == found {
        return Ok(());
    }
    Err(PyValueError::new_err(format!(
        "{what}: expected {expected} values, one for each position, found {found}"
    )))
}

fn unknown_status(found: &str) -> PyErr {
    let names: Vec<&str> = SolutionStatus::ALL.iter().map(|s| s.name()).collect();
    PyValueError::new_err(format!(
        "status: expected one of {}, found \"{found}\"",
        names.join(", ")
    ))
}

/// A trajectory as arrays.
pub fn trajectory_arrays<'py>(
    py: Python<'py>,
    trajectory: &Trajectory,
) -> PyResult<Bound<'py, PyDict>> {
    let fixes = trajectory.fixes();
    let arrays = PyDict::new(py);
    let time_s: Vec<f64> = fixes.iter().map(|fix| fix.time_s).collect();
    let position_m: Vec<[f64; 3]> = fixes.iter().map(|fix| fix.position_m).collect();
    let sigma_m: Option<Vec<[f64; 3]>> = fixes.iter().map(Fix::standard_deviation_m).collect();
    let status: Vec<&str> = fixes.iter().map(|fix| fix.status.name()).collect();
    arrays.set_item("time_s", numpy::PyArray1::from_vec(py, time_s))?;
    arrays.set_item("position_m", positions(py, &position_m)?)?;
    let sigma_m = sigma_m.map(|sigma_m| positions(py, &sigma_m)).transpose()?;
    arrays.set_item("sigma_m", sigma_m)?;
    arrays.set_item("status", status)?;
    arrays.set_item("origin_deg_m", origin_deg_m(trajectory.frame()))?;
    let start = trajectory.time_origin().gps_time();
    arrays.set_item("gps_start", start.map(|t| (t.week(), t.tow_s())))?;
    Ok(arrays)
}

/// Latitude, longitude (degrees) and ellipsoidal height (m) of a frame's origin.
pub fn origin_deg_m(frame: &Frame) -> Option<[f64; 3]> {
    let origin = frame.enu()?.geodetic_from_enu([0.0; 3]);
    Some([
        origin.latitude_deg(),
        origin.longitude_deg(),
        origin.height_m,
    ])
}
