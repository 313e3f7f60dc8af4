//! The transposed direct kernel: pixels of a row are spread over the range bins of a pulse.
//!
//! This kernel adds to a bin the terms that the direct kernel reads from the bin: a pixel's value without the
//! carrier's phase between the bin's centre and the pixel's range, times the powers of the distance δ from
//! the centre. Ranges along a row follow from a double-precision centre, as in the direct kernel.

use super::cosine_power::CosinePower;
use super::lanes::{Lanes, MAX_LANES, ROUNDING};
use super::two_ways::{mean, spreading};
use crate::vector::{dot, norm};
use std::ops::Range;

/// A row, a pulse, and the bins between them.
pub(crate) struct SpreadRow<'a> {
    /// Vectors from the antennas of the pulse (one or two) to pixel 0, m. With two antennas the range is the mean of
    /// both ranges.
    pub from_antennas_m: &'a [[f64; 3]],
    /// Unit vector along the row and distance of the pixels, m.
    pub unit: [f64; 3],
    pub pixel_m: f64,
    /// Real and imaginary parts, padded with zeros to a multiple of [`MAX_LANES`].
    pub real: &'a [f32],
    pub imag: &'a [f32],
    /// Pixels that share a double-precision centre, a multiple of [`MAX_LANES`].
    pub segment: usize,
    pub bin_m: f64,
    /// Absolute number of the pulse's first bin.
    pub first_bin: i64,
    /// Pixels nearer than this range are passed to `reference`, m.
    pub reference_below_m: f64,
    /// cos αδ and sin(αδ)/δ in powers of δ².
    pub cosine: [f32; 4],
    pub sine: [f32; 4],
    /// A further weight of the pixels that is not part of the bins.
    pub weight: Option<RowWeight>,
}

/// A weight that changes from pixel to pixel.
pub(crate) enum RowWeight {
    /// The pattern of an antenna with a tilted boresight.
    Tilt(RowTilt),
    /// The ratio of the bistatic spreading to the spreading at the mean range.
    Ways,
}

/// The antenna's pattern along a row, relative to the pattern of an antenna that points straight down.
pub(crate) struct RowTilt {
    /// Ratio of the cosines from boresight and vertical at pixel 0, and its change a pixel.
    pub ratio: f64,
    pub slope: f64,
    /// The power function of the ratio.
    pub power: CosinePower,
}

/// Numbers a bin of a table of `degree`: coefficients side by side, in fours.
pub(crate) const fn step(degree: usize) -> usize {
    if degree <= 1 { 4 } else { 8 }
}

/// Ranges of a place of a row from both antennas, and its offsets along the row, m. A single antenna counts
/// twice.
struct Seen {
    ranges_m: [f64; 2],
    along_m: [f64; 2],
}

impl SpreadRow<'_> {
    /// The place `columns` pixels along the row.
    #[inline(always)]
    fn seen(&self, columns: f64) -> Seen {
        let last = self.from_antennas_m.len() - 1;
        let from_m = [self.from_antennas_m[0], self.from_antennas_m[last]];
        let d = from_m.map(|from_m| -> [f64; 3] {
            std::array::from_fn(|a| from_m[a] + columns * self.pixel_m * self.unit[a])
        });
        Seen {
            ranges_m: d.map(norm),
            along_m: d.map(|d| dot(d, self.unit)),
        }
    }
}

impl Seen {
    /// Ranges from an antenna to `offset` along the row from this place, and their excess over the range of
    /// this place, m.
    #[inline(always)]
    fn exact<S: Lanes>(&self, s: S, antenna: usize, offset: S::V) -> [S::V; 2] {
        let range0 = s.splat(self.ranges_m[antenna] as f32);
        let along0 = s.splat(self.along_m[antenna] as f32);
        let square_difference = s.mul(offset, s.add(s.add(along0, offset), along0));
        let square = s.max(s.mul_add(range0, range0, square_difference), s.splat(1e-30));
        let range = s.sqrt(square);
        [range, s.div(square_difference, s.add(range, range0))]
    }
}

