//! Soil as a medium of propagation.

use crate::error::ImagingError;
use num_complex::Complex64;
use std::f64::consts::PI;

/// Permittivity of vacuum, F/m (CODATA 2018).
pub const VACUUM_PERMITTIVITY_F_M: f64 = 8.854_187_812_8e-12;

/// A homogeneous soil.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Soil {
    /// Real relative permittivity ε′.
    pub relative_permittivity: f64,
    /// Conductivity σ, S/m.
    pub conductivity_s_m: f64,
}

impl Soil {
    /// Complex refractive index √(ε′ − jσ/(2πfε₀)) at a frequency, n − jκ with κ ≥ 0.
    ///
    /// A plane wave decays by e^{−2πfκℓ/c} over a length ℓ (e^{jωt} convention).
    ///
    /// ```
    /// use acerra_imaging::refraction::Soil;
    /// let soil = Soil { relative_permittivity: 9.0, conductivity_s_m: 0.01 };
    /// let index = soil.refractive_index(1e9);
    /// assert!((index.re - 3.0).abs() < 1e-3);
    /// // In a good dielectric the decay is σ/2 · √(µ₀/ε₀)/n at any frequency.
    /// let decay_np_m = std::f64::consts::TAU * 1e9 / 299_792_458.0 * -index.im;
    /// assert!((decay_np_m - 0.5 * 0.01 * 376.73 / 3.0).abs() < 1e-3);
    /// ```
    #[must_use]
    pub fn refractive_index(&self, frequency_hz: f64) -> Complex64 {
        let loss = self.conductivity_s_m / (2.0 * PI * frequency_hz * VACUUM_PERMITTIVITY_F_M);
        // The principal root of a number with a negative imaginary part has a negative imaginary part.
        Complex64::new(self.relative_permittivity, -loss).sqrt()
    }

    /// This soil, if the wave speed in the soil does not exceed the speed in air.
    pub(crate) fn checked(self) -> Result<Self, ImagingError> {
        if !(1.0..=100.0).contains(&self.relative_permittivity) {
            return Err(ImagingError::OutOfRange {
                what: "relative_permittivity",
                expected: "from 1 to 100",
                found: self.relative_permittivity,
            });
        }
        if !(0.0..=10.0).contains(&self.conductivity_s_m) {
            return Err(ImagingError::OutOfRange {
                what: "conductivity_s_m",
                expected: "from 0 to 10 S/m",
                found: self.conductivity_s_m,
            });
        }
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two-way loss over 10 cm from independent figures: 36 dB at 4 GHz for ε = 9 − 1.5j, 3.6 dB for 4 −
    /// 0.1j.
    #[test]
    fn losses_are_those_of_known_soils() {
        let loss_db = |re: f64, im: f64, hz: f64| {
            let soil = Soil {
                relative_permittivity: re,
                conductivity_s_m: im * 2.0 * PI * hz * VACUUM_PERMITTIVITY_F_M,
            };
            let decay = -soil.refractive_index(hz).im * 2.0 * PI * hz / 299_792_458.0;
            2.0 * 0.1 * decay * 20.0 / std::f64::consts::LN_10
        };
        assert!((loss_db(9.0, 1.5, 4e9) - 36.0).abs() < 0.5);
        assert!((loss_db(4.0, 0.1, 4e9) - 3.6).abs() < 0.1);
        assert!((loss_db(9.0, 1.5, 0.5e9) - 4.5).abs() < 0.1);
    }

    #[test]
    fn impossible_soils_are_refused() {
        for (relative_permittivity, conductivity_s_m) in [
            (0.5, 0.0),
            (f64::NAN, 0.0),
            (4.0, -1.0),
            (4.0, f64::INFINITY),
        ] {
            let soil = Soil {
                relative_permittivity,
                conductivity_s_m,
            };
            assert!(soil.checked().is_err());
        }
    }
}
