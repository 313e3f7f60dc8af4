//! Half the optical way over squares of pixels below level ground, for antennas apart.
//!
//! The optical length of a ray and its weight are functions P and w of the straight distance R. Their polynomials
//! about the middle of a square follow from those of R, G + Q − GQ/R with a linear part G and a quadratic part Q:
//! P′G + (P′Q + P″G²/2) + G((P″ − P′/R)Q + P‴G²/6). The mean of both antennas is that of the coefficients, the weight
//! of a contribution the product of both polynomials up to second order.

use super::job::HALF;
use super::rays::{Place, Rays, RaysView};
use super::square_expansion::{Expansion, Groups, Seen, SquareSetup};
use crate::kernel::lanes::Lanes;
use crate::kernel::two_ways::half_sum;

/// First of the rows of parameters with the coefficients of third order, and of those with the weights.
pub(super) const CUBE_ROW: usize = 10;
pub(super) const WEIGHT_ROW: usize = 14;
/// Rows of parameters of a pulse.
pub(super) const RAY_ROWS: usize = 20;

/// One antenna's way to the groups of a block, one lane a group.
struct OneWay<S: Lanes> {
    /// The optical length, in bins and pixels.
    way: Expansion<S>,
    /// Coefficients of i³, i²j, ij² and j³.
    cubes: [S::V; 4],
    /// Weight at the middle, its changes along the row and across, and its terms of i², ij and j².
    weight: [S::V; 6],
    /// Bounds of the linear, the quadratic and the dropped part of the weight over a group.
    most: [S::V; 3],
}

/// Half the way there and back, and the weight of a contribution.
pub(super) struct TwoWays<S: Lanes> {
    pub half: Expansion<S>,
    cubes: [S::V; 4],
    weight: [S::V; 6],
    /// Bound of the error of the weight, and the error allowed.
    weight_error: S::V,
    allowed: S::V,
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
        (view, antenna, m, pulse): (&RaysView, usize, usize, usize),
        bin_m: f64,
    ) -> Self {
        let frame = &setup.frame;
        let [pu, pv] = frame.pixel_m.map(|p| p as f32);
        let (skew, bins) = (frame.skew as f32, (1.0 / bin_m) as f32);
        let (one, half) = (s.splat(1.0), s.splat(HALF));
        let seen: &Seen = &setup.from[antenna][m];
        let place: Place = setup.places[antenna][m];
        let row = &view.rows[antenna][pulse];
        let range0 = s.splat(seen.range_m);
        let along0 = s.splat(seen.along_m);
        let along = s.add(along0, groups.along_m);
        let across = s.mul_add(groups.along_m, s.splat(skew), s.splat(seen.across_m));
        let square_difference = s.mul(groups.along_m, s.add(along, along0));
        let square = s.max(s.mul_add(range0, range0, square_difference), s.splat(1e-30));
        let range = s.sqrt(square);
        let sum = s.add(range, range0);
        let reciprocal = s.div(one, s.mul(sum, range));
        let inverse = s.mul(reciprocal, sum);
        let difference = s.mul(s.mul(square_difference, reciprocal), range);
        // Linear and quadratic part of the straight distance, m.
        let (u, v) = (s.mul(along, inverse), s.mul(across, inverse));
        let (a, b) = (s.mul(u, s.splat(pu)), s.mul(v, s.splat(pv)));
        let bend = [
            s.mul(inverse, s.splat(0.5 * pu * pu)),
            s.mul(inverse, s.splat(pu * pv)),
            s.mul(inverse, s.splat(0.5 * pv * pv)),
        ];
        let q = [
            s.mul(bend[0], s.neg_mul_add(u, u, one)),
            s.mul(bend[1], s.neg_mul_add(u, v, s.splat(skew))),
            s.mul(bend[2], s.neg_mul_add(v, v, one)),
        ];
        let squares = [s.mul(a, a), s.mul(s.splat(2.0), s.mul(a, b)), s.mul(b, b)];
        let most_linear = s.mul(half, s.add(s.abs(a), s.abs(b)));
        let most_bend = s.mul(
            s.splat(HALF * HALF),
            s.add(s.add(s.abs(q[0]), s.abs(q[1])), s.abs(q[2])),
        );
        let most_square = s.mul(most_linear, most_linear);

        let rays = Rays::at(s, view, (row, place), difference);
        let [excess, e1, f2, f3] = rays.excess_powers(s);
        let f1 = s.add(e1, s.splat(bins));
        let second = sums(s, [f1, f2], &q, &squares);
        // G((2 f₂ − f₁/R) Q + f₃ G²)
        let mixed = s.neg_mul_add(f1, inverse, s.add(f2, f2));
        let [caa, cab, cbb] = sums(s, [mixed, f3], &q, &squares);
        let cubes = [
            s.mul(a, caa),
            s.mul_add(a, cab, s.mul(b, caa)),
            s.mul_add(a, cbb, s.mul(b, cab)),
            s.mul(b, cbb),
        ];
        let third = s.mul(
            most_linear,
            s.mul_add(s.abs(mixed), most_bend, s.mul(s.abs(f3), most_square)),
        );
        // Of fourth order: a refracted way changes over lengths of the antenna's height, a straight one over its distance.
        let (reach, near) = (s.sqrt(groups.reach_square), row.inverse_apparent);
        let bent = s.mul_add(f1, most_bend, s.mul(s.abs(f2), most_square));
        let fourth = s.mul_add(
            s.mul(third, reach),
            s.splat(row.inverse_height),
            s.mul(s.mul(bent, groups.reach_square), s.splat(near * near)),
        );

        let [w0, w1, w2, w3] = rays.weight_powers(s);
        let weight = sums(s, [w1, w2], &q, &squares);
        let weight_mixed = s.neg_mul_add(w1, inverse, s.add(w2, w2));
        let most = [
            s.mul(s.abs(w1), most_linear),
            s.mul_add(s.abs(w1), most_bend, s.mul(s.abs(w2), most_square)),
            s.mul(
                most_linear,
                s.mul_add(
                    s.abs(weight_mixed),
                    most_bend,
                    s.mul(s.abs(w3), most_square),
                ),
            ),
        ];
        let zero = s.splat(0.0);
        Self {
            way: Expansion {
                range_m: range,
                t: s.add(
                    s.mul_add(difference, s.splat(bins), s.splat(setup.fraction[m])),
                    excess,
                ),
                slope: [s.mul(f1, a), s.mul(f1, b)],
                along_square: second[0],
                product: second[1],
                across_square: second[2],
                inverse_bins: zero,
                truncation_error: fourth,
                third,
                uneven: zero,
                rise: zero,
                slope_change: [zero; 2],
                half_curvature: zero,
            },
            cubes,
            weight: [
                w0,
                s.mul(w1, a),
                s.mul(w1, b),
                weight[0],
                weight[1],
                weight[2],
            ],
            most,
        }
    }
}