/// Adds the row to `bins` `[entries, step]`; pieces next to the antenna go to `reference` instead.
#[inline(always)]
pub(crate) fn spread_row<S: Lanes, const DEGREE: usize, const TERMS: usize>(
    s: S,
    job: &SpreadRow,
    bins: &mut [f32],
    reference: &mut dyn FnMut(Range<usize>),
) {
    let n = S::N;
    let length = job.real.len();
    let step = step(DEGREE);
    let entries = bins.len() / step;
    assert!(length.is_multiple_of(MAX_LANES) && job.imag.len() == length);
    assert!(job.segment.is_multiple_of(MAX_LANES) && job.segment > 0 && entries > 0);

    let mut lane = [0f32; MAX_LANES];
    for (l, v) in lane.iter_mut().enumerate() {
        *v = (l as f64 * job.pixel_m) as f32;
    }
    // SAFETY: `lane` has MAX_LANES ≥ N numbers.
    let lanes = unsafe { s.load(lane.as_ptr()) };
    let (rounding, zero) = (s.splat(ROUNDING), s.splat(0.0));
    let a_metre = s.splat((1.0 / job.bin_m) as f32);
    let mut start = 0;
    while start < length {
        let end = (start + job.segment).min(length);
        let centre = start as f64 + 0.5 * (end - start - 1) as f64;
        let seen = job.seen(centre);
        let nearest = seen.ranges_m.iter().copied().fold(f64::INFINITY, f64::min);
        if nearest - 0.5 * (end - start) as f64 * job.pixel_m < job.reference_below_m {
            reference(start..end);
            start = end;
            continue;
        }
        let t0 = 0.5 * (seen.ranges_m[0] + seen.ranges_m[1]) / job.bin_m - job.first_bin as f64;
        let whole = (t0 as i32).clamp(0, entries as i32 - 1);
        let fraction = s.splat((t0 - f64::from(whole)) as f32);
        let lowest = s.splat(-(whole as f32));
        let highest = s.splat((entries as i32 - 1 - whole) as f32);
        let mut at = start;
        while at < end {
            let offset = s.add(lanes, s.splat(((at as f64 - centre) * job.pixel_m) as f32));
            let [sent, mut difference] = seen.exact(s, 0, offset);
            let mut received = sent;
            if job.from_antennas_m.len() > 1 {
                let [range, of_received] = seen.exact(s, 1, offset);
                received = range;
                difference = mean(s, difference, of_received);
            }
            let t = s.mul_add(difference, a_metre, fraction);
            let i = s.sub(s.add(t, rounding), rounding);
            let delta = s.sub(t, i);
            // Both maxima also turn NaN into a number within the limits.
            let i = s.max(i, lowest);
            let i = s.sub(zero, s.max(s.sub(zero, i), s.sub(zero, highest)));
            let i = s.add(i, rounding);

            let square = s.mul(delta, delta);
            let mut cosine = s.splat(job.cosine[TERMS - 1]);
            let mut sine = s.splat(job.sine[TERMS - 2]);
            for k in (0..TERMS - 1).rev() {
                cosine = s.mul_add(cosine, square, s.splat(job.cosine[k]));
            }
            for k in (0..TERMS - 2).rev() {
                sine = s.mul_add(sine, square, s.splat(job.sine[k]));
            }
            sine = s.mul(sine, delta);
            // SAFETY: `at` + N ≤ `length`, the length of both parts; indices past `whole` are kept
            // within the limits, and every bin holds `step` numbers.
            unsafe {
                let re = s.load(job.real.as_ptr().add(at));
                let im = s.load(job.imag.as_ptr().add(at));
                let (re, im) = match &job.weight {
                    None => (re, im),
                    Some(RowWeight::Ways) => {
                        let weight = spreading(s, sent, received);
                        (s.mul(re, weight), s.mul(im, weight))
                    }
                    Some(RowWeight::Tilt(tilt)) => {
                        let first = s.splat((tilt.ratio + at as f64 * tilt.slope) as f32);
                        let a_metre = s.splat((tilt.slope / job.pixel_m) as f32);
                        let weight = tilt.power.of(s, s.mul_add(lanes, a_metre, first));
                        (s.mul(re, weight), s.mul(im, weight))
                    }
                };
                let (re, im) = (
                    s.mul_add(im, sine, s.mul(re, cosine)),
                    s.neg_mul_add(re, sine, s.mul(im, cosine)),
                );
                let (re1, im1) = (s.mul(re, delta), s.mul(im, delta));
                let to = bins.as_mut_ptr().add(whole as usize * step);
                s.scatter_add4(to, i, step, [re, im, re1, im1]);
                if DEGREE > 1 {
                    let (re2, im2) = (s.mul(re1, delta), s.mul(im1, delta));
                    let (re3, im3) = if DEGREE > 2 {
                        (s.mul(re2, delta), s.mul(im2, delta))
                    } else {
                        (zero, zero)
                    };
                    s.scatter_add4(to.add(4), i, step, [re2, im2, re3, im3]);
                }
            }
            at += n;
        }
        start = end;
    }
}
