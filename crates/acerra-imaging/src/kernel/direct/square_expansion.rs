//! Expansion of the range over squares of pixels, and the choice between windows, gathers and the
//! double-precision sum for each pulse.

use super::job::{Band, CHUNK, GROUP, HALF, Job, PixelWeight, SIDE};
use super::rays::Place;
use super::square_ground::SquareGround;
use super::square_rays::{RAY_ROWS, TwoWays};
use super::unwindowed::{Unwindowed, whole_and_rest};
use crate::kernel::aligned::Aligned;
use crate::kernel::lanes::{Lanes, MAX_LANES, ROUNDING};
use crate::kernel::two_ways::{half_sum, half_sums, lesser, spreading};
use crate::vector::{dot, norm};
use std::ops::Range;

/// Pulses of a chunk and the pixels of one block: groups side by side in a strip of [`SIDE`] rows.
pub(super) struct SquareBlock<'a, S> {
    pub s: S,
    pub job: &'a Job<'a>,
    pub band: &'a Band,
    /// First column of the block, and its first row.
    pub column: usize,
    pub row: usize,
    /// Groups that hold pixels of the band.
    pub groups: usize,
    pub pulses: Range<usize>,
    /// Heights of the block's pixels; level ground for kernels without heights.
    pub ground: &'a SquareGround,
}

/// Axes of a band.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    /// Distance of pixels along the row and across, m.
    pub pixel_m: [f64; 2],
    /// Unit vectors along the row and across.
    unit: [[f64; 3]; 2],
    /// Cosine of the angle between the unit vectors.
    pub skew: f64,
    /// Half the square of the distance along, the product of both distances, and half the square of that across, m².
    pub bends: [f32; 3],
}

impl Frame {
    fn of(band: &Band) -> Self {
        let pixel_m = [band.u_m, band.v_m].map(|v| norm(v).max(1e-12));
        let unit = [
            band.u_m.map(|x| x / pixel_m[0]),
            band.v_m.map(|x| x / pixel_m[1]),
        ];
        Self {
            pixel_m,
            unit,
            skew: dot(unit[0], unit[1]),
            bends: [
                (0.5 * pixel_m[0] * pixel_m[0]) as f32,
                (pixel_m[0] * pixel_m[1]) as f32,
                (0.5 * pixel_m[1] * pixel_m[1]) as f32,
            ],
        }
    }
}

impl<S: Lanes> SquareBlock<'_, S> {
    /// The point of the band's plane at some pixels from the block's first one, raised by `up_m`, m.
    #[inline(always)]
    pub fn point_m(&self, along: f64, across: f64, up_m: f64) -> [f64; 3] {
        let (i, j) = (self.column as f64 + along, self.row as f64 + across);
        let band = self.band;
        let at = |axis: usize| band.origin_m[axis] + i * band.u_m[axis] + j * band.v_m[axis];
        [at(0), at(1), at(2) + up_m]
    }
}

/// Offset of a point from an antenna.
#[derive(Clone, Copy, Default)]
pub(super) struct Seen {
    pub range_m: f32,
    /// Along the row and across, m.
    pub along_m: f32,
    pub across_m: f32,
    /// Above the antenna, m.
    pub up_m: f32,
}

/// The middle of a group, relative to the antennas of a pulse.
pub(super) struct Origin {
    pub from: [Seen; 2],
    /// Places of the ranges among tabulated rays, where there are any.
    pub places: [Place; 2],
    /// Mean range in bins, as whole bins past the pulse's entry 0 and a fraction.
    pub whole: i32,
    pub fraction: f32,
}

