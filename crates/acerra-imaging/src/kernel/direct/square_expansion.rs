//! Expansion of the range over squares of pixels.

use super::job::{GROUP, HALF, SIDE};
use super::square_setup::{Frame, SquareBlock, SquareSetup};
use crate::kernel::lanes::{Lanes, MAX_LANES, ROUNDING};
use crate::kernel::two_ways::{half_sum, half_sums, lesser};

/// The range over each group, one lane a group, in bins and pixels.
#[derive(Clone, Copy)]
pub(super) struct Expansion<S: Lanes> {
    /// Range at the middle from the nearer antenna, m.
    pub range_m: S::V,
    /// Range at the middle, bins past the whole bins of the block's middle.
    pub t: S::V,
    pub slope: [S::V; 2],
    /// Half the second derivative along the row.
    pub along_square: S::V,
    /// Mixed second derivative.
    pub product: S::V,
    /// Half the second derivative across.
    pub across_square: S::V,
    /// One over the range in bins.
    pub inverse_bins: S::V,
    /// Bound of the expansion's truncation error.
    pub truncation_error: S::V,
    /// Bound of the third-order part over a group.
    pub third: S::V,
    /// Bound of the change of range by heights off the planes of the groups.
    pub uneven: S::V,
    /// Derivative of the range with height (bins a metre).
    pub rise: S::V,
    /// Derivatives of both slopes with height.
    pub slope_change: [S::V; 2],
    pub half_curvature: S::V,
}

/// The groups of a block, one lane each.
pub(super) struct Groups<S: Lanes> {
    /// Offsets of the groups' middles from the block's middle along the row, m.
    pub along_m: S::V,
    /// Heights of the groups' middles above the block's middle, m; zero over level ground.
    pub plane_m: S::V,
    /// Slopes of the groups' planes.
    pub slope: [S::V; 2],
    /// Largest departures of pixels from the groups' planes, m.
    pub uneven_m: S::V,
    /// Squared lengths of the axes in the groups' planes (axes of the band are unit vectors).
    pub axes: [S::V; 2],
    /// Inner products of these axes.
    pub skew: S::V,
    /// Square of the greatest distance of a pixel from the middle, m².
    pub reach_square: S::V,
    /// That distance on a plane, m.
    pub reach: f32,
    /// Least range at which tables are read, m.
    pub near_m: S::V,
}

impl<S: Lanes> Groups<S> {
    #[inline(always)]
    pub fn of<const RELIEF: bool>(block: &SquareBlock<S>, frame: &Frame) -> Self {
        let (s, n) = (block.s, S::N);
        let [pu, pv] = frame.pixel_m.map(|p| p as f32);
        let mut offsets = [0f32; MAX_LANES];
        for (k, o) in offsets.iter_mut().enumerate() {
            // Groups without pixels repeat the last one that has any.
            let k = k.min(block.groups - 1) as f32;
            *o = (k - 0.5 * (n - 1) as f32) * SIDE as f32 * pu;
        }
        let zero = s.splat(0.0);
        let near_m = block.job.reference_below_m as f32 + (HALF + 1.0) * (pu + pv);
        let (one, skew) = (s.splat(1.0), frame.skew as f32);
        let reach_square = HALF * HALF * (pu * pu + pv * pv + 2.0 * pu * pv * skew.abs());
        let mut groups = Self {
            // SAFETY: `offsets` has MAX_LANES ≥ N numbers.
            along_m: unsafe { s.load(offsets.as_ptr()) },
            plane_m: zero,
            slope: [zero; 2],
            uneven_m: zero,
            axes: [one; 2],
            skew: s.splat(skew),
            reach_square: s.splat(reach_square),
            reach: reach_square.sqrt(),
            near_m: s.splat(near_m),
        };
        if RELIEF {
            let ground = block.ground;
            // SAFETY: all arrays have MAX_LANES ≥ N numbers.
            unsafe {
                groups.plane_m = s.load(ground.plane_m.as_ptr());
                groups.slope = [0, 1].map(|axis| s.load(ground.slope[axis].as_ptr()));
                groups.uneven_m = s.load(ground.uneven_m.as_ptr());
            }
            // Steep squares extend farther from their middles.
            let [su, sv] = groups.slope.map(|slope| s.abs(slope));
            let rise = s.mul_add(su, s.splat(pu), s.mul(sv, s.splat(pv)));
            let more = s.mul_add(rise, s.splat(HALF + 1.0), groups.uneven_m);
            groups.near_m = s.add(groups.near_m, more);
            let [su, sv] = groups.slope;
            groups.axes = [s.mul_add(su, su, one), s.mul_add(sv, sv, one)];
            groups.skew = s.mul_add(su, sv, groups.skew);
            let [uu, vv] = groups.axes;
            let square = s.mul_add(uu, s.splat(pu * pu), s.mul(vv, s.splat(pv * pv)));
            let square = s.mul_add(s.abs(groups.skew), s.splat(2.0 * pu * pv), square);
            let reach = s.mul_add(s.sqrt(square), s.splat(HALF), groups.uneven_m);
            groups.reach_square = s.mul(reach, reach);
        }
        groups
    }
}

