//! Powers of the ratio of two cosines, vector by vector.

use super::lanes::Lanes;

/// Number of successive square roots of the ratio for a power that is not whole: ρ^(1/32) of a ratio between
/// 10⁻⁴ and 10⁴ lies between 0.75 and 1.34.
const ROOTS: u32 = 5;
/// Terms of the binomial series of the remaining power.
const TERMS: usize = 9;
/// Largest value: for larger ones the cosine in the denominator has vanished in the range table.
const MOST: f64 = 1e30;

/// ρⁿ for ρ ≥ 0, and 0 below, for a power n between 0 and 100; relative error below 10⁻⁵ for
/// 10⁻⁴ ≤ ρ ≤ 10⁴.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CosinePower {
    whole: u32,
    /// Thirty-seconds beyond the whole power, and the binomial series of the remaining power; `None` for
    /// whole powers.
    rest: Option<(u32, [f32; TERMS])>,
    most: f32,
}

impl CosinePower {
    /// The function ρⁿ for the power `n`.
    pub fn new(n: f64) -> Self {
        let whole = n.floor();
        let roots = f64::from(2u32.pow(ROOTS)) * (n - whole);
        let power = roots - roots.floor();
        let mut series = [0f32; TERMS];
        let mut binomial = 1.0;
        for (k, term) in series.iter_mut().enumerate() {
            *term = binomial as f32;
            binomial *= (power - k as f64) / (k + 1) as f64;
        }
        Self {
            whole: whole as u32,
            rest: (roots > 0.0).then_some((roots.floor() as u32, series)),
            most: MOST.powf(n.max(1.0).recip()) as f32,
        }
    }

    /// ρⁿ in every lane; 0 where ρ is negative or NaN.
    #[inline(always)]
    pub fn of<S: Lanes>(&self, s: S, ratio: S::V) -> S::V {
        let zero = s.splat(0.0);
        // min(ρ, most) by max alone.
        let ratio = s.max(ratio, zero);
        let ratio = s.sub(zero, s.max(s.sub(zero, ratio), s.splat(-self.most)));
        let value = whole_power(s, ratio, self.whole);
        let Some((roots, series)) = self.rest else {
            return value;
        };
        let mut root = ratio;
        for _ in 0..ROOTS {
            root = s.sqrt(root);
        }
        let beyond = s.sub(root, s.splat(1.0));
        let mut rest = s.splat(series[TERMS - 1]);
        for term in series[..TERMS - 1].iter().rev() {
            rest = s.mul_add(rest, beyond, s.splat(*term));
        }
        s.mul(value, s.mul(whole_power(s, root, roots), rest))
    }
}

/// `base` to a whole power, by squaring.
#[inline(always)]
fn whole_power<S: Lanes>(s: S, mut base: S::V, mut power: u32) -> S::V {
    let mut value = s.splat(1.0);
    while power > 0 {
        if power & 1 == 1 {
            value = s.mul(value, base);
        }
        power >>= 1;
        if power > 0 {
            base = s.mul(base, base);
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::dispatch::dispatch;
    use crate::kernel::level::SimdLevel;

    fn powers<S: Lanes>(s: S, power: CosinePower, ratio: f32) -> Vec<f32> {
        let mut out = vec![0f32; S::N];
        // SAFETY: `out` has N numbers.
        unsafe { s.store(out.as_mut_ptr(), power.of(s, s.splat(ratio))) };
        out
    }

    #[test]
    fn powers_agree_with_the_library_at_every_level() {
        for &level in SimdLevel::available() {
            for n in [0.25, 0.7, 1.0, 1.5, 2.0, 3.37, 8.0, 20.0] {
                let power = CosinePower::new(n);
                for ratio in [1e-4, 0.02, 0.5, 0.93, 1.0, 1.2, 3.0, 25.0] {
                    let expected = f64::from(ratio as f32).powf(n);
                    if !(1e-30..MOST).contains(&expected) {
                        continue;
                    }
                    for found in dispatch!(level, s => powers(s, power, ratio as f32)) {
                        let error = f64::from(found) / expected - 1.0;
                        assert!(error.abs() < 1e-5, "{ratio}^{n} at {level:?}: {error:e}");
                    }
                }
                for nothing in [-0.3, f32::NAN] {
                    let found = dispatch!(level, s => powers(s, power, nothing));
                    assert!(found.iter().all(|v| *v == 0.0), "{found:?}");
                }
            }
            // Steep powers of large ratios stay finite: their cosine is 0 in the table.
            let steep = dispatch!(level, s => powers(s, CosinePower::new(100.0), 1e6));
            assert!(steep.iter().all(|v| v.is_finite()));
        }
    }
}
