//! Tiles of rows, block by block and chunk by chunk of pulses.

use super::evaluator::Evaluator;
use super::expansion::{Block, Paths, Setup, expand, parameter_rows};
use super::job::{
    Band, CHUNK, Job, PixelWeight, TILE, Tally, block_width, tile_rows, vectors_a_group,
};
use crate::kernel::aligned::Aligned;
use crate::kernel::lanes::{Lanes, MAX_LANES};
use crate::kernel::profile::DELAYS;
use crate::kernel::two_ways::{mean, spreading};
use num_complex::Complex32;

/// Images a band into `out` `[rows, columns]`; the caller keeps `rows` within [`tile_rows`].
///
/// `DEGREE` is the degree of the table, `TERMS` the number of the cosine's coefficients (the sine has one
/// fewer); `CUBIC` adds the third order of the range within a vector, and `WEIGHTED` applies the weight of
/// the pixels in `job.weight`.
#[inline(always)]
pub(crate) fn band<
    S: Lanes,
    const DEGREE: usize,
    const TERMS: usize,
    const CUBIC: bool,
    const WEIGHTED: bool,
>(
    s: S,
    job: &Job,
    band: &Band,
    out: &mut [Complex32],
) -> Tally {
    assert!(band.rows <= tile_rows(S::N) && out.len() == band.rows * band.columns);
    assert!(job.table.degree == DEGREE && WEIGHTED == job.weight.is_some());
    let width = block_width(S::N);
    let (mut real, mut imag) = (Aligned([0f32; TILE]), Aligned([0f32; TILE]));
    let (real, imag) = (&mut real.0, &mut imag.0);
    let mut setup = Setup::new();
    let mut tally = Tally::default();
    let unscale = (1.0 / job.table.scale) as f32;
    let mut column = 0;
    while column < band.columns && !job.control.is_cancelled() {
        let kept = (band.columns - column).min(width);
        real.fill(0.0);
        imag.fill(0.0);
        // Gathers touch a cache line a lane: only with fewer pulses do these lines stay in the first-level
        // cache.
        let chunk = if job.table.interleaved { 2 } else { CHUNK };
        let mut first = job.pulses.start;
        while first < job.pulses.end {
            let count = (job.pulses.end - first).min(chunk);
            for row in 0..band.rows {
                let at = row * width..(row + 1) * width;
                let block = Block {
                    s,
                    job,
                    band,
                    column,
                    row,
                    groups: kept.div_ceil(S::N * vectors_a_group(S::N)),
                    pulses: first..first + count,
                };
                let sums = (&mut real[at.clone()], &mut imag[at]);
                sum_block::<S, DEGREE, TERMS, CUBIC, WEIGHTED>(
                    &block, &mut setup, sums, &mut tally,
                );
            }
            first += count;
        }
        for row in 0..band.rows {
            let line = &mut out[row * band.columns + column..][..kept];
            let (re, im) = (&real[row * width..], &imag[row * width..]);
            for ((o, re), im) in line.iter_mut().zip(re).zip(im) {
                *o = Complex32::new(re * unscale, im * unscale);
            }
        }
        column += width;
    }
    tally
}

/// Adds the contributions of a chunk of pulses to a block.
#[inline(always)]
fn sum_block<
    S: Lanes,
    const DEGREE: usize,
    const TERMS: usize,
    const CUBIC: bool,
    const WEIGHTED: bool,
>(
    block: &Block<S>,
    setup: &mut Setup,
    (real, imag): (&mut [f32], &mut [f32]),
    tally: &mut Tally,
) {
    let (s, n, job) = (block.s, S::N, block.job);
    let pair = vectors_a_group(n);
    let width = block_width(n);
    assert!(real.len() >= width && imag.len() >= width && block.groups <= n);
    setup.measure::<S, WEIGHTED>(block);
    let paths = expand::<S, CUBIC, WEIGHTED>(block, setup);

    let mut lane = [0f32; MAX_LANES];
    for (l, v) in lane.iter_mut().enumerate() {
        *v = l as f32 - 0.5 * (n - 1) as f32;
    }
    let sum = BlockSum::<S, DEGREE, TERMS, CUBIC, WEIGHTED> {
        block,
        setup,
        paths: &paths,
        // SAFETY: `lane` has MAX_LANES ≥ N numbers.
        lanes: unsafe { s.load(lane.as_ptr()) },
        chunk_table: &job.table.coefficients[block.pulses.start * job.table.pulse_stride..]
            [..block.pulses.len() * job.table.pulse_stride],
        evaluator: Evaluator::of(s, job),
    };
    for k in 0..block.groups {
        let mut sums = sum.windows(k);
        for (side, sums) in sums.iter_mut().enumerate().take(pair) {
            let vector = pair * k + side;
            sum.gathers(vector, sums);
            // SAFETY: `vector` < pair·N, and `real`, `imag` hold pair·N·N numbers.
            unsafe {
                let at = vector * n;
                let (re, im) = (real.as_mut_ptr().add(at), imag.as_mut_ptr().add(at));
                s.store(re, s.add(s.load(re), sums[0]));
                s.store(im, s.add(s.load(im), sums[1]));
            }
        }
    }
    let count = |pulses: usize| (pulses * pair * block.groups) as u64;
    tally.window += count(paths.windowed);
    tally.gather += count(paths.others.gathered().len());
    tally.reference += count(paths.others.reference().len());
    if !paths.others.reference().is_empty() {
        sum_reference(block, &paths, real, imag);
    }
}

