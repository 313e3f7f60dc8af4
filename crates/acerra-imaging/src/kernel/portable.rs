//! Eight-lane arrays for any processor; the compiler turns the loops into its own vectors.

use super::lanes::{Lanes, ROUNDING};

#[derive(Clone, Copy)]
pub(super) struct Portable;

type V = [f32; 8];

#[inline(always)]
fn map(a: V, b: V, f: impl Fn(f32, f32) -> f32) -> V {
    let mut out = [0.0; 8];
    for k in 0..8 {
        out[k] = f(a[k], b[k]);
    }
    out
}

/// a·b + c, fused only where the target has it: elsewhere it would be a call into the C library.
#[inline(always)]
fn fused(a: f32, b: f32, c: f32) -> f32 {
    if cfg!(any(target_arch = "aarch64", target_feature = "fma")) {
        a.mul_add(b, c)
    } else {
        a * b + c
    }
}

/// The whole number in the low bits after adding `ROUNDING`.
#[inline(always)]
fn whole(i: f32) -> i32 {
    i.to_bits() as i32 - ROUNDING.to_bits() as i32
}

impl Lanes for Portable {
    type V = V;
    const N: usize = 8;

    #[inline(always)]
    fn splat(self, x: f32) -> V {
        [x; 8]
    }
    #[inline(always)]
    unsafe fn load(self, p: *const f32) -> V {
        // SAFETY: the caller has 8 numbers there; arrays of f32 need no more than its alignment.
        unsafe { p.cast::<V>().read() }
    }
    #[inline(always)]
    unsafe fn store(self, p: *mut f32, v: V) {
        // SAFETY: as for `load`.
        unsafe { p.cast::<V>().write(v) }
    }
    #[inline(always)]
    fn add(self, a: V, b: V) -> V {
        map(a, b, |a, b| a + b)
    }
    #[inline(always)]
    fn sub(self, a: V, b: V) -> V {
        map(a, b, |a, b| a - b)
    }
    #[inline(always)]
    fn mul(self, a: V, b: V) -> V {
        map(a, b, |a, b| a * b)
    }
    #[inline(always)]
    fn div(self, a: V, b: V) -> V {
        map(a, b, |a, b| a / b)
    }
    #[inline(always)]
    fn sqrt(self, a: V) -> V {
        map(a, a, |a, _| a.sqrt())
    }
    #[inline(always)]
    fn max(self, a: V, b: V) -> V {
        map(a, b, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn abs(self, a: V) -> V {
        map(a, a, |a, _| a.abs())
    }
    #[inline(always)]
    fn floor(self, a: V) -> V {
        // `f32::floor` is a call where SSE4.1 is not assumed; arguments here stay below 2²².
        map(a, a, |a, _| {
            let r = (a + ROUNDING) - ROUNDING;
            if r > a { r - 1.0 } else { r }
        })
    }
    #[inline(always)]
    fn mul_add(self, a: V, b: V, c: V) -> V {
        let mut out = c;
        for k in 0..8 {
            out[k] = fused(a[k], b[k], c[k]);
        }
        out
    }
    #[inline(always)]
    fn neg_mul_add(self, a: V, b: V, c: V) -> V {
        let mut out = c;
        for k in 0..8 {
            out[k] = fused(-a[k], b[k], c[k]);
        }
        out
    }
    #[inline(always)]
    fn all_le(self, a: V, b: V) -> bool {
        (0..8).all(|k| a[k] <= b[k])
    }
    #[inline(always)]
    fn pick(self, window: V, i: V) -> V {
        map(i, i, |i, _| window[(i.to_bits() & 7) as usize])
    }
    #[inline(always)]
    fn pick2(self, windows: [V; 2], i: V) -> V {
        map(i, i, |i, _| {
            let at = (i.to_bits() & 15) as usize;
            windows[at >> 3][at & 7]
        })
    }
    #[inline(always)]
    unsafe fn store_rounded(self, p: *mut i32, i: V, plus: i32) {
        for (k, v) in i.iter().enumerate() {
            // SAFETY: the caller has room for 8 integers.
            unsafe { p.add(k).write(whole(*v).wrapping_add(plus)) }
        }
    }
    #[inline(always)]
    unsafe fn gather(self, p: *const f32, i: V) -> V {
        // SAFETY: the caller vouches for every index.
        map(i, i, |i, _| unsafe { *p.offset(whole(i) as isize) })
    }
    #[inline(always)]
    unsafe fn gather4(self, p: *const f32, i: V, step: usize) -> [V; 4] {
        let mut out = [[0.0; 8]; 4];
        for l in 0..8 {
            for (k, row) in out.iter_mut().enumerate() {
                // SAFETY: the caller vouches for every index.
                row[l] = unsafe { *p.offset(whole(i[l]) as isize * step as isize + k as isize) };
            }
        }
        out
    }
    #[inline(always)]
    unsafe fn scatter_add4(self, p: *mut f32, i: V, step: usize, v: [V; 4]) {
        for l in 0..8 {
            let at = whole(i[l]) as isize * step as isize;
            for (k, row) in v.iter().enumerate() {
                // SAFETY: the caller vouches for every index.
                unsafe { *p.offset(at + k as isize) += row[l] };
            }
        }
    }
    #[inline(always)]
    unsafe fn scatter_add8(self, p: *mut f32, i: V, v: [V; 8]) {
        for l in 0..8 {
            let at = whole(i[l]) as isize * 8;
            for (k, row) in v.iter().enumerate() {
                // SAFETY: the caller vouches for every index.
                unsafe { *p.offset(at + k as isize) += row[l] };
            }
        }
    }
    #[inline(always)]
    fn negate_odd(self, v: V, i: V) -> V {
        map(v, i, |v, i| f32::from_bits(v.to_bits() ^ i.to_bits() << 31))
    }
    #[inline(always)]
    fn vectorize<R>(self, f: impl FnOnce(Self) -> R) -> R {
        f(self)
    }
}
