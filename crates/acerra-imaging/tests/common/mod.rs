//! What the tests of the engines share.

#![allow(dead_code, clippy::unwrap_used)] // not every test uses everything

use acerra_imaging::{Complex64, PulseArrays, Pulses, Spreading, reference};

/// Speed of light, m/s.
pub const C: f64 = acerra_imaging::SPEED_OF_LIGHT_M_S;

/// Reproducible numbers in (−1, 1).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 11) as f64) / (1u64 << 52) as f64 - 1.0
    }
    pub fn complex(&mut self) -> Complex64 {
        Complex64::new(self.next(), self.next())
    }
}

/// Positions, frequencies and noisy echoes of random targets.
pub struct Campaign {
    pub position_m: Vec<[f64; 3]>,
    pub frequency_hz: Vec<f64>,
    pub spectrum: Vec<Complex64>,
    pub weight: Vec<f64>,
}

impl Campaign {
    pub fn new(
        position_m: Vec<[f64; 3]>,
        frequency_hz: Vec<f64>,
        scene: &[[f64; 3]],
        seed: u64,
    ) -> Self {
        let mut random = Random(seed);
        let scatterers: Vec<_> = scene
            .iter()
            .map(|&position_m| reference::Scatterer {
                position_m,
                reflectivity: random.complex(),
            })
            .collect();
        let mut campaign = Self::quiet(position_m, frequency_hz, &scatterers);
        let spectrum = &mut campaign.spectrum;
        let rms =
            (spectrum.iter().map(|e| e.norm_sqr()).sum::<f64>() / spectrum.len() as f64).sqrt();
        for e in spectrum {
            *e += random.complex() * (0.3 * rms.max(1e-9));
        }
        for w in &mut campaign.weight {
            *w = 1.0 + 0.3 * random.next();
        }
        campaign
    }

    /// The echoes of `scene` alone, every pulse weighing 1.
    pub fn quiet(
        position_m: Vec<[f64; 3]>,
        frequency_hz: Vec<f64>,
        scene: &[reference::Scatterer],
    ) -> Self {
        let spreading = Spreading::InverseSquare;
        let spectrum = reference::forward(&position_m, &frequency_hz, scene, C, spreading).unwrap();
        Self {
            weight: vec![1.0; position_m.len()],
            position_m,
            frequency_hz,
            spectrum,
        }
    }

    pub fn pulses(&self) -> Pulses<'_> {
        Pulses::new(PulseArrays {
            position_m: &self.position_m,
            frequency_hz: &self.frequency_hz,
            spectrum: &self.spectrum,
            weight: &self.weight,
            light_speed_m_s: C,
        })
        .unwrap()
    }

    /// Positions scattered about [0, 0, height], targets in and far outside the patch.
    pub fn random(range_m: f64, pulses: usize, frequency_hz: Vec<f64>, seed: u64) -> Self {
        let mut r = Random(seed);
        let position: Vec<_> = (0..pulses)
            .map(|_| {
                [
                    -0.6 * range_m + r.next(),
                    2.0 * r.next(),
                    0.8 * range_m + 0.3 * r.next(),
                ]
            })
            .collect();
        let scene: Vec<_> = (0..12)
            .map(|k| {
                // A third of them beyond the unambiguous range.
                let far = if k % 3 == 0 { 40.0 } else { 0.6 };
                [far * r.next(), far * r.next(), 0.2 * r.next()]
            })
            .collect();
        Self::new(position, frequency_hz, &scene, seed ^ 77)
    }
}

/// `n` even frequencies over 3.1–4.8 GHz.
pub fn band(n: usize) -> Vec<f64> {
    (0..n)
        .map(|k| 3.1e9 + 1.7e9 * k as f64 / (n - 1) as f64)
        .collect()
}

/// Makes one test a level: `name(level)` at all levels of this processor.
#[allow(unused_macros)]
macro_rules! at_every_level {
    ($($name:ident),* $(,)?) => {
        mod every_level {
            $(#[test] fn $name() {
                for &level in acerra_imaging::SimdLevel::available() {
                    super::$name(level);
                }
            })*
        }
    };
}