/// Sums over the pulses of a chunk, group by group.
struct BlockSum<
    'a,
    S: Lanes,
    const DEGREE: usize,
    const TERMS: usize,
    const CUBIC: bool,
    const WEIGHTED: bool,
> {
    block: &'a Block<'a, S>,
    setup: &'a Setup,
    paths: &'a Paths,
    /// Pixels from a vector's middle.
    lanes: S::V,
    /// Coefficients of the chunk's pulses.
    chunk_table: &'a [f32],
    evaluator: Evaluator<S, DEGREE, TERMS>,
}

impl<S: Lanes, const DEGREE: usize, const TERMS: usize, const CUBIC: bool, const WEIGHTED: bool>
    BlockSum<'_, S, DEGREE, TERMS, CUBIC, WEIGHTED>
{
    /// Sums of group `k` over the pulses read from windows: real and imaginary part of each vector.
    #[inline(always)]
    fn windows(&self, k: usize) -> [[S::V; 2]; 2] {
        let (s, n) = (self.block.s, S::N);
        let pair = vectors_a_group(n);
        let shift = s.splat(0.5 * ((pair - 1) * n) as f32);
        let lanes_of = [s.sub(self.lanes, shift), s.add(self.lanes, shift)];
        let mut sums = [[s.splat(0.0); 2]; 2];
        let row_length = parameter_rows(WEIGHTED) * n;
        // SAFETY: the first `windowed` parameter sets were written, k < N; windows were checked to lie
        // within their pulse's rows.
        unsafe {
            let mut at = self.setup.windowed.0.as_ptr().add(k);
            let end = at.add(self.paths.windowed * row_length);
            while at < end {
                let term = |row: usize| s.splat(*at.add(row * n));
                let next = at.add(row_length);
                for side in 0..pair {
                    let lanes = lanes_of[side];
                    let t = s.sub(term(0), term(4 + 2 * side));
                    let slope = if CUBIC {
                        s.mul_add(lanes, s.mul_add(lanes, term(3), term(2)), term(1))
                    } else {
                        s.mul_add(lanes, term(2), term(1))
                    };
                    let t = s.mul_add(lanes, slope, t);
                    let start = (*at.add((5 + 2 * side) * n)).to_bits() as i32;
                    let window = self.chunk_table.as_ptr().offset(start as isize);
                    let weight = self.weight(|| s.mul_add(lanes, term(9), term(8)));
                    self.evaluator
                        .windowed::<false>(window, t, weight, &mut sums[side]);
                }
                at = next;
            }
        }
        sums
    }

    /// The weight of pixels, where `given` returns the weight itself or the ratio of cosines on which the
    /// weight depends.
    #[inline(always)]
    fn weight(&self, given: impl FnOnce() -> S::V) -> Option<S::V> {
        match &self.block.job.weight {
            Some(PixelWeight::Tilt(tilt)) if WEIGHTED => Some(tilt.power.of(self.block.s, given())),
            Some(PixelWeight::Ways) if WEIGHTED => Some(given()),
            _ => None,
        }
    }

    /// Adds the pulses that gather to the sums of a vector.
    #[inline(always)]
    fn gathers(&self, vector: usize, sums: &mut [S::V; 2]) {
        let (s, job) = (self.block.s, self.block.job);
        let table = &job.table;
        let bins = s.splat((1.0 / table.bin_m) as f32);
        for &m in self.paths.others.gathered() {
            let m = usize::from(m);
            let origin = self.origin(m, vector);
            let sent = origin.exact(s, 0);
            let (mut difference, mut received) = (sent.difference_m, sent);
            if job.antennas_m.len() > 1 {
                received = origin.exact(s, 1);
                difference = mean(s, difference, received.difference_m);
            }
            let t = s.mul_add(difference, bins, s.splat(origin.fraction));
            let slope = s.splat(self.setup.ratio_slope[m]);
            let weight = self.weight(
                #[inline(always)]
                || match &job.weight {
                    Some(PixelWeight::Ways) => spreading(s, sent.range_m, received.range_m),
                    _ => s.mul_add(origin.offset_m, slope, s.splat(origin.ratio)),
                },
            );
            // SAFETY: the rounded index, counted from the start of the pulse's row, is clamped into
            // the row.
            unsafe {
                let row = self.chunk_table.as_ptr().add(m * table.pulse_stride);
                let whole = origin.whole;
                let lowest = s.splat(-(whole as f32));
                let highest = s.splat((table.stride as i32 - 1 - whole) as f32);
                self.evaluator
                    .gathered(row, whole, t, (lowest, highest), weight, sums);
            }
        }
    }

    /// The point from which exact ranges of a vector are counted: the block's centre, or the vector's middle
    /// where single precision does not reach from the block's centre.
    #[inline(always)]
    fn origin(&self, m: usize, vector: usize) -> Origin<S> {
        let (s, n, block) = (self.block.s, S::N, self.block);
        let (job, setup) = (block.job, self.setup);
        let pixel = s.splat(job.pixel_m as f32);
        // From the block's centre to the vector's middle: half pixels, and so exact.
        let middle = (vector * n) as f32 + 0.5 * (n - 1) as f32 - 0.5 * (block_width(n) - 1) as f32;
        if job.near_centre {
            return Origin {
                range_m: setup.range_m.map(|of_antenna| of_antenna[m]),
                along_m: setup.along_m.map(|of_antenna| of_antenna[m]),
                whole: setup.whole[m],
                fraction: setup.fraction[m],
                offset_m: s.mul(s.add(self.lanes, s.splat(middle)), pixel),
                ratio: setup.ratio[m],
            };
        }
        let ([x, y, z], unit) = (block.centre_m(), block.unit());
        let (along, pulse) = (f64::from(middle) * job.pixel_m, block.pulses.start + m);
        let ([mut range_m, mut along_m], mut mean) = ([[0f32; 2]; 2], 0.0);
        for (k, antenna_m) in job.antennas_m.iter().enumerate() {
            let (dx, dy, dz) = (
                x + along * unit[0] - antenna_m[0][pulse],
                y + along * unit[1] - antenna_m[1][pulse],
                z + along * unit[2] - antenna_m[2][pulse],
            );
            let range = (dx * dx + dy * dy + dz * dz).sqrt();
            mean += range / job.antennas_m.len() as f64;
            range_m[k] = range as f32;
            along_m[k] = (dx * unit[0] + dy * unit[1] + dz * unit[2]) as f32;
        }
        let t = mean * (1.0 / job.table.bin_m) - job.table.first_bin[pulse];
        let whole = t as i32;
        Origin {
            range_m,
            along_m,
            whole,
            fraction: (t - f64::from(whole)) as f32,
            offset_m: s.mul(self.lanes, pixel),
            ratio: setup.ratio[m] + setup.ratio_slope[m] * along as f32,
        }
    }
}

