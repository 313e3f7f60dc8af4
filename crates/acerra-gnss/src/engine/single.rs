//! Single-point positioning from pseudoranges, its validation, and velocity from Doppler.

use super::constellation::{Constellation, SatelliteState, Unusable};
use super::measurement::Epoch;
use super::noise::{below_cn0_mask, system_factor};
use crate::atmosphere::{RELATIVE_HUMIDITY, not_below_zero_height, saastamoinen_m};
use crate::geometry::{azimuth_elevation_rad, line_of_sight};
use crate::navigation::Klobuchar;
use crate::options::{PpkOptions, RuleSet};
use crate::orbit_state::EARTH_ROTATION_RAD_S;
use crate::satellite::System;
use crate::signal::{FREQUENCY_L1_HZ, SPEED_OF_LIGHT_M_S};
use crate::solution::NotFixedReason;
use acerra_geo::geodesy::EnuFrame;
use acerra_geo::time::GpsTime;
use nalgebra::{SMatrix, SVector};
use std::f64::consts::FRAC_PI_2;

/// Position (3), GPS clock, and offsets of GLONASS, Galileo, BeiDou, NavIC against it.
const STATES: usize = 8;
const LARGEST_ITERATIONS: usize = 10;
const CODE_ERROR_FACTOR: f64 = 100.0;
const CODE_BIAS_ERROR_M: f64 = 0.3;
const MISSING_CLOCK_VARIANCE_M2: f64 = 0.01;
/// Satellites down to which outlying ones are left out of a position that fails its validation.
const LEAST_FOR_BEST_EFFORT: usize = 6;
/// Root mean square of the residuals beyond which such a position is none (m).
const LARGEST_RMS_M: f64 = 30.0;
/// Distance (m) over which no satellite's elevation changes by more than 0.2°.
const LARGEST_STEP_M: f64 = 50e3;
/// 0.999 quantiles of χ² for 1, 2, … degrees of freedom.
const CHI_SQUARE_999: [f64; 30] = [
    10.8, 13.8, 16.3, 18.5, 20.5, 22.5, 24.3, 26.1, 27.9, 29.6, 31.3, 32.9, 34.5, 36.1, 37.7, 39.3,
    40.8, 42.3, 43.8, 45.3, 46.8, 48.3, 49.7, 51.2, 52.6, 54.1, 55.5, 56.9, 58.3, 59.7,
];

/// Everything a single-point position needs to know.
pub(crate) struct SingleContext<'a> {
    pub constellation: &'a Constellation,
    pub klobuchar: &'a Klobuchar,
    pub options: &'a PpkOptions,
    /// The receiver is the base (for the C/N₀ mask).
    pub base: bool,
}

/// A validated single-point position.
#[derive(Debug, Clone)]
pub(crate) struct SinglePoint {
    pub position_ecef_m: [f64; 3],
    pub covariance_ecef_m2: [[f64; 3]; 3],
    pub satellites: usize,
    /// Velocity (m/s) and its covariance.
    pub velocity: Option<([f64; 3], [[f64; 3]; 3])>,
    /// Tag minus receiver clock.
    pub time: GpsTime,
}

fn clock_state(system: System) -> Option<usize> {
    match system {
        System::Gps | System::Qzss | System::Sbas => None,
        System::Glonass => Some(4),
        System::Galileo => Some(5),
        System::Beidou => Some(6),
        System::Navic => Some(7),
    }
}

fn chi_square_999(freedom: usize) -> f64 {
    CHI_SQUARE_999.get(freedom - 1).copied().unwrap_or_else(|| {
        // Wilson and Hilferty's approximation, better than 0.2 % there.
        let n = freedom as f64;
        let spread = 2.0 / (9.0 * n);
        n * (1.0 - spread + 3.090_232 * spread.sqrt()).powi(3)
    })
}

/// Where an iteration begins.
#[derive(Clone, Copy)]
struct Start {
    position_ecef_m: [f64; 3],
    /// The receiver is there but for a satellite or two that misled it: directions are known, and
    /// with them the delays in the atmosphere. Elsewhere, at the Earth's centre at worst, they are
    /// not before the first step.
    is_near: bool,
}

impl Start {
    /// The place that an iteration from here came to.
    fn moved_to(self, position_ecef_m: [f64; 3]) -> Self {
        let squares = (0..3).map(|k| (position_ecef_m[k] - self.position_ecef_m[k]).powi(2));
        Self {
            position_ecef_m,
            is_near: squares.sum::<f64>().sqrt() < LARGEST_STEP_M,
        }
    }
}

