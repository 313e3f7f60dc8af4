//! Measurement noise and masks.

use crate::options::{Cn0Mask, PpkOptions, RuleSet};
use crate::satellite::System;
use crate::signal::SPEED_OF_LIGHT_M_S;

/// How much noisier than GPS a system's measurements are taken to be.
pub(crate) const fn system_factor(system: System) -> f64 {
    match system {
        System::Glonass => 1.5,
        System::Sbas => 3.0,
        _ => 1.0,
    }
}

/// Variance (m²) of a single difference between rover and base of one satellite's phase or code.
pub(crate) fn single_difference_variance_m2(
    options: &PpkOptions,
    system: System,
    slot: usize,
    is_code: bool,
    elevation_rad: f64,
    baseline_m: f64,
    age_s: f64,
) -> f64 {
    let ratio = if is_code {
        options.code_phase_ratio[slot]
    } else if options.rules == RuleSet::Demo5 {
        options.code_phase_ratio[slot] / options.code_phase_ratio[0]
    } else {
        1.0
    };
    let scale = system_factor(system) * ratio;
    let a = scale * options.phase_error_m;
    let b = scale * options.phase_error_elevation_m / elevation_rad.sin();
    let c = options.phase_error_baseline_m * baseline_m / 1e4;
    let d = SPEED_OF_LIGHT_M_S * options.clock_stability * age_s;
    2.0 * (a * a + b * b + c * c) + d * d
}

/// Whether a signal is below the C/N₀ mask.
pub(crate) fn below_cn0_mask(
    mask: Option<&Cn0Mask>,
    base: bool,
    slot: usize,
    elevation_rad: f64,
    cn0_db_hz: f64,
) -> bool {
    let Some(mask) = mask else { return false };
    if !(if base { mask.base } else { mask.rover }) {
        return false;
    }
    let place = (elevation_rad.to_degrees() - 5.0) / 10.0;
    let values = &mask.least_db_hz[slot];
    let least = if place <= 0.0 {
        values[0]
    } else if place >= 8.0 {
        values[8]
    } else {
        let index = place as usize;
        let share = place - index as f64;
        values[index] * (1.0 - share) + values[index + 1] * share
    };
    cn0_db_hz < least
}
