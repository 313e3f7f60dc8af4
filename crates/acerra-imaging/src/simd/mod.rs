//! Vectors of single-precision numbers at every instruction set that the kernels know.
//!
//! A kernel is written once over [`Lanes`]; a level's token can only be had where the processor
//! has the instructions, and the kernel is compiled for each level inside a function that enables
//! them. This module and its children are the only place of the crate where `unsafe` is allowed.
#![allow(unsafe_code)]

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
pub(crate) mod merge;
mod portable;
pub(crate) mod rows;
pub(crate) mod split;
pub(crate) mod spread;
pub(crate) mod surface;
pub(crate) mod turn;

use crate::ImagingError;
use std::fmt;

/// Most lanes that a level has.
pub(crate) const MAX_LANES: usize = 16;

/// An instruction set that the kernels are compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum SimdLevel {
    /// Eight-lane arrays as the compiler turns them into what every processor of the target has
    /// (SSE2 on x86-64, NEON on 64-bit Arm).
    Portable,
    /// AVX2 and FMA, 8 lanes.
    Avx2,
    /// AVX-512 F, 16 lanes.
    Avx512,
}

impl SimdLevel {
    /// The best level of this processor.
    #[must_use]
    pub fn detect() -> Self {
        *Self::available().last().unwrap_or(&Self::Portable)
    }

    /// All levels of this processor, slowest first.
    #[must_use]
    pub fn available() -> &'static [Self] {
        const ALL: [SimdLevel; 3] = [SimdLevel::Portable, SimdLevel::Avx2, SimdLevel::Avx512];
        #[cfg(target_arch = "x86_64")]
        {
            let avx2 = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
            if avx2 && is_x86_feature_detected!("avx512f") {
                return &ALL;
            }
            if avx2 {
                return &ALL[..2];
            }
        }
        &ALL[..1]
    }

    /// This level, if the processor has it.
    ///
    /// # Errors
    /// [`ImagingError::NoSuchLevel`] where it has not.
    pub fn checked(self) -> Result<Self, ImagingError> {
        if Self::available().contains(&self) {
            Ok(self)
        } else {
            Err(ImagingError::NoSuchLevel { level: self.name() })
        }
    }

    /// Short name, as printed in explanations.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Portable => "portable",
            Self::Avx2 => "AVX2+FMA",
            Self::Avx512 => "AVX-512",
        }
    }

    /// Measured peak of this level on one thread: fused multiply-adds of single numbers a second
    /// (twice that in FLOP/s). Takes a few milliseconds.
    ///
    /// # Errors
    /// [`ImagingError::NoSuchLevel`] where the processor lacks it.
    pub fn measure_peak(self) -> Result<f64, ImagingError> {
        self.checked()?;
        const ROUNDS: u32 = 400_000;
        const CHAINS: usize = 12;
        let mut best = f64::INFINITY;
        for _ in 0..4 {
            let start = std::time::Instant::now();
            let sum = dispatch!(self, s => multiply_add(s, ROUNDS, std::hint::black_box(0.999)));
            best = best.min(start.elapsed().as_secs_f64());
            std::hint::black_box(sum);
        }
        Ok(f64::from(ROUNDS) * (CHAINS * self.lanes()) as f64 / best)
    }

    /// Numbers in one vector.
    #[must_use]
    pub fn lanes(self) -> usize {
        match self {
            Self::Portable | Self::Avx2 => 8,
            Self::Avx512 => 16,
        }
    }
}

impl fmt::Display for SimdLevel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// `rounds` steps of twelve independent chains of fused multiply-adds.
#[inline(always)]
fn multiply_add<S: Lanes>(s: S, rounds: u32, factor: f32) -> f32 {
    let (a, b) = (s.splat(factor), s.splat(0.001));
    let mut chains: [S::V; 12] = std::array::from_fn(|k| s.splat(k as f32));
    for _ in 0..rounds {
        for c in &mut chains {
            *c = s.mul_add(*c, a, b);
        }
    }
    let mut out = [0f32; MAX_LANES];
    let sum = chains.into_iter().reduce(|a, b| s.add(a, b));
    // SAFETY: `out` has MAX_LANES ≥ N places.
    unsafe { s.store(out.as_mut_ptr(), sum.unwrap_or(a)) };
    out.iter().sum()
}

/// Adding this to |t| < 2²² rounds t to a whole number, which then stands in the low mantissa bits.
pub(crate) const ROUNDING: f32 = 12_582_912.0; // 1.5 · 2²³