/// One pseudorange equation.
struct Row {
    residual_m: f64,
    variance_m2: f64,
    design: [f64; STATES],
}

struct Equations {
    rows: Vec<Row>,
    satellites: usize,
    /// Azimuth and elevation of satellites used.
    directions: Vec<(f64, f64)>,
    used: Vec<usize>,
}

struct Converged {
    x: SVector<f64, STATES>,
    covariance: SMatrix<f64, STATES, STATES>,
    equations: Equations,
}

impl Converged {
    fn position(&self) -> [f64; 3] {
        [self.x[0], self.x[1], self.x[2]]
    }
}

impl SingleContext<'_> {
    /// Satellite states of an epoch, one per measurement.
    pub(crate) fn states(
        &self,
        epoch: &Epoch,
        selection_time: GpsTime,
        with_rates: bool,
    ) -> Vec<Result<SatelliteState, Unusable>> {
        epoch
            .measurements
            .iter()
            .map(|m| {
                let rates = with_rates && m.doppler_hz[0] != 0.0;
                let pseudorange = m.any_pseudorange_m();
                self.constellation
                    .state(m.satellite, selection_time, epoch.tag, pseudorange, rates)
            })
            .collect()
    }

    /// The single-point position of `epoch`, starting from `start`.
    ///
    /// On failure the reason, and the position where the iteration ended.
    pub(crate) fn solve(
        &self,
        epoch: &Epoch,
        states: &[Result<SatelliteState, Unusable>],
        start_ecef_m: [f64; 3],
    ) -> Result<SinglePoint, (NotFixedReason, [f64; 3])> {
        let all = vec![true; epoch.measurements.len()];
        let far = Start {
            position_ecef_m: start_ecef_m,
            is_near: false,
        };
        let (found, start) = match self.converge(epoch, states, far, &all) {
            Ok(solved) => {
                let near = far.moved_to(solved.position());
                (self.validated(solved), near)
            }
            Err(failure) => (Err(failure), far),
        };
        let solved = match found {
            Err(failure) if self.options.raim => self
                .leave_one_out(epoch, states, start)
                .or_else(|| self.best_effort(epoch, states, start))
                .ok_or(failure),
            other => other,
        }?;
        let position_ecef_m = solved.position();
        Ok(SinglePoint {
            position_ecef_m,
            covariance_ecef_m2: std::array::from_fn(|i| {
                std::array::from_fn(|j| solved.covariance[(i, j)])
            }),
            satellites: solved.equations.satellites,
            velocity: self.velocity(epoch, states, position_ecef_m, &solved.equations.used),
            time: epoch.tag - solved.x[3] / SPEED_OF_LIGHT_M_S,
        })
    }

    fn equations(
        &self,
        epoch: &Epoch,
        states: &[Result<SatelliteState, Unusable>],
        x: &SVector<f64, STATES>,
        first_iteration: bool,
        keep: &[bool],
    ) -> Equations {
        let position = [x[0], x[1], x[2]];
        let frame = EnuFrame::from_ecef(position);
        let place = frame.origin();
        let options = self.options;
        let mut result = Equations {
            rows: Vec::with_capacity(states.len() + 5),
            satellites: 0,
            directions: Vec::with_capacity(states.len()),
            used: Vec::with_capacity(states.len()),
        };
        let zenith_troposphere_m =
            saastamoinen_m(&not_below_zero_height(place), FRAC_PI_2, RELATIVE_HUMIDITY);
        let mut clock_seen = [false; STATES];
        for (k, (m, state)) in epoch.measurements.iter().zip(states).enumerate() {
            let (Ok(state), true) = (state, keep[k]) else {
                continue;
            };
            let pseudorange = m.code_m[0];
            let frequency = m.frequency_hz[0];
            if pseudorange == 0.0 || frequency == 0.0 {
                continue;
            }
            let Some(sight) = line_of_sight(state.position_ecef_m, position) else {
                continue;
            };
            // The first iteration may start at the Earth's centre, where no direction is up.
            let (azimuth, elevation) = if first_iteration {
                (0.0, FRAC_PI_2)
            } else {
                azimuth_elevation_rad(&frame, sight.unit_ecef)
            };
            if !first_iteration
                && (elevation < options.elevation_mask_rad
                    || below_cn0_mask(
                        options.cn0_mask.as_ref(),
                        self.base,
                        0,
                        elevation,
                        m.cn0_db_hz[0],
                    ))
            {
                continue;
            }
            let system = self.constellation.id(m.satellite).system();
            let scale = (FREQUENCY_L1_HZ / frequency).powi(2);
            let (ionosphere_l1, troposphere) = if first_iteration {
                (0.0, 0.0)
            } else {
                (
                    self.klobuchar
                        .delay_l1_m(epoch.tag, place, azimuth, elevation),
                    if elevation > 0.0 {
                        zenith_troposphere_m / elevation.sin()
                    } else {
                        0.0
                    },
                )
            };
            let ionosphere_variance = (0.5 * ionosphere_l1).powi(2)
                * if options.rules == RuleSet::Demo5 {
                    scale * scale
                } else {
                    scale
                };
            let sin_elevation = elevation.max(5f64.to_radians()).sin();
            let troposphere_variance = (0.3 / (elevation.sin() + 0.1)).powi(2);
            let factor = system_factor(system)
                * if options.rules == RuleSet::Demo5 {
                    options.code_phase_ratio[0]
                } else {
                    CODE_ERROR_FACTOR
                };
            let code_variance = factor
                * factor
                * (options.phase_error_m.powi(2)
                    + options.phase_error_elevation_m.powi(2) / sin_elevation);
            let corrected =
                pseudorange - self.constellation.group_delay_m(m.satellite, m.first_code);
            let mut residual = corrected
                - (sight.range_m + x[3] - SPEED_OF_LIGHT_M_S * state.clock_s
                    + ionosphere_l1 * scale
                    + troposphere);
            let u = sight.unit_ecef;
            let mut design = [-u[0], -u[1], -u[2], 1.0, 0.0, 0.0, 0.0, 0.0];
            let clock = clock_state(system);
            if let Some(index) = clock {
                design[index] = 1.0;
                residual -= x[index];
            }
            clock_seen[clock.unwrap_or(3)] = true;
            result.rows.push(Row {
                residual_m: residual,
                variance_m2: code_variance
                    + state.variance_m2
                    + CODE_BIAS_ERROR_M * CODE_BIAS_ERROR_M
                    + ionosphere_variance
                    + troposphere_variance,
                design,
            });
            result.satellites += 1;
            result.directions.push((azimuth, elevation));
            result.used.push(k);
        }
        for index in (3..STATES).filter(|&index| !clock_seen[index]) {
            let mut design = [0.0; STATES];
            design[index] = 1.0;
            result.rows.push(Row {
                residual_m: 0.0,
                variance_m2: MISSING_CLOCK_VARIANCE_M2,
                design,
            });
        }
        result
    }

    fn converge(
        &self,
        epoch: &Epoch,
        states: &[Result<SatelliteState, Unusable>],
        start: Start,
        keep: &[bool],
    ) -> Result<Converged, (NotFixedReason, [f64; 3])> {
        let mut x = SVector::<f64, STATES>::zeros();
        for k in 0..3 {
            x[k] = start.position_ecef_m[k];
        }
        let position = |x: &SVector<f64, STATES>| [x[0], x[1], x[2]];
        for iteration in 0..LARGEST_ITERATIONS {
            let equations =
                self.equations(epoch, states, &x, iteration == 0 && !start.is_near, keep);
            if equations.rows.len() < STATES {
                let used = equations.satellites;
                let reason = NotFixedReason::TooFewSatellitesForSingle { used };
                return Err((reason, position(&x)));
            }
            let mut normal = SMatrix::<f64, STATES, STATES>::zeros();
            let mut right = SVector::<f64, STATES>::zeros();
            for row in &equations.rows {
                let h = SVector::from(row.design);
                let weight = 1.0 / row.variance_m2;
                normal.ger(weight, &h, &h, 1.0);
                right += h * (row.residual_m * weight);
            }
            let Some(covariance) = normal.try_inverse() else {
                return Err((NotFixedReason::SinglePointFailed, position(&x)));
            };
            let step = covariance * right;
            x += step;
            if !x.iter().all(|v| v.is_finite() && v.abs() < 1e12) {
                return Err((NotFixedReason::SinglePointFailed, start.position_ecef_m));
            }
            if step.norm() < 1e-4 {
                return Ok(Converged {
                    x,
                    covariance,
                    equations,
                });
            }
        }
        Err((NotFixedReason::SinglePointFailed, position(&x)))
    }

    /// The position, if its residuals and its geometry allow it.
    fn validated(&self, solved: Converged) -> Result<Converged, (NotFixedReason, [f64; 3])> {
        let end = solved.position();
        let rows = &solved.equations.rows;
        if rows.len() > STATES && self.options.rules == RuleSet::Rtklib {
            let sum: f64 = rows
                .iter()
                .map(|r| r.residual_m * r.residual_m / r.variance_m2)
                .sum();
            if sum > chi_square_999(rows.len() - STATES) {
                return Err((NotFixedReason::SinglePointFailed, end));
            }
        }
        let gdop = gdop(&solved.equations.directions);
        if gdop.is_nan() || gdop <= 0.0 || gdop > self.options.max_gdop {
            return Err((NotFixedReason::PoorGeometry { gdop }, end));
        }
        Ok(solved)
    }

    /// Among the solutions that leave out one satellite, the one with the least residuals.
    fn leave_one_out(
        &self,
        epoch: &Epoch,
        states: &[Result<SatelliteState, Unusable>],
        start: Start,
    ) -> Option<Converged> {
        let mut keep = vec![true; epoch.measurements.len()];
        if states.iter().filter(|s| s.is_ok()).count() < 6 {
            return None;
        }
        let mut best: Option<(f64, Converged)> = None;
        for left_out in 0..keep.len() {
            if states[left_out].is_err() {
                continue;
            }
            keep[left_out] = false;
            let converged = self.converge(epoch, states, start, &keep);
            if let Ok(solved) = converged.and_then(|solved| self.validated(solved)) {
                let n = solved.equations.satellites;
                if n >= 5 {
                    let sum: f64 = solved.equations.rows[..n]
                        .iter()
                        .map(|r| r.residual_m * r.residual_m)
                        .sum();
                    let rms = (sum / n as f64).sqrt();
                    if rms < best.as_ref().map_or(100.0, |(least, _)| *least) {
                        best = Some((rms, solved));
                    }
                }
            }
            keep[left_out] = true;
        }
        best.map(|(_, solved)| solved)
    }

    /// The solution without the satellites whose residuals stand out most; where those that remain
    /// still contradict each other, its covariance grows as their residuals say.
    fn best_effort(
        &self,
        epoch: &Epoch,
        states: &[Result<SatelliteState, Unusable>],
        start: Start,
    ) -> Option<Converged> {
        let mut keep = vec![true; epoch.measurements.len()];
        loop {
            let mut solved = self.converge(epoch, states, start, &keep).ok()?;
            let n = solved.equations.satellites;
            let rows = &solved.equations.rows[..n];
            let square = |r: &Row| r.residual_m * r.residual_m / r.variance_m2;
            let sum: f64 = rows.iter().map(square).sum();
            let freedom = solved.equations.rows.len().checked_sub(STATES)?;
            let contradicting = freedom > 0 && sum > chi_square_999(freedom);
            if contradicting && n > LEAST_FOR_BEST_EFFORT {
                let worst =
                    (0..n).max_by(|a, b| square(&rows[*a]).total_cmp(&square(&rows[*b])))?;
                keep[solved.equations.used[worst]] = false;
                continue;
            }
            let rms_m = (rows.iter().map(|r| r.residual_m.powi(2)).sum::<f64>() / n as f64).sqrt();
            let gdop = gdop(&solved.equations.directions);
            if rms_m > LARGEST_RMS_M || gdop.is_nan() || gdop > self.options.max_gdop {
                return None;
            }
            if contradicting {
                solved.covariance *= sum / freedom as f64;
            }
            return Some(solved);
        }
    }

    fn velocity(
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

/// Geometric dilution of precision with one clock; infinite when singular.
fn gdop(directions: &[(f64, f64)]) -> f64 {
    let mut normal = SMatrix::<f64, 4, 4>::zeros();
    for &(azimuth, elevation) in directions {
        let (sin_az, cos_az) = azimuth.sin_cos();
        let (sin_el, cos_el) = elevation.sin_cos();
        let h = SVector::from([cos_el * sin_az, cos_el * cos_az, sin_el, 1.0]);
        normal += h * h.transpose();
    }
    if directions.len() < 4 {
        return f64::INFINITY;
    }
    normal
        .try_inverse()
        .map_or(f64::INFINITY, |q| q.trace().sqrt())
}
