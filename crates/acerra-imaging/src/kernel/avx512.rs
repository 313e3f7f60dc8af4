//! Sixteen lanes of AVX-512 F.

use super::instructions::instructions;
use super::lanes::{DOUBLES, Lanes, ROUNDING};
use std::arch::x86_64::*;

#[derive(Clone, Copy)]
pub(super) struct Avx512(());

type V = __m512;

impl Avx512 {
    /// The token, where the processor has the instructions.
    pub(super) fn new() -> Option<Self> {
        (is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma"))
        .then_some(Self(()))
    }
}

/// The whole numbers in the low bits after adding `ROUNDING`.
#[inline(always)]
fn whole(i: V) -> __m512i {
    // SAFETY: only called from methods of the token.
    unsafe {
        _mm512_sub_epi32(
            _mm512_castps_si512(i),
            _mm512_set1_epi32(ROUNDING.to_bits() as i32),
        )
    }
}

/// Four vectors transposed by quarters: vector l holds the four numbers of lanes l, l + 4, l + 8 and
/// l + 12.
#[inline(always)]
fn quads(v: [V; 4]) -> [V; 4] {
    // SAFETY: only called from methods of the token.
    unsafe {
        let (ab, ab2) = (
            _mm512_unpacklo_ps(v[0], v[1]),
            _mm512_unpackhi_ps(v[0], v[1]),
        );
        let (cd, cd2) = (
            _mm512_unpacklo_ps(v[2], v[3]),
            _mm512_unpackhi_ps(v[2], v[3]),
        );
        [
            _mm512_shuffle_ps::<0x44>(ab, cd),
            _mm512_shuffle_ps::<0xee>(ab, cd),
            _mm512_shuffle_ps::<0x44>(ab2, cd2),
            _mm512_shuffle_ps::<0xee>(ab2, cd2),
        ]
    }
}

/// The four numbers at each of four places.
///
/// # Safety
/// All must be readable.
#[inline(always)]
unsafe fn four(at: [*const f32; 4]) -> V {
    // SAFETY: only called from methods of the token; the caller vouches for the memory.
    unsafe {
        let v = _mm512_castps128_ps512(_mm_loadu_ps(at[0]));
        let v = _mm512_insertf32x4::<1>(v, _mm_loadu_ps(at[1]));
        let v = _mm512_insertf32x4::<2>(v, _mm_loadu_ps(at[2]));
        _mm512_insertf32x4::<3>(v, _mm_loadu_ps(at[3]))
    }
}

#[inline]
#[target_feature(enable = "avx512f,avx2,fma")]
fn enabled<R>(s: Avx512, f: impl FnOnce(Avx512) -> R) -> R {
    f(s)
}

impl Lanes for Avx512 {
    type V = V;
    type Doubles = __m512d;
    const N: usize = 16;

    instructions! {
        fn splat(x: f32) -> V = _mm512_set1_ps(x);
        fn add(a: V, b: V) -> V = _mm512_add_ps(a, b);
        fn sub(a: V, b: V) -> V = _mm512_sub_ps(a, b);
        fn mul(a: V, b: V) -> V = _mm512_mul_ps(a, b);
        fn div(a: V, b: V) -> V = _mm512_div_ps(a, b);
        fn sqrt(a: V) -> V = _mm512_sqrt_ps(a);
        fn max(a: V, b: V) -> V = _mm512_max_ps(a, b);
        fn mul_add(a: V, b: V, c: V) -> V = _mm512_fmadd_ps(a, b, c);
        fn neg_mul_add(a: V, b: V, c: V) -> V = _mm512_fnmadd_ps(a, b, c);
        fn abs(a: V) -> V = _mm512_abs_ps(a);
        // 0x09 rounds down, silently.
        fn floor(a: V) -> V = _mm512_roundscale_ps::<0x09>(a);
        fn all_le(a: V, b: V) -> bool = _mm512_cmp_ps_mask::<_CMP_LE_OQ>(a, b) == 0xffff;
        // The permutation uses the low 4 bits of a lane.
        fn pick(window: V, i: V) -> V = _mm512_permutexvar_ps(_mm512_castps_si512(i), window);
        fn splat_f64(x: f64) -> __m512d = _mm512_set1_pd(x);
        fn mul_add_f64(a: __m512d, b: __m512d, c: __m512d) -> __m512d = _mm512_fmadd_pd(a, b, c);
        fn neg_mul_add_f64(a: __m512d, b: __m512d, c: __m512d) -> __m512d = _mm512_fnmadd_pd(a, b, c);
    }

