//! Expansion of the range over the groups of a block, and the choice between windows, gathers and the
//! double-precision sum for each pulse.

use super::job::{Band, CHUNK, Job, PixelWeight, block_width, vectors_a_group};
use super::unwindowed::{Unwindowed, whole_and_rest};
use crate::kernel::aligned::Aligned;
use crate::kernel::lanes::{Lanes, MAX_LANES, ROUNDING};
use crate::kernel::two_ways::{lesser, mean, spreading};
use crate::vector::dot;
use std::ops::Range;

/// Greatest number of parameter rows of a pulse; without a weight of the pixels only the first eight are
/// used.
const MOST_ROWS: usize = 10;

/// Number of parameter rows of a pulse, with or without a weight of the pixels.
pub(super) const fn parameter_rows(weighted: bool) -> usize {
    if weighted { MOST_ROWS } else { 8 }
}

/// Pulses of a chunk and the pixels of one block.
pub(super) struct Block<'a, S> {
    pub s: S,
    pub job: &'a Job<'a>,
    pub band: &'a Band,
    /// First column of the block, and its row.
    pub column: usize,
    pub row: usize,
    /// Groups that hold pixels of the band.
    pub groups: usize,
    pub pulses: Range<usize>,
}

impl<S: Lanes> Block<'_, S> {
    /// The block's centre, m.
    #[inline(always)]
    pub fn centre_m(&self) -> [f64; 3] {
        let along = self.column as f64 + 0.5 * (block_width(S::N) - 1) as f64;
        let band = self.band;
        std::array::from_fn(|axis| {
            band.origin_m[axis] + along * band.u_m[axis] + self.row as f64 * band.v_m[axis]
        })
    }

    /// Unit vector along the row.
    #[inline(always)]
    pub fn unit(&self) -> [f64; 3] {
        self.band.u_m.map(|u| u / self.job.pixel_m)
    }
}

/// Parameters of the pulses of a chunk for one block.
pub(super) struct Setup {
    /// Parameters of each pulse that has windows, [`parameter_rows`] rows of N, one lane a group: the range
    /// at the group's middle in bins past `whole`; the coefficients of the first, second and third power of
    /// the pixel; for either vector the whole bins from `whole` to the vector's window, and the bits of the
    /// integer at which the window starts in the chunk's table. With a weight of the pixels also the weight
    /// (or the ratio of cosines on which the weight depends) at the group's middle, and its change a pixel.
    pub windowed: Aligned<{ CHUNK * MOST_ROWS * MAX_LANES }>,
    /// Range and along-row offset of the block's centre from each antenna of each pulse, m.
    pub range_m: [[f32; CHUNK]; 2],
    pub along_m: [[f32; CHUNK]; 2],
    /// Ratio of the cosines from boresight and vertical at the block's centre.
    pub ratio: [f32; CHUNK],
    /// Change of the ratio along the row, 1/m.
    pub ratio_slope: [f32; CHUNK],
    /// The mean range in bins: whole bins past the pulse's entry 0, and the rest.
    pub fraction: [f32; CHUNK],
    pub whole: [i32; CHUNK],
}

impl Setup {
    pub fn new() -> Self {
        Self {
            windowed: Aligned([0.0; CHUNK * MOST_ROWS * MAX_LANES]),
            range_m: [[0.0; CHUNK]; 2],
            along_m: [[0.0; CHUNK]; 2],
            ratio: [0.0; CHUNK],
            ratio_slope: [0.0; CHUNK],
            fraction: [0.0; CHUNK],
            whole: [0; CHUNK],
        }
    }

