//! Merging: a sub-aperture's coarse image is interpolated to a row of the fine grid, given back the
//! phase of the range to the sub-aperture's centre, and added.
//!
//! A row is held phase by phase: of fine pixels D·q + p all q of one p stand together, so that the
//! interpolation taps are plain vectors of coarse samples.

use super::{Lanes, MAX_LANES, ROUNDING};
use crate::factorized::TAPS;

/// A sub-aperture and the fine row it is added to.
pub(crate) struct MergeRow<'a> {
    /// From the antenna's reference point to pixel 0 of the row, m.
    pub from_centre_m: [f64; 3],
    /// Unit vector along the row and distance of the pixels, m.
    pub unit: [f64; 3],
    pub pixel_m: f64,
    /// Turns of the carrier a metre of range, 2f/c.
    pub turns_a_metre: f64,
    /// Coarse rows about this fine row, real and imaginary, and their weights.
    pub rows: [(&'a [f32], &'a [f32], f32); TAPS],
    /// Interpolation weights of each of the D phases.
    pub weights: &'a [[f32; TAPS]],
    /// Coarse intervals in the row.
    pub intervals: usize,
    /// cos and sin(2πx)/x in powers of x², |x| ≤ ½.
    pub cosine: [f32; 6],
    pub sine: [f32; 6],
}

/// Adds to `real`, `imag` `[D, padded]`; `line` `[2, coarse columns + MAX_LANES]` is scratch.
#[inline(always)]
pub(crate) fn merge_row<S: Lanes>(
    s: S,
    job: &MergeRow,
    padded: usize,
    line: &mut [f32],
    real: &mut [f32],
    imag: &mut [f32],
) {
    let n = S::N;
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
    let mut lane = [0f32; MAX_LANES];
    let interval_m = job.pixel_m * phases as f64;
    for (l, v) in lane.iter_mut().enumerate() {
        *v = ((l as f64 - 0.5 * (n - 1) as f64) * interval_m) as f32;
    }
    // SAFETY: `lane` has MAX_LANES ≥ N numbers.
    let lanes = unsafe { s.load(lane.as_ptr()) };
    let rounding = s.splat(ROUNDING);
    let turns = s.splat(job.turns_a_metre as f32);
    let tiny = s.splat(1e-30);
    let mut q = 0;
    while q < job.intervals {
        // The middle of these N intervals in double precision, the rest from there.
        let along = (q as f64 + 0.5 * (n - 1) as f64) * interval_m;
        let d: [f64; 3] = std::array::from_fn(|a| job.from_centre_m[a] + along * job.unit[a]);
        let range = crate::rows::norm(d);
        let turn = range * job.turns_a_metre;
        let fraction = s.splat((turn - turn.round()) as f32);
        let range0 = s.splat(range as f32);
        let along0 = s.splat(crate::rows::dot(d, job.unit) as f32);
        for (p, weights) in job.weights.iter().enumerate() {
            let offset = s.add(lanes, s.splat((p as f64 * job.pixel_m) as f32));
            let square_difference = s.mul(offset, s.add(s.add(along0, offset), along0));
            let square = s.max(s.mul_add(range0, range0, square_difference), tiny);
            let difference = s.div(
                square_difference,
                s.max(s.add(s.sqrt(square), range0), tiny),
            );
            let t = s.mul_add(difference, turns, fraction);
            let x = s.sub(t, s.sub(s.add(t, rounding), rounding));
            let x2 = s.mul(x, x);
            let (mut cosine, mut sine) = (s.splat(job.cosine[5]), s.splat(job.sine[5]));
            for k in (0..5).rev() {
                cosine = s.mul_add(cosine, x2, s.splat(job.cosine[k]));
                sine = s.mul_add(sine, x2, s.splat(job.sine[k]));
            }
            sine = s.mul(sine, x);
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
