//! Unit phasors in double precision, several side by side.

use super::lanes::{DOUBLES, Lanes};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Complex numbers side by side.
#[derive(Clone, Copy)]
pub(crate) struct Phasors<S: Lanes> {
    pub re: S::Doubles,
    pub im: S::Doubles,
}

impl<S: Lanes> Phasors<S> {
    /// The number in every place.
    #[inline(always)]
    pub fn splat(s: S, z: Complex64) -> Self {
        Self {
            re: s.splat_f64(z.re),
            im: s.splat_f64(z.im),
        }
    }

    /// `self`·z + c, place by place.
    #[inline(always)]
    pub fn times_add(self, s: S, z: Self, c: Self) -> Self {
        let re = s.neg_mul_add_f64(self.im, z.im, c.re);
        let im = s.mul_add_f64(self.im, z.re, c.im);
        Self {
            re: s.mul_add_f64(self.re, z.re, re),
            im: s.mul_add_f64(self.re, z.im, im),
        }
    }

    /// `self`·z, place by place.
    #[inline(always)]
    pub fn times(self, s: S, z: Self) -> Self {
        self.times_add(s, z, Self::splat(s, Complex64::ZERO))
    }

    /// The numbers one by one.
    #[inline(always)]
    pub fn numbers(self, s: S) -> [Complex64; DOUBLES] {
        let (re, im) = (s.store_f64(self.re), s.store_f64(self.im));
        std::array::from_fn(
            #[inline(always)]
            |k| Complex64::new(re[k], im[k]),
        )
    }
}

/// Adding this to |t| < 2⁵¹ rounds t to a whole number, which then is in the low mantissa bits.
const ROUNDING: f64 = 6_755_399_441_055_744.0; // 1.5 · 2⁵²

/// Taylor coefficients of sin x/x and cos x in x², to below a rounding error for |x| ≤ π/4.
const SINE: [f64; 9] = reciprocal_factorials(1);
const COSINE: [f64; 9] = reciprocal_factorials(0);

/// (−1)^k/(2k + `odd`)!
const fn reciprocal_factorials(odd: usize) -> [f64; 9] {
    let mut c = [1.0; 9];
    let mut k = 1;
    while k < 9 {
        c[k] = -c[k - 1] / ((2 * k + odd) * (2 * k + odd - 1)) as f64;
        k += 1;
    }
    c
}

/// A power series of nine terms.
#[inline(always)]
fn series<S: Lanes>(s: S, x: S::Doubles, coefficients: &[f64; 9]) -> S::Doubles {
    let mut sum = s.splat_f64(coefficients[8]);
    for n in (0..8).rev() {
        sum = s.mul_add_f64(sum, x, s.splat_f64(coefficients[n]));
    }
    sum
}

/// e^{j2πt} for t in turns, |t| < 2⁴⁹, to about two rounding errors in addition to the rounding of t itself.
#[inline(always)]
pub(crate) fn phasors<S: Lanes>(s: S, turns: [f64; DOUBLES]) -> Phasors<S> {
    let mut quarters = [0u64; DOUBLES];
    let mut x = [0.0; DOUBLES];
    for (k, turns) in turns.into_iter().enumerate() {
        let rounded = turns * 4.0 + ROUNDING;
        quarters[k] = rounded.to_bits();
        // Exact: both are multiples of the last place of t or of a quarter.
        x[k] = (turns - 0.25 * (rounded - ROUNDING)) * TAU;
    }
    let mut squares = x;
    for (square, x) in squares.iter_mut().zip(x) {
        *square = x * x;
    }
    let squares = s.load_f64(squares);
    let sine = s.store_f64(series(s, squares, &SINE));
    let cosine = s.store_f64(series(s, squares, &COSINE));
    let (mut re, mut im) = ([0.0; DOUBLES], [0.0; DOUBLES]);
    for k in 0..DOUBLES {
        let (sine, cosine, quarter) = (sine[k] * x[k], cosine[k], quarters[k]);
        let is_odd = quarter & 1 == 1;
        let turned_re = if is_odd { sine } else { cosine };
        let turned_im = if is_odd { cosine } else { sine };
        // The real part is negative in quarters 1 and 2, the imaginary part in 2 and 3.
        let re_sign = (quarter.wrapping_add(1) & 2) << 62;
        let im_sign = (quarter & 2) << 62;
        re[k] = f64::from_bits(turned_re.to_bits() ^ re_sign);
        im[k] = f64::from_bits(turned_im.to_bits() ^ im_sign);
    }
    Phasors {
        re: s.load_f64(re),
        im: s.load_f64(im),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::dispatch::dispatch;
    use crate::kernel::level::SimdLevel;

    #[test]
    fn phasors_are_exact_at_every_level() {
        // Eighths and their neighbours, both signs, and turns of long ranges.
        let mut turns: Vec<f64> = (-40..=40).map(|k| f64::from(k) / 8.0).collect();
        turns.extend((-400..=400).map(|k| f64::from(k) * 0.0137));
        turns.extend((0..400).map(|k| 6.2e4 + f64::from(k) * 0.371));
        for &level in SimdLevel::available() {
            for some in turns.chunks_exact(DOUBLES) {
                let some: [f64; DOUBLES] = some.try_into().unwrap();
                let found = dispatch!(level, s => phasors(s, some).numbers(s));
                for (k, turns) in some.into_iter().enumerate() {
                    // The fraction of a turn is exact.
                    let part = turns - turns.round();
                    let expected = Complex64::cis(TAU * part);
                    let found = found[k];
                    assert!(
                        (found - expected).norm() < 6e-16,
                        "{level:?}: {turns} {found} for {expected}"
                    );
                }
            }
        }
    }
}
