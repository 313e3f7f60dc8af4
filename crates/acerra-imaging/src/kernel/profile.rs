//! Range profiles in double precision: Σ_n E_n z^n of evenly spaced frequencies, z = e^{jΔ}.
//!
//! The sum is divided into [`CHAINS`] polynomials of every so-manieth term in powers of z to the number
//! of chains, whose steps of Horner's scheme do not wait for each other.

use super::dispatch::dispatch;
use super::lanes::Lanes;
use super::level::SimdLevel;
use num_complex::Complex64;

/// Polynomials side by side.
const CHAINS: usize = 16;

/// Σ_n `spectrum[n]` e^{jn·`step_rad`}, to about a rounding error a term.
pub(crate) fn even_sum(level: SimdLevel, spectrum: &[Complex64], step_rad: f64) -> Complex64 {
    dispatch!(level, s => chains(s, spectrum, step_rad))
}

/// The same in vectors that the compiler makes for the level of `_s`.
#[inline(always)]
fn chains<S: Lanes>(_s: S, spectrum: &[Complex64], step_rad: f64) -> Complex64 {
    let advance = Complex64::cis(CHAINS as f64 * step_rad);
    let (whole, rest) = spectrum.split_at(spectrum.len() / CHAINS * CHAINS);
    let (mut re, mut im) = ([0f64; CHAINS], [0f64; CHAINS]);
    for ((re, im), e) in re.iter_mut().zip(&mut im).zip(rest) {
        (*re, *im) = (e.re, e.im);
    }
    let (cosine, sine) = (advance.re, advance.im);
    for piece in whole.rchunks_exact(CHAINS) {
        let mut next = [[0f64; CHAINS]; 2];
        for k in 0..CHAINS {
            next[0][k] = re[k] * cosine - im[k] * sine + piece[k].re;
            next[1][k] = re[k] * sine + im[k] * cosine + piece[k].im;
        }
        [re, im] = next;
    }
    let step = Complex64::cis(step_rad);
    let mut sum = Complex64::ZERO;
    for (re, im) in re.into_iter().zip(im).rev() {
        sum = sum * step + Complex64::new(re, im);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_level_sums_any_number_of_terms() {
        for &level in SimdLevel::available() {
            for n in [0, 1, 15, 16, 17, 213, 1000] {
                let spectrum: Vec<_> = (0..n)
                    .map(|k| Complex64::new((0.7 * f64::from(k)).sin(), (0.3 * f64::from(k)).cos()))
                    .collect();
                let size: f64 = spectrum.iter().map(|e| e.norm()).sum();
                for step_rad in [0.0, 1e-3, 0.8, -3.1, 40.0] {
                    let expected: Complex64 = spectrum
                        .iter()
                        .enumerate()
                        .map(|(k, e)| e * Complex64::cis(k as f64 * step_rad))
                        .sum();
                    let found = even_sum(level, &spectrum, step_rad);
                    assert!((found - expected).norm() <= 1e-12 * size.max(1.0));
                }
            }
        }
    }
}