/// A vector of `N` single-precision numbers. A value of the implementing type is proof that the
/// processor has the instructions.
pub(crate) trait Lanes: Copy {
    /// The vector.
    type V: Copy;
    /// Numbers in it, at most [`MAX_LANES`].
    const N: usize;

    fn splat(self, x: f32) -> Self::V;
    /// # Safety
    /// `N` numbers must be readable at `p`.
    unsafe fn load(self, p: *const f32) -> Self::V;
    /// # Safety
    /// `N` numbers must be writable at `p`.
    unsafe fn store(self, p: *mut f32, v: Self::V);
    fn add(self, a: Self::V, b: Self::V) -> Self::V;
    fn sub(self, a: Self::V, b: Self::V) -> Self::V;
    fn mul(self, a: Self::V, b: Self::V) -> Self::V;
    fn div(self, a: Self::V, b: Self::V) -> Self::V;
    fn sqrt(self, a: Self::V) -> Self::V;
    fn max(self, a: Self::V, b: Self::V) -> Self::V;
    fn abs(self, a: Self::V) -> Self::V;
    fn floor(self, a: Self::V) -> Self::V;
    /// a·b + c
    fn mul_add(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// c − a·b
    fn neg_mul_add(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// True if a ≤ b in every lane (false where one is NaN).
    fn all_le(self, a: Self::V, b: Self::V) -> bool;
    /// Lane l becomes `window[bits(i[l]) mod N]`, i made by adding [`ROUNDING`].
    fn pick(self, window: Self::V, i: Self::V) -> Self::V;
    /// The whole numbers that adding [`ROUNDING`] left in `i`, plus `plus`, stored as integers.
    ///
    /// # Safety
    /// `N` integers must be writable at `p`.
    unsafe fn store_rounded(self, p: *mut i32, i: Self::V, plus: i32);
    /// Lane l becomes the number at `p` + the whole number in `i[l]`.
    ///
    /// # Safety
    /// All those must be readable.
    unsafe fn gather(self, p: *const f32, i: Self::V) -> Self::V;
    /// Four vectors: lane l of vector k becomes the number at `p` + step·i[l] + k, where i holds
    /// whole numbers made by adding [`ROUNDING`].
    ///
    /// # Safety
    /// All those must be readable.
    unsafe fn gather4(self, p: *const f32, i: Self::V, step: usize) -> [Self::V; 4];
    /// The transpose of [`Lanes::gather4`]: lane l of vector k is added to the number at
    /// `p` + step·i[l] + k, lane after lane, so that lanes may meet in one place.
    ///
    /// # Safety
    /// All those must be writable.
    unsafe fn scatter_add4(self, p: *mut f32, i: Self::V, step: usize, v: [Self::V; 4]);
    /// Runs `f` where the compiler may use this level's instructions.
    fn vectorize<R>(self, f: impl FnOnce(Self) -> R) -> R;
}

/// Calls `$f::<Level, …>(token, …)` at the level chosen, compiled for it.
macro_rules! dispatch {
    ($level:expr, $token:ident => $body:expr) => {
        match $level {
            #[cfg(target_arch = "x86_64")]
            $crate::simd::SimdLevel::Avx2 => {
                let token = $crate::simd::avx2_token();
                $crate::simd::Lanes::vectorize(
                    token,
                    #[inline(always)]
                    |$token| $body,
                )
            }
            #[cfg(target_arch = "x86_64")]
            $crate::simd::SimdLevel::Avx512 => {
                let token = $crate::simd::avx512_token();
                $crate::simd::Lanes::vectorize(
                    token,
                    #[inline(always)]
                    |$token| $body,
                )
            }
            _ => {
                let token = $crate::simd::portable_token();
                $crate::simd::Lanes::vectorize(
                    token,
                    #[inline(always)]
                    |$token| $body,
                )
            }
        }
    };
}
pub(crate) use dispatch;

pub(crate) fn portable_token() -> impl Lanes {
    portable::Portable
}

/// The AVX2 token.
///
/// Panics where the processor has no AVX2: plans check the level long before.
#[cfg(target_arch = "x86_64")]
pub(crate) fn avx2_token() -> impl Lanes {
    avx2::Avx2::new().expect("the plan checked the level")
}

/// The AVX-512 token; see [`avx2_token`].
#[cfg(target_arch = "x86_64")]
pub(crate) fn avx512_token() -> impl Lanes {
    avx512::Avx512::new().expect("the plan checked the level")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exercise<S: Lanes>(s: S) {
        let n = S::N;
        let a: Vec<f32> = (0..n).map(|k| 0.75 * k as f32 - 2.3).collect();
        let b: Vec<f32> = (0..n).map(|k| 1.5 + 0.1 * k as f32).collect();
        let table: Vec<f32> = (0..64).map(|k| (k * k) as f32).collect();
        let mut out = vec![0.0f32; n];
        let mut ints = vec![0i32; n];
        s.vectorize(
            #[inline(always)]
            |s| {
                // SAFETY: all slices hold at least N numbers; gathered indices lie in 0..64.
                unsafe {
                    let (va, vb) = (s.load(a.as_ptr()), s.load(b.as_ptr()));
                    let mut check = |v: S::V, f: &dyn Fn(f32, f32) -> f32| {
                        s.store(out.as_mut_ptr(), v);
                        for k in 0..n {
                            let expected = f(a[k], b[k]);
                            assert!((out[k] - expected).abs() <= 1e-6 * expected.abs().max(1.0));
                        }
                    };
                    check(s.add(va, vb), &|a, b| a + b);
                    check(s.sub(va, vb), &|a, b| a - b);
                    check(s.mul(va, vb), &|a, b| a * b);
                    check(s.div(va, vb), &|a, b| a / b);
                    check(s.sqrt(vb), &|_, b| b.sqrt());
                    check(s.max(va, vb), &f32::max);
                    check(s.abs(va), &|a, _| a.abs());
                    check(s.floor(va), &|a, _| a.floor());
                    check(s.splat(7.5), &|_, _| 7.5);
                    check(s.mul_add(va, vb, s.splat(3.0)), &|a, b| a * b + 3.0);
                    check(s.neg_mul_add(va, vb, s.splat(3.0)), &|a, b| 3.0 - a * b);
                    let i = s.add(s.mul(va, va), s.splat(ROUNDING));
                    check(s.pick(s.load(table.as_ptr()), i), &|a, _| {
                        table[(a * a).round_ties_even() as usize % n]
                    });
                    let small = s.add(s.mul_add(vb, vb, s.splat(5.0)), s.splat(ROUNDING));
                    check(s.gather(table.as_ptr(), small), &|_, b| {
                        table[(b * b + 5.0).round_ties_even() as usize]
                    });
                    let quads = s.gather4(table.as_ptr(), small, 2);
                    for (q, v) in quads.into_iter().enumerate() {
                        check(v, &|_, b| {
                            table[(b * b + 5.0).round_ties_even() as usize * 2 + q]
                        });
                    }
                    // Lanes that meet in one place must all arrive.
                    let half = s.add(s.mul(va, s.splat(0.5)), s.splat(ROUNDING + 4.0));
                    let mut spread = [0f32; 64];
                    s.scatter_add4(spread.as_mut_ptr(), half, 4, [va, vb, va, vb]);
                    let mut expected = [0f32; 64];
                    for k in 0..n {
                        let at = ((0.5 * a[k]).round_ties_even() + 4.0) as usize * 4;
                        for (q, v) in [a[k], b[k], a[k], b[k]].into_iter().enumerate() {
                            expected[at + q] += v;
                        }
                    }
                    assert_eq!(spread, expected);
                    s.store_rounded(ints.as_mut_ptr(), s.add(va, s.splat(ROUNDING)), 3);
                    for k in 0..n {
                        assert_eq!(ints[k], a[k].round_ties_even() as i32 + 3);
                    }
                    assert!(s.all_le(va, s.splat(a[n - 1])));
                    assert!(!s.all_le(va, s.splat(a[n - 1] - 0.1)));
                    assert!(!s.all_le(s.splat(f32::NAN), vb));
                }
            },
        );
    }

    #[test]
    fn every_level_computes_the_same() {
        for &level in SimdLevel::available() {
            dispatch!(level, s => exercise(s));
        }
    }

    #[test]
    fn absent_levels_are_errors() {
        for level in [SimdLevel::Portable, SimdLevel::Avx2, SimdLevel::Avx512] {
            assert_eq!(
                level.checked().is_ok(),
                SimdLevel::available().contains(&level)
            );
        }
        assert!(SimdLevel::Portable.checked().is_ok());
        assert!(SimdLevel::detect().checked().is_ok());
    }
}
