//! Range profiles in double precision: Σ_n E_n e^{j2πf_nτ} of evenly spaced frequencies, at several delays τ
//! side by side.
//!
//! The sum is divided into polynomials of every COUNT-th term in a power of z = e^{j2πΔfτ}, whose steps of
//! Horner's scheme do not wait for each other; they are then joined as a polynomial in z.

use super::dispatch::dispatch;
use super::lanes::{DOUBLES, Lanes};
use super::level::SimdLevel;
use super::phasor::{Phasors, phasors};
use num_complex::Complex64;

/// Delays side by side.
pub(crate) const DELAYS: usize = DOUBLES;

/// Σ_n `spectrum[n]` e^{j2π(`start_hz` + n·`step_hz`)τ} for every delay τ (s), to about a rounding error a
/// term.
pub(crate) fn even_sums(
    level: SimdLevel,
    spectrum: &[Complex64],
    [start_hz, step_hz]: [f64; 2],
    delays_s: &[f64; DELAYS],
) -> [Complex64; DELAYS] {
    dispatch!(level, s => sums(s, spectrum, [start_hz, step_hz], delays_s))
}

/// As [`even_sums`], compiled for the level of `s`, with as many polynomials as the registers hold.
#[inline(always)]
fn sums<S: Lanes>(
    s: S,
    spectrum: &[Complex64],
    [start_hz, step_hz]: [f64; 2],
    delays_s: &[f64; DELAYS],
) -> [Complex64; DELAYS] {
    let z = phasors_of(s, step_hz, delays_s);
    let sum = if S::N > 8 {
        polynomials::<S, 4>(s, spectrum, z)
    } else {
        polynomials::<S, 2>(s, spectrum, z)
    };
    sum.times(s, phasors_of(s, start_hz, delays_s)).numbers(s)
}

/// e^{j2πfτ} of one frequency.
#[inline(always)]
fn phasors_of<S: Lanes>(s: S, frequency_hz: f64, delays_s: &[f64; DELAYS]) -> Phasors<S> {
    let mut turns = *delays_s;
    for turns in &mut turns {
        *turns *= frequency_hz;
    }
    phasors(s, turns)
}

/// Σ_n `spectrum[n]` zⁿ by COUNT polynomials, a power of two.
#[inline(always)]
fn polynomials<S: Lanes, const COUNT: usize>(
    s: S,
    spectrum: &[Complex64],
    z: Phasors<S>,
) -> Phasors<S> {
    let mut advance = z;
    for _ in 0..COUNT.ilog2() {
        advance = advance.times(s, advance);
    }
    let (whole, rest) = spectrum.split_at(spectrum.len() / COUNT * COUNT);
    let mut sums = [Phasors::splat(s, Complex64::ZERO); COUNT];
    for (sum, e) in sums.iter_mut().zip(rest) {
        *sum = Phasors::splat(s, *e);
    }
    for piece in whole.rchunks_exact(COUNT) {
        for k in 0..COUNT {
            sums[k] = sums[k].times_add(s, advance, Phasors::splat(s, piece[k]));
        }
    }
    let mut sum = sums[COUNT - 1];
    for k in (0..COUNT - 1).rev() {
        sum = sum.times_add(s, z, sums[k]);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_level_sums_any_number_of_terms() {
        let delays_s = [0.0, 1e-9, 2.1e-8, 6.667e-8, 3.3e-7, 1e-6, 2e-5, -4e-8];
        let (start_hz, step_hz) = (3.1e9, 8e6);
        for &level in SimdLevel::available() {
            for n in [0, 1, 2, 3, 4, 5, 16, 213, 1000] {
                let spectrum: Vec<_> = (0..n)
                    .map(|k| Complex64::new((0.7 * f64::from(k)).sin(), (0.3 * f64::from(k)).cos()))
                    .collect();
                let size: f64 = spectrum.iter().map(|e| e.norm()).sum();
                let found = even_sums(level, &spectrum, [start_hz, step_hz], &delays_s);
                for (tau, found) in delays_s.iter().zip(found) {
                    let phase = |k: usize| (start_hz + step_hz * k as f64) * tau;
                    let expected: Complex64 = spectrum
                        .iter()
                        .enumerate()
                        .map(|(k, e)| e * Complex64::cis(std::f64::consts::TAU * phase(k)))
                        .sum();
                    // Turns are rounded to 1e-16 of themselves.
                    let tolerance = 1e-12 + 1e-15 * phase(n as usize).abs() * 6.3;
                    assert!(
                        (found - expected).norm() <= tolerance * size.max(1.0),
                        "{level:?}, {n} terms, {tau} s: {found} for {expected}"
                    );
                }
            }
        }
    }
}