impl Origin {
    /// Group `k` of a block, seen by pulse `m` of the chunk.
    #[inline(always)]
    pub fn of<S: Lanes>(block: &SquareBlock<S>, frame: &Frame, k: usize, m: usize) -> Self {
        let along = (SIDE * k) as f64 + f64::from(HALF);
        let up_m = block.ground.middle_m + f64::from(block.ground.plane_m[k]);
        let (point, job) = (block.point_m(along, f64::from(HALF), up_m), block.job);
        let pulse = block.pulses.start + m;
        let (mut from, mut mean) = ([Seen::default(); 2], 0.0);
        let mut places = [Place::default(); 2];
        for (k, (seen, antenna_m)) in from.iter_mut().zip(job.antennas_m).enumerate() {
            let d: [f64; 3] = std::array::from_fn(|axis| point[axis] - antenna_m[axis][pulse]);
            let range = norm(d);
            mean += range / job.antennas_m.len() as f64;
            *seen = Seen {
                range_m: range as f32,
                along_m: dot(d, frame.unit[0]) as f32,
                across_m: dot(d, frame.unit[1]) as f32,
                up_m: d[2] as f32,
            };
            if let Some(rays) = &job.rays {
                let row = &rays.rows[k][pulse];
                places[k] = row.place(range);
                mean += row.beyond_m / job.antennas_m.len() as f64;
            }
        }
        let bins = mean * (1.0 / job.table.bin_m) - job.table.first_bin[pulse];
        let (whole, fraction) = whole_and_rest(bins);
        Self {
            from,
            places,
            whole,
            fraction,
        }
    }
}

/// Parameters of the pulses of a chunk for one block.
pub(super) struct SquareSetup {
    /// Parameters of each pulse that has windows, [`Self::rows`] rows of N, one lane a group: slopes of the
    /// range along the row and across (bins a pixel); half its second derivatives along, mixed (whole) and
    /// across; one over the range in bins; and for either vector the range at the group's middle in bins past
    /// that vector's window, and the bits of the integer at which the window starts in the chunk's table;
    /// over uneven ground also the change of the range with height (bins a metre), that of its slopes along
    /// the row and across, and half its second derivative with height; last the weight of the group, where
    /// pixels have one. Below level ground the rows of [`TwoWays`] follow instead. Pulses of narrow windows are stored from the front on, those of wide ones from the
    /// back.
    pub windowed: Aligned<{ CHUNK * Self::MOST_ROWS * MAX_LANES }>,
    pub frame: Frame,
    /// Middle of the block from each antenna of each pulse, and the mean range in bins.
    pub from: [[Seen; CHUNK]; 2],
    /// Places of these ranges among tabulated rays, where there are any.
    pub places: [[Place; CHUNK]; 2],
    pub fraction: [f32; CHUNK],
    whole: [i32; CHUNK],
}

impl SquareSetup {
    const MOST_ROWS: usize = RAY_ROWS;

    /// Rows of parameters of a pulse.
    pub const fn rows(relief: bool, rays: bool) -> usize {
        if rays {
            RAY_ROWS
        } else {
            Self::weight_row(relief) + 1
        }
    }

    /// The row of the weights.
    pub const fn weight_row(relief: bool) -> usize {
        if relief { 14 } else { 10 }
    }

    pub fn new(band: &Band) -> Self {
        Self {
            windowed: Aligned([0.0; CHUNK * Self::MOST_ROWS * MAX_LANES]),
            frame: Frame::of(band),
            from: [[Seen::default(); CHUNK]; 2],
            places: [[Place::default(); CHUNK]; 2],
            fraction: [0.0; CHUNK],
            whole: [0; CHUNK],
        }
    }

