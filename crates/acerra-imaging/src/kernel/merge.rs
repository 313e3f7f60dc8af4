//! Merging: a sub-aperture's coarse image is interpolated to a row of the fine grid, multiplied by
//! the carrier phase of the range to the sub-aperture's centre, and added.
//!
//! A row is held phase by phase: of fine pixels D·q + p all q of one p stand together, so that the
//! interpolation taps are plain vectors of coarse samples.

use super::lanes::{Lanes, MAX_LANES};
use super::phase::{PhaseRow, RowCarrier};

/// Coarse samples from which a value is interpolated, in either direction.
pub(crate) const TAPS: usize = 12;

/// A sub-aperture and the fine row it is added to.
pub(crate) struct MergeRow<'a> {
    /// The fine row, seen from the sub-aperture's centre.
    pub phase: PhaseRow,
    /// Coarse rows about this fine row, real and imaginary, and their weights.
    pub rows: [(&'a [f32], &'a [f32], f32); TAPS],
    /// Interpolation weights of each of the D phases.
    pub weights: &'a [[f32; TAPS]],
    /// Coarse intervals in the row.
    pub intervals: usize,
    /// Those that a padded row holds.
    pub padded: usize,
}

/// Adds to `real`, `imag` `[D, padded]`; `line` `[2, coarse columns + MAX_LANES]` is scratch.
#[inline(always)]
pub(crate) fn merge_row<S: Lanes>(
    s: S,
    job: &MergeRow,
    line: &mut [f32],
    real: &mut [f32],
    imag: &mut [f32],
) {
    let n = S::N;
    let padded = job.padded;
    let coarse = padded + TAPS;
    let phases = job.weights.len();
    assert!(padded.is_multiple_of(MAX_LANES) && job.intervals <= padded);
    assert!(line.len() >= 2 * coarse && real.len() >= phases * padded);
    assert!(imag.len() >= phases * padded);
    assert!(
        job.rows
            .iter()
            .all(|r| r.0.len() >= coarse && r.1.len() >= coarse)
    );
    let (line_re, line_im) = line.split_at_mut(coarse);

    // Across rows: one coarse line at this fine row.
    let mut c = 0;
    while c < coarse {
        let at = c.min(coarse - n);
        // SAFETY: `coarse` ≥ N numbers stand in every row and line, and `at` ≤ coarse − N.
        unsafe {
            let (mut re, mut im) = (s.splat(0.0), s.splat(0.0));
            for row in &job.rows {
                let w = s.splat(row.2);
                re = s.mul_add(w, s.load(row.0.as_ptr().add(at)), re);
                im = s.mul_add(w, s.load(row.1.as_ptr().add(at)), im);
            }
            s.store(line_re.as_mut_ptr().add(at), re);
            s.store(line_im.as_mut_ptr().add(at), im);
        }
        c += n;
    }

    // Along the row.
    let carrier = RowCarrier::new(s, &job.phase, phases);
    let mut q = 0;
    while q < job.intervals {
        let at_middle = carrier.intervals(q);
        for (p, weights) in job.weights.iter().enumerate() {
            let (cosine, sine) = carrier.phase(&at_middle, p);
            // SAFETY: q + N ≤ padded and q + TAPS + N ≤ padded + TAPS.
            unsafe {
                let (mut re, mut im) = (s.splat(0.0), s.splat(0.0));
                for (k, w) in weights.iter().enumerate() {
                    let w = s.splat(*w);
                    re = s.mul_add(w, s.load(line_re.as_ptr().add(q + k)), re);
                    im = s.mul_add(w, s.load(line_im.as_ptr().add(q + k)), im);
                }
                let at = p * padded + q;
                let (to_re, to_im) = (real.as_mut_ptr().add(at), imag.as_mut_ptr().add(at));
                let sum = s.mul_add(re, cosine, s.load(to_re));
                s.store(to_re, s.neg_mul_add(im, sine, sum));
                let sum = s.mul_add(re, sine, s.load(to_im));
                s.store(to_im, s.mul_add(im, cosine, sum));
            }
        }
        q += n;
    }
}
