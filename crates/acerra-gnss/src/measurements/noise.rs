//! Measurement noise and masks.

use crate::observations::satellite::System;
use crate::observations::signal::SPEED_OF_LIGHT_M_S;
use crate::options::{Cn0Mask, PpkOptions};

/// Phase variance of a signal of 0 dB-Hz (m²·Hz), from which it falls with the signal's power: the
/// SIGMA-ε model (Hartinger and Brunner 1999, "Variances of GPS phase observations: the SIGMA-ε
/// model", GPS Solutions 2(4)).
const SIGMA_EPSILON_M2_HZ: f64 = 0.224;

/// Noise factor of a system's measurements relative to GPS.
pub(crate) const fn system_factor(system: System) -> f64 {
    match system {
        System::Glonass => 1.5,
        System::Sbas => 3.0,
        _ => 1.0,
    }
}

/// The parameters of a signal's noise.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SignalView {
    pub system: System,
    pub slot: usize,
    pub is_code: bool,
    pub sin_elevation: f64,
    /// Carrier-to-noise density at rover and base (dB-Hz), 0 where unknown.
    pub cn0_db_hz: [f64; 2],
    /// [`noise_power`] of both densities.
    pub noise_power: [f64; 2],
}

/// Noise over carrier power in one hertz of a carrier-to-noise density (dB-Hz).
pub(crate) fn noise_power(cn0_db_hz: f64) -> f64 {
    10f64.powf(-0.1 * cn0_db_hz)
}

/// Distance and time between rover and base measurements.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Separation {
    pub baseline_m: f64,
    /// Time between the measurements (s), for the receiver clocks' noise.
    pub age_s: f64,
}

impl Separation {
    /// No separation in place and time.
    pub(crate) const NONE: Self = Self {
        baseline_m: 0.0,
        age_s: 0.0,
    };
}

/// Variance (m²) of a single difference between rover and base of one satellite's phase or code.
pub(crate) fn single_difference_variance_m2(
    options: &PpkOptions,
    signal: &SignalView,
    separation: Separation,
) -> f64 {
    single_difference_variances_m2(options, signal, separation)[0]
}

/// The variance of a single difference (m²), and the variance of an equal signal of unknown strength (m²).
pub(crate) fn single_difference_variances_m2(
    options: &PpkOptions,
    signal: &SignalView,
    separation: Separation,
) -> [f64; 2] {
    let &SignalView {
        system,
        slot,
        is_code,
        sin_elevation,
        cn0_db_hz,
        noise_power,
    } = signal;
    let ratio = if is_code {
        options.code_phase_ratio[slot]
    } else {
        options.phase_factor(slot)
    };
    let scale = system_factor(system) * ratio;
    let a = scale * options.phase_error_m;
    let b = scale * options.phase_error_elevation_m / sin_elevation;
    let c = options.phase_error_baseline_m * separation.baseline_m / 1e4;
    let d = SPEED_OF_LIGHT_M_S * options.clock_stability * separation.age_s;
    let by_elevation = a * a + b * b + c * c;
    let of_receiver = |(cn0, power): (f64, f64)| {
        if options.weigh_weak_signals && cn0 > 0.0 {
            by_elevation.max(scale * scale * SIGMA_EPSILON_M2_HZ * power)
        } else {
            by_elevation
        }
    };
    let both = cn0_db_hz.into_iter().zip(noise_power);
    let mut variance = both.map(of_receiver).sum::<f64>() + d * d;
    if options.phase_error_cn0_m > 0.0 {
        let e = scale * options.phase_error_cn0_m;
        for cn0 in cn0_db_hz.into_iter().filter(|&cn0| cn0 > 0.0) {
            let below = (PpkOptions::CN0_REFERENCE_DB_HZ - cn0).max(0.0);
            variance += e * e * 10f64.powf(0.1 * below);
        }
    }
    [variance, by_elevation + by_elevation + d * d]
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
    let values = &mask.min_db_hz[slot];
    let least = if place <= 0.0 {
        values[0]
    } else if place >= 8.0 {
        values[8]
    } else {
        let index = place as usize;
        let share = place - index as f64;
        values[index] * (1.0 - share) + values[index + 1] * share
    };
    // Receivers that do not report the strength of a signal leave it at 0.
    cn0_db_hz > 0.0 && cn0_db_hz < least
}

/// Factor on the variance of a signal that is `drop_db` below its usual strength.
pub(crate) fn weak_signal_factor(options: &PpkOptions, drop_db: f64) -> f64 {
    let Some(free_db) = options.weak_signal_drop_db else {
        return 1.0;
    };
    if drop_db <= free_db {
        return 1.0;
    }
    10f64.powf(0.2 * (drop_db - free_db))
}
