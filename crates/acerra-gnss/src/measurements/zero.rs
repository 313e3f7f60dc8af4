//! Zero differences: measurements minus the prediction by geometry, clocks and the dry troposphere.

use super::constellation::{SatelliteState, Unusable};
use super::measurement::Epoch;
use super::noise::below_cn0_mask;
use crate::observations::signal::{FREQUENCY_SLOTS, SPEED_OF_LIGHT_M_S};
use crate::options::PpkOptions;
use crate::orbits::atmosphere::{Niell, not_below_zero_height, saastamoinen_m};
use crate::orbits::geometry::{azimuth_rad, elevation_rad, line_of_sight};
use acerra_geo::geodesy::{EnuFrame, Geodetic};
use acerra_geo::time::GpsTime;
use std::f64::consts::FRAC_PI_2;

/// Zero differences of one satellite; 0 means "absent".
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ZeroDifference {
    /// Phase residual, ambiguity and receiver clock included (m).
    pub phase_m: [f64; FREQUENCY_SLOTS],
    /// Code residual, receiver clock included (m).
    pub code_m: [f64; FREQUENCY_SLOTS],
    /// Carrier-to-noise density (dB-Hz).
    pub cn0_db_hz: [f64; FREQUENCY_SLOTS],
    /// C/N₀ below its usual value (dB).
    pub cn0_drop_db: [f64; FREQUENCY_SLOTS],
    /// Noise over carrier power in one hertz.
    pub noise_power: [f64; FREQUENCY_SLOTS],
    /// Unit vector from receiver to satellite.
    pub unit_ecef: [f64; 3],
    /// Derivative of the residuals with respect to the receiver's position: the unit vector and, where the
    /// troposphere follows the height, the decrease of the tropospheric delay with height.
    pub by_position_ecef: [f64; 3],
    /// East and north of the direction to the satellite.
    pub horizontal: [f64; 2],
    /// Zero when the satellite is not used.
    pub elevation_rad: f64,
    /// Sine of the elevation.
    pub sin_elevation: f64,
}

impl ZeroDifference {
    /// Azimuth from north (rad).
    pub(crate) fn azimuth_rad(&self) -> f64 {
        let [east, north] = self.horizontal;
        azimuth_rad(east, north)
    }
}

/// Height difference over which the change of the tropospheric delay is computed (m).
const ABOVE_M: f64 = 10.0;

fn above(place: &Geodetic) -> Geodetic {
    Geodetic {
        height_m: place.height_m + ABOVE_M,
        ..*place
    }
}

/// Delay by the dry troposphere at one place and time.
struct DryDelay {
    zenith_m: f64,
    mapping: Niell,
}

impl DryDelay {
    fn at(time: GpsTime, place: &Geodetic, follows_height: bool) -> Self {
        let in_atmosphere = if follows_height {
            *place
        } else {
            not_below_zero_height(place)
        };
        Self {
            zenith_m: saastamoinen_m(&in_atmosphere, FRAC_PI_2, 0.0),
            mapping: Niell::new(time, place),
        }
    }

    fn slant_m(&self, elevation_rad: f64) -> f64 {
        self.mapping.at(elevation_rad).hydrostatic * self.zenith_m
    }
}

/// Zero differences of every measurement of `epoch` for a receiver at `position_ecef_m`;
/// satellites without a state or below the elevation mask stay zero.
pub(crate) fn zero_differences(
    options: &PpkOptions,
    epoch: &Epoch,
    states: &[Result<SatelliteState, Unusable>],
    position_ecef_m: [f64; 3],
    base: bool,
) -> Vec<ZeroDifference> {
    let frame = EnuFrame::from_ecef(position_ecef_m);
    let place = frame.origin();
    let follows = options.troposphere_follows_height;
    let delay = DryDelay::at(epoch.tag, place, follows);
    let delay_above = (follows && !base)
        .then(|| DryDelay::at(epoch.tag, &above(place), follows))
        .filter(|above| above.zenith_m > 0.0 && delay.zenith_m > 0.0);
    let up_ecef = frame.ecef_vector_from_enu([0.0, 0.0, 1.0]);
    let (antenna, calibration) = if base {
        (options.base_antenna_m, &options.base_calibration)
    } else {
        (options.rover_antenna_m, &options.rover_calibration)
    };
    epoch
        .measurements
        .iter()
        .zip(states)
        .map(|(m, state)| {
            let mut result = ZeroDifference::default();
            let Ok(state) = state else { return result };
            let Some(sight) = line_of_sight(state.position_ecef_m, position_ecef_m) else {
                return result;
            };
            let [east, north, up] = frame.enu_vector_from_ecef(sight.unit_ecef);
            let elevation = elevation_rad(up);
            if elevation.is_nan() || elevation < options.elevation_mask_rad {
                return result;
            }
            let delay_m = delay.slant_m(elevation);
            let gradient = delay_above
                .as_ref()
                .map_or(0.0, |above| (above.slant_m(elevation) - delay_m) / ABOVE_M);
            result.unit_ecef = sight.unit_ecef;
            result.by_position_ecef =
                std::array::from_fn(|k| sight.unit_ecef[k] - gradient * up_ecef[k]);
            result.horizontal = [east, north];
            result.elevation_rad = elevation;
            result.cn0_db_hz = m.cn0_db_hz;
            result.cn0_drop_db = m.cn0_drop_db;
            result.noise_power = m.noise_power;
            let (sin_el, cos_el) = elevation.sin_cos();
            result.sin_elevation = sin_el;
            let mut antenna_m = antenna[2] * sin_el;
            if antenna[0] != 0.0 || antenna[1] != 0.0 {
                let (sin_az, cos_az) = result.azimuth_rad().sin_cos();
                antenna_m += antenna[0] * cos_el * sin_az + antenna[1] * cos_el * cos_az;
            }
            let predicted =
                sight.range_m - SPEED_OF_LIGHT_M_S * state.clock_s + delay_m - antenna_m;
            for slot in 0..options.frequencies.min(FREQUENCY_SLOTS) {
                let frequency = m.frequency_hz[slot];
                if frequency == 0.0
                    || below_cn0_mask(
                        options.cn0_mask.as_ref(),
                        base,
                        slot,
                        elevation,
                        m.cn0_db_hz[slot],
                    )
                {
                    continue;
                }
                let phase_centre_m = calibration
                    .as_ref()
                    .zip(m.signal[slot])
                    .and_then(|(calibration, code)| calibration.of_signal(m.system, code))
                    .map_or(0.0, |at| at.range_m(result.azimuth_rad(), elevation));
                let predicted = predicted + phase_centre_m;
                if m.phase_cycles[slot] != 0.0 {
                    result.phase_m[slot] =
                        m.phase_cycles[slot] * SPEED_OF_LIGHT_M_S / frequency - predicted;
                }
                if m.code_m[slot] != 0.0 {
                    result.code_m[slot] = m.code_m[slot] - predicted;
                }
            }
            result
        })
        .collect()
}
