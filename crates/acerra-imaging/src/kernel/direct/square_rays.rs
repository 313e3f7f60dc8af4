//! Half the optical way over squares of pixels below level ground, for antennas apart.
//!
//! The optical length of a ray and its weight are functions P and w of the straight distance R. Their polynomials
//! about the middle of a square follow from those of R, G + Q − GQ/R with a linear part G and a quadratic part Q:
//! P′G + (P′Q + P″G²/2) + G((P″ − P′/R)Q + P‴G²/6). The mean of both antennas is that of the coefficients, the weight
//! of a contribution one over the product of both polynomials up to second order: one over a weight is close to a power
//! of the distance, whose terms of third order are small.

use super::job::HALF;
use super::rays::{RayRow, Rays, RaysView};
use super::square_expansion::{Expansion, Groups};
use super::square_setup::{CUBE_ROW, FLAT_ROW, RAY_ROWS, Seen, SquareSetup, WEIGHT_ROW};
use crate::kernel::lanes::Lanes;
use crate::kernel::two_ways::half_sum;

/// Share of the allowed error up to which the last orders are left out.
const FLAT: f32 = 0.6;
/// Mean of the square of a pixel's place in a square along an axis, and the slope of the line nearest to its cube.
const MEAN_SQUARE: f32 = 1.25;
pub(super) const CUBE_SLOPE: f32 = 2.05;
/// Root mean square of the third order that linear terms leave, at most, relative to the bound of the third order.
const LEFT: f32 = 0.35;

/// One antenna's way to the groups of a block, one lane a group.
struct OneWay<S: Lanes> {
    /// The optical length, in bins and pixels.
    way: Expansion<S>,
    /// Coefficients of i³, i²j, ij² and j³.
    cubes: [S::V; 4],
    /// One over the weight at the middle, its changes along the row and across, and its terms of i², ij and j².
    inverse: [S::V; 6],
    /// Bound of its third order over the square.
    inverse_third: S::V,
}

/// Half the way there and back, and the weight of a contribution.
pub(super) struct TwoWays<S: Lanes> {
    pub half: Expansion<S>,
    cubes: [S::V; 4],
    /// One over the weight of a contribution, as that of one way.
    inverse: [S::V; 6],
    inverse_third: S::V,
}

/// a·x + b·y of quadratic forms x and y.
#[inline(always)]
fn sums<S: Lanes>(s: S, [a, b]: [S::V; 2], x: &[S::V; 3], y: &[S::V; 3]) -> [S::V; 3] {
    [
        s.mul_add(a, x[0], s.mul(b, y[0])),
        s.mul_add(a, x[1], s.mul(b, y[1])),
        s.mul_add(a, x[2], s.mul(b, y[2])),
    ]
}

#[inline(always)]
fn absolute_sum<S: Lanes>(s: S, [a, b]: [S::V; 2]) -> S::V {
    s.add(s.abs(a), s.abs(b))
}

/// Bound of the third order over a square.
#[inline(always)]
fn third_order<S: Lanes>(s: S, cubes: &[S::V; 4]) -> S::V {
    let third = s.add(
        absolute_sum(s, [cubes[0], cubes[1]]),
        absolute_sum(s, [cubes[2], cubes[3]]),
    );
    s.mul(third, s.splat(HALF * HALF * HALF))
}

/// Sum of the magnitudes of a polynomial's linear terms.
#[inline(always)]
fn linear_sum<S: Lanes>(s: S, of: &[S::V; 6]) -> S::V {
    absolute_sum(s, [of[1], of[2]])
}

/// Sum of the magnitudes of its quadratic terms.
#[inline(always)]
fn square_sum<S: Lanes>(s: S, of: &[S::V; 6]) -> S::V {
    s.add(absolute_sum(s, [of[3], of[4]]), s.abs(of[5]))
}

/// The terms k and l of two polynomials multiplied crosswise.
#[inline(always)]
fn crossed<S: Lanes>(s: S, (a, b): (&[S::V; 6], &[S::V; 6]), [k, l]: [usize; 2]) -> S::V {
    s.mul_add(a[k], b[l], s.mul(a[l], b[k]))
}

