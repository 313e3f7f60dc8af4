//! Ranges over groups of neighbouring pixels, one lane a group: expansions about the groups' middles.
//!
//! With the line of sight d to a group's middle, R = |d|, and a pixel at o from there, let L = d·o/R and
//! Q = (|o|² − L²)/(2R). Then the range is (R + L)√(1 + 2QR/(R + L)²) = R + L + Q − LQ/R + …: the second
//! order ends after Q, the third after LQ/R.

use super::lanes::{Lanes, MAX_LANES};
use super::two_ways::{half_sum, half_sums, spreading};
use crate::vector::{dot, norm};
use std::ops::Range;

/// Strips, rows of groups one after another, and a pulse.
#[derive(Clone)]
pub(crate) struct StripGeometry<'a> {
    /// Vectors from the antennas of the pulse (one or two) to the first pixel of the first strip, m. With two
    /// antennas the range is the mean of both ranges.
    pub from_antennas_m: &'a [[f64; 3]],
    /// Whether values are multiplied by the ratio of the bistatic spreading to the spreading at the mean
    /// range, at the middle of each group.
    pub two_spreadings: bool,
    pub strips: usize,
    /// Numbers from one strip to the next.
    pub stride: usize,
    /// Unit vectors along the rows and across them, and the pixels' distances, m.
    pub unit: [[f64; 3]; 2],
    pub pixel_m: [f64; 2],
    /// Groups of a strip that are taken, from a multiple of [`MAX_LANES`] on.
    pub groups: Range<usize>,
    pub bin_m: f64,
    /// Absolute number of the pulse's first bin.
    pub first_bin: i64,
    /// Bins of the pulse.
    pub entries: usize,
    /// Blocks nearer than this range are passed to the fallback, m.
    pub reference_below_m: f64,
}

/// Callback for the blocks (strip and groups) for which expansions do not hold.
pub(crate) type Fallback<'a> = dyn FnMut((usize, Range<usize>), &mut [f32]) + 'a;

/// Parameters that all blocks of strips share. `CUBIC` expansions are of third order, others of second.
pub(super) struct Strip<'a, S: Lanes, const COLUMNS: usize, const ROWS: usize, const CUBIC: bool> {
    s: S,
    geometry: &'a StripGeometry<'a>,
    /// Offsets of the groups' middles from the block's middle, m.
    offsets_m: S::V,
    skew: S::V,
    /// Units of the expansion a metre, and the pixels' distances, m.
    units_a_metre: f32,
    pixel: [f32; 2],
    /// Error allowed to the expansion, units.
    tolerance: S::V,
}

/// The range over each group about its middle, one lane a group, in units and pixels.
pub(super) struct Expanded<S: Lanes> {
    pub slope: [S::V; 2],
    /// Half the second derivative along the row.
    pub along_square: S::V,
    /// Mixed second derivative.
    pub product: S::V,
    /// Half the second derivative across.
    pub across_square: S::V,
    /// One over the range, 1/units.
    pub inverse_range: S::V,
    /// Greatest departure from the range at the middle, units.
    pub reach: S::V,
    /// The range at the middle in bins past `whole`.
    pub t: S::V,
    pub whole: i32,
    /// Factor of the values of each group, where they have one.
    pub weight: Option<S::V>,
}

/// The range from an antenna over each group about its middle, in the same units.
#[derive(Clone, Copy)]
struct About<S: Lanes> {
    /// Range at the group's middle, m.
    range_m: S::V,
    /// Excess of this range over the range at the block's middle, m.
    difference_m: S::V,
    slope: [S::V; 2],
    along_square: S::V,
    product: S::V,
    across_square: S::V,
    inverse_range: S::V,
    /// Bound of the linear part over a group.
    linear: S::V,
    /// Bound of the quadratic part over a group.
    squares: S::V,
    dropped: S::V,
}

impl StripGeometry<'_> {
    /// Checks what kernels rely on: bins of `step` numbers, and parts `[strips, blocks, rows, columns,
    /// MAX_LANES]` of groups of `pixels`.
    #[inline(always)]
    pub fn check<S: Lanes>(&self, pixels: usize, parts: [&[f32]; 2], bins: usize, step: usize) {
        let strip = self.groups.end.div_ceil(MAX_LANES) * pixels * MAX_LANES;
        let length = (self.strips.max(1) - 1) * self.stride + strip;
        assert!(parts.iter().all(|part| part.len() >= length) && strip <= self.stride);
        assert!(bins == self.entries * step && self.entries > 0);
        assert!(MAX_LANES.is_multiple_of(S::N) && self.groups.start.is_multiple_of(MAX_LANES));
    }

    /// Strip and first group of every block of `lanes`.
    #[inline(always)]
    pub fn blocks(&self, lanes: usize) -> impl Iterator<Item = (usize, usize)> {
        let groups = self.groups.clone();
        (0..self.strips).flat_map(move |strip| {
            groups
                .clone()
                .step_by(lanes)
                .map(move |first| (strip, first))
        })
    }

    /// Groups of the block from group `first` on.
    #[inline(always)]
    pub fn block(&self, first: usize, lanes: usize) -> Range<usize> {
        first..(first + lanes).min(self.groups.end)
    }

    /// Where the block of a strip from group `first` on begins, for groups of `pixels`.
    #[inline(always)]
    pub fn start(&self, strip: usize, first: usize, pixels: usize) -> usize {
        strip * self.stride + first / MAX_LANES * pixels * MAX_LANES + first % MAX_LANES
    }
}