impl<S: Lanes> Expansion<S> {
    #[inline(always)]
    pub fn of<const CUBIC: bool, const RELIEF: bool>(
        s: S,
        groups: &Groups<S>,
        setup: &SquareSetup,
        (antenna, m): (usize, usize),
        bin_m: f64,
    ) -> Self {
        let frame = &setup.frame;
        let [pu, pv] = frame.pixel_m.map(|p| p as f32);
        let (skew, bins) = (frame.skew as f32, (1.0 / bin_m) as f32);
        let (one, zero, tiny) = (s.splat(1.0), s.splat(0.0), s.splat(1e-30));
        let seen = &setup.from[antenna][m];
        let range0 = s.splat(seen.range_m);
        let (along0, up0) = (s.splat(seen.along_m), s.splat(seen.up_m));
        let along = s.add(along0, groups.along_m);
        let across = s.mul_add(groups.along_m, s.splat(skew), s.splat(seen.across_m));
        let up = s.add(up0, groups.plane_m);
        let mut square_difference = s.mul(groups.along_m, s.add(along, along0));
        if RELIEF {
            square_difference = s.mul_add(groups.plane_m, s.add(up, up0), square_difference);
        }
        let square = s.max(s.mul_add(range0, range0, square_difference), tiny);
        let range = s.sqrt(square);
        let difference = s.div(square_difference, s.add(range, range0));
        let inverse = s.div(one, range);
        // Slopes of the range along the axes of the group's plane, followed by the squared lengths and the
        // inner product of these axes.
        let (mut u, mut v) = (s.mul(along, inverse), s.mul(across, inverse));
        let ([uu, vv], uv) = (groups.axes, groups.skew);
        let mut rise = zero;
        if RELIEF {
            let [su, sv] = groups.slope;
            rise = s.mul(up, inverse);
            (u, v) = (s.mul_add(su, rise, u), s.mul_add(sv, rise, v));
        }
        let curvature = s.mul(inverse, s.splat(0.5 * bins));
        let along_square = s.mul(s.mul(curvature, s.splat(pu * pu)), s.neg_mul_add(u, u, uu));
        let across_square = s.mul(s.mul(curvature, s.splat(pv * pv)), s.neg_mul_add(v, v, vv));
        let product = s.mul(
            s.mul(curvature, s.splat(2.0 * pu * pv)),
            s.neg_mul_add(u, v, uv),
        );
        let slope = [s.mul(u, s.splat(pu * bins)), s.mul(v, s.splat(pv * bins))];
        let half = s.splat(HALF);
        let mut most_linear = s.mul(half, s.add(s.abs(slope[0]), s.abs(slope[1])));
        let mut most_square = s.mul(
            s.splat(HALF * HALF),
            s.add(s.add(along_square, s.abs(product)), across_square),
        );
        let mut expansion = Self {
            range_m: range,
            t: s.mul_add(difference, s.splat(bins), s.splat(setup.fraction[m])),
            slope,
            along_square,
            product,
            across_square,
            inverse_bins: s.mul(inverse, s.splat(1.0 / bins)),
            truncation_error: zero,
            third: zero,
            uneven: zero,
            rise: zero,
            slope_change: [zero; 2],
            half_curvature: zero,
        };
        if RELIEF {
            let change = |slope: S::V, of: S::V, pixel: f32| {
                let along = s.neg_mul_add(of, rise, slope);
                s.mul(s.mul(along, inverse), s.splat(pixel * bins))
            };
            let [su, sv] = groups.slope;
            expansion.uneven = s.mul(groups.uneven_m, s.splat(bins));
            expansion.rise = s.mul(rise, s.splat(bins));
            expansion.slope_change = [change(su, u, pu), change(sv, v, pv)];
            expansion.half_curvature = s.mul(curvature, s.neg_mul_add(rise, rise, one));
            let [cu, cv] = expansion.slope_change.map(|c| s.abs(c));
            let of_slopes = s.mul(half, s.add(cu, cv));
            let of_height = s.mul_add(expansion.half_curvature, groups.uneven_m, of_slopes);
            most_linear = s.mul_add(groups.uneven_m, s.abs(expansion.rise), most_linear);
            most_square = s.mul_add(groups.uneven_m, of_height, most_square);
        }
        let third = s.mul(s.mul(most_linear, most_square), expansion.inverse_bins);
        expansion.third = third;
        expansion.truncation_error = if CUBIC {
            // The fourth derivative is at most 12 (1 − gradient²)/R³ along any direction.
            let ratio = s.mul(s.mul(inverse, inverse), groups.reach_square);
            s.mul(ratio, most_square)
        } else {
            third
        };
        expansion
    }