    #[inline(always)]
    fn reciprocal(self, a: V) -> V {
        // SAFETY: `self` proves the instructions.
        let x = unsafe { _mm512_rcp14_ps(a) };
        // A step of Newton's method doubles the fourteen bits.
        self.mul_add(x, self.neg_mul_add(a, x, self.splat(1.0)), x)
    }
    #[inline(always)]
    fn inverse_sqrt(self, a: V) -> V {
        // SAFETY: `self` proves the instructions.
        let x = unsafe { _mm512_rsqrt14_ps(a) };
        let half = self.mul(x, self.splat(0.5));
        let rest = self.neg_mul_add(self.mul(a, x), x, self.splat(1.0));
        self.mul_add(half, rest, x)
    }
    #[inline(always)]
    unsafe fn load(self, p: *const f32) -> V {
        // SAFETY: `self` proves the instructions; the caller vouches for the memory.
        unsafe { _mm512_loadu_ps(p) }
    }
    #[inline(always)]
    unsafe fn store(self, p: *mut f32, v: V) {
        // SAFETY: `self` proves the instructions; the caller vouches for the memory.
        unsafe { _mm512_storeu_ps(p, v) }
    }
    #[inline(always)]
    fn pick2(self, [low, high]: [V; 2], i: V) -> V {
        // SAFETY: `self` proves the instructions; the permutation uses the low 5 bits of a lane.
        unsafe { _mm512_permutex2var_ps(low, _mm512_castps_si512(i), high) }
    }
    #[inline(always)]
    unsafe fn gather(self, p: *const f32, i: V) -> V {
        // SAFETY: `self` proves the instructions; the caller vouches for every index.
        unsafe { _mm512_i32gather_ps::<4>(whole(i), p) }
    }
    #[inline(always)]
    unsafe fn store_rounded(self, p: *mut i32, i: V, plus: i32) {
        // SAFETY: `self` proves the instructions; the caller vouches for the memory.
        unsafe {
            _mm512_storeu_si512(
                p.cast(),
                _mm512_add_epi32(whole(i), _mm512_set1_epi32(plus)),
            )
        }
    }
    #[inline(always)]
    unsafe fn gather4(self, p: *const f32, i: V, step: usize) -> [V; 4] {
        let mut at = [0i32; 16];
        // SAFETY: `self` proves the instructions; the caller vouches for four numbers at every
        // index. Four-number loads and a transposition beat gathers of single numbers.
        unsafe {
            _mm512_storeu_si512(at.as_mut_ptr().cast(), whole(i));
            let at = at.map(|i| p.offset(i as isize * step as isize));
            let a = four([at[0], at[4], at[8], at[12]]);
            let b = four([at[1], at[5], at[9], at[13]]);
            let c = four([at[2], at[6], at[10], at[14]]);
            let d = four([at[3], at[7], at[11], at[15]]);
            quads([a, b, c, d])
        }
    }
    #[inline(always)]
    unsafe fn scatter_add4(self, p: *mut f32, i: V, step: usize, v: [V; 4]) {
        let mut at = [0i32; 16];
        // SAFETY: `self` proves the instructions; the caller vouches for four numbers at every
        // index. After the transposition each quarter holds the four numbers of a lane.
        unsafe {
            _mm512_storeu_si512(at.as_mut_ptr().cast(), whole(i));
            let quads = quads(v);
            let add = |l: usize, quad: __m128| {
                let to = p.offset(at[l] as isize * step as isize);
                _mm_storeu_ps(to, _mm_add_ps(_mm_loadu_ps(to), quad));
            };
            for (l, quad) in quads.into_iter().enumerate() {
                add(l, _mm512_castps512_ps128(quad));
            }
            for (l, quad) in quads.into_iter().enumerate() {
                add(l + 4, _mm512_extractf32x4_ps::<1>(quad));
            }
            for (l, quad) in quads.into_iter().enumerate() {
                add(l + 8, _mm512_extractf32x4_ps::<2>(quad));
            }
            for (l, quad) in quads.into_iter().enumerate() {
                add(l + 12, _mm512_extractf32x4_ps::<3>(quad));
            }
        }
    }
    #[inline(always)]
    unsafe fn scatter_add8(self, p: *mut f32, i: V, v: [V; 8]) {
        let mut at = [0i32; 16];
        let (low, high) = (
            quads([v[0], v[1], v[2], v[3]]),
            quads([v[4], v[5], v[6], v[7]]),
        );
        // SAFETY: `self` proves the instructions; the caller vouches for eight numbers at every index.
        unsafe {
            _mm512_storeu_si512(at.as_mut_ptr().cast(), whole(i));
            let first = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11);
            let last = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
            for (k, lanes) in [first, last].into_iter().enumerate() {
                for l in 0..4 {
                    let (low, high) = (_mm512_castps_pd(low[l]), _mm512_castps_pd(high[l]));
                    let pair = _mm512_permutex2var_pd(low, lanes, high);
                    let to = p.offset(at[l + 8 * k] as isize * 8);
                    let eight = _mm256_castpd_ps(_mm512_castpd512_pd256(pair));
                    _mm256_storeu_ps(to, _mm256_add_ps(_mm256_loadu_ps(to), eight));
                    let to = p.offset(at[l + 8 * k + 4] as isize * 8);
                    let eight = _mm256_castpd_ps(_mm512_extractf64x4_pd::<1>(pair));
                    _mm256_storeu_ps(to, _mm256_add_ps(_mm256_loadu_ps(to), eight));
                }
            }
        }
    }
    #[inline(always)]
    fn negate_odd(self, v: V, i: V) -> V {
        // SAFETY: `self` proves the instructions; the lowest bit of `i` moves to the sign.
        unsafe {
            let sign = _mm512_slli_epi32::<31>(_mm512_castps_si512(i));
            _mm512_castsi512_ps(_mm512_xor_si512(_mm512_castps_si512(v), sign))
        }
    }
    #[inline(always)]
    fn load_f64(self, x: [f64; DOUBLES]) -> __m512d {
        // SAFETY: `self` proves the instructions; eight numbers are read.
        unsafe { _mm512_loadu_pd(x.as_ptr()) }
    }
    #[inline(always)]
    fn store_f64(self, v: __m512d) -> [f64; DOUBLES] {
        let mut out = [0.0; DOUBLES];
        // SAFETY: `self` proves the instructions; eight numbers are written.
        unsafe { _mm512_storeu_pd(out.as_mut_ptr(), v) };
        out
    }
    #[inline(always)]
    fn vectorize<R>(self, f: impl FnOnce(Self) -> R) -> R {
        // SAFETY: `self` proves the instructions.
        unsafe { enabled(self, f) }
    }
}
