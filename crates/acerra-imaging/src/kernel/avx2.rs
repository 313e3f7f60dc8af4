//! Eight lanes of AVX2 with FMA.

use super::instructions::instructions;
use super::lanes::{DOUBLES, Lanes, ROUNDING};
use std::arch::x86_64::*;

#[derive(Clone, Copy)]
pub(super) struct Avx2(());

type V = __m256;
type Doubles = [__m256d; 2];

impl Avx2 {
    /// The token, where the processor has the instructions.
    pub(super) fn new() -> Option<Self> {
        (is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")).then_some(Self(()))
    }
}

/// The whole numbers in the low bits after adding `ROUNDING`.
#[inline(always)]
fn whole(i: V) -> __m256i {
    // SAFETY: only called from methods of the token.
    unsafe {
        _mm256_sub_epi32(
            _mm256_castps_si256(i),
            _mm256_set1_epi32(ROUNDING.to_bits() as i32),
        )
    }
}

/// Byte offsets of the places of `step` numbers given by the lanes; two lanes leave their register at a time.
#[inline(always)]
fn bytes_from(i: __m256i, step: usize) -> [isize; 8] {
    // SAFETY: only called from methods of the token.
    let pairs = unsafe {
        let bytes = _mm256_mullo_epi32(i, _mm256_set1_epi32(4 * step as i32));
        let (low, high) = (
            _mm256_castsi256_si128(bytes),
            _mm256_extracti128_si256::<1>(bytes),
        );
        [
            _mm_cvtsi128_si64(low),
            _mm_extract_epi64::<1>(low),
            _mm_cvtsi128_si64(high),
            _mm_extract_epi64::<1>(high),
        ]
    };
    std::array::from_fn(|l| match l % 2 {
        0 => pairs[l / 2] as i32 as isize,
        _ => (pairs[l / 2] >> 32) as isize,
    })
}

/// Four vectors transposed by quarters: vector l holds the four numbers of lanes l and l + 4.
#[inline(always)]
fn quads(v: [V; 4]) -> [V; 4] {
    // SAFETY: only called from methods of the token.
    unsafe {
        let (ab, ab2) = (
            _mm256_unpacklo_ps(v[0], v[1]),
            _mm256_unpackhi_ps(v[0], v[1]),
        );
        let (cd, cd2) = (
            _mm256_unpacklo_ps(v[2], v[3]),
            _mm256_unpackhi_ps(v[2], v[3]),
        );
        [
            _mm256_shuffle_ps::<0x44>(ab, cd),
            _mm256_shuffle_ps::<0xee>(ab, cd),
            _mm256_shuffle_ps::<0x44>(ab2, cd2),
            _mm256_shuffle_ps::<0xee>(ab2, cd2),
        ]
    }
}

/// The four numbers at `low` and the four at `high`.
///
/// # Safety
/// All must be readable.
#[inline(always)]
unsafe fn pair(low: *const f32, high: *const f32) -> V {
    // SAFETY: only called from methods of the token; the caller vouches for the memory.
    unsafe {
        let (low, high) = (_mm_loadu_ps(low), _mm_loadu_ps(high));
        _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(low), high)
    }
}

#[inline]
#[target_feature(enable = "avx2,fma")]
fn enabled<R>(s: Avx2, f: impl FnOnce(Avx2) -> R) -> R {
    f(s)
}

impl Lanes for Avx2 {
    type V = V;
    type Doubles = Doubles;
    const N: usize = 8;