impl<'a, S: Lanes, const COLUMNS: usize, const ROWS: usize, const CUBIC: bool>
    Strip<'a, S, COLUMNS, ROWS, CUBIC>
{
    /// The parameters for expansions in `units_a_metre` with errors up to `tolerance` units.
    #[inline(always)]
    pub fn of(s: S, geometry: &'a StripGeometry<'a>, units_a_metre: f64, tolerance: f64) -> Self {
        let mut lane = [0f32; MAX_LANES];
        for (k, v) in lane.iter_mut().enumerate() {
            let groups = k as f64 - 0.5 * (S::N - 1) as f64;
            *v = (groups * COLUMNS as f64 * geometry.pixel_m[0]) as f32;
        }
        Self {
            s,
            geometry,
            // SAFETY: `lane` has MAX_LANES ≥ N numbers.
            offsets_m: unsafe { s.load(lane.as_ptr()) },
            skew: s.splat(dot(geometry.unit[0], geometry.unit[1]) as f32),
            units_a_metre: units_a_metre as f32,
            pixel: geometry.pixel_m.map(|p| p as f32),
            tolerance: s.splat(tolerance as f32),
        }
    }

    /// Expands the ranges of the block of a strip from group `first` on; `None` where the expansion does not
    /// hold. Lanes past the last group repeat the last group. All degrees of bins share this function.
    #[inline(never)]
    pub fn expand(&self, strip: usize, first: usize) -> Option<Expanded<S>> {
        self.s.vectorize(
            #[inline(always)]
            |_| self.expand_here(strip, first),
        )
    }

    #[inline(always)]
    fn expand_here(&self, strip: usize, first: usize) -> Option<Expanded<S>> {
        let (s, geometry) = (self.s, self.geometry);
        let half = [0.5 * (COLUMNS * S::N - 1) as f64, 0.5 * (ROWS - 1) as f64];
        let along_m = ((first * COLUMNS) as f64 + half[0]) * geometry.pixel_m[0];
        let across_m = ((strip * ROWS) as f64 + half[1]) * geometry.pixel_m[1];
        let last = geometry.from_antennas_m.len() - 1;
        let d = [0, last].map(|antenna| -> [f64; 3] {
            std::array::from_fn(|a| {
                geometry.from_antennas_m[antenna][a]
                    + along_m * geometry.unit[0][a]
                    + across_m * geometry.unit[1][a]
            })
        });
        let ranges_m = d.map(norm);
        let block_m = half[0] * geometry.pixel_m[0] + half[1] * geometry.pixel_m[1];
        // NaN counts as near.
        let is_far = |range_m: f64| range_m - block_m >= geometry.reference_below_m;
        if !(is_far(ranges_m[0]) && is_far(ranges_m[1])) {
            return None;
        }
        let mut offsets_m = self.offsets_m;
        if first + S::N > geometry.groups.end {
            let last = (geometry.groups.end - first) as f64 - 0.5 * (S::N + 1) as f64;
            let last_m = s.splat((-last * COLUMNS as f64 * geometry.pixel_m[0]) as f32);
            let zero = s.splat(0.0);
            offsets_m = s.sub(zero, s.max(s.sub(zero, offsets_m), last_m));
        }
        let mean_m = 0.5 * (ranges_m[0] + ranges_m[1]);
        let t0 = mean_m / geometry.bin_m - geometry.first_bin as f64;
        let whole = (t0 as i32).clamp(0, geometry.entries as i32 - 1);
        let sent = self.about((d[0], ranges_m[0]), offsets_m)?;
        let (mut about, mut weight) = (sent, None);
        if last > 0 {
            let received = self.about((d[1], ranges_m[1]), offsets_m)?;
            about = sent.mean::<CUBIC>(s, &received);
            if geometry.two_spreadings {
                weight = Some(spreading(s, sent.range_m, received.range_m));
            }
        }
        if !s.all_le(about.dropped, self.tolerance) {
            return None;
        }
        let fraction = s.splat((t0 - f64::from(whole)) as f32);
        let a_metre = s.splat((1.0 / geometry.bin_m) as f32);
        Some(Expanded {
            slope: about.slope,
            along_square: about.along_square,
            product: about.product,
            across_square: about.across_square,
            inverse_range: about.inverse_range,
            reach: s.add(about.linear, about.squares),
            t: s.mul_add(about.difference_m, a_metre, fraction),
            whole,
            weight,
        })
    }

    /// Expands the ranges from an antenna seen from `d`, at `range_m`; `None` where the expansion does not converge.
    #[inline(always)]
    fn about(&self, (d, range_m): ([f64; 3], f64), offsets_m: S::V) -> Option<About<S>> {
        let (s, geometry) = (self.s, self.geometry);
        let (one, tiny) = (s.splat(1.0), s.splat(1e-30));
        let (range0, along0) = (s.splat(range_m as f32), dot(d, geometry.unit[0]) as f32);
        let along = s.add(s.splat(along0), offsets_m);
        let across = s.splat(dot(d, geometry.unit[1]) as f32);
        let across = s.mul_add(offsets_m, self.skew, across);
        let square_difference = s.mul(offsets_m, s.add(along, s.splat(along0)));
        let square = s.max(s.mul_add(range0, range0, square_difference), tiny);
        let range = s.sqrt(square);
        let difference = s.div(square_difference, s.add(range, range0));
        let inverse = s.div(one, range);
        let (u, v) = (s.mul(along, inverse), s.mul(across, inverse));
        let (units, [pu, pv]) = (self.units_a_metre, self.pixel);
        let curvature = s.mul(inverse, s.splat(0.5 * units));
        let along_square = s.mul(curvature, s.splat(pu * pu));
        let along_square = s.mul(along_square, s.neg_mul_add(u, u, one));
        let across_square = s.mul(curvature, s.splat(pv * pv));
        let across_square = s.mul(across_square, s.neg_mul_add(v, v, one));
        let product = s.mul(curvature, s.splat(2.0 * pu * pv));
        let product = s.mul(product, s.neg_mul_add(u, v, self.skew));
        let slope = [s.mul(u, s.splat(pu * units)), s.mul(v, s.splat(pv * units))];

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
        let inverse_range = s.mul(inverse, s.splat(1.0 / units));
        let reach = s.add(linear, squares);
        let dropped = if CUBIC {
            // Q/(1 + L/R) leaves QL²/R² (1 − …) of its expansion, the root no more than Q²/(2R) (1 + L/R)⁻³;
            // one fifth of R bounds both remainders.
            let share = s.mul(linear, inverse_range);
            if !s.all_le(share, s.splat(0.2)) {
                return None;
            }
            let rest = s.mul(s.mul(share, share), s.splat(1.25));
            s.mul(squares, s.mul_add(squares, inverse_range, rest))
        } else {
            // Third order −LQ/R; what follows is below Q²/R.
            s.mul(s.mul(squares, reach), inverse_range)
        };
        Some(About {
            range_m: range,
            difference_m: difference,
            slope,
            along_square,
            product,
            across_square,
            inverse_range,
            linear,
            squares,
            dropped,
        })
    }
}