    /// Half the way there and back, from those of its parts.
    ///
    /// Of third order it has the product of the means, linear part times square part over range, for the mean of the
    /// products: what that drops are the products of two half differences and a mean.
    #[inline(always)]
    pub fn mean<const CUBIC: bool>(self, s: S, other: Self, uneven_m: S::V) -> Self {
        let mut mean = self.half_sum(s, &other, s.splat(1.0));
        mean.range_m = lesser(s, self.range_m, other.range_m);
        if CUBIC {
            let apart = self.half_sum(s, &other, s.splat(-1.0));
            let [linear, square] = mean.most(s, uneven_m);
            let [linear_apart, square_apart] = apart.most(s, uneven_m);
            let one = s.mul_add(linear, square_apart, s.mul(square, linear_apart));
            let both = s.mul(linear_apart, square_apart);
            let dropped = s.mul_add(
                one,
                s.abs(apart.inverse_bins),
                s.mul(both, mean.inverse_bins),
            );
            mean.truncation_error = s.add(mean.truncation_error, dropped);
        }
        mean
    }

    /// Half of the sum of two expansions, or half of their difference where `sign` is −1.
    #[inline(always)]
    pub fn half_sum(&self, s: S, other: &Self, sign: S::V) -> Self {
        half_sums!(
            (s, sign, self, other),
            [
                range_m,
                t,
                along_square,
                product,
                across_square,
                inverse_bins,
                truncation_error,
                third,
                uneven,
                rise,
                half_curvature,
            ],
            [slope, slope_change]
        )
    }

