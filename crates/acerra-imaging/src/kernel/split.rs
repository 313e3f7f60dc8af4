//! Splitting, the transpose of merging: a row of the fine grid is divided by the carrier phase of
//! the range to a sub-aperture's centre and shared out among the samples of a coarse line.

use super::lanes::{Lanes, MAX_LANES};
use super::merge::MOST_TAPS;
use super::phase::{PhaseRow, RowCarrier};

/// A fine row, and the sub-aperture to which its pixels are distributed.
pub(crate) struct SplitRow<'a> {
    /// The fine row, seen from the sub-aperture's centre.
    pub phase: PhaseRow,
    /// Pixels of a cell.
    pub pixels: usize,
    /// Weights of the pixels in each sample of a cell.
    pub shares: &'a [Vec<Share>],
    /// Weights of the coarse rows about the fine row.
    pub across: &'a [f32],
    /// Cells in the row.
    pub intervals: usize,
    /// Cells in a padded row.
    pub padded: usize,
}

/// A pixel's weight in a sample of its cell or of a following cell.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Share {
    /// Pixel of the cell, and number of cells from the pixel's to the sample's, at most [`MOST_TAPS`].
    pub pixel: usize,
    pub cells: usize,
    pub weight: f32,
}

/// Numbers of the scratch that [`split_row`] takes for cells of some pixels.
pub(crate) fn split_scratch(pixels: usize, padded: usize) -> usize {
    2 * pixels * (padded + 2 * MOST_TAPS)
}

/// Adds the fine row `real`, `imag` `[pixels, padded]` to the coarse rows about it, as many as there are weights
/// across, which follow one another: the first samples of all cells, then the second ones, and so on. The
/// scratch, see [`split_scratch`], holds the row without its phase.
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
    let (phases, rows) = (job.pixels, job.across.len());
    let coarse = coarse_re.len() / rows;
    // Samples of one kind, one a cell.
    let line = coarse / job.shares.len();
    // A phase's row follows MOST_TAPS zeros and is followed by as many more.
    let stride = padded + 2 * MOST_TAPS;
    assert!(padded.is_multiple_of(MAX_LANES) && job.intervals <= padded);
    assert!(real.len() >= phases * padded && imag.len() >= phases * padded);
    assert!(scratch.len() >= split_scratch(phases, padded));
    assert!(coarse * rows == coarse_re.len() && coarse_im.len() == coarse_re.len());
    assert!(line * job.shares.len() == coarse && n <= line && line <= padded + MOST_TAPS);
    let mut shares = job.shares.iter().flatten();
    assert!(shares.all(|share| share.pixel < phases && share.cells <= MOST_TAPS));
    let (rotated_re, rotated_im) = scratch.split_at_mut(phases * stride);

    let carrier = RowCarrier::new(s, &job.phase, phases, None);
    let mut q = 0;
    while q < job.intervals {
        let at_middle = carrier.intervals::<false>(q);
        for p in 0..phases {
            let (cosine, sine) = carrier.phase::<false>(&at_middle, p);
            // SAFETY: q + N ≤ padded, and every row has `padded` or `stride` numbers.
            unsafe {
                let at = p * padded + q;
                let (re, im) = (s.load(real.as_ptr().add(at)), s.load(imag.as_ptr().add(at)));
                let to = p * stride + MOST_TAPS + q;
                let rotated = s.mul_add(im, sine, s.mul(re, cosine));
                s.store(rotated_re.as_mut_ptr().add(to), rotated);
                let rotated = s.neg_mul_add(re, sine, s.mul(im, cosine));
                s.store(rotated_im.as_mut_ptr().add(to), rotated);
            }
        }
        q += n;
    }

    for (kind, shares) in job.shares.iter().enumerate() {
        let first = kind * line;
        let mut c = 0;
        while c < line {
            let at = c.min(line - n);
            // The last vector reaches back over samples of the vector before.
            let fresh = at == c;
            let (mut re, mut im) = (s.splat(0.0), s.splat(0.0));
            for share in shares {
                let w = s.splat(share.weight);
                let from = share.pixel * stride + MOST_TAPS + at - share.cells;
                // SAFETY: `cells` ≤ MOST_TAPS, and `at` + N ≤ line ≤ padded + MOST_TAPS.
                unsafe {
                    re = s.mul_add(w, s.load(rotated_re.as_ptr().add(from)), re);
                    im = s.mul_add(w, s.load(rotated_im.as_ptr().add(from)), im);
                }
            }
            if fresh {
                for (k, w) in job.across.iter().enumerate() {
                    let w = s.splat(*w);
                    // SAFETY: `first` + `at` + N ≤ coarse numbers of row k.
                    unsafe {
                        let to = coarse_re.as_mut_ptr().add(k * coarse + first + at);
                        s.store(to, s.mul_add(w, re, s.load(to)));
                        let to = coarse_im.as_mut_ptr().add(k * coarse + first + at);
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
                        coarse_re[k * coarse + first + at + l] += w * line_re[l];
                        coarse_im[k * coarse + first + at + l] += w * line_im[l];
                    }
                }
            }
            c += n;
        }
    }
}
