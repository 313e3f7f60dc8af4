//! Errors of a table's polynomials for many widths of bins, from moments of the spectrum's power.
//!
//! The least-squares polynomial of degree L for e^{jxu}, u in [−1, 1], has the mean square error Σ_{l > L}
//! (2l + 1) j_l(x)², and j_l(x)² = Σ_k a_{l,k} x^{2(l + k)} with a_{l,0} = 1/((2l + 1)!!)² (Abramowitz and
//! Stegun, 10.1.2 and 9.1.14). The mean over frequencies of powers p_n and phases x_n = X·y_n is then a power
//! series in X² whose coefficients are the moments Σ p_n y_n^{2j}.

use super::spec::{MAX_DEGREE, TableSpec};
use crate::engine::travel_time::TravelTime;
use crate::pulses::Pulses;

/// Powers of X² that are kept.
const POWERS: usize = 20;
/// Largest X for which the powers kept give ten digits.
const SERIES_BELOW: f64 = 1.2;

/// Relative RMS errors of tables for one spectrum.
pub(crate) struct FitErrors<'a> {
    pulses: &'a Pulses<'a>,
    power: &'a [f64],
    /// Index of the frequency that tables take as carrier: the one nearest to the middle.
    pub carrier: usize,
    /// Greatest distance of a frequency from the carrier, Hz.
    widest_hz: f64,
    /// Σ p_n y_n^{2j}/Σ p_n, y_n being the distance from the carrier relative to the greatest.
    moments: [f64; POWERS],
}

impl<'a> FitErrors<'a> {
    /// Errors for data whose power at each frequency is `power` `[N]`; `None` without frequencies.
    pub fn new(pulses: &'a Pulses<'a>, power: &'a [f64]) -> Option<Self> {
        let f = pulses.frequency_hz();
        let lowest = f.iter().copied().fold(f64::INFINITY, f64::min);
        let middle = 0.5 * (lowest + f.iter().copied().fold(0.0, f64::max));
        let distance = |k: usize| (f[k] - middle).abs();
        let carrier = (0..f.len()).min_by(|a, b| distance(*a).total_cmp(&distance(*b)))?;
        let from_carrier = f.iter().map(|v| (v - f[carrier]).abs());
        let widest_hz = from_carrier.clone().fold(0.0, f64::max);
        let mut moments = [0.0; POWERS];
        for (from_carrier, p) in from_carrier.zip(power) {
            let square = (from_carrier / widest_hz.max(f64::MIN_POSITIVE)).powi(2);
            let mut term = *p;
            for moment in &mut moments {
                *moment += term;
                term *= square;
            }
        }
        let total = moments[0].max(f64::MIN_POSITIVE);
        Some(Self {
            pulses,
            power,
            carrier,
            widest_hz,
            moments: moments.map(|moment| moment / total),
        })
    }

    /// [`TableSpec::fit_error`] of a table with the carrier of these frequencies.
    pub fn of(&self, spec: &TableSpec) -> f64 {
        let wavenumber = TravelTime::of(self.pulses).wavenumber_rad_m(self.widest_hz);
        let x = 0.5 * wavenumber * spec.bin_m * spec.reach;
        if x > SERIES_BELOW || spec.carrier != self.carrier {
            return spec.fit_error(self.pulses, self.power);
        }
        let square = x * x;
        let series = coefficients(spec.degree);
        let terms = series.iter().zip(&self.moments).rev();
        terms
            .fold(0.0, |sum, (c, moment)| sum * square + c * moment)
            .max(0.0)
            .sqrt()
    }
}

/// Coefficients of the powers of x² in Σ_{l > degree} (2l + 1) j_l(x)².
fn coefficients(degree: usize) -> &'static [f64; POWERS] {
    static OF_DEGREES: [[f64; POWERS]; MAX_DEGREE + 1] = {
        let mut of_degrees = [[0.0; POWERS]; MAX_DEGREE + 1];
        let mut l = POWERS;
        while l > 0 {
            l -= 1;
            let squares = square_of_bessel(l);
            let mut degree = 0;
            while degree <= MAX_DEGREE && degree < l {
                let mut j = l;
                while j < POWERS {
                    of_degrees[degree][j] += (2 * l + 1) as f64 * squares[j];
                    j += 1;
                }
                degree += 1;
            }
        }
        of_degrees
    };
    &OF_DEGREES[degree]
}

/// Coefficients of the powers of x² in j_l(x)².
const fn square_of_bessel(l: usize) -> [f64; POWERS] {
    let mut first = 1.0;
    let mut k = 1;
    while k <= l {
        first /= ((2 * k + 1) * (2 * k + 1)) as f64;
        k += 1;
    }
    let mut of_powers = [0.0; POWERS];
    let mut a = first;
    let mut k = 0;
    while l + k < POWERS {
        of_powers[l + k] = a;
        let below = (k + 1) * (2 * l + k + 2) * (2 * l + 2 * k + 3);
        a *= -((2 * l + 2 * k + 2) as f64) / below as f64;
        k += 1;
    }
    of_powers
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pulses::PulseArrays;
    use num_complex::Complex64;

    #[test]
    fn the_series_is_the_sum_over_frequencies() {
        let frequency_hz: Vec<f64> = (0..213).map(|n| 3.1e9 + 8e6 * f64::from(n)).collect();
        let spectrum = vec![Complex64::ONE; 213];
        let pulses = Pulses::new(PulseArrays {
            position_m: &[[0.0; 3]],
            frequency_hz: &frequency_hz,
            spectrum: &spectrum,
            weight: &[1.0],
            light_speed_m_s: 3e8,
        })
        .unwrap();
        let even = vec![1.0; 213];
        let hann: Vec<f64> = (0..213)
            .map(|n| (std::f64::consts::PI * f64::from(n) / 212.0).sin().powi(4))
            .collect();
        for power in [even, hann] {
            let errors = FitErrors::new(&pulses, &power).unwrap();
            assert_eq!(errors.carrier, 106);
            for degree in 1..=3 {
                for bin_m in [1e-3, 5e-3, 0.01, 0.02, 0.05, 0.06, 0.07, 0.2] {
                    let spec = TableSpec {
                        bin_m,
                        degree,
                        period: None,
                        carrier: errors.carrier,
                        interleaved: false,
                        reach: 1.0,
                    };
                    let expected = spec.fit_error(&pulses, &power);
                    let found = errors.of(&spec);
                    assert!(
                        (found / expected - 1.0).abs() < 1e-9,
                        "degree {degree}, bins of {bin_m} m: {found:e} for {expected:e}"
                    );
                }
            }
        }
    }
}
