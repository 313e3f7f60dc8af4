//! Pseudorange equations.

use super::context::SingleContext;
use crate::measurements::constellation::{SatelliteState, Unusable};
use crate::measurements::measurement::{Epoch, Measurement};
use crate::measurements::noise::{below_cn0_mask, system_factor};
use crate::observations::satellite::System;
use crate::observations::signal::{FREQUENCY_L1_HZ, SPEED_OF_LIGHT_M_S};
use crate::orbits::atmosphere::{RELATIVE_HUMIDITY, not_below_zero_height, saastamoinen_m};
use crate::orbits::geometry::{azimuth_elevation_rad, line_of_sight};
use acerra_geo::geodesy::EnuFrame;
use acerra_geo::time::GpsTime;
use nalgebra::SVector;
use std::f64::consts::FRAC_PI_2;

/// Number of states: position (3), GPS clock, and clock offsets of GLONASS, Galileo, BeiDou, NavIC relative
/// to GPS.
pub(super) const STATES: usize = 8;
const CODE_ERROR_FACTOR: f64 = 100.0;
const CODE_BIAS_ERROR_M: f64 = 0.3;
const MISSING_CLOCK_VARIANCE_M2: f64 = 0.01;

fn clock_state(system: System) -> Option<usize> {
    match system {
        System::Gps | System::Qzss | System::Sbas => None,
        System::Glonass => Some(4),
        System::Galileo => Some(5),
        System::Beidou => Some(6),
        System::Navic => Some(7),
    }
}

/// One pseudorange equation.
pub(super) struct Row {
    pub residual_m: f64,
    pub variance_m2: f64,
    pub design: [f64; STATES],
}

/// The equations of an epoch.
pub(super) struct Equations {
    /// Equations of satellites, followed by equations of clocks without a satellite.
    pub rows: Vec<Row>,
    pub satellites: usize,
    /// Azimuth and elevation of satellites used.
    pub directions: Vec<(f64, f64)>,
    /// Indices of the satellites used among the measurements.
    pub used: Vec<usize>,
}

/// The receiver about which equations are linearised.
struct About {
    time: GpsTime,
    position_ecef_m: [f64; 3],
    frame: EnuFrame,
    zenith_troposphere_m: f64,
    /// Clock offset from GPS time (m).
    clock_m: f64,
    directions_known: bool,
}

/// Delays of a signal (m): in the ionosphere on L1, and in the troposphere.
struct Delays {
    ionosphere_l1_m: f64,
    troposphere_m: f64,
}

impl SingleContext<'_> {
    /// The equations at the state `x`; before directions are known every satellite is assumed in the zenith,
    /// and signals without delay.
    pub(super) fn equations(
        &self,
        epoch: &Epoch,
        states: &[Result<SatelliteState, Unusable>],
        x: &SVector<f64, STATES>,
        directions_known: bool,
        keep: &[bool],
    ) -> Equations {
        let position_ecef_m = [x[0], x[1], x[2]];
        let frame = EnuFrame::from_ecef(position_ecef_m);
        let above = not_below_zero_height(frame.origin());
        let about = About {
            time: epoch.tag,
            position_ecef_m,
            zenith_troposphere_m: saastamoinen_m(&above, FRAC_PI_2, RELATIVE_HUMIDITY),
            frame,
            clock_m: x[3],
            directions_known,
        };
        let mut result = Equations {
            rows: Vec::with_capacity(states.len() + 5),
            satellites: 0,
            directions: Vec::with_capacity(states.len()),
            used: Vec::with_capacity(states.len()),
        };
        let mut clock_seen = [false; STATES];
        for (k, (m, state)) in epoch.measurements.iter().zip(states).enumerate() {
            let (Ok(state), true) = (state, keep[k]) else {
                continue;
            };
            let Some((mut row, direction)) = self.equation(m, state, &about) else {
                continue;
            };
            let system = self.constellation.id(m.satellite).system();
            let clock = clock_state(system);
            if let Some(index) = clock {
                row.design[index] = 1.0;
                row.residual_m -= x[index];
            }
            clock_seen[clock.unwrap_or(3)] = true;
            result.rows.push(row);
            result.satellites += 1;
            result.directions.push(direction);
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

    /// The equation of one satellite without the offset of its system's clock, and its azimuth and elevation;
    /// `None` where the satellite is not used.
    fn equation(
        &self,
        m: &Measurement,
        state: &SatelliteState,
        about: &About,
    ) -> Option<(Row, (f64, f64))> {
        let (pseudorange, frequency) = (m.code_m[0], m.frequency_hz[0]);
        if pseudorange == 0.0 || frequency == 0.0 {
            return None;
        }
        let sight = line_of_sight(state.position_ecef_m, about.position_ecef_m)?;
        // The iteration may start at the Earth's centre, where no direction is up.
        let (azimuth, elevation) = if about.directions_known {
            azimuth_elevation_rad(&about.frame, sight.unit_ecef)
        } else {
            (0.0, FRAC_PI_2)
        };
        if about.directions_known && self.is_masked(elevation, m.cn0_db_hz[0]) {
            return None;
        }
        let scale = (FREQUENCY_L1_HZ / frequency).powi(2);
        let delays = self.delays(about, azimuth, elevation);
        let corrected = pseudorange - self.constellation.group_delay_m(m.satellite, m.first_code);
        let predicted = sight.range_m + about.clock_m - SPEED_OF_LIGHT_M_S * state.clock_s
            + delays.ionosphere_l1_m * scale
            + delays.troposphere_m;
        let u = sight.unit_ecef;
        let system = self.constellation.id(m.satellite).system();
        let row = Row {
            residual_m: corrected - predicted,
            variance_m2: self.code_variance_m2(system, elevation)
                + state.variance_m2
                + CODE_BIAS_ERROR_M * CODE_BIAS_ERROR_M
                + self.ionosphere_variance_m2(&delays, scale)
                + (0.3 / (elevation.sin() + 0.1)).powi(2),
            design: [-u[0], -u[1], -u[2], 1.0, 0.0, 0.0, 0.0, 0.0],
        };
        Some((row, (azimuth, elevation)))
    }

    fn is_masked(&self, elevation: f64, cn0_db_hz: f64) -> bool {
        let options = self.options;
        elevation < options.elevation_mask_rad
            || below_cn0_mask(
                options.cn0_mask.as_ref(),
                self.base,
                0,
                elevation,
                cn0_db_hz,
            )
    }

    fn delays(&self, about: &About, azimuth: f64, elevation: f64) -> Delays {
        if !about.directions_known {
            return Delays {
                ionosphere_l1_m: 0.0,
                troposphere_m: 0.0,
            };
        }
        let place = about.frame.origin();
        Delays {
            ionosphere_l1_m: self
                .klobuchar
                .delay_l1_m(about.time, place, azimuth, elevation),
            troposphere_m: if elevation > 0.0 {
                about.zenith_troposphere_m / elevation.sin()
            } else {
                0.0
            },
        }
    }

    fn code_variance_m2(&self, system: System, elevation: f64) -> f64 {
        let options = self.options;
        let sin_elevation = elevation.max(5f64.to_radians()).sin();
        let factor = system_factor(system) * options.single_point_code_factor(CODE_ERROR_FACTOR);
        factor
            * factor
            * (options.phase_error_m.powi(2)
                + options.phase_error_elevation_m.powi(2) / sin_elevation)
    }

    fn ionosphere_variance_m2(&self, delays: &Delays, scale: f64) -> f64 {
        let scale = self.options.policy().ionosphere_scale(scale);
        (0.5 * delays.ionosphere_l1_m).powi(2) * scale
    }
}