    /// Bounds of the linear and of the quadratic part over a group whose heights depart by up to `uneven_m`
    /// from the group's plane, bins.
    #[inline(always)]
    fn most(&self, s: S, uneven_m: S::V) -> [S::V; 2] {
        let half = s.splat(HALF);
        let slopes = s.add(s.abs(self.slope[0]), s.abs(self.slope[1]));
        let squares = s.add(s.abs(self.along_square), s.abs(self.product));
        let squares = s.add(squares, s.abs(self.across_square));
        let changes = s.add(s.abs(self.slope_change[0]), s.abs(self.slope_change[1]));
        let of_height = s.mul_add(s.abs(self.half_curvature), uneven_m, s.mul(half, changes));
        [
            s.mul_add(uneven_m, s.abs(self.rise), s.mul(half, slopes)),
            s.mul_add(uneven_m, of_height, s.mul(s.splat(HALF * HALF), squares)),
        ]
    }

    /// Number of bins that a vector spans, and for either vector of a group the whole bins at which its
    /// window must start.
    #[inline(always)]
    pub fn windows<const CUBIC: bool, const RELIEF: bool>(&self, s: S) -> (S::V, [S::V; 2]) {
        let vectors = GROUP / S::N;
        // Rows from a vector's middle to its edge, and from the group's middle to the vectors' middles.
        let rows = 0.5 * (SIDE / vectors - 1) as f32;
        let shift = 0.5 * ((vectors - 1) * SIDE / vectors) as f32;
        // A range is convex: over a vector it stays above its tangent plane at the vector's middle,
        // whose slopes differ from those of the group's by the second derivatives.
        let along = s.mul_add(s.abs(self.product), s.splat(shift), s.abs(self.slope[0]));
        let across = s.mul_add(
            self.across_square,
            s.splat(2.0 * shift),
            s.abs(self.slope[1]),
        );
        let mut reach = s.mul_add(across, s.splat(rows), s.mul(along, s.splat(HALF)));
        if CUBIC {
            reach = s.mul_add(self.third, s.splat(3.0), reach);
        }
        if RELIEF {
            // A range changes by no more than a height does.
            reach = s.add(reach, self.uneven);
        }
        let bend = s.mul_add(
            self.across_square,
            s.splat(rows * rows),
            s.mul_add(
                s.abs(self.product),
                s.splat(HALF * rows),
                s.mul(self.along_square, s.splat(HALF * HALF)),
            ),
        );
        let span = s.add(s.add(reach, reach), bend);
        // Half a bin up for rounding, a little down for safety.
        let lowest = s.mul_add(
            self.across_square,
            s.splat(shift * shift),
            s.sub(self.t, s.sub(reach, s.splat(0.499))),
        );
        let windows = [
            s.floor(s.neg_mul_add(self.slope[1], s.splat(shift), lowest)),
            s.floor(s.mul_add(self.slope[1], s.splat(shift), lowest)),
        ];
        (span, windows)
    }

    /// Stores the parameters of a pulse in `rows`, windows counted from `start` in the chunk's table.
    #[inline(always)]
    pub fn store<const RELIEF: bool>(
        &self,
        s: S,
        windows: [S::V; 2],
        start: i32,
        rows: &mut [f32],
    ) {
        let n = S::N;
        let rounding = s.splat(ROUNDING);
        assert!(rows.len() >= SquareSetup::rows(RELIEF, false) * n);
        // SAFETY: `rows` holds that many rows of N numbers.
        unsafe {
            let at = rows.as_mut_ptr();
            s.store(at, self.slope[0]);
            s.store(at.add(n), self.slope[1]);
            s.store(at.add(2 * n), self.along_square);
            s.store(at.add(3 * n), self.product);
            s.store(at.add(4 * n), self.across_square);
            s.store(at.add(5 * n), self.inverse_bins);
            for (side, window) in windows.into_iter().enumerate().take(GROUP / n) {
                s.store(at.add((6 + 2 * side) * n), s.sub(self.t, window));
                let bits = at.add((7 + 2 * side) * n).cast();
                s.store_rounded(bits, s.add(window, rounding), start);
            }
            if RELIEF {
                s.store(at.add(10 * n), self.rise);
                s.store(at.add(11 * n), self.slope_change[0]);
                s.store(at.add(12 * n), self.slope_change[1]);
                s.store(at.add(13 * n), self.half_curvature);
            }
        }
    }
}
