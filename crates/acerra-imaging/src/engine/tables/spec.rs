//! Bin width, degree and error of range tables.

use crate::engine::travel_time::TravelTime;
use crate::pulses::Pulses;
use num_complex::Complex64;

/// Highest polynomial degree.
pub(crate) const MAX_DEGREE: usize = 3;

/// Bins and polynomials of a range table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TableSpec {
    /// Width of a bin, m.
    pub bin_m: f64,
    /// Polynomial degree, 1 to [`MAX_DEGREE`].
    pub degree: usize,
    /// Bins in one period c/(2Δf); `None` where frequencies are uneven.
    pub period: Option<usize>,
    /// Index of the frequency taken as carrier.
    pub carrier: usize,
    /// Coefficients of a bin side by side, for gathers, instead of bins side by side, for windows.
    pub interleaved: bool,
    /// Bins about a bin's centre over which its polynomials are fitted: 1, or more where groups of pixels
    /// go to the bin of their middle.
    pub reach: f64,
}

impl TableSpec {
    /// Two-way carrier phase advance per range bin, α = 2πf_c·b·dτ/dR, rad.
    pub fn carrier_rad(&self, pulses: &Pulses) -> f64 {
        let law = TravelTime::of(pulses);
        law.wavenumber_rad_m(pulses.frequency_hz()[self.carrier]) * self.bin_m
    }

    /// Phase advance per range bin of each frequency relative to the carrier, rad.
    pub fn ramps_rad(&self, pulses: &Pulses) -> Vec<f64> {
        let f = pulses.frequency_hz();
        let law = TravelTime::of(pulses);
        f.iter()
            .map(|v| law.wavenumber_rad_m(v - f[self.carrier]) * self.bin_m)
            .collect()
    }

    /// The polynomials in δ of each frequency's phase ramp e^{jθδ}, δ in bins, over the table's reach.
    pub fn ramp_fits(&self, pulses: &Pulses) -> Vec<[Complex64; MAX_DEGREE + 1]> {
        let inverse = 1.0 / self.reach;
        let fit = |ramp: &f64| {
            let [c0, c1, c2, c3] = fit_phase_ramp(ramp * self.reach, self.degree);
            let square = inverse * inverse;
            [c0, c1 * inverse, c2 * square, c3 * (square * inverse)]
        };
        self.ramps_rad(pulses).iter().map(fit).collect()
    }

    /// Relative RMS error of the polynomials for a spectrum of the given power a frequency.
    pub fn fit_error(&self, pulses: &Pulses, power: &[f64]) -> f64 {
        let mut error = 0.0;
        for (ramp, p) in self.ramps_rad(pulses).iter().zip(power) {
            error += p * ramp_residual(0.5 * ramp * self.reach, self.degree);
        }
        (error / power.iter().sum::<f64>().max(f64::MIN_POSITIVE)).sqrt()
    }

    /// Range from which 1/R² is folded into the bins with relative RMS error below `accuracy`, m.
    pub fn folding_range_m(&self, accuracy: f64) -> f64 {
        // The first power of bin/R that the polynomial drops, times the RMS of its remainder.
        let dropped = [0.0, 3.0 * 0.0745, 4.0 * 0.0189, 5.0 * 0.0048][self.degree];
        self.reach
            * self.bin_m
            * (dropped / accuracy)
                .powf(1.0 / (self.degree + 1) as f64)
                .max(4.0)
    }
}

/// Least-squares monomial coefficients of the phase ramp e^{jθδ} on [−½, ½]; [`ramp_residual`] gives their
/// error.
///
/// With u = 2δ and x = θ/2 the ramp is e^{jxu} = Σ_l (2l + 1) j^l j_l(x) P_l(u), the plane wave's
/// expansion in Legendre polynomials P_l by spherical Bessel functions j_l (Abramowitz and Stegun,
/// 10.1.47); the polynomial of least squares keeps its first terms.
pub(crate) fn fit_phase_ramp(ramp_rad: f64, degree: usize) -> [Complex64; MAX_DEGREE + 1] {
    let x = 0.5 * ramp_rad;
    let [a0, a1, a2, a3]: [Complex64; MAX_DEGREE + 1] = std::array::from_fn(|l| {
        if l > degree {
            return Complex64::ZERO;
        }
        let size = (2 * l + 1) as f64 * spherical_bessel(l, x);
        Complex64::I.powu(l as u32) * size
    });
    [a0 - a2 * 0.5, a1 * 2.0 - a3 * 3.0, a2 * 6.0, a3 * 20.0]
}