impl<S: Lanes> OneWay<S> {
    #[inline(always)]
    fn of(
        s: S,
        groups: &Groups<S>,
        setup: &SquareSetup,
        (view, row, antenna, m): (&RaysView, &RayRow, usize, usize),
        bin_m: f64,
    ) -> Self {
        let frame = &setup.frame;
        // Lengths are in records from here on, optical lengths in bins.
        let per_m = row.per_m as f32;
        let [pu, pv] = frame.pixel_m.map(|p| p as f32 * per_m);
        let [bu, buv, bv] = frame.bends.map(|b| b * per_m);
        let (skew, bins) = (frame.skew as f32, (1.0 / bin_m) as f32);
        let one = s.splat(1.0);
        let seen: &Seen = &setup.from[antenna][m];
        let range0 = s.splat(seen.range_m);
        let along0 = s.splat(seen.along_m);
        let along = s.add(along0, groups.along_m);
        let across = s.mul_add(groups.along_m, s.splat(skew), s.splat(seen.across_m));
        let square_difference = s.mul(groups.along_m, s.add(along, along0));
        let square = s.max(s.mul_add(range0, range0, square_difference), s.splat(1e-30));
        let inverse = s.inverse_sqrt(square);
        let range = s.mul(square, inverse);
        let difference = s.mul(square_difference, s.reciprocal(s.add(range, range0)));
        // Linear and quadratic part of the straight distance, and the square of the linear part.
        let (u, v) = (s.mul(along, inverse), s.mul(across, inverse));
        let (a, b) = (s.mul(u, s.splat(pu)), s.mul(v, s.splat(pv)));
        let q = [
            s.mul(s.mul(inverse, s.splat(bu)), s.neg_mul_add(u, u, one)),
            s.mul(
                s.mul(inverse, s.splat(buv)),
                s.neg_mul_add(u, v, s.splat(skew)),
            ),
            s.mul(s.mul(inverse, s.splat(bv)), s.neg_mul_add(v, v, one)),
        ];
        let squares = [s.mul(a, a), s.mul(s.add(a, a), b), s.mul(b, b)];

        let place = setup.places[antenna][m];
        let rays = Rays::at(s, view, (row, place), difference);
        let [[excess, e1, f2, f3], [w0, w1, w2, w3]] = rays.powers(s);
        let f1 = s.add(e1, s.splat(row.record_bins));
        let [second_u, second_uv, second_v] = sums(s, [f1, f2], &q, &squares);
        // Largest linear and quadratic part of the straight distance over the square, in records.
        let linear = s.mul(s.splat(HALF), absolute_sum(s, [a, b]));
        let quadratic = s.add(absolute_sum(s, [q[0], q[1]]), s.abs(q[2]));
        // No place of the square is nearer to the antenna than the range at the middle less the reach.
        let nearest = s.max(s.sub(range, s.splat(groups.reach)), s.splat(1e-9));
        let inverse_nearest = s.reciprocal(nearest);
        let shortened = s.mul(range, inverse_nearest);
        let quadratic = s.mul(quadratic, s.mul(shortened, s.splat(HALF * HALF)));
        let square = s.mul(linear, linear);
        // G((2 f₂ − f₁/R) Q + f₃ G²)
        let per_record = s.mul(inverse, s.splat(row.record_m));
        let mixed = s.neg_mul_add(f1, per_record, s.add(f2, f2));
        // Of fourth order: P⁗G⁴/24 + Q(3 P‴G²/6 − (P″ − P′/R)(G²/R − Q/2)).
        let near = s.mul(inverse_nearest, s.splat(row.record_m));
        let turning = s.mul_add(square, near, s.mul(quadratic, s.splat(0.5)));
        let bending = s.mul(s.abs(f3), s.mul(square, s.splat(3.0)));
        let bending = s.mul_add(s.abs(mixed), turning, bending);
        let truncation_error = s.mul_add(
            quadratic,
            bending,
            s.mul(rays.fourth, s.mul(square, square)),
        );
        let [caa, cab, cbb] = sums(s, [mixed, f3], &q, &squares);
        let [weight_u, weight_uv, weight_v] = sums(s, [w1, w2], &q, &squares);
        // As G((2 f₂ − f₁/R) Q + f₃ G²).
        let curving = s.neg_mul_add(w1, per_record, s.add(w2, w2));
        let inverse_third = s.mul(
            linear,
            s.mul_add(s.abs(curving), quadratic, s.mul(s.abs(w3), square)),
        );
        let zero = s.splat(0.0);
        Self {
            way: Expansion {
                range_m: range,
                t: s.add(
                    s.mul_add(difference, s.splat(bins), s.splat(setup.fraction[m])),
                    excess,
                ),
                slope: [s.mul(f1, a), s.mul(f1, b)],
                along_square: second_u,
                product: second_uv,
                across_square: second_v,
                inverse_bins: zero,
                truncation_error,
                third: zero,
                uneven: zero,
                rise: zero,
                slope_change: [zero; 2],
                half_curvature: zero,
            },
            cubes: [
                s.mul(a, caa),
                s.mul_add(a, cab, s.mul(b, caa)),
                s.mul_add(a, cbb, s.mul(b, cab)),
                s.mul(b, cbb),
            ],
            inverse_third,
            inverse: [
                w0,
                s.mul(w1, a),
                s.mul(w1, b),
                weight_u,
                weight_uv,
                weight_v,
            ],
        }
    }
}

