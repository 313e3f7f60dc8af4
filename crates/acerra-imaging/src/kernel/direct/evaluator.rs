//! Contribution of a pulse at given ranges: polynomial of the range bin times the carrier.

use super::job::Job;
use crate::kernel::lanes::{Lanes, ROUNDING};

/// Evaluator of contributions at known ranges.
pub(super) struct Evaluator<S: Lanes, const DEGREE: usize, const TERMS: usize> {
    s: S,
    rounding: S::V,
    cosine: [S::V; 4],
    sine: [S::V; 4],
    stride: usize,
    interleaved: bool,
}

impl<S: Lanes, const DEGREE: usize, const TERMS: usize> Evaluator<S, DEGREE, TERMS> {
    /// The evaluator for the table and the carrier of a job.
    #[inline(always)]
    pub fn of(s: S, job: &Job) -> Self {
        Self {
            s,
            rounding: s.splat(ROUNDING),
            cosine: job.cosine.map(|c| s.splat(c)),
            sine: job.sine.map(|c| s.splat(c)),
            stride: job.table.stride,
            interleaved: job.table.interleaved,
        }
    }

    /// Adds the contribution at `t` bins past a window of N entries (2N where `TWO`), from which each lane
    /// picks its own inside registers, times `weight` where there is one.
    ///
    /// # Safety
    /// The window's entries must be readable at `window` and at every coefficient row after it.
    #[inline(always)]
    pub unsafe fn windowed<const TWO: bool>(
        &self,
        window: *const f32,
        t: S::V,
        weight: Option<S::V>,
        sum: &mut [S::V; 2],
    ) {
        let s = self.s;
        let i = s.add(t, self.rounding);
        let delta = s.sub(t, s.sub(i, self.rounding));
        self.add(
            delta,
            // SAFETY: the caller vouches for the rows.
            #[inline(always)]
            |row| unsafe {
                let at = window.add(row * self.stride);
                if TWO {
                    s.pick2([s.load(at), s.load(at.add(S::N))], i)
                } else {
                    s.pick(s.load(at), i)
                }
            },
            weight,
            sum,
        );
    }

    /// Adds the contribution at `whole` + `t` bins past the start of a pulse's `row`, the index past
    /// `whole` kept within the limits, times `weight` where there is one.
    ///
    /// # Safety
    /// Entries `whole` + the limits must be readable in every coefficient row of `row`.
    #[inline(always)]
    pub unsafe fn gathered(
        &self,
        row: *const f32,
        whole: i32,
        t: S::V,
        (lowest, highest): (S::V, S::V),
        weight: Option<S::V>,
        sum: &mut [S::V; 2],
    ) {
        let s = self.s;
        let i = s.sub(s.add(t, self.rounding), self.rounding);
        let delta = s.sub(t, i);
        // max(lowest, ·) and −max(−highest, −·) also turn NaN into a number within the limits.
        let zero = s.splat(0.0);
        let i = s.max(i, lowest);
        let i = s.sub(zero, s.max(s.sub(zero, i), s.sub(zero, highest)));
        let i = s.add(i, self.rounding);
        if self.interleaved {
            let step = 2 * (DEGREE + 1);
            // SAFETY: the caller vouches for the entries; those of even degree, of which the last
            // half of the second four is none, are read singly.
            unsafe {
                let row = row.offset(whole as isize * step as isize);
                let first = s.gather4(row, i, step);
                let last = match DEGREE {
                    1 => first,
                    3 => s.gather4(row.add(4), i, step),
                    _ => {
                        let i = s.mul(s.sub(i, self.rounding), s.splat(step as f32));
                        let i = s.add(i, self.rounding);
                        let (re, im) = (s.gather(row.add(4), i), s.gather(row.add(5), i));
                        [re, im, re, im]
                    }
                };
                self.add(
                    delta,
                    #[inline(always)]
                    |k| if k < 4 { first[k] } else { last[k - 4] },
                    weight,
                    sum,
                );
            }
        } else {
            self.add(
                delta,
                // SAFETY: the caller vouches for the entries within the limits.
                #[inline(always)]
                |k| unsafe { s.gather(row.offset(whole as isize).add(k * self.stride), i) },
                weight,
                sum,
            );
        }
    }

    /// Adds the value at `delta` of the polynomial with the coefficients `entry`. `entry` must be inlined
    /// always: a closure that is not inlined is compiled without the level's instructions.
    #[inline(always)]
    fn add(
        &self,
        delta: S::V,
        entry: impl Fn(usize) -> S::V,
        weight: Option<S::V>,
        sum: &mut [S::V; 2],
    ) {
        let s = self.s;
        let (mut re, mut im) = (entry(2 * DEGREE), entry(2 * DEGREE + 1));
        for p in (0..DEGREE).rev() {
            re = s.mul_add(re, delta, entry(2 * p));
            im = s.mul_add(im, delta, entry(2 * p + 1));
        }
        let square = s.mul(delta, delta);
        // The sine needs one term fewer than the cosine for the same error.
        let (mut cosine, mut sine) = (self.cosine[TERMS - 1], self.sine[TERMS - 2]);
        for k in (0..TERMS - 1).rev() {
            cosine = s.mul_add(cosine, square, self.cosine[k]);
        }
        for k in (0..TERMS - 2).rev() {
            sine = s.mul_add(sine, square, self.sine[k]);
        }
        sine = s.mul(sine, delta);
        if let Some(weight) = weight {
            (cosine, sine) = (s.mul(cosine, weight), s.mul(sine, weight));
        }
        sum[0] = s.neg_mul_add(im, sine, s.mul_add(re, cosine, sum[0]));
        sum[1] = s.mul_add(im, cosine, s.mul_add(re, sine, sum[1]));
    }
}
