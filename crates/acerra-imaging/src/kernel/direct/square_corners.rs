//! Half ways and weights over squares of pixels below uneven ground, from those at the corners.
//!
//! By Fermat's principle a ray tells the slope of the way too. Lengths and slopes at its corners determine a polynomial over
//! a square (Hermite).

use super::corners::MOST_CORNERS;
use super::square_expansion::Expansion;
use super::square_rays::{CUBE_SLOPE, TwoWays};
use super::tile_corners::{EDGE, NO_WEIGHT, TileCorners};
use crate::kernel::aligned::Aligned;
use crate::kernel::lanes::Lanes;

/// Half ways of pulse `m` of the chunk over the squares of a strip, and their weights; `fraction` is that of
/// [`TileCorners::base_m`] in bins.
#[inline(always)]
pub(super) fn ways<S: Lanes>(
    s: S,
    corners: &TileCorners,
    (strip, m): (usize, usize),
    (fraction, bin_m): (f32, f64),
) -> TwoWays<S> {
    let corner = corners.row(strip);
    let (from, followed) = (corner[0], corners.followed(m));
    assert!(from + S::N <= MOST_CORNERS);
    let w = Symmetric::at(s, &followed.beyond_m, corner);
    let u = Symmetric::at(s, &followed.change_m[0], corner);
    let v = Symmetric::at(s, &followed.change_m[1], corner);
    let bins = s.splat((1.0 / bin_m) as f32);
    // SAFETY: squares of a strip are N numbers within the array, as those of corners are.
    let has = unsafe { s.load(corners.has_polynomial().0.as_ptr().add(from)) };
    let kept = s.mul(bins, has);
    // With values and slopes at (±h, ±h), h = 2 pixels.
    let times = |a: S::V, by: f32| s.mul(a, s.splat(by));
    let (c21, c12) = (times(u.both, 0.125), times(v.both, 0.125));
    let (c20, c02) = (times(u.along, 0.25), times(v.across, 0.25));
    let (half_along, half_across) = (times(w.along, 0.5), times(w.across, 0.5));
    let c30 = times(s.sub(u.mean, half_along), 0.125);
    let c03 = times(s.sub(v.mean, half_across), 0.125);
    let edge = s.splat(EDGE * EDGE);
    let c10 = s.neg_mul_add(edge, s.add(c30, c12), half_along);
    let c01 = s.neg_mul_add(edge, s.add(c03, c21), half_across);
    let c00 = s.neg_mul_add(edge, s.add(c20, c02), w.mean);
    // Of i³j and ij³ the squares keep the nearest multiple of ij.
    let twisted = times(s.sub(s.add(u.across, v.along), w.both), 1.0 / 16.0);
    let c11 = s.neg_mul_add(edge, twisted, times(w.both, 0.25));
    let c11 = s.mul_add(twisted, s.splat(CUBE_SLOPE), c11);
    let zero = s.splat(0.0);
    let half = Expansion {
        range_m: zero,
        t: s.mul_add(c00, bins, s.splat(fraction)),
        slope: [s.mul(c10, kept), s.mul(c01, kept)],
        along_square: s.mul(c20, kept),
        product: s.mul(c11, kept),
        across_square: s.mul(c02, kept),
        inverse_bins: zero,
        truncation_error: zero,
        third: zero,
        uneven: zero,
        rise: zero,
        slope_change: [zero; 2],
        half_curvature: zero,
    };
    let cubes = [
        s.mul(c30, kept),
        s.mul(c21, kept),
        s.mul(c12, kept),
        s.mul(c03, kept),
    ];
    TwoWays::new(s, half, cubes, inverse(s, corners, has, (corner, m)))
}

/// One over the weights of the squares from `corner` on of pulse `m` of the chunk.
#[inline(always)]
fn inverse<S: Lanes>(
    s: S,
    corners: &TileCorners,
    has: S::V,
    (corner, m): ([usize; 2], usize),
) -> [S::V; 6] {
    let from = corner[0];
    let ([before, after], share) = corners.bends(m);
    let least = s.splat(1.0 / NO_WEIGHT);
    let at = Symmetric::of(
        s,
        &corners.followed(m).weight,
        corner,
        #[inline(always)]
        |weight| s.reciprocal(s.max(weight, least)),
    );
    assert!(from + S::N <= MOST_CORNERS);
    let bend = |axis: usize| {
        // SAFETY: checked above.
        let (a, b) = unsafe {
            (
                s.load(before[axis].0.as_ptr().add(from)),
                s.load(after[axis].0.as_ptr().add(from)),
            )
        };
        s.mul_add(s.splat(share), s.sub(b, a), a)
    };
    let [along, across] = [bend(0), bend(1)];
    let none = s.neg_mul_add(has, s.splat(NO_WEIGHT), s.splat(NO_WEIGHT));
    let middle = s.neg_mul_add(s.splat(EDGE * EDGE), s.add(along, across), at.mean);
    let kept = |of: S::V, by: f32| s.mul(of, s.mul(has, s.splat(by)));
    [
        s.add(kept(middle, 1.0), none),
        kept(at.along, 1.0 / EDGE),
        kept(at.across, 1.0 / EDGE),
        kept(along, 1.0),
        kept(at.both, 1.0 / (EDGE * EDGE)),
        kept(across, 1.0),
    ]
}

/// Sums of the values at the corners of squares, of even and odd sign along the row and across, divided by four.
struct Symmetric<S: Lanes> {
    mean: S::V,
    along: S::V,
    across: S::V,
    both: S::V,
}

impl<S: Lanes> Symmetric<S> {
    /// Of the squares whose first corners are at `from` and those after it.
    #[inline(always)]
    fn at(s: S, of: &Aligned<MOST_CORNERS>, corner: [usize; 2]) -> Self {
        Self::of(
            s,
            of,
            corner,
            #[inline(always)]
            |v| v,
        )
    }

    /// Of functions of the values.
    #[inline(always)]
    fn of(
        s: S,
        of: &Aligned<MOST_CORNERS>,
        [from, stride]: [usize; 2],
        value: impl Fn(S::V) -> S::V,
    ) -> Self {
        assert!(from + stride + 1 + S::N <= MOST_CORNERS);
        // SAFETY: checked above.
        let [a, b, c, d] = unsafe {
            let at = of.0.as_ptr().add(from);
            [
                s.load(at),
                s.load(at.add(1)),
                s.load(at.add(stride)),
                s.load(at.add(stride + 1)),
            ]
        };
        let [a, b, c, d] = [value(a), value(b), value(c), value(d)];
        let quarter = s.splat(0.25);
        let ([ab, cd], [ba, dc]) = ([s.add(a, b), s.add(c, d)], [s.sub(b, a), s.sub(d, c)]);
        Self {
            mean: s.mul(quarter, s.add(ab, cd)),
            along: s.mul(quarter, s.add(ba, dc)),
            across: s.mul(quarter, s.sub(cd, ab)),
            both: s.mul(quarter, s.sub(dc, ba)),
        }
    }
}
