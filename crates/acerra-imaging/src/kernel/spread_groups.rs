//! The transposed direct kernel for pixels that are small beside a wavelength: groups of neighbouring
//! pixels are summed in registers and added to a range bin once a group.
//!
//! [`spread_row`](super::spread::spread_row) adds to a bin Σ v e^{−jαδ} δ^p over its pixels, δ being the
//! distance from the bin's centre. A group's pixels all go to the bin of the group's middle, whose
//! polynomials hold so far beyond its edges. With δ = u + ε, ε from the bin's centre to the group's middle
//! and u from there to a pixel, the same sums are e^{−jαε} Σ_q C(p, q) ε^{p−q} Σ v e^{−jαu} u^q: moments
//! about the group's middle, moved once. Lanes are neighbouring groups; ranges over a group are expanded to
//! second order about its middle.

use super::lanes::{Lanes, MAX_LANES, ROUNDING};
use super::spread::step;
use crate::vector::{dot, norm};
use std::f64::consts::PI;
use std::ops::Range;

/// Degree of the moments.
pub(crate) const DEGREE: usize = 3;
/// Most coefficients of the polynomials over half a turn.
pub(crate) const MAX_TERMS: usize = 5;

/// Shape and error budget of groups of pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GroupSpec {
    /// Pixels of a group along the row and across: 4 × 4, 4 × 2 or 2 × 2.
    pub shape: [usize; 2],
    /// Coefficients of the cosine over half a turn; the sine has one less.
    pub terms: usize,
    /// Distance from a group's middle up to which polynomials hold, m.
    pub reach_m: f64,
}

/// One row of groups, a pulse, and the bins between them.
pub(crate) struct SpreadStrip<'a> {
    /// From the antenna to the strip's first pixel, m.
    pub from_antenna_m: [f64; 3],
    /// Unit vectors along the rows and across them, and the pixels' distances, m.
    pub unit: [[f64; 3]; 2],
    pub pixel_m: [f64; 2],
    /// Real and imaginary parts `[blocks, ROWS, COLUMNS, MAX_LANES]`: pixels of the same place in their
    /// groups side by side, zeros beyond the image.
    pub real: &'a [f32],
    pub imag: &'a [f32],
    /// Groups that hold pixels.
    pub groups: usize,
    pub bin_m: f64,
    /// Absolute number of the pulse's first bin.
    pub first_bin: i64,
    /// Two-way carrier phase advance per range bin, α, rad.
    pub carrier_rad: f64,
    /// Blocks nearer than this go elsewhere, m.
    pub reference_below_m: f64,
    /// Phase error allowed to the range expansion, rad.
    pub phase_tolerance_rad: f64,
    /// Distance from a group's middle up to which polynomials hold, m.
    pub reach_m: f64,
    /// cos αδ and sin(αδ)/δ in powers of δ², |δ| ≤ ½ bin.
    pub cosine: [f32; 4],
    pub sine: [f32; 4],
    /// cos πr and sin(πr)/r in powers of r², |r| ≤ ½.
    pub turn_cosine: [f32; MAX_TERMS],
    pub turn_sine: [f32; MAX_TERMS],
}

/// Adds the strip to `bins` `[entries, step]` of degree 3. Blocks of groups for which the expansion does
/// not hold go to `fallback`.
///
/// Groups hold `COLUMNS` × `ROWS` pixels; `TERMS` counts the coefficients of the cosine over half a turn.
#[inline(always)]
pub(crate) fn spread_strip<
    S: Lanes,
    const COLUMNS: usize,
    const ROWS: usize,
    const TERMS: usize,
