//! Power, noise, coupling, quantisation: from field strengths to the integers of a log.

use rand_chacha::ChaCha8Rng;

use super::model::RadarModel;
use super::scatter::{Echo, SPEED_OF_LIGHT_M_S};
use crate::flight::normal;

/// Thermal noise power of 1 Hz at 290 K (dBm).
const NOISE_DBM_HZ: f64 = -173.98;

/// The radio's receiver.
#[derive(Clone, Debug)]
pub struct Receiver {
    noise_counts: f64,
    full_scale_counts: f64,
    /// Counts of an echo of strength 1 (√RCS/R² = 1/m).
    counts_per_strength: f64,
    coupling: Vec<Echo>,
}

impl Receiver {
    /// The receiver of `radar`, by the radar equation
    /// P_r = P_t G² λ² σ / ((4π)³ R⁴), noise kTBF, 2^PII pulses integrated.
    #[must_use]
    pub fn new(radar: &RadarModel) -> Self {
        let [low, high] = radar.band_ghz.map(|f| f * 1e9);
        let wavelength_m = SPEED_OF_LIGHT_M_S / (0.5 * (low + high));
        let noise_dbm = noise_power_dbm(radar);
        let received_dbm =
            radar.transmit_power_dbm + 2.0 * radar.antenna_gain_dbi + 20.0 * wavelength_m.log10()
                - 30.0 * (4.0 * std::f64::consts::PI).log10();
        // A sine of power P has an amplitude of √(2P).
        let counts = |power_dbm: f64| {
            radar.noise_counts.max(1e-3)
                * (2.0 * 10.0_f64.powf(0.1 * (power_dbm - noise_dbm))).sqrt()
        };
        let counts_per_strength = counts(received_dbm);
        let direct = counts(radar.transmit_power_dbm - radar.coupling_db) / counts_per_strength;
        // Antenna to antenna, then a ringing that dies away within some nanoseconds.
        let coupling = (0..8_u8)
            .map(|k| {
                let k = f64::from(k);
                Echo {
                    delay_s: (0.5 + 0.62 * k) * 1e-9,
                    strength: direct * (-0.7 * k).exp(),
                    phase_rad: 0.9 * k * k,
                }
            })
            .collect();
        Self {
            noise_counts: radar.noise_counts,
            full_scale_counts: radar.noise_counts.max(1.0)
                * 10.0_f64.powf(0.05 * radar.dynamic_range_db),
            counts_per_strength,
            coupling,
        }
    }

    /// The coupling, as echoes.
    #[must_use]
    pub fn coupling(&self) -> &[Echo] {
        &self.coupling
    }

    /// Counts of an echo of strength 1 (√RCS/R² = 1/m).
    #[must_use]
    pub fn counts_per_strength(&self) -> f64 {
        self.counts_per_strength
    }

    /// Adds noise to a record of strengths, scales it to counts, clips and rounds.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "clipped to full scale first"
    )]
    pub fn quantise(&self, record: &[f64], rng: &mut ChaCha8Rng) -> Vec<i32> {
        record
            .iter()
            .map(|strength| {
                let counts = strength * self.counts_per_strength + self.noise_counts * normal(rng);
                counts
                    .clamp(-self.full_scale_counts, self.full_scale_counts)
                    .round() as i32
            })
            .collect()
    }
}

/// Noise power within the band after integration (dBm).
#[must_use]
pub fn noise_power_dbm(radar: &RadarModel) -> f64 {
    let bandwidth_hz = 1e9 * (radar.band_ghz[1] - radar.band_ghz[0]);
    NOISE_DBM_HZ + 10.0 * bandwidth_hz.log10() + radar.noise_figure_db
        - 10.0 * f64::from(radar.integration_index) * 2.0_f64.log10()
}