    /// Computes the ranges from every antenna to the block's centre in double precision.
    #[inline(always)]
    pub fn measure<S: Lanes, const WEIGHTED: bool>(&mut self, block: &Block<S>) {
        let ([x, y, z], unit, job) = (block.centre_m(), block.unit(), block.job);
        let inverse_bin = 1.0 / job.table.bin_m;
        let start = &job.table.first_bin[block.pulses.clone()];
        let share = 1.0 / job.antennas_m.len() as f64;
        let mut mean = [0f64; CHUNK];
        let seen = self.range_m.iter_mut().zip(&mut self.along_m);
        for (antenna_m, (ranges, alongs)) in job.antennas_m.iter().zip(seen) {
            let px = &antenna_m[0][block.pulses.clone()];
            let py = &antenna_m[1][block.pulses.clone()];
            let pz = &antenna_m[2][block.pulses.clone()];
            for m in 0..block.pulses.len() {
                let (dx, dy, dz) = (x - px[m], y - py[m], z - pz[m]);
                let range = (dx * dx + dy * dy + dz * dz).sqrt();
                let along = dx * unit[0] + dy * unit[1] + dz * unit[2];
                mean[m] += share * range;
                ranges[m] = range as f32;
                alongs[m] = along as f32;
                if WEIGHTED && let Some(PixelWeight::Tilt(tilt)) = &job.weight {
                    let b = tilt.per_metre[block.pulses.start + m];
                    self.ratio[m] = (dx * b[0] + dy * b[1] + dz * b[2]) as f32;
                    self.ratio_slope[m] = dot(unit, b) as f32;
                }
            }
        }
        for m in 0..block.pulses.len() {
            (self.whole[m], self.fraction[m]) = whole_and_rest(mean[m] * inverse_bin - start[m]);
        }
    }

    /// Range of the block's centre from the nearest of a pulse's antennas, m.
    #[inline(always)]
    fn nearest_m(&self, m: usize, antennas: usize) -> f32 {
        let ranges_m = &self.range_m[..antennas];
        ranges_m
            .iter()
            .fold(f32::INFINITY, |nearest, r| nearest.min(r[m]))
    }
}

/// Pulses of a chunk by the way in which they are read for one block.
pub(super) struct Paths {
    /// Pulses with parameters in [`Setup::windowed`].
    pub windowed: usize,
    pub others: Unwindowed,
}

/// Lengths and scales of the groups of a block.
struct Groups<S: Lanes> {
    /// Offset of each group's middle from the block's centre, m.
    along_m: S::V,
    /// Least range at which tables are read, m.
    near_m: S::V,
    pixel: f32,
    bins: f32,
}

impl<S: Lanes> Groups<S> {
    /// Pixels from the middle of a group to its end.
    const HALF: f32 = 0.5 * (vectors_a_group(S::N) * S::N - 1) as f32;
    /// Pixels from the middle of a vector to its end.
    const HALF_VECTOR: f32 = 0.5 * (S::N - 1) as f32;
    /// Pixels from the middle of a group to that of its vectors.
    const SHIFT: f32 = 0.5 * ((vectors_a_group(S::N) - 1) * S::N) as f32;

    #[inline(always)]
    fn of(block: &Block<S>) -> Self {
        let (s, job) = (block.s, block.job);
        let pixel = job.pixel_m as f32;
        let mut offsets = [0f32; MAX_LANES];
        for (k, o) in offsets.iter_mut().enumerate() {
            let k = k.min(block.groups - 1) as f32;
            *o = (k - Self::HALF_VECTOR) * (vectors_a_group(S::N) * S::N) as f32 * pixel;
        }
        Self {
            // SAFETY: `offsets` has MAX_LANES ≥ N numbers.
            along_m: unsafe { s.load(offsets.as_ptr()) },
            near_m: s.splat(job.reference_below_m as f32 + (Self::HALF + 1.0) * pixel),
            pixel,
            bins: (1.0 / job.table.bin_m) as f32,
        }
    }
}

/// The range over each group, one lane a group.
#[derive(Clone, Copy)]
struct Expansion<S: Lanes> {
    /// Range at the middle from the nearer antenna, m.
    range_m: S::V,
    /// Range at the middle, in bins past the whole bins of the block's centre.
    t: S::V,
    /// Coefficients of the powers of the pixel, bins.
    first: S::V,
    second: S::V,
    third: S::V,
    /// Bound of the expansion's truncation error, bins.
    truncation_error: S::V,
    /// Largest departure of the odd powers from the range at a vector's middle, bins.
    reach: S::V,
}