>(
    s: S,
    job: &SpreadStrip,
    bins: &mut [f32],
    fallback: &mut dyn FnMut(Range<usize>, &mut [f32]),
) {
    let n = S::N;
    const { assert!(step(DEGREE) == 8) };
    let entries = bins.len() / step(DEGREE);
    let block_length = ROWS * COLUMNS * MAX_LANES;
    let length = job.groups.div_ceil(MAX_LANES) * block_length;
    assert!(job.real.len() == length && job.imag.len() == length);
    assert!(MAX_LANES.is_multiple_of(n) && TERMS <= MAX_TERMS && entries > 0);

    let mut lane = [0f32; MAX_LANES];
    for (k, v) in lane.iter_mut().enumerate() {
        let groups = k as f64 - 0.5 * (n - 1) as f64;
        *v = (groups * COLUMNS as f64 * job.pixel_m[0]) as f32;
    }
    // SAFETY: `lane` has MAX_LANES ≥ N numbers.
    let offsets_m = unsafe { s.load(lane.as_ptr()) };
    let strip = Strip::<S, COLUMNS, ROWS>::of(s, job, offsets_m);
    let moments = Moments::<S, COLUMNS, ROWS, TERMS>::of(s, job);
    let (rounding, zero) = (s.splat(ROUNDING), s.splat(0.0));
    let mut first = 0;
    while first < job.groups {
        let block = first..(first + n).min(job.groups);
        let expanded = strip.expand(first, entries);
        let Some(at) = expanded else {
            fallback(block, bins);
            first += n;
            continue;
        };
        let start = first / MAX_LANES * block_length + first % MAX_LANES;
        // SAFETY: `first` is a multiple of N and less than `groups`, so that N lanes of its block lie
        // within both parts, for each of the block's places.
        let sums = unsafe {
            moments.sum(
                &at,
                job.real.as_ptr().add(start),
                job.imag.as_ptr().add(start),
            )
        };
        let i = s.sub(s.add(at.t, rounding), rounding);
        let i = s.max(i, s.splat(-(at.whole as f32)));
        let highest = s.splat((entries as i32 - 1 - at.whole) as f32);
        let i = s.sub(zero, s.max(s.sub(zero, i), s.sub(zero, highest)));
        let moved = moments.moved(sums, s.sub(at.t, i));
        let i = s.add(i, rounding);
        // SAFETY: indices past `whole` are kept within the limits, and every bin holds 8 numbers.
        unsafe {
            let to = bins.as_mut_ptr().add(at.whole as usize * step(DEGREE));
            s.scatter_add8(to, i, moved);
        }
        first += n;
    }
}

/// What all blocks of a strip share.
struct Strip<'a, S: Lanes, const COLUMNS: usize, const ROWS: usize> {
    s: S,
    job: &'a SpreadStrip<'a>,
    /// From the block's middle to its groups' middles, m.
    offsets_m: S::V,
    skew: S::V,
    /// Half turns of the carrier a metre, and the pixels' distances, m.
    half_turns_a_metre: f32,
    pixel: [f32; 2],
    tolerance: S::V,
    reach: S::V,
}

/// The range over each group about its middle, one lane a group, in half turns of the carrier and pixels.
struct Expanded<S: Lanes> {
    slope: [S::V; 2],
    /// Half the second derivative along, the mixed one, and half that across.
    along_square: S::V,
    product: S::V,
    across_square: S::V,
    /// The range at the middle in bins past `whole`.
    t: S::V,
    whole: i32,
}

impl<'a, S: Lanes, const COLUMNS: usize, const ROWS: usize> Strip<'a, S, COLUMNS, ROWS> {
    #[inline(always)]
    fn of(s: S, job: &'a SpreadStrip<'a>, offsets_m: S::V) -> Self {
        let half_turns_a_metre = job.carrier_rad / (PI * job.bin_m);
        Self {
            s,
            job,
            offsets_m,
            skew: s.splat(dot(job.unit[0], job.unit[1]) as f32),
            half_turns_a_metre: half_turns_a_metre as f32,
            pixel: job.pixel_m.map(|p| p as f32),
            tolerance: s.splat((job.phase_tolerance_rad / PI) as f32),
            reach: s.splat((job.reach_m * half_turns_a_metre) as f32),
        }
    }

