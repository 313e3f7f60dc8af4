//! Values of a configuration file that depend on each other and are combined at the end.

use acerra_geo::geodesy::{Geodetic, ecef_from_geodetic};

use super::error::ConfError;
use crate::observations::signal::FREQUENCY_SLOTS;
use crate::options::{
    BasePosition, BaselineLength, Cn0Mask, Dynamics, PartialAmbiguity, PositioningMode, PpkOptions,
};

/// Standard deviation (m) of a baseline's length where none is stated, typical of a tape measure.
const LEAST_LENGTH_SIGMA_M: f64 = 1e-3;

/// Values that depend on each other and are combined at the end.
pub(super) struct Pending {
    pub dynamics: bool,
    pub noise: [f64; 2],
    pub masks: [[f64; 9]; FREQUENCY_SLOTS],
    pub masked: [bool; 2],
    pub base_kind: u32,
    pub base_values: [f64; 3],
    pub base_line: u64,
    pub partial: PartialAmbiguity,
    pub ratio_range: [Option<f64>; 2],
    /// Length of the baseline and its standard deviation.
    pub baseline_m: [f64; 2],
}

impl Pending {
    /// Values before any key is read.
    pub(super) fn of(options: &PpkOptions) -> Self {
        let noise = options
            .dynamics
            .map_or([0.1, 0.01], |d| [d.horizontal_noise, d.vertical_noise]);
        Self {
            dynamics: options.dynamics.is_some(),
            noise,
            masks: [[0.0; 9]; FREQUENCY_SLOTS],
            masked: [false; 2],
            base_kind: 0,
            base_values: [0.0; 3],
            base_line: 0,
            partial: options.partial_ambiguity.unwrap_or(PartialAmbiguity {
                filter_new_satellites: false,
                min_satellites_to_fix: 3,
                min_pairs_to_hold: 3,
                min_pairs_to_drop: usize::MAX,
            }),
            ratio_range: [None; 2],
            baseline_m: [0.0; 2],
        }
    }

    /// Applies the values to the options.
    pub(super) fn finish(&self, options: &mut PpkOptions) -> Result<(), ConfError> {
        options.dynamics = self.dynamics.then_some(Dynamics {
            horizontal_noise: self.noise[0],
            vertical_noise: self.noise[1],
        });
        if self.masked.contains(&true) {
            options.cn0_mask = Some(Cn0Mask {
                min_db_hz: self.masks,
                rover: self.masked[0],
                base: self.masked[1],
            });
        }
        for (value, given) in options
            .ratio_threshold_range
            .iter_mut()
            .zip(self.ratio_range)
        {
            *value = given.unwrap_or(*value);
        }
        if options.partial_ambiguity.is_some() {
            options.partial_ambiguity = Some(self.partial);
        }
        // In RTKLIB a fixed base has no length, and a length is positive.
        let [length_m, sigma_m] = self.baseline_m;
        if options.mode == PositioningMode::MovingBase && length_m > 0.0 {
            options.baseline_length = Some(BaselineLength {
                length_m,
                sigma_m: sigma_m.max(LEAST_LENGTH_SIGMA_M),
            });
        }
        let [a, b, c] = self.base_values;
        options.base_position = match self.base_kind {
            1 => BasePosition::Ecef([a, b, c]),
            2 => BasePosition::AverageSingle,
            4 => BasePosition::Header,
            _ => {
                if a.abs() > 90.0 || b.abs() > 360.0 {
                    return Err(ConfError::Value {
                        line: self.base_line,
                        key: "ant2-pos1, ant2-pos2".to_owned(),
                        expected: "latitude and longitude in degrees".to_owned(),
                        found: format!("{a} {b}"),
                    });
                }
                BasePosition::Ecef(ecef_from_geodetic(&Geodetic::from_degrees(a, b, c)))
            }
        };
        Ok(())
    }
}