impl<S: Lanes> TwoWays<S> {
    /// Ways with their coefficients of third order and one over the weight, which have no further terms.
    #[inline(always)]
    pub fn new(s: S, half: Expansion<S>, cubes: [S::V; 4], inverse: [S::V; 6]) -> Self {
        Self {
            half: Expansion {
                third: third_order(s, &cubes),
                ..half
            },
            cubes,
            inverse,
            inverse_third: s.splat(0.0),
        }
    }

    /// Bins over which a vector's ways extend, and the first bin of each vector, however ways bend.
    #[inline(always)]
    pub fn windows(&self, s: S) -> (S::V, [S::V; 2]) {
        let zero = s.splat(0.0);
        let [ii, ij, jj] = [
            self.half.along_square,
            self.half.product,
            self.half.across_square,
        ];
        let squares = s.add(absolute_sum(s, [ii, ij]), s.abs(jj));
        // A reach holds three times the third order.
        let third = s.mul_add(squares, s.splat(HALF * HALF / 3.0), self.half.third);
        let bounded = Expansion {
            along_square: zero,
            product: zero,
            across_square: zero,
            third,
            ..self.half
        };
        bounded.windows::<true, false>(s)
    }

    /// Half of the ways of pulse `m` of a chunk, the pulse `pulse` of all.
    #[inline(always)]
    pub fn of(
        s: S,
        groups: &Groups<S>,
        setup: &SquareSetup,
        (view, m, pulse): (&RaysView, usize, usize),
        bin_m: f64,
    ) -> Self {
        let rows = [&view.rows[0][pulse], &view.rows[1][pulse]];
        let sent = OneWay::of(s, groups, setup, (view, rows[0], 0, m), bin_m);
        let received = OneWay::of(s, groups, setup, (view, rows[1], 1, m), bin_m);
        let one = s.splat(1.0);
        let (a, b) = (&sent.inverse, &received.inverse);
        let inverse = [
            s.mul(a[0], b[0]),
            crossed(s, (a, b), [0, 1]),
            crossed(s, (a, b), [0, 2]),
            s.mul_add(a[1], b[1], crossed(s, (a, b), [0, 3])),
            s.add(crossed(s, (a, b), [1, 2]), crossed(s, (a, b), [0, 4])),
            s.mul_add(a[2], b[2], crossed(s, (a, b), [0, 5])),
        ];
        let cubes = [
            half_sum(s, one, sent.cubes[0], received.cubes[0]),
            half_sum(s, one, sent.cubes[1], received.cubes[1]),
            half_sum(s, one, sent.cubes[2], received.cubes[2]),
            half_sum(s, one, sent.cubes[3], received.cubes[3]),
        ];
        let mut half = sent.way.half_sum(s, &received.way, one);
        half.third = third_order(s, &cubes);
        let most = |of: &[S::V; 6]| [linear_sum(s, of), square_sum(s, of)];
        let ([linear_a, square_a], [linear_b, square_b]) = (most(a), most(b));
        let third = s.mul_add(linear_a, square_b, s.mul(linear_b, square_a));
        let third = s.mul_add(
            a[0],
            received.inverse_third,
            s.mul(third, s.splat(HALF.powi(3))),
        );
        Self {
            half,
            cubes,
            inverse,
            inverse_third: s.mul_add(b[0], sent.inverse_third, third),
        }
    }