impl<S: Lanes> Expansion<S> {
    #[inline(always)]
    fn of<const CUBIC: bool>(
        s: S,
        groups: &Groups<S>,
        setup: &Setup,
        (antenna, m): (usize, usize),
    ) -> Self {
        let (pixel, bins) = (groups.pixel, groups.bins);
        let (one, tiny) = (s.splat(1.0), s.splat(1e-30));
        let (half, half_vector) = (Groups::<S>::HALF, Groups::<S>::HALF_VECTOR);
        let per_pixel = s.splat(pixel * bins);
        let range0 = s.splat(setup.range_m[antenna][m]);
        let along0 = s.splat(setup.along_m[antenna][m]);
        let along = s.add(along0, groups.along_m);
        let square_difference = s.mul(groups.along_m, s.add(along, along0));
        let square = s.max(s.mul_add(range0, range0, square_difference), tiny);
        let range = s.sqrt(square);
        let sum = s.add(range, range0);
        let reciprocal = s.div(one, s.mul(sum, range));
        let inverse_range = s.mul(reciprocal, sum);
        let difference = s.mul(s.mul(square_difference, reciprocal), range);
        let gradient = s.mul(along, inverse_range);
        let bend = s.neg_mul_add(gradient, gradient, one);
        let curvature = s.mul(bend, inverse_range);
        let t = s.mul_add(difference, s.splat(bins), s.splat(setup.fraction[m]));
        let first = s.mul(gradient, per_pixel);
        let second = s.mul(curvature, s.splat(0.5 * pixel * pixel * bins));
        let third = s.mul(
            s.mul(s.mul(gradient, curvature), inverse_range),
            s.splat(-0.5 * pixel * pixel * pixel * bins),
        );
        let (first, truncation_error) = if CUBIC {
            // The fourth derivative is at most 12 (1 − gradient²)/R³.
            let fourth = s.mul(s.mul(second, inverse_range), inverse_range);
            (first, s.mul(fourth, s.splat(pixel * pixel * half.powi(4))))
        } else {
            // The line nearest to x³ over |x| ≤ h is 3h²x/5; the error is at most 2h³/5.
            (
                s.mul_add(third, s.splat(0.6 * half * half), first),
                s.mul(s.abs(third), s.splat(0.4 * half.powi(3))),
            )
        };
        // The range is convex: over a vector it stays above its tangent at the vector's middle.
        let mut steepest = s.mul_add(second, s.splat(2.0 * Groups::<S>::SHIFT), s.abs(first));
        if CUBIC {
            steepest = s.mul_add(s.abs(third), s.splat(3.0 * half * half), steepest);
        }
        Self {
            range_m: range,
            t,
            first,
            second,
            third,
            truncation_error,
            reach: s.mul(steepest, s.splat(half_vector)),
        }
    }

    /// The expansion of the mean of both ranges.
    #[inline(always)]
    fn mean(self, s: S, other: Self) -> Self {
        Self {
            range_m: lesser(s, self.range_m, other.range_m),
            t: mean(s, self.t, other.t),
            first: mean(s, self.first, other.first),
            second: mean(s, self.second, other.second),
            third: mean(s, self.third, other.third),
            truncation_error: mean(s, self.truncation_error, other.truncation_error),
            reach: mean(s, self.reach, other.reach),
        }
    }

    /// Ratio S²/(R_t R_r) of the bistatic spreading to the spreading at the mean range, at the middle of each
    /// group, and its change a pixel.
    #[inline(always)]
    fn spreading(&self, s: S, other: &Self, bins: f32) -> [S::V; 2] {
        let (a, b) = (self.range_m, other.range_m);
        let twice = s.add(a, b);
        let weight = spreading(s, a, b);
        let of_mean = s.div(s.mul(s.splat(2.0), s.add(self.first, other.first)), twice);
        let of_ways = s.add(s.div(self.first, a), s.div(other.first, b));
        let change = s.mul(s.sub(of_mean, of_ways), s.splat(1.0 / bins));
        [weight, s.mul(weight, change)]
    }

    /// Number of bins that a vector spans, and for either vector of a group the whole bins at which its
    /// window must start.
    #[inline(always)]
    fn windows(&self, s: S) -> (S::V, [S::V; 2]) {
        let (half_vector, shift) = (Groups::<S>::HALF_VECTOR, Groups::<S>::SHIFT);
        let span = s.mul_add(
            self.second,
            s.splat(half_vector * half_vector),
            s.add(self.reach, self.reach),
        );
        // Half a bin up for rounding, a little down for safety.
        let lowest = s.mul_add(
            self.second,
            s.splat(shift * shift),
            s.sub(self.t, s.sub(self.reach, s.splat(0.499))),
        );
        let windows = if vectors_a_group(S::N) > 1 {
            [
                s.floor(s.neg_mul_add(self.first, s.splat(shift), lowest)),
                s.floor(s.mul_add(self.first, s.splat(shift), lowest)),
            ]
        } else {
            [s.floor(lowest), s.floor(lowest)]
        };
        (span, windows)
    }