/// Mean square error of the least-squares polynomial of degree `degree` for e^{jxu} on [−1, 1]: Σ_{l >
/// degree} (2l + 1) j_l(x)², all terms together being 1.
fn ramp_residual(x: f64, degree: usize) -> f64 {
    let x = x.abs();
    if x > SERIES_BELOW {
        let term = |l: usize| (2 * l + 1) as f64 * spherical_bessel(l, x).powi(2);
        return (1.0 - (0..=degree).map(term).sum::<f64>()).max(0.0);
    }
    // Summed from its first term: a difference from 1 would lose residuals below 1e-16.
    if x < RECURRENCE_ABOVE {
        let l = degree + 1;
        return (2 * l + 1) as f64 * spherical_bessel(l, x).powi(2);
    }
    // Downward recurrence (Miller's algorithm; Abramowitz and Stegun, 10.5), scaled by j_0 = sin x/x.
    let mut bessel = [0.0; RECURRENCE_FROM + 2];
    bessel[RECURRENCE_FROM] = 1e-200;
    let inverse = 1.0 / x;
    for l in (1..=RECURRENCE_FROM).rev() {
        bessel[l - 1] = (2 * l + 1) as f64 * inverse * bessel[l] - bessel[l + 1];
    }
    let scale = x.sin() * inverse / bessel[0];
    let term = |l: usize| (2 * l + 1) as f64 * (bessel[l] * scale).powi(2);
    (degree + 1..RECURRENCE_FROM).rev().map(term).sum()
}

/// Arguments from which [`ramp_residual`] sums by recurrence: below, the first term is all of the sum to
/// eight digits and the recurrence would overflow.
const RECURRENCE_ABOVE: f64 = 1e-4;
/// Order at which the downward recurrence starts: the error relative to j_4(3) is below 1e-20.
const RECURRENCE_FROM: usize = 20;

/// Arguments up to which the power series of j_l keeps ten digits.
const SERIES_BELOW: f64 = 3.0;

/// The spherical Bessel function j_l(x) of the first kind: by its power series (Abramowitz and Stegun,
/// 10.1.2) at small arguments, by upward recurrence (10.1.19) above, where only l ≤ 3 is needed.
fn spherical_bessel(l: usize, x: f64) -> f64 {
    if x.abs() > SERIES_BELOW {
        let (mut before, mut here) = (x.cos() / x, x.sin() / x);
        for k in 0..l {
            (before, here) = (here, (2 * k + 1) as f64 / x * here - before);
        }
        return here;
    }
    let mut term = (1..=l).fold(1.0, |t, k| t * x / (2 * k + 1) as f64);
    let (mut sum, square) = (term, -0.5 * x * x);
    for k in 1..40 {
        term *= square / (k * (2 * (l + k) + 1)) as f64;
        sum += term;
        if term.abs() <= 1e-17 * sum.abs() {
            break;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Midpoint sums over many points.
    fn residual_by_sums(ramp_rad: f64, monomial: &[Complex64; 4]) -> f64 {
        let count = 20_000;
        (0..count)
            .map(|k| {
                let delta = (f64::from(k) + 0.5) / f64::from(count) - 0.5;
                let fit = monomial
                    .iter()
                    .rev()
                    .fold(Complex64::ZERO, |sum, c| sum * delta + c);
                (Complex64::cis(ramp_rad * delta) - fit).norm_sqr()
            })
            .sum::<f64>()
            / f64::from(count)
    }

    #[test]
    fn the_residual_is_that_of_the_polynomial() {
        for degree in 0..=MAX_DEGREE {
            for ramp_rad in [-9.0, -0.3, 0.02, 0.4, 1.7, 5.99, 6.01, 12.0] {
                let monomial = fit_phase_ramp(ramp_rad, degree);
                let residual = ramp_residual(0.5 * ramp_rad, degree);
                let expected = residual_by_sums(ramp_rad, &monomial);
                assert!(
                    (residual - expected).abs() < 1e-6 * expected + 1e-17,
                    "{degree} {ramp_rad}: {residual:e} for {expected:e}"
                );
            }
        }
    }

    #[test]
    fn no_other_polynomial_leaves_less() {
        let monomial = fit_phase_ramp(1.3, 2);
        let residual = ramp_residual(0.65, 2);
        for k in 0..3 {
            for step in [Complex64::new(1e-3, 0.0), Complex64::new(0.0, -1e-3)] {
                let mut other = monomial;
                other[k] += step;
                assert!(residual_by_sums(1.3, &other) > residual);
            }
        }
    }

    /// Residuals below the rounding error of 1 are compared with the sum of power series.
    #[test]
    fn small_residuals_keep_their_digits() {
        for degree in 0..=MAX_DEGREE {
            for x in [1e-7, 0.99e-4, 1.01e-4, 3e-3, 0.1, 1.0, 2.99] {
                let term = |l: usize| (2 * l + 1) as f64 * spherical_bessel(l, x).powi(2);
                let expected: f64 = (degree + 1..30).map(term).sum();
                let found = ramp_residual(x, degree);
                assert!(
                    (found / expected - 1.0).abs() < 1e-8,
                    "{degree} {x}: {found:e} for {expected:e}"
                );
            }
        }
    }

    #[test]
    fn a_ramp_of_zero_leaves_nothing() {
        assert_eq!(ramp_residual(0.0, 1), 0.0);
        assert_eq!(
            fit_phase_ramp(0.0, 1),
            [
                Complex64::ONE,
                Complex64::ZERO,
                Complex64::ZERO,
                Complex64::ZERO
            ]
        );
    }
}