impl<S: Lanes> About<S> {
    /// The expansion of the mean of both ranges. Kernels of third order use the product of the means (linear
    /// part times quadratic part over range) instead of the mean of the products; the error is the product of
    /// two half differences and a mean.
    #[inline(always)]
    fn mean<const CUBIC: bool>(&self, s: S, other: &Self) -> Self {
        let mut mean = self.half_sum(s, other, s.splat(1.0));
        if CUBIC {
            // The pixels of a group lie at most 1.5 pixels from its middle.
            let apart = self.half_sum(s, other, s.splat(-1.0));
            let slopes = s.add(s.abs(apart.slope[0]), s.abs(apart.slope[1]));
            let linear_apart = s.mul(s.splat(1.5), slopes);
            let squares = s.add(s.abs(apart.along_square), s.abs(apart.product));
            let squares = s.add(squares, s.abs(apart.across_square));
            let squares_apart = s.mul(s.splat(2.25), squares);
            let one = s.mul_add(
                mean.linear,
                squares_apart,
                s.mul(mean.squares, linear_apart),
            );
            let both = s.mul(linear_apart, squares_apart);
            let dropped = s.mul_add(
                one,
                s.abs(apart.inverse_range),
                s.mul(both, mean.inverse_range),
            );
            mean.dropped = s.add(mean.dropped, dropped);
        }
        mean
    }

    /// Half of the sum of two expansions, or half of their difference where `sign` is −1.
    #[inline(always)]
    fn half_sum(&self, s: S, other: &Self, sign: S::V) -> Self {
        half_sums!(
            (s, sign, self, other),
            [
                range_m,
                difference_m,
                along_square,
                product,
                across_square,
                inverse_range,
                linear,
                squares,
                dropped,
            ],
            [slope]
        )
    }
}