    /// Stores the parameters of a pulse in `rows`, windows counted from `start` in the chunk's table.
    #[inline(always)]
    fn store<const CUBIC: bool>(&self, s: S, windows: [S::V; 2], start: i32, rows: &mut [f32]) {
        let n = S::N;
        let rounding = s.splat(ROUNDING);
        assert!(rows.len() >= parameter_rows(false) * n);
        // SAFETY: `rows` holds that many rows of N numbers.
        unsafe {
            let at = rows.as_mut_ptr();
            s.store(at, self.t);
            s.store(at.add(n), self.first);
            s.store(at.add(2 * n), self.second);
            if CUBIC {
                s.store(at.add(3 * n), self.third);
            }
            s.store(at.add(4 * n), windows[0]);
            s.store_rounded(at.add(5 * n).cast(), s.add(windows[0], rounding), start);
            if vectors_a_group(n) > 1 {
                s.store(at.add(6 * n), windows[1]);
                s.store_rounded(at.add(7 * n).cast(), s.add(windows[1], rounding), start);
            }
        }
    }
}

/// Expands the ranges of all pulses of a chunk and decides how each pulse is read. All degrees of tables
/// share this function.
#[inline(never)]
pub(super) fn expand<S: Lanes, const CUBIC: bool, const WEIGHTED: bool>(
    block: &Block<S>,
    setup: &mut Setup,
) -> Paths {
    block.s.vectorize(
        #[inline(always)]
        |_| expand_here::<S, CUBIC, WEIGHTED>(block, setup),
    )
}

#[inline(always)]
fn expand_here<S: Lanes, const CUBIC: bool, const WEIGHTED: bool>(
    block: &Block<S>,
    setup: &mut Setup,
) -> Paths {
    let (s, job, n) = (block.s, block.job, S::N);
    let table = &job.table;
    let groups = Groups::of(block);
    let tolerance = s.splat(job.tolerance_bins as f32);
    let last_window = s.splat(table.stride as f32 - 2.0 - n as f32);
    let widest = s.splat((n - 1) as f32 - 0.05);
    let zero = s.splat(0.0);
    let half_block = 0.5 * block_width(n) as f32 * groups.pixel;
    let mut paths = Paths {
        windowed: 0,
        others: Unwindowed::default(),
    };
    for m in 0..block.pulses.len() {
        let nearest_m = setup.nearest_m(m, job.antennas_m.len());
        if !job.windows && nearest_m - half_block > job.reference_below_m as f32 {
            paths.others.gather(m);
            continue;
        }
        let sent = Expansion::of::<CUBIC>(s, &groups, setup, (0, m));
        let (mut expansion, mut received) = (sent, sent);
        if job.antennas_m.len() > 1 {
            received = Expansion::of::<CUBIC>(s, &groups, setup, (1, m));
            expansion = sent.mean(s, received);
        }
        if !s.all_le(groups.near_m, expansion.range_m) {
            paths.others.refer(m);
            continue;
        }
        let (span, windows) = expansion.windows(s);
        let whole = s.splat(setup.whole[m] as f32);
        let least = s.sub(
            whole,
            s.max(s.sub(zero, windows[0]), s.sub(zero, windows[1])),
        );
        let most = s.add(whole, s.max(windows[0], windows[1]));
        let fits = job.windows
            && s.all_le(span, widest)
            && s.all_le(expansion.truncation_error, tolerance)
            && s.all_le(zero, least)
            && s.all_le(most, last_window);
        if !fits {
            paths.others.gather(m);
            continue;
        }
        let length = parameter_rows(WEIGHTED) * n;
        let rows = &mut setup.windowed.0[paths.windowed * length..][..length];
        let start = (m * table.pulse_stride) as i32 + setup.whole[m];
        expansion.store::<CUBIC>(s, windows, start, rows);
        if WEIGHTED {
            let [weight, change] = if let Some(PixelWeight::Ways) = job.weight {
                sent.spreading(s, &received, groups.bins)
            } else {
                let slope = s.splat(setup.ratio_slope[m]);
                let ratio = s.mul_add(groups.along_m, slope, s.splat(setup.ratio[m]));
                [ratio, s.mul(slope, s.splat(groups.pixel))]
            };
            // SAFETY: `rows` holds ten rows of N numbers.
            unsafe {
                let at = rows.as_mut_ptr();
                s.store(at.add(8 * n), weight);
                s.store(at.add(9 * n), change);
            }
        }
        paths.windowed += 1;
    }
    paths
}