impl<S: Lanes> TwoWays<S> {
    /// Half of the ways of pulse `m` of a chunk, the pulse `pulse` of all.
    #[inline(always)]
    pub fn of(
        s: S,
        groups: &Groups<S>,
        setup: &SquareSetup,
        (view, m, pulse): (&RaysView, usize, usize),
        bin_m: f64,
    ) -> Self {
        let sent = OneWay::of(s, groups, setup, (view, 0, m, pulse), bin_m);
        let received = OneWay::of(s, groups, setup, (view, 1, m, pulse), bin_m);
        let one = s.splat(1.0);
        let (a, b) = (&sent.weight, &received.weight);
        let weight = [
            s.mul(a[0], b[0]),
            crossed(s, (a, b), [0, 1]),
            crossed(s, (a, b), [0, 2]),
            s.mul_add(a[1], b[1], crossed(s, (a, b), [0, 3])),
            s.add(crossed(s, (a, b), [1, 2]), crossed(s, (a, b), [0, 4])),
            s.mul_add(a[2], b[2], crossed(s, (a, b), [0, 5])),
        ];
        let ([la, qa, ca], [lb, qb, cb]) = (sent.most, received.most);
        let of_thirds = s.mul_add(s.abs(a[0]), cb, s.mul(s.abs(b[0]), ca));
        Self {
            half: sent.way.half_sum(s, &received.way, one),
            cubes: [
                half_sum(s, one, sent.cubes[0], received.cubes[0]),
                half_sum(s, one, sent.cubes[1], received.cubes[1]),
                half_sum(s, one, sent.cubes[2], received.cubes[2]),
                half_sum(s, one, sent.cubes[3], received.cubes[3]),
            ],
            weight,
            weight_error: s.mul_add(la, qb, s.mul_add(qa, lb, of_thirds)),
            allowed: s.mul(s.splat(view.weight_tolerance), s.abs(weight[0])),
        }
    }

    /// Whether the error of the weight is within its tolerance.
    #[inline(always)]
    pub fn has_smooth_weight(&self, s: S) -> bool {
        s.all_le(self.weight_error, self.allowed)
    }

    /// Stores the coefficients of third order and the weights in the rows of a pulse.
    #[inline(always)]
    pub fn store(&self, s: S, rows: &mut [f32]) {
        assert!(rows.len() >= RAY_ROWS * S::N);
        let of_third = (CUBE_ROW..).zip(self.cubes);
        for (row, v) in of_third.chain((WEIGHT_ROW..).zip(self.weight)) {
            // SAFETY: `rows` holds RAY_ROWS rows of N numbers.
            unsafe { s.store(rows.as_mut_ptr().add(row * S::N), v) };
        }
    }
}
