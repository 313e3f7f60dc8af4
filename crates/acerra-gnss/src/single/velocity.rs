//! Velocity from Doppler shifts.

use super::context::SingleContext;
use crate::measurements::constellation::{SatelliteState, Unusable};
use crate::measurements::measurement::Epoch;
use crate::observations::signal::SPEED_OF_LIGHT_M_S;
use crate::orbits::geometry::line_of_sight;
use crate::orbits::state::EARTH_ROTATION_RAD_S;
use nalgebra::{SMatrix, SVector};

const LARGEST_ITERATIONS: usize = 10;

impl SingleContext<'_> {
    /// Velocity (m/s) at a position by the satellites `used`, and its covariance.
    pub(super) fn velocity(
        &self,
        epoch: &Epoch,
        states: &[Result<SatelliteState, Unusable>],
        position: [f64; 3],
        used: &[usize],
    ) -> Option<([f64; 3], [[f64; 3]; 3])> {
        let mut x = SVector::<f64, 4>::zeros();
        for _ in 0..LARGEST_ITERATIONS {
            let mut normal = SMatrix::<f64, 4, 4>::zeros();
            let mut right = SVector::<f64, 4>::zeros();
            let mut rows = 0;
            for &k in used {
                let m = &epoch.measurements[k];
                let Ok(SatelliteState {
                    position_ecef_m: s,
                    rates: Some((v, drift)),
                    ..
                }) = states[k]
                else {
                    continue;
                };
                let frequency = m.frequency_hz[0];
                if m.doppler_hz[0] == 0.0 || frequency == 0.0 {
                    continue;
                }
                let u = line_of_sight(s, position)?.unit_ecef;
                let relative = [v[0] - x[0], v[1] - x[1], v[2] - x[2]];
                let along = relative[0] * u[0] + relative[1] * u[1] + relative[2] * u[2];
                let sagnac = EARTH_ROTATION_RAD_S / SPEED_OF_LIGHT_M_S
                    * (v[1] * position[0] + s[1] * x[0] - v[0] * position[1] - s[0] * x[1]);
                let predicted = along + sagnac + x[3] - SPEED_OF_LIGHT_M_S * drift;
                let wavelength = SPEED_OF_LIGHT_M_S / frequency;
                let sigma = self.options.doppler_error_hz * wavelength;
                let h = SVector::from([-u[0], -u[1], -u[2], 1.0]);
                let weight = 1.0 / (sigma * sigma);
                normal += h * h.transpose() * weight;
                right += h * ((-m.doppler_hz[0] * wavelength - predicted) * weight);
                rows += 1;
            }
            if rows < 4 {
                return None;
            }
            let covariance = normal.try_inverse()?;
            let step = covariance * right;
            x += step;
            if step.norm() < 1e-6 {
                let covariance =
                    std::array::from_fn(|i| std::array::from_fn(|j| covariance[(i, j)]));
                return Some(([x[0], x[1], x[2]], covariance));
            }
        }
        None
    }
}