    /// Computes the ranges from every antenna to the block's middle in double precision.
    #[inline(always)]
    pub fn measure<S: Lanes, const RAYS: bool>(&mut self, block: &SquareBlock<S>) {
        let along = 0.5 * (SIDE * S::N - 1) as f64;
        let middle = block.point_m(along, f64::from(HALF), block.ground.middle_m);
        let ([x, y, z], job) = (middle, block.job);
        let ([u, v], inverse_bin) = (self.frame.unit, 1.0 / job.table.bin_m);
        let start = &job.table.first_bin[block.pulses.clone()];
        let share = 1.0 / job.antennas_m.len() as f64;
        let [mut mean, mut ranges_m] = [[0f64; CHUNK]; 2];
        let seen = self.from.iter_mut().zip(&mut self.places);
        for (k, ((from, places), antenna_m)) in seen.zip(job.antennas_m).enumerate() {
            let px = &antenna_m[0][block.pulses.clone()];
            let py = &antenna_m[1][block.pulses.clone()];
            let pz = &antenna_m[2][block.pulses.clone()];
            for m in 0..block.pulses.len() {
                let (dx, dy, dz) = (x - px[m], y - py[m], z - pz[m]);
                let range = (dx * dx + dy * dy + dz * dz).sqrt();
                mean[m] += share * range;
                from[m] = Seen {
                    range_m: range as f32,
                    along_m: (dx * u[0] + dy * u[1] + dz * u[2]) as f32,
                    across_m: (dx * v[0] + dy * v[1] + dz * v[2]) as f32,
                    up_m: dz as f32,
                };
                ranges_m[m] = range;
            }
            if RAYS && let Some(rays) = &job.rays {
                let rows = &rays.rows[k][block.pulses.clone()];
                for (m, row) in rows.iter().enumerate() {
                    places[m] = row.place(ranges_m[m]);
                    mean[m] += share * row.beyond_m;
                }
            }
        }
        for m in 0..block.pulses.len() {
            (self.whole[m], self.fraction[m]) = whole_and_rest(mean[m] * inverse_bin - start[m]);
        }
    }
}

/// Pulses of a chunk by the way in which they are read for one block.
pub(super) struct SquarePaths {
    /// Pulses with parameters in [`SquareSetup::windowed`], whose windows are one register or two.
    pub narrow: usize,
    pub wide: usize,
    /// Whether the rays of a pulse with windows need the third order of ways, or the second of weights.
    pub is_bent: bool,
    pub others: Unwindowed,
}

