//! Weighted sums of table rows that start at different places: consecutive numbers of a row belong to consecutive
//! delays.

use super::lanes::{DOUBLES, Lanes, MAX_LANES};
use super::phasor::phasors;

/// Number of vectors summed side by side, so that additions do not wait for each other.
const VECTORS: usize = 2;
/// The length of a sum is a multiple of this at every level.
pub(crate) const BLOCK: usize = VECTORS * MAX_LANES;

/// Two rows of the table and their complex factors: the neighbours between which a time lies.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Term {
    /// Places of the real parts in the table; imaginary parts follow a row's length later.
    pub start: [usize; 2],
    /// Complex factors of both rows: real and imaginary parts.
    pub factor: [[f32; 2]; 2],
}

/// e^{j2π`turns`} times `weight`, for every place.
#[inline(always)]
pub(crate) fn weighted_phasors<S: Lanes>(
    s: S,
    turns: [f64; DOUBLES],
    weight: [f64; DOUBLES],
) -> [[f64; 2]; DOUBLES] {
    let one = phasors(s, turns);
    let (re, im) = (s.store_f64(one.re), s.store_f64(one.im));
    let mut out = [[0.0; 2]; DOUBLES];
    for k in 0..DOUBLES {
        out[k] = [re[k] * weight[k], im[k] * weight[k]];
    }
    out
}

/// Σ over the terms of factor times row, both parts at every one of the `re.len()` delays, a multiple of
/// [`BLOCK`].
///
/// Panics where a term leaves the table.
#[inline(always)]
pub(crate) fn sum<S: Lanes>(
    s: S,
    table: &[f32],
    row: usize,
    terms: &[Term],
    [re, im]: [&mut [f32]; 2],
) {
    assert!(re.len().is_multiple_of(BLOCK) && im.len() == re.len());
    for term in terms {
        for start in term.start {
            assert!(start + row + re.len() <= table.len());
        }
    }
    for from in (0..re.len()).step_by(VECTORS * S::N) {
        let mut sums = [[[s.splat(0.0); 2]; 2]; VECTORS];
        for term in terms {
            for (k, start) in term.start.into_iter().enumerate() {
                let [factor_re, factor_im] = term.factor[k];
                let (factor_re, factor_im) = (s.splat(factor_re), s.splat(factor_im));
                for (v, sums) in sums.iter_mut().enumerate() {
                    let at = start + from + v * S::N;
                    // SAFETY: `at` + N does not exceed `start` + the delays, and a row later the table still
                    // holds as many numbers, as asserted above.
                    let (a, b) = unsafe {
                        let first = table.as_ptr().add(at);
                        (s.load(first), s.load(first.add(row)))
                    };
                    let [sum_re, sum_im] = sums[k];
                    let sum_re = s.mul_add(a, factor_re, sum_re);
                    let sum_im = s.mul_add(a, factor_im, sum_im);
                    sums[k] = [
                        s.neg_mul_add(b, factor_im, sum_re),
                        s.mul_add(b, factor_re, sum_im),
                    ];
                }
            }
        }
        for (v, [near, far]) in sums.into_iter().enumerate() {
            let at = from + v * S::N;
            // SAFETY: `at` + N does not exceed the length of either part, a multiple of VECTORS · N.
            unsafe {
                s.store(re.as_mut_ptr().add(at), s.add(near[0], far[0]));
                s.store(im.as_mut_ptr().add(at), s.add(near[1], far[1]));
            }
        }
    }
}
