//! The calibration of one antenna type.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;
use std::fmt;

use crate::observations::satellite::System;
use crate::observations::signal::{FREQUENCY_L1_HZ, SignalCode};

/// Bands this near in frequency replace each other where one is not calibrated (Hz).
const NEAR_HZ: f64 = 60e6;

/// Phase centre of an antenna at one frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct FrequencyCalibration {
    /// Phase centre offset from the antenna reference point: east, north, up (m).
    pub offset_enu_m: [f64; 3],
    /// Zenith angles of the variations: first, last and step (rad).
    pub zenith_rad: [f64; 3],
    /// Variations without regard to azimuth (m), by zenith angle.
    pub variation_m: Vec<f64>,
    /// Variations by azimuth (outer, from north by the step below) and zenith angle (m); empty
    /// where the calibration does not depend on azimuth.
    pub azimuth_variation_m: Vec<Vec<f64>>,
    /// Step of azimuth (rad), 0 where there is none.
    pub azimuth_step_rad: f64,
}

impl FrequencyCalibration {
    /// Contribution of the antenna to the range from its reference point (m), for a signal from this
    /// direction: −PCO·e + PCV, bilinear between the calibration's directions.
    #[must_use]
    pub fn range_m(&self, azimuth_rad: f64, elevation_rad: f64) -> f64 {
        let (sin_az, cos_az) = azimuth_rad.sin_cos();
        let (sin_el, cos_el) = elevation_rad.sin_cos();
        let [east, north, up] = self.offset_enu_m;
        let along = cos_el * (east * sin_az + north * cos_az) + up * sin_el;
        self.variation_at_m(azimuth_rad, FRAC_PI_2 - elevation_rad) - along
    }

    fn variation_at_m(&self, azimuth_rad: f64, zenith_rad: f64) -> f64 {
        if self.azimuth_variation_m.is_empty() || self.azimuth_step_rad <= 0.0 {
            return self.along_zenith_m(&self.variation_m, zenith_rad);
        }
        // The last row is for 360° and repeats the first.
        let rows = self.azimuth_variation_m.len();
        let place = azimuth_rad.rem_euclid(std::f64::consts::TAU) / self.azimuth_step_rad;
        let row = (place.floor() as usize).min(rows - 1);
        let next = (row + 1).min(rows - 1);
        let part = place - row as f64;
        let at = |row: usize| self.along_zenith_m(&self.azimuth_variation_m[row], zenith_rad);
        at(row) + (at(next) - at(row)) * part.clamp(0.0, 1.0)
    }

    /// Linear interpolation between the two nearest zenith angles; the outermost value beyond the table.
    fn along_zenith_m(&self, values: &[f64], zenith_rad: f64) -> f64 {
        let [first, _, step] = self.zenith_rad;
        let Some(last) = values.len().checked_sub(1) else {
            return 0.0;
        };
        let place = ((zenith_rad - first) / step).clamp(0.0, last as f64);
        let below = (place.floor() as usize).min(last);
        let above = (below + 1).min(last);
        values[below] + (values[above] - values[below]) * (place - below as f64)
    }
}

/// The calibration of an antenna type, by system and band.
#[derive(Clone, PartialEq)]
pub struct AntennaCalibration {
    /// Antenna type and radome, as in RINEX headers (`TRM57971.00     NONE`).
    pub antenna: String,
    /// Calibrations by system and RINEX band digit.
    pub frequencies: BTreeMap<(System, u8), FrequencyCalibration>,
}

/// Names the antenna and its frequencies, without the tables.
impl fmt::Debug for AntennaCalibration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let offsets = self.frequencies.iter().map(|((system, band), c)| {
            let name = format!("{}{band}", system.letter());
            (name, c.offset_enu_m)
        });
        f.debug_struct("AntennaCalibration")
            .field("antenna", &self.antenna)
            .field("offsets_enu_m", &offsets.collect::<BTreeMap<_, _>>())
            .finish()
    }
}

impl AntennaCalibration {
    /// The calibration for a signal: of the signal's band, or else of the nearest carrier within 60 MHz (many
    /// calibrations hold L1 and L2 of GPS and GLONASS only).
    #[must_use]
    pub fn of_signal(&self, system: System, code: SignalCode) -> Option<&FrequencyCalibration> {
        if let Some(own) = self.frequencies.get(&(system, code.band)) {
            return Some(own);
        }
        let carrier = |system: System, band: u8| {
            let code = SignalCode::new(band, 'X');
            code.carrier_frequency_hz(system, Some(0))
        };
        let wanted_hz = carrier(system, code.band).unwrap_or(FREQUENCY_L1_HZ);
        let distance = |(&(system, band), found): (&(System, u8), _)| {
            let away_hz = (carrier(system, band)? - wanted_hz).abs();
            (away_hz <= NEAR_HZ).then_some((away_hz, found))
        };
        self.frequencies
            .iter()
            .filter_map(distance)
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, found)| found)
    }
}
