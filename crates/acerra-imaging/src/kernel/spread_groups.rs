//! The transposed direct kernel for pixels that are small relative to a wavelength: groups of neighbouring
//! pixels are summed in registers and added to a range bin once a group.
//!
//! [`spread_row`](super::spread::spread_row) adds to a bin Σ v e^{−jαδ} δ^p over its pixels, δ being the
//! distance from the bin's centre. A group's pixels all go to the bin of the group's middle, whose
//! polynomials are fitted far enough beyond the bin's edges. With δ = u + ε, ε from the bin's centre to the
//! group's middle and u from there to a pixel, these sums are e^{−jαε} Σ_q C(p, q) ε^{p−q} Σ v e^{−jαu} u^q:
//! moments about the group's middle, moved once. Lanes are neighbouring groups; ranges over a group are
//! expanded to second order about its middle.

use super::lanes::{Lanes, MAX_LANES, ROUNDING};
use super::spread::step;
use super::spread_expansion::{Expanded, Fallback, Strip, StripGeometry};
use std::f64::consts::PI;

/// Degree of the moments.
pub(crate) const DEGREE: usize = 3;
/// Most coefficients of the polynomials over half a turn.
pub(crate) const MAX_TERMS: usize = 5;

/// Groups of a strip, a pulse, and the bins between them.
pub(crate) struct SpreadStrip<'a> {
    pub geometry: StripGeometry<'a>,
    /// Real and imaginary parts `[strips, blocks, ROWS, COLUMNS, MAX_LANES]`: pixels of the same place in
    /// their groups side by side, zeros beyond the image.
    pub real: &'a [f32],
    pub imag: &'a [f32],
    /// Two-way carrier phase advance per range bin, α, rad.
    pub carrier_rad: f64,
    /// Phase error allowed to the range expansion, rad.
    pub phase_tolerance_rad: f64,
    /// Distance from a bin's centre up to which polynomials hold, m.
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
    fallback: &mut Fallback,
) {
    let n = S::N;
    let geometry = &job.geometry;
    let entries = geometry.entries;
    const { assert!(step(DEGREE) == 8) };
    geometry.check::<S>(
        COLUMNS * ROWS,
        [job.real, job.imag],
        bins.len(),
        step(DEGREE),
    );
    assert!(TERMS <= MAX_TERMS);

    let half_turns_a_metre = job.carrier_rad / (PI * geometry.bin_m);
    let tolerance = job.phase_tolerance_rad / PI;
    let shared = Strip::<S, COLUMNS, ROWS, false>::of(s, geometry, half_turns_a_metre, tolerance);
    let reach = s.splat((job.reach_m * half_turns_a_metre) as f32);
    let moments = Moments::<S, COLUMNS, ROWS, TERMS>::of(s, job);
    let (rounding, zero) = (s.splat(ROUNDING), s.splat(0.0));
    for (strip, first) in geometry.blocks(n) {
        let expanded = shared
            .expand(strip, first)
            .filter(|at| s.all_le(at.reach, reach));
        let Some(at) = expanded else {
            fallback((strip, geometry.block(first, n)), bins);
            continue;
        };
        let start = geometry.start(strip, first, COLUMNS * ROWS);
        // SAFETY: `first` is a multiple of N and less than the groups' end, so that N lanes of its block
        // lie within both parts, for each of the block's places.
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
        let moved = moments.moved(sums, s.sub(at.t, i), at.weight);
        let i = s.add(i, rounding);
        // SAFETY: indices past `whole` are kept within the limits, and every bin holds 8 numbers.
        unsafe {
            let to = bins.as_mut_ptr().add(at.whole as usize * step(DEGREE));
            s.scatter_add8(to, i, moved);
        }
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
                let square = s.mul(u, u);
                let cube = s.mul(square, u);
                sums[0] = [s.add(sums[0][0], re), s.add(sums[0][1], im)];
                for (sum, power) in sums[1..].iter_mut().zip([u, square, cube]) {
                    *sum = [s.mul_add(re, power, sum[0]), s.mul_add(im, power, sum[1])];
                }
            }
        }
        sums
    }

    /// Moments in bins about the bins' centres, from which the groups' middles are `epsilon` bins away, times `weight`
    /// where there is one: the eight numbers that are added to a bin.
    #[inline(always)]
    fn moved(&self, sums: Sums<S>, epsilon: S::V, weight: Option<S::V>) -> [S::V; 8] {
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
        if let Some(weight) = weight {
            (cosine, sine) = (s.mul(cosine, weight), s.mul(sine, weight));
        }
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

    /// Moments about a point, from the moments about a point `epsilon` away.
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
