//! Arrays for any processor; the compiler turns the loops into its vector instructions.

use super::lanes::{DOUBLES, Lanes, ROUNDING};

/// Arrays of `L` numbers, a power of two: eight, or in tests as many as the widest level has.
#[derive(Clone, Copy)]
pub(super) struct Portable<const L: usize>;

#[inline(always)]
fn map<const L: usize>(a: [f32; L], b: [f32; L], f: impl Fn(f32, f32) -> f32) -> [f32; L] {
    let mut out = [0.0; L];
    for k in 0..L {
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

/// Arrays in double precision.
#[inline(always)]
fn fused_f64(a: f64, b: f64, c: f64) -> f64 {
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

impl<const L: usize> Lanes for Portable<L> {
    type V = [f32; L];
    type Doubles = [f64; DOUBLES];
    const N: usize = L;

    #[inline(always)]
    fn splat(self, x: f32) -> [f32; L] {
        [x; L]
    }
    #[inline(always)]
    unsafe fn load(self, p: *const f32) -> [f32; L] {
        // SAFETY: the caller has L numbers there; arrays of f32 need no more than its alignment.
        unsafe { p.cast::<[f32; L]>().read() }
    }
    #[inline(always)]
    unsafe fn store(self, p: *mut f32, v: [f32; L]) {
        // SAFETY: as for `load`.
        unsafe { p.cast::<[f32; L]>().write(v) }
    }
    #[inline(always)]
    fn add(self, a: [f32; L], b: [f32; L]) -> [f32; L] {
        map(a, b, |a, b| a + b)
    }
    #[inline(always)]
    fn sub(self, a: [f32; L], b: [f32; L]) -> [f32; L] {
        map(a, b, |a, b| a - b)
    }
    #[inline(always)]
    fn mul(self, a: [f32; L], b: [f32; L]) -> [f32; L] {
        map(a, b, |a, b| a * b)
    }
    #[inline(always)]
    fn div(self, a: [f32; L], b: [f32; L]) -> [f32; L] {
        map(a, b, |a, b| a / b)
    }
    #[inline(always)]
    fn sqrt(self, a: [f32; L]) -> [f32; L] {
        map(a, a, |a, _| a.sqrt())
    }
    #[inline(always)]
    fn max(self, a: [f32; L], b: [f32; L]) -> [f32; L] {
        map(a, b, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn abs(self, a: [f32; L]) -> [f32; L] {
        map(a, a, |a, _| a.abs())
    }
    #[inline(always)]
    fn floor(self, a: [f32; L]) -> [f32; L] {
        // `f32::floor` is a call where SSE4.1 is not assumed; arguments here stay below 2²².
        map(a, a, |a, _| {
            let r = (a + ROUNDING) - ROUNDING;
            if r > a { r - 1.0 } else { r }
        })
    }
    #[inline(always)]
    fn mul_add(self, a: [f32; L], b: [f32; L], c: [f32; L]) -> [f32; L] {
        let mut out = c;
        for k in 0..L {
            out[k] = fused(a[k], b[k], c[k]);
        }
        out
    }
    #[inline(always)]
    fn neg_mul_add(self, a: [f32; L], b: [f32; L], c: [f32; L]) -> [f32; L] {
        let mut out = c;
        for k in 0..L {
            out[k] = fused(-a[k], b[k], c[k]);
        }
        out
    }
    #[inline(always)]
    fn all_le(self, a: [f32; L], b: [f32; L]) -> bool {
        (0..L).all(|k| a[k] <= b[k])
    }
    #[inline(always)]
    fn pick(self, window: [f32; L], i: [f32; L]) -> [f32; L] {
        map(i, i, |i, _| window[i.to_bits() as usize & (L - 1)])
    }
    #[inline(always)]
    fn pick2(self, windows: [[f32; L]; 2], i: [f32; L]) -> [f32; L] {
        map(i, i, |i, _| {
            let at = i.to_bits() as usize & (2 * L - 1);
            windows[at / L][at & (L - 1)]
        })
    }
    #[inline(always)]
    unsafe fn store_rounded(self, p: *mut i32, i: [f32; L], plus: i32) {
        for (k, v) in i.iter().enumerate() {
            // SAFETY: the caller has room for L integers.
            unsafe { p.add(k).write(whole(*v).wrapping_add(plus)) }
        }
    }
    #[inline(always)]
    unsafe fn gather(self, p: *const f32, i: [f32; L]) -> [f32; L] {
        // SAFETY: the caller vouches for every index.
        map(i, i, |i, _| unsafe { *p.offset(whole(i) as isize) })
    }
    #[inline(always)]
    unsafe fn gather4(self, p: *const f32, i: [f32; L], step: usize) -> [[f32; L]; 4] {
        let mut out = [[0.0; L]; 4];
        for l in 0..L {
            for (k, row) in out.iter_mut().enumerate() {
                // SAFETY: the caller vouches for every index.
                row[l] = unsafe { *p.offset(whole(i[l]) as isize * step as isize + k as isize) };
            }
        }
        out
    }
    #[inline(always)]
    unsafe fn scatter_add4(self, p: *mut f32, i: [f32; L], step: usize, v: [[f32; L]; 4]) {
        for l in 0..L {
            let at = whole(i[l]) as isize * step as isize;
            for (k, row) in v.iter().enumerate() {
                // SAFETY: the caller vouches for every index.
                unsafe { *p.offset(at + k as isize) += row[l] };
            }
        }
    }
    #[inline(always)]
    unsafe fn scatter_add8(self, p: *mut f32, i: [f32; L], v: [[f32; L]; 8]) {
        for l in 0..L {
            let at = whole(i[l]) as isize * 8;
            for (k, row) in v.iter().enumerate() {
                // SAFETY: the caller vouches for every index.
                unsafe { *p.offset(at + k as isize) += row[l] };
            }
        }
    }
    #[inline(always)]
    fn negate_odd(self, v: [f32; L], i: [f32; L]) -> [f32; L] {
        map(v, i, |v, i| f32::from_bits(v.to_bits() ^ i.to_bits() << 31))
    }
    #[inline(always)]
    fn splat_f64(self, x: f64) -> [f64; DOUBLES] {
        [x; DOUBLES]
    }
    #[inline(always)]
    fn load_f64(self, x: [f64; DOUBLES]) -> [f64; DOUBLES] {
        x
    }
    #[inline(always)]
    fn store_f64(self, v: [f64; DOUBLES]) -> [f64; DOUBLES] {
        v
    }
    #[inline(always)]
    fn mul_add_f64(
        self,
        a: [f64; DOUBLES],
        b: [f64; DOUBLES],
        c: [f64; DOUBLES],
    ) -> [f64; DOUBLES] {
        let mut out = c;
        for (k, out) in out.iter_mut().enumerate() {
            *out = fused_f64(a[k], b[k], *out);
        }
        out
    }
    #[inline(always)]
    fn neg_mul_add_f64(
        self,
        a: [f64; DOUBLES],
        b: [f64; DOUBLES],
        c: [f64; DOUBLES],
    ) -> [f64; DOUBLES] {
        self.mul_add_f64(a.map(|a| -a), b, c)
    }
    #[inline(always)]
    fn vectorize<R>(self, f: impl FnOnce(Self) -> R) -> R {
        f(self)
    }
}