    /// Expands the ranges of the block from group `first` on; `None` where that does not hold.
    #[inline(always)]
    fn expand(&self, first: usize, entries: usize) -> Option<Expanded<S>> {
        let (s, job) = (self.s, self.job);
        let half = [0.5 * (COLUMNS * S::N - 1) as f64, 0.5 * (ROWS - 1) as f64];
        let along_m = ((first * COLUMNS) as f64 + half[0]) * job.pixel_m[0];
        let across_m = half[1] * job.pixel_m[1];
        let d: [f64; 3] = std::array::from_fn(|a| {
            job.from_antenna_m[a] + along_m * job.unit[0][a] + across_m * job.unit[1][a]
        });
        let range_m = norm(d);
        let block_m = half[0] * job.pixel_m[0] + half[1] * job.pixel_m[1];
        // False for NaN too.
        let far = range_m - block_m >= job.reference_below_m;
        if !far {
            return None;
        }
        let t0 = range_m / job.bin_m - job.first_bin as f64;
        let whole = (t0 as i32).clamp(0, entries as i32 - 1);
        let (one, tiny) = (s.splat(1.0), s.splat(1e-30));
        let (range0, along0) = (s.splat(range_m as f32), dot(d, job.unit[0]) as f32);
        let along = s.add(s.splat(along0), self.offsets_m);
        let across = s.splat(dot(d, job.unit[1]) as f32);
        let across = s.mul_add(self.offsets_m, self.skew, across);
        let square_difference = s.mul(self.offsets_m, s.add(along, s.splat(along0)));
        let square = s.max(s.mul_add(range0, range0, square_difference), tiny);
        let range = s.sqrt(square);
        let difference = s.div(square_difference, s.add(range, range0));
        let inverse = s.div(one, range);
        let (u, v) = (s.mul(along, inverse), s.mul(across, inverse));
        let (turns, [pu, pv]) = (self.half_turns_a_metre, self.pixel);
        let curvature = s.mul(inverse, s.splat(0.5 * turns));
        let along_square = s.mul(curvature, s.splat(pu * pu));
        let along_square = s.mul(along_square, s.neg_mul_add(u, u, one));
        let across_square = s.mul(curvature, s.splat(pv * pv));
        let across_square = s.mul(across_square, s.neg_mul_add(v, v, one));
        let product = s.mul(curvature, s.splat(2.0 * pu * pv));
        let product = s.mul(product, s.neg_mul_add(u, v, self.skew));
        let slope = [s.mul(u, s.splat(pu * turns)), s.mul(v, s.splat(pv * turns))];

        let [hu, hv] = [COLUMNS, ROWS].map(|side| 0.5 * (side - 1) as f32);
        let linear = s.mul_add(
            s.abs(slope[0]),
            s.splat(hu),
            s.mul(s.abs(slope[1]), s.splat(hv)),
        );
        let squares = s.mul_add(
            along_square,
            s.splat(hu * hu),
            s.mul_add(
                s.abs(product),
                s.splat(hu * hv),
                s.mul(across_square, s.splat(hv * hv)),
            ),
        );
        // Third order −LQ/R for linear and quadratic parts L and Q; what follows is below Q²/R.
        let reach = s.add(linear, squares);
        let dropped = s.mul(s.mul(squares, reach), s.mul(inverse, s.splat(1.0 / turns)));
        if !s.all_le(dropped, self.tolerance) || !s.all_le(reach, self.reach) {
            return None;
        }
        let fraction = s.splat((t0 - f64::from(whole)) as f32);
        Some(Expanded {
            slope,
            along_square,
            product,
            across_square,
            t: s.mul_add(difference, s.splat((1.0 / job.bin_m) as f32), fraction),
            whole,
        })
    }
}

/// Sums over the pixels of groups.
struct Moments<S: Lanes, const COLUMNS: usize, const ROWS: usize, const TERMS: usize> {
    s: S,
    bins_a_half_turn: S::V,
    cosine: [S::V; 4],
    sine: [S::V; 4],
    turn_cosine: [S::V; MAX_TERMS],
    turn_sine: [S::V; MAX_TERMS],
}

/// Real and imaginary parts of the moments 0 to 3.
type Sums<S> = [[<S as Lanes>::V; 2]; DEGREE + 1];