impl SquarePaths {
    /// The slot of the next pulse whose windows are of one register, or of two.
    #[inline(always)]
    fn slot(&mut self, is_narrow: bool) -> usize {
        if is_narrow {
            self.narrow += 1;
            self.narrow - 1
        } else {
            self.wide += 1;
            CHUNK - self.wide
        }
    }
}

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
    fn of<const RELIEF: bool>(block: &SquareBlock<S>, frame: &Frame) -> Self {
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
    fn of<const CUBIC: bool, const RELIEF: bool>(
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
    fn mean<const CUBIC: bool>(self, s: S, other: Self, uneven_m: S::V) -> Self {
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
    fn windows<const CUBIC: bool, const RELIEF: bool>(&self, s: S) -> (S::V, [S::V; 2]) {
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
    fn store<const RELIEF: bool>(&self, s: S, windows: [S::V; 2], start: i32, rows: &mut [f32]) {
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

/// Expands the ranges of all pulses of a chunk and decides how each pulse is read. All degrees of tables
/// share this function.
#[inline(never)]
pub(super) fn expand<
    S: Lanes,
    const CUBIC: bool,
    const WIDE: bool,
    const RELIEF: bool,
    const RAYS: bool,
>(
    block: &SquareBlock<S>,
    setup: &mut SquareSetup,
) -> SquarePaths {
    block.s.vectorize(
        #[inline(always)]
        |_| expand_here::<S, CUBIC, WIDE, RELIEF, RAYS>(block, setup),
    )
}

#[inline(always)]
fn expand_here<
    S: Lanes,
    const CUBIC: bool,
    const WIDE: bool,
    const RELIEF: bool,
    const RAYS: bool,
>(
    block: &SquareBlock<S>,
    setup: &mut SquareSetup,
) -> SquarePaths {
    let (s, job, n) = (block.s, block.job, S::N);
    let table = &job.table;
    let groups = Groups::of::<RELIEF>(block, &setup.frame);
    let tolerance = s.splat(job.tolerance_bins as f32);
    let window = if WIDE { 2 * n } else { n };
    let last_window = s.splat(table.stride as f32 - 2.0 - window as f32);
    let [narrowest, widest] = [n, window].map(|entries| s.splat((entries - 1) as f32 - 0.05));
    let zero = s.splat(0.0);
    let mut paths = SquarePaths {
        narrow: 0,
        wide: 0,
        is_bent: false,
        others: Unwindowed::default(),
    };
    for m in 0..block.pulses.len() {
        if RAYS && let Some(rays) = &job.rays {
            // Tables hold no weights and rays no near field: every place is read from tables.
            let of_pulse = (rays, m, block.pulses.start + m);
            let ways = TwoWays::of(s, &groups, setup, of_pulse, table.bin_m);
            let (span, windows) = ways.half.windows::<CUBIC, RELIEF>(s);
            let negative = s.max(s.sub(zero, windows[0]), s.sub(zero, windows[1]));
            let whole = s.splat(setup.whole[m] as f32);
            let most = s.add(whole, s.max(windows[0], windows[1]));
            let fits = job.windows
                && s.all_le(span, widest)
                && s.all_le(ways.half.truncation_error, tolerance)
                && ways.has_smooth_weight(s, rays.weight_tolerance)
                && s.all_le(negative, whole)
                && s.all_le(most, last_window);
            if !fits {
                paths.others.gather(m);
                continue;
            }
            let slot = paths.slot(!WIDE || s.all_le(span, narrowest));
            let length = RAY_ROWS * n;
            let rows = &mut setup.windowed.0[slot * length..][..length];
            let start = (m * table.pulse_stride) as i32 + setup.whole[m];
            ways.half.store::<RELIEF>(s, windows, start, rows);
            ways.store(s, rows);
            let tolerance_bins = job.tolerance_bins as f32;
            paths.is_bent |= !ways.is_flat(s, tolerance_bins, rays.weight_tolerance);
            continue;
        }
        let sent = Expansion::of::<CUBIC, RELIEF>(s, &groups, setup, (0, m), table.bin_m);
        let (mut expansion, mut received) = (sent, sent);
        if job.antennas_m.len() > 1 {
            received = Expansion::of::<CUBIC, RELIEF>(s, &groups, setup, (1, m), table.bin_m);
            expansion = sent.mean::<CUBIC>(s, received, groups.uneven_m);
        }
        if !s.all_le(groups.near_m, expansion.range_m) {
            paths.others.refer(m);
            continue;
        }
        let (span, windows) = expansion.windows::<CUBIC, RELIEF>(s);
        let whole = s.splat(setup.whole[m] as f32);
        let negative = s.max(s.sub(zero, windows[0]), s.sub(zero, windows[1]));
        let most = s.add(whole, s.max(windows[0], windows[1]));
        let fits = job.windows
            && s.all_le(span, widest)
            && s.all_le(expansion.truncation_error, tolerance)
            && s.all_le(negative, whole)
            && s.all_le(most, last_window);
        if !fits {
            paths.others.gather(m);
            continue;
        }
        let length = SquareSetup::rows(RELIEF, false) * n;
        let slot = paths.slot(!WIDE || s.all_le(span, narrowest));
        let rows = &mut setup.windowed.0[slot * length..][..length];
        let start = (m * table.pulse_stride) as i32 + setup.whole[m];
        expansion.store::<RELIEF>(s, windows, start, rows);
        if let Some(PixelWeight::Ways) = job.weight {
            let weight = spreading(s, sent.range_m, received.range_m);
            let row = &mut rows[SquareSetup::weight_row(RELIEF) * n..];
            assert!(row.len() >= n);
            // SAFETY: the row holds N numbers.
            unsafe { s.store(row.as_mut_ptr(), weight) };
        }
    }
    paths
}
