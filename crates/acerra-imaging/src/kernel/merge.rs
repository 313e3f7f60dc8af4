//! Merging: a sub-aperture's coarse image is interpolated to a row of the fine grid, multiplied by
//! the carrier phase of the range to the sub-aperture's centre, and added.
//!
//! A row is held phase by phase: of fine pixels D·q + p all q of one p stand together, so that the
//! interpolation taps are plain vectors of coarse samples.

use super::lanes::{Lanes, MAX_LANES};
use super::phase::{PhaseRow, RowCarrier};

/// Coarse samples from which a value is interpolated, in either direction: few, or more where they spare samples.
pub(crate) const TAPS: usize = 12;
pub(crate) const MOST_TAPS: usize = 16;

/// A sub-aperture and the fine row it is added to.
pub(crate) struct MergeRow<'a> {
    /// The fine row, seen from the sub-aperture's centre.
    pub phase: PhaseRow,
    /// Coarse rows about this fine row, real and imaginary, and their weights; those beyond the taps do not count.
    pub rows: [(&'a [f32], &'a [f32], f32); MOST_TAPS],
    /// Interpolation weights of each of the D pixels of a cell.
    pub weights: &'a [[f32; MOST_TAPS]],
    /// Where the samples that each of them takes in the first cell stand in a coarse row; those of the cells that
    /// follow come next to them.
    pub offsets: &'a [[usize; MOST_TAPS]],
    /// Coarse samples of a cell.
    pub samples: usize,
    /// Cells in the row.
    pub intervals: usize,
    /// Those that a padded row holds.
    pub padded: usize,
}

/// Adds what `T` taps, of cells of one sample where `WHOLE`, make to `real`, `imag` `[D, padded]`; `line` `[2, coarse columns + MAX_LANES]` is scratch.
#[inline(always)]
pub(crate) fn merge_row<S: Lanes, const T: usize, const WHOLE: bool>(
    s: S,
    job: &MergeRow,
    line: &mut [f32],
    real: &mut [f32],
    imag: &mut [f32],
) {
    let n = S::N;
    let padded = job.padded;
    let coarse = job.rows[0].0.len();
    let phases = job.weights.len();
    assert!(coarse >= n && job.offsets.len() == phases);
    assert!(T <= MOST_TAPS);
    assert!(WHOLE == (job.samples == 1));
    if WHOLE {
        assert!(padded + T - 1 <= coarse);
    } else {
        let mut offsets = job.offsets.iter().flat_map(|offsets| &offsets[..T]);
        assert!(offsets.all(|at| at + padded <= coarse));
    }
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
            for row in &job.rows[..T] {
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
        for (p, (weights, offsets)) in job.weights.iter().zip(job.offsets).enumerate() {
            let (cosine, sine) = carrier.phase(&at_middle, p);
            // SAFETY: q + N ≤ padded, and a tap's samples of `padded` cells lie within the line.
            unsafe {
                let (mut re, mut im) = (s.splat(0.0), s.splat(0.0));
                for k in 0..T {
                    // Taps of whole cells stand side by side.
                    let at = q + if WHOLE { k } else { offsets[k] };
                    let w = s.splat(weights[k]);
                    re = s.mul_add(w, s.load(line_re.as_ptr().add(at)), re);
                    im = s.mul_add(w, s.load(line_im.as_ptr().add(at)), im);
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