impl<S: Lanes, const COLUMNS: usize, const ROWS: usize, const TERMS: usize>
    Moments<S, COLUMNS, ROWS, TERMS>
{
    #[inline(always)]
    fn of(s: S, job: &SpreadStrip) -> Self {
        Self {
            s,
            bins_a_half_turn: s.splat((PI / job.carrier_rad) as f32),
            cosine: job.cosine.map(|c| s.splat(c)),
            sine: job.sine.map(|c| s.splat(c)),
            turn_cosine: job.turn_cosine.map(|c| s.splat(c)),
            turn_sine: job.turn_sine.map(|c| s.splat(c)),
        }
    }

    /// Σ v e^{−jπu} u^p over the pixels of each group, u in half turns from the group's middle.
    ///
    /// # Safety
    /// N numbers must be readable at `real` and `imag` and [`MAX_LANES`] after them for every further
    /// place in the groups.
    #[inline(always)]
    unsafe fn sum(&self, at: &Expanded<S>, real: *const f32, imag: *const f32) -> Sums<S> {
        let s = self.s;
        let rounding = s.splat(ROUNDING);
        let mut sums: Sums<S> = [[s.splat(0.0); 2]; DEGREE + 1];
        for row in 0..ROWS {
            let y = s.splat(row as f32 - 0.5 * (ROWS - 1) as f32);
            let rise = s.mul(y, s.mul_add(y, at.across_square, at.slope[1]));
            let slope = s.mul_add(y, at.product, at.slope[0]);
            for column in 0..COLUMNS {
                let x = s.splat(column as f32 - 0.5 * (COLUMNS - 1) as f32);
                let u = s.mul_add(x, s.mul_add(x, at.along_square, slope), rise);
                let i = s.add(u, rounding);
                let r = s.sub(u, s.sub(i, rounding));
                let square = s.mul(r, r);
                let (mut cosine, mut sine) =
                    (self.turn_cosine[TERMS - 1], self.turn_sine[TERMS - 2]);
                for k in (0..TERMS - 1).rev() {
                    cosine = s.mul_add(cosine, square, self.turn_cosine[k]);
                }
                for k in (0..TERMS - 2).rev() {
                    sine = s.mul_add(sine, square, self.turn_sine[k]);
                }
                // e^{−jπu} = (−1)^i e^{−jπr}
                cosine = s.negate_odd(cosine, i);
                sine = s.negate_odd(s.mul(sine, r), i);
                let place = (row * COLUMNS + column) * MAX_LANES;
                // SAFETY: the caller vouches for every place in the groups.
                let (re, im) = unsafe { (s.load(real.add(place)), s.load(imag.add(place))) };
                let (re, im) = (
                    s.mul_add(im, sine, s.mul(re, cosine)),
                    s.neg_mul_add(re, sine, s.mul(im, cosine)),
                );
                let (re1, im1) = (s.mul(re, u), s.mul(im, u));
                let (re2, im2) = (s.mul(re1, u), s.mul(im1, u));
                sums[0] = [s.add(sums[0][0], re), s.add(sums[0][1], im)];
                sums[1] = [s.add(sums[1][0], re1), s.add(sums[1][1], im1)];
                sums[2] = [s.add(sums[2][0], re2), s.add(sums[2][1], im2)];
                sums[3] = [s.mul_add(re2, u, sums[3][0]), s.mul_add(im2, u, sums[3][1])];
            }
        }
        sums
    }

    /// Moments in bins about the bins' centres, from which the groups' middles are `epsilon` bins away:
    /// the eight numbers that are added to a bin.
    #[inline(always)]
    fn moved(&self, sums: Sums<S>, epsilon: S::V) -> [S::V; 8] {
        let s = self.s;
        let square = s.mul(epsilon, epsilon);
        let (mut cosine, mut sine) = (self.cosine[3], self.sine[2]);
        for k in (0..3).rev() {
            cosine = s.mul_add(cosine, square, self.cosine[k]);
        }
        for k in (0..2).rev() {
            sine = s.mul_add(sine, square, self.sine[k]);
        }
        sine = s.mul(sine, epsilon);
        let b = self.bins_a_half_turn;
        let scales = [s.splat(1.0), b, s.mul(b, b), s.mul(s.mul(b, b), b)];
        let mut m = sums;
        for (m, scale) in m.iter_mut().zip(scales) {
            let (re, im) = (s.mul(m[0], scale), s.mul(m[1], scale));
            *m = [
                s.mul_add(im, sine, s.mul(re, cosine)),
                s.neg_mul_add(re, sine, s.mul(im, cosine)),
            ];
        }
        let re = self.about(m.map(|m| m[0]), epsilon);
        let im = self.about(m.map(|m| m[1]), epsilon);
        [re[0], im[0], re[1], im[1], re[2], im[2], re[3], im[3]]
    }

    /// Moments about a point from those about another, `epsilon` away.
    #[inline(always)]
    fn about(&self, [m0, m1, m2, m3]: [S::V; 4], epsilon: S::V) -> [S::V; 4] {
        let s = self.s;
        let three = s.splat(3.0);
        let first = s.mul_add(epsilon, m0, m1);
        let second = s.mul_add(epsilon, s.add(first, m1), m2);
        let third = s.mul_add(epsilon, m0, s.mul(three, m1));
        let third = s.mul_add(epsilon, third, s.mul(three, m2));
        [m0, first, second, s.mul_add(epsilon, third, m3)]
    }
}
