//! Dispatch from a level chosen at run time to the code compiled for that level.

#[cfg(target_arch = "x86_64")]
use super::{avx2, avx512};
use super::{lanes::Lanes, portable};

/// Evaluates an expression over the token of a level, compiled for its instructions.
macro_rules! dispatch {
    ($level:expr, $token:ident => $body:expr) => {
        match $level {
            #[cfg(target_arch = "x86_64")]
            $crate::kernel::level::SimdLevel::Avx2 => {
                let token = $crate::kernel::dispatch::avx2_token();
                $crate::kernel::lanes::Lanes::vectorize(
                    token,
                    #[inline(always)]
                    |$token| $body,
                )
            }
            #[cfg(target_arch = "x86_64")]
            $crate::kernel::level::SimdLevel::Avx512 => {
                let token = $crate::kernel::dispatch::avx512_token();
                $crate::kernel::lanes::Lanes::vectorize(
                    token,
                    #[inline(always)]
                    |$token| $body,
                )
            }
            _ => {
                let token = $crate::kernel::dispatch::portable_token();
                $crate::kernel::lanes::Lanes::vectorize(
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
    portable::Portable::<8>
}

/// Portable arrays as wide as the vectors of the widest level, for tests of the dependence on the width where
/// the processor has no such vectors.
#[cfg(test)]
pub(crate) fn wide_token() -> impl Lanes {
    portable::Portable::<{ super::lanes::MAX_LANES }>
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
    use crate::kernel::lanes::{Lanes, ROUNDING};
    use crate::kernel::level::SimdLevel;

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
                    let two = [s.load(table.as_ptr()), s.load(table.as_ptr().add(n))];
                    let beyond = s.add(s.mul(s.splat(4.0), va), s.splat(ROUNDING + 16.0));
                    check(s.pick2(two, beyond), &|a, _| {
                        table[(4.0 * a + 16.0).round_ties_even() as usize % (2 * n)]
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
                    let columns = [va, vb, va, vb, vb, va, vb, va];
                    let mut spread = [0f32; 128];
                    s.scatter_add8(spread.as_mut_ptr(), half, columns);
                    let mut expected = [0f32; 128];
                    for k in 0..n {
                        let at = ((0.5 * a[k]).round_ties_even() + 4.0) as usize * 8;
                        let columns = [a[k], b[k], a[k], b[k], b[k], a[k], b[k], a[k]];
                        for (q, v) in columns.into_iter().enumerate() {
                            expected[at + q] += v;
                        }
                    }
                    for (found, expected) in spread.iter().zip(&expected) {
                        assert!((found - expected).abs() <= 1e-6 * expected.abs());
                    }
                    check(
                        s.negate_odd(vb, s.add(va, s.splat(ROUNDING))),
                        &|a, b| match a.round_ties_even() as i32 % 2 {
                            0 => b,
                            _ => -b,
                        },
                    );
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
        exercise(super::wide_token());
    }
}