    instructions! {
        fn splat(x: f32) -> V = _mm256_set1_ps(x);
        fn add(a: V, b: V) -> V = _mm256_add_ps(a, b);
        fn sub(a: V, b: V) -> V = _mm256_sub_ps(a, b);
        fn mul(a: V, b: V) -> V = _mm256_mul_ps(a, b);
        fn div(a: V, b: V) -> V = _mm256_div_ps(a, b);
        fn sqrt(a: V) -> V = _mm256_sqrt_ps(a);
        fn max(a: V, b: V) -> V = _mm256_max_ps(a, b);
        fn mul_add(a: V, b: V, c: V) -> V = _mm256_fmadd_ps(a, b, c);
        fn neg_mul_add(a: V, b: V, c: V) -> V = _mm256_fnmadd_ps(a, b, c);
        fn abs(a: V) -> V = _mm256_andnot_ps(_mm256_set1_ps(-0.0), a);
        fn floor(a: V) -> V = _mm256_floor_ps(a);
        fn all_le(a: V, b: V) -> bool =
            _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(a, b)) == 0xff;
        // The permutation uses the low 3 bits of a lane.
        fn pick(window: V, i: V) -> V = _mm256_permutevar8x32_ps(window, _mm256_castps_si256(i));
        fn splat_f64(x: f64) -> Doubles = [_mm256_set1_pd(x); 2];
        fn mul_add_f64(a: Doubles, b: Doubles, c: Doubles) -> Doubles =
            [_mm256_fmadd_pd(a[0], b[0], c[0]), _mm256_fmadd_pd(a[1], b[1], c[1])];
        fn neg_mul_add_f64(a: Doubles, b: Doubles, c: Doubles) -> Doubles =
            [_mm256_fnmadd_pd(a[0], b[0], c[0]), _mm256_fnmadd_pd(a[1], b[1], c[1])];
    }

    #[inline(always)]
    unsafe fn load(self, p: *const f32) -> V {
        // SAFETY: `self` proves the instructions; the caller vouches for the memory.
        unsafe { _mm256_loadu_ps(p) }
    }
    #[inline(always)]
    unsafe fn store(self, p: *mut f32, v: V) {
        // SAFETY: `self` proves the instructions; the caller vouches for the memory.
        unsafe { _mm256_storeu_ps(p, v) }
    }
    #[inline(always)]
    fn pick2(self, [low, high]: [V; 2], i: V) -> V {
        // SAFETY: `self` proves the instructions. Bit 3 of a lane chooses the window, once it is in
        // the sign.
        unsafe {
            let i = _mm256_castps_si256(i);
            let which = _mm256_castsi256_ps(_mm256_slli_epi32::<28>(i));
            let (low, high) = (
                _mm256_permutevar8x32_ps(low, i),
                _mm256_permutevar8x32_ps(high, i),
            );
            _mm256_blendv_ps(low, high, which)
        }
    }
    #[inline(always)]
    unsafe fn gather(self, p: *const f32, i: V) -> V {
        // SAFETY: `self` proves the instructions; the caller vouches for every index.
        unsafe { _mm256_i32gather_ps::<4>(p, whole(i)) }
    }
    #[inline(always)]
    unsafe fn store_rounded(self, p: *mut i32, i: V, plus: i32) {
        // SAFETY: `self` proves the instructions; the caller vouches for the memory.
        unsafe {
            _mm256_storeu_si256(
                p.cast(),
                _mm256_add_epi32(whole(i), _mm256_set1_epi32(plus)),
            )
        }
    }
    #[inline(always)]
    unsafe fn gather4(self, p: *const f32, i: V, step: usize) -> [V; 4] {
        let mut at = [0i32; 8];
        // SAFETY: `self` proves the instructions; the caller vouches for four numbers at every
        // index. Four-number loads and a transposition beat gathers of single numbers.
        unsafe {
            _mm256_storeu_si256(at.as_mut_ptr().cast(), whole(i));
            let at = at.map(|i| p.offset(i as isize * step as isize));
            let (a, b) = (pair(at[0], at[4]), pair(at[1], at[5]));
            let (c, d) = (pair(at[2], at[6]), pair(at[3], at[7]));
            quads([a, b, c, d])
        }
    }
    #[inline(always)]
    unsafe fn scatter_add4(self, p: *mut f32, i: V, step: usize, v: [V; 4]) {
        // SAFETY: `self` proves the instructions; the caller vouches for four numbers at every
        // index. After the transposition each quarter holds the four numbers of a lane.
        unsafe {
            let at = bytes_from(whole(i), step);
            let quads = quads(v);
            let add = |l: usize, quad: __m128| {
                let to = p.byte_offset(at[l]);
                _mm_storeu_ps(to, _mm_add_ps(_mm_loadu_ps(to), quad));
            };
            for (l, quad) in quads.into_iter().enumerate() {
                add(l, _mm256_castps256_ps128(quad));
            }
            for (l, quad) in quads.into_iter().enumerate() {
                add(l + 4, _mm256_extractf128_ps::<1>(quad));
            }
        }
    }
    #[inline(always)]
    unsafe fn scatter_add8(self, p: *mut f32, i: V, v: [V; 8]) {
        let (low, high) = (
            quads([v[0], v[1], v[2], v[3]]),
            quads([v[4], v[5], v[6], v[7]]),
        );
        // SAFETY: `self` proves the instructions; the caller vouches for eight numbers at every index.
        unsafe {
            let at = bytes_from(whole(i), 8);
            for l in 0..4 {
                let to = p.byte_offset(at[l]);
                let eight = _mm256_permute2f128_ps::<0x20>(low[l], high[l]);
                _mm256_storeu_ps(to, _mm256_add_ps(_mm256_loadu_ps(to), eight));
            }
            for l in 0..4 {
                let to = p.byte_offset(at[l + 4]);
                let eight = _mm256_permute2f128_ps::<0x31>(low[l], high[l]);
                _mm256_storeu_ps(to, _mm256_add_ps(_mm256_loadu_ps(to), eight));
            }
        }
    }
    #[inline(always)]
    fn negate_odd(self, v: V, i: V) -> V {
        // SAFETY: `self` proves the instructions; the lowest bit of `i` moves to the sign.
        unsafe {
            let sign = _mm256_slli_epi32::<31>(_mm256_castps_si256(i));
            _mm256_xor_ps(v, _mm256_castsi256_ps(sign))
        }
    }
    #[inline(always)]
    fn load_f64(self, x: [f64; DOUBLES]) -> Doubles {
        // SAFETY: `self` proves the instructions; twice four of the eight numbers are read.
        unsafe {
            [
                _mm256_loadu_pd(x.as_ptr()),
                _mm256_loadu_pd(x.as_ptr().add(4)),
            ]
        }
    }
    #[inline(always)]
    fn store_f64(self, v: Doubles) -> [f64; DOUBLES] {
        let mut out = [0.0; DOUBLES];
        // SAFETY: `self` proves the instructions; twice four of the eight numbers are written.
        unsafe {
            _mm256_storeu_pd(out.as_mut_ptr(), v[0]);
            _mm256_storeu_pd(out.as_mut_ptr().add(4), v[1]);
        }
        out
    }
    #[inline(always)]
    fn vectorize<R>(self, f: impl FnOnce(Self) -> R) -> R {
        // SAFETY: `self` proves the instructions.
        unsafe { enabled(self, f) }
    }
}
