//! The noise of data, measured at ranges that no pixel and no ground can answer from.

use crate::error::{InvertError, check_length};
use crate::flight::Flight;
use acerra_imaging::Complex64;
use std::f64::consts::{LN_2, PI, TAU};

/// The noise measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseLevel {
    /// Standard deviation σ of a datum d(m, n) (complex, unweighted), were the noise white over all
    /// fast time as it is in the quiet ranges.
    pub sigma: f64,
    /// Range cells used in the estimate.
    pub cells: usize,
    /// Pulses used in the estimate.
    pub pulses: usize,
}

/// Fewest range cells from which a level is estimated.
const LEAST_CELLS: usize = 64;

/// Measures the noise in the quiet ranges `[near, far]` (m) of each pulse, empty where near ≥ far.
///
/// Range profiles are formed with a Hann window over the band, so that the sidelobes of strong echoes
/// beyond the quiet ranges fall off; the mean power of exponentially distributed values is their median
/// over ln 2, which a few echoes do not move. What sidelobes remain make the level an upper bound.
/// `None` where fewer than 64 range cells are quiet.
///
/// # Errors
/// Arrays of other lengths than the flight's.
pub fn measure_noise(
    flight: &Flight,
    spectrum: &[Complex64],
    quiet_m: &[[f64; 2]],
) -> Result<Option<NoiseLevel>, InvertError> {
    check_length("spectrum", flight.samples(), spectrum.len())?;
    check_length("quiet_m", flight.position_m().len(), quiet_m.len())?;
    let f = flight.frequency_hz();
    let count = f.len();
    let (low_hz, high_hz) = flight.spread().band_hz();
    if count < 8 || high_hz <= low_hz {
        return Ok(None);
    }
    let window: Vec<f64> = (0..count)
        .map(|n| 0.5 - 0.5 * (TAU * (n as f64 + 0.5) / count as f64).cos())
        .collect();
    let gain: f64 = window.iter().map(|w| w * w).sum();
    // A cell of the windowed profile is twice as wide as one of the band.
    let cell_m = flight.light_speed_m_s() / (high_hz - low_hz);
    let mut powers = Vec::new();
    let mut pulses = 0;
    for ((row, [near_m, far_m]), root) in spectrum
        .chunks(count)
        .zip(quiet_m)
        .zip(flight.root_weight())
    {
        let cells = ((far_m - near_m) / cell_m).floor();
        if *root <= 0.0 || !(1.0..1e5).contains(&cells) {
            continue;
        }
        pulses += 1;
        for k in 0..cells as usize {
            let range_m = near_m + (k as f64 + 0.5) * cell_m;
            let delay = 4.0 * PI * range_m / flight.light_speed_m_s();
            let profile: Complex64 = row
                .iter()
                .zip(f)
                .zip(&window)
                .map(|((e, f), w)| e * Complex64::cis(f * delay) * *w)
                .sum();
            powers.push(profile.norm_sqr() / gain);
        }
    }
    if powers.len() < LEAST_CELLS {
        return Ok(None);
    }
    let middle = powers.len() / 2;
    let (_, median, _) = powers.select_nth_unstable_by(middle, f64::total_cmp);
    let power = *median / LN_2;
    Ok((power > 0.0).then(|| NoiseLevel {
        sigma: power.sqrt(),
        cells: powers.len(),
        pulses,
    }))
}

impl NoiseLevel {
    /// ‖noise‖ in weighted data of which the share `held` of the unambiguous fast time is kept, the rest
    /// being zero.
    #[must_use]
    pub fn norm(&self, flight: &Flight, held: f64) -> f64 {
        let weights: f64 = flight.root_weight().iter().map(|root| root * root).sum();
        self.sigma * (weights * flight.frequency_hz().len() as f64 * held.clamp(0.0, 1.0)).sqrt()
    }

    /// Standard deviation of ⟨Lᵢ, noise⟩/‖Lᵢ‖ over pixels, as a root mean square.
    #[must_use]
    pub fn correlated(&self, flight: &Flight) -> f64 {
        let root = flight.root_weight();
        let (sum2, sum4) = root.iter().fold((0.0, 0.0), |(sum2, sum4), r| {
            (sum2 + r * r, sum4 + r.powi(4))
        });
        if sum2 > 0.0 {
            self.sigma * (sum4 / sum2).sqrt()
        } else {
            self.sigma
        }
    }
}