/// A point near a vector, seen from the antennas of a pulse, and the vector's pixels seen from it.
struct Origin<S: Lanes> {
    range_m: [f32; 2],
    along_m: [f32; 2],
    /// Mean range in bins, as whole bins past the pulse's entry 0 and a fraction.
    whole: i32,
    fraction: f32,
    /// Offsets of the pixels along the row, m.
    offset_m: S::V,
    /// Ratio of the cosines from boresight and vertical at the point.
    ratio: f32,
}

/// Ranges of a vector's pixels from an antenna, and their excess over the range of the origin, m.
#[derive(Clone, Copy)]
struct Exact<S: Lanes> {
    range_m: S::V,
    difference_m: S::V,
}

impl<S: Lanes> Origin<S> {
    #[inline(always)]
    fn exact(&self, s: S, antenna: usize) -> Exact<S> {
        let along0 = s.splat(self.along_m[antenna]);
        let range0 = s.splat(self.range_m[antenna]);
        let offset = self.offset_m;
        let square_difference = s.mul(offset, s.add(s.add(along0, offset), along0));
        let square = s.max(s.mul_add(range0, range0, square_difference), s.splat(1e-30));
        let range_m = s.sqrt(square);
        Exact {
            range_m,
            difference_m: s.div(square_difference, s.add(range_m, range0)),
        }
    }
}

/// Adds the pulses next to a block in double precision.
fn sum_reference<S: Lanes>(block: &Block<S>, paths: &Paths, real: &mut [f32], imag: &mut [f32]) {
    let (job, band) = (block.job, block.band);
    let pixels = (block.groups * vectors_a_group(S::N) * S::N).min(band.columns - block.column);
    let point_m = |i: usize| -> [f64; 3] {
        let along = (block.column + i) as f64;
        std::array::from_fn(|axis| {
            band.origin_m[axis] + along * band.u_m[axis] + block.row as f64 * band.v_m[axis]
        })
    };
    for &m in paths.others.reference() {
        let pulse = block.pulses.start + m as usize;
        for first in (0..pixels).step_by(DELAYS) {
            let count = DELAYS.min(pixels - first);
            let points_m: [[f64; 3]; DELAYS] = std::array::from_fn(|k| point_m(first + k));
            let values = job.reference.contributions(pulse, &points_m[..count]);
            for (i, value) in (first..).zip(&values[..count]) {
                real[i] += (value.re * job.table.scale) as f32;
                imag[i] += (value.im * job.table.scale) as f32;
            }
        }
    }
}