    /// Whether the expansion of one over the weight errs by no more than a share `tolerance`.
    #[inline(always)]
    pub fn has_smooth_weight(&self, s: S, tolerance: f32) -> bool {
        s.all_le(
            self.inverse_third,
            s.mul(self.inverse[0], s.splat(tolerance)),
        )
    }

    /// Whether ways without their third order and weights without their second err by little more than the share [`FLAT`]
    /// of a tolerance of the ways, in bins, and of the weight: the terms that remain are those nearest to all terms.
    #[inline(always)]
    pub fn is_flat(&self, s: S, tolerance_bins: f32, tolerance: f32) -> bool {
        let left = s.mul_add(self.half.third, s.splat(LEFT), self.half.truncation_error);
        // Of second order one over 1 + l + q has l² − q.
        let [whole, i, j, ii, ij, jj] = self.inverse;
        let square = s.add(
            absolute_sum(
                s,
                [
                    s.neg_mul_add(whole, ii, s.mul(i, i)),
                    s.neg_mul_add(whole, jj, s.mul(j, j)),
                ],
            ),
            s.abs(s.neg_mul_add(whole, ij, s.mul(s.add(i, i), j))),
        );
        let allowed = s.mul(s.mul(whole, whole), s.splat(FLAT * tolerance));
        s.all_le(left, s.splat(FLAT * tolerance_bins)) && s.all_le(square, allowed)
    }

    /// Stores the coefficients of third order and the weights in the rows of a pulse.
    #[inline(always)]
    pub fn store(&self, s: S, rows: &mut [f32]) {
        assert!(rows.len() >= RAY_ROWS * S::N);
        let (cubes, inverse) = (&self.cubes, &self.inverse);
        let (mean, slope) = (s.splat(MEAN_SQUARE), s.splat(CUBE_SLOPE));
        let weight = s.reciprocal(inverse[0]);
        let [along, across, along_square, across_square] =
            [inverse[1], inverse[2], inverse[3], inverse[5]].map(|v| s.mul(v, weight));
        let bent = s.sub(
            s.mul_add(along, along, s.mul(across, across)),
            s.add(along_square, across_square),
        );
        let flat = [
            s.mul_add(
                cubes[2],
                mean,
                s.mul_add(cubes[0], slope, self.half.slope[0]),
            ),
            s.mul_add(
                cubes[1],
                mean,
                s.mul_add(cubes[3], slope, self.half.slope[1]),
            ),
            s.mul(weight, s.mul_add(bent, mean, s.splat(1.0))),
            s.sub(s.splat(0.0), s.mul(weight, along)),
            s.sub(s.splat(0.0), s.mul(weight, across)),
        ];
        // SAFETY: `rows` holds RAY_ROWS rows of N numbers.
        unsafe {
            let at = rows.as_mut_ptr();
            for (k, v) in cubes.iter().enumerate() {
                s.store(at.add((CUBE_ROW + k) * S::N), *v);
            }
            for (k, v) in inverse.iter().enumerate() {
                s.store(at.add((WEIGHT_ROW + k) * S::N), *v);
            }
            for (k, v) in flat.iter().enumerate() {
                s.store(at.add((FLAT_ROW + k) * S::N), *v);
            }
        }
    }
}
