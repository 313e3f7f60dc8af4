//! Splitting, the transpose of merging: a row of the fine grid is divided by the carrier phase of
//! the range to a sub-aperture's centre and shared out among the samples of a coarse line.

use super::lanes::{Lanes, MAX_LANES};
use super::merge::TAPS;
use super::phase::{PhaseRow, RowCarrier};

/// A fine row and the sub-aperture it is split off to.
pub(crate) struct SplitRow<'a> {
    /// The fine row, seen from the sub-aperture's centre.
    pub phase: PhaseRow,
    /// Interpolation weights of each of the D phases along the row.
    pub weights: &'a [[f32; TAPS]],
    /// Weights of the coarse rows about the fine row.
    pub across: [f32; TAPS],
    /// Coarse intervals in the row.
    pub intervals: usize,
    /// Those that a padded row holds.
    pub padded: usize,
}

/// Adds the fine row `real`, `imag` `[D, padded]` to the [`TAPS`] coarse rows about it, which stand
/// one after another. `scratch` `[2, D, padded + 2·TAPS]` holds the row without its phase.
#[inline(always)]
pub(crate) fn split_row<S: Lanes>(
    s: S,
    job: &SplitRow,
    (real, imag): (&[f32], &[f32]),
    scratch: &mut [f32],
    (coarse_re, coarse_im): (&mut [f32], &mut [f32]),
) {
    let n = S::N;
    let padded = job.padded;
    let coarse = padded + TAPS;
    let phases = job.weights.len();
    // A phase's row stands after TAPS zeros and is followed by TAPS more.
    let stride = padded + 2 * TAPS;
    assert!(padded.is_multiple_of(MAX_LANES) && job.intervals <= padded);
    assert!(real.len() >= phases * padded && imag.len() >= phases * padded);
    assert!(scratch.len() >= 2 * phases * stride);
    assert!(coarse_re.len() >= TAPS * coarse && coarse_im.len() >= TAPS * coarse);
    let (rotated_re, rotated_im) = scratch.split_at_mut(phases * stride);

    let carrier = RowCarrier::new(s, &job.phase, phases);
    let mut q = 0;
    while q < job.intervals {
        let at_middle = carrier.intervals(q);
        for p in 0..phases {
            let (cosine, sine) = carrier.phase(&at_middle, p);
            // SAFETY: q + N ≤ padded, and every row has `padded` or `stride` numbers.
            unsafe {
                let at = p * padded + q;
                let (re, im) = (s.load(real.as_ptr().add(at)), s.load(imag.as_ptr().add(at)));
                let to = p * stride + TAPS + q;
                let rotated = s.mul_add(im, sine, s.mul(re, cosine));
                s.store(rotated_re.as_mut_ptr().add(to), rotated);
                let rotated = s.neg_mul_add(re, sine, s.mul(im, cosine));
                s.store(rotated_im.as_mut_ptr().add(to), rotated);
            }
        }
        q += n;
    }

    let mut c = 0;
    while c < coarse {
        let at = c.min(coarse - n);
        // The last vector reaches back over columns that the one before has dealt with.
        let fresh = at == c;
        let (mut re, mut im) = (s.splat(0.0), s.splat(0.0));
        for (p, weights) in job.weights.iter().enumerate() {
            for (k, w) in weights.iter().enumerate() {
                let w = s.splat(*w);
                let from = p * stride + TAPS + at - k;
                // SAFETY: 0 ≤ `at` − k + TAPS and `at` + N ≤ padded + TAPS.
                unsafe {
                    re = s.mul_add(w, s.load(rotated_re.as_ptr().add(from)), re);
                    im = s.mul_add(w, s.load(rotated_im.as_ptr().add(from)), im);
                }
            }
        }
        if fresh {
            for (k, w) in job.across.iter().enumerate() {
                let w = s.splat(*w);
                // SAFETY: `at` + N ≤ coarse numbers of row k.
                unsafe {
                    let to = coarse_re.as_mut_ptr().add(k * coarse + at);
                    s.store(to, s.mul_add(w, re, s.load(to)));
                    let to = coarse_im.as_mut_ptr().add(k * coarse + at);
                    s.store(to, s.mul_add(w, im, s.load(to)));
                }
            }
        } else {
            let (mut line_re, mut line_im) = ([0f32; MAX_LANES], [0f32; MAX_LANES]);
            // SAFETY: both have MAX_LANES ≥ N numbers.
            unsafe {
                s.store(line_re.as_mut_ptr(), re);
                s.store(line_im.as_mut_ptr(), im);
            }
            for (k, w) in job.across.iter().enumerate() {
                for l in c - at..n {
                    coarse_re[k * coarse + at + l] += w * line_re[l];
                    coarse_im[k * coarse + at + l] += w * line_im[l];
                }
            }
        }
        c += n;
    }
}
