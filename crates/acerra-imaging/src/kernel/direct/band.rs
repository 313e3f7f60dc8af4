//! Tiles of rows, block by block and chunk by chunk of pulses.

use super::evaluator::Evaluator;
use super::expansion::{Block, Paths, Setup, expand, parameter_rows};
use super::job::{Band, CHUNK, Job, TILE, Tally, block_width, tile_rows, vectors_a_group};
use crate::kernel::aligned::Aligned;
use crate::kernel::lanes::{Lanes, MAX_LANES};
use crate::kernel::profile::DELAYS;
use num_complex::Complex32;

/// Images a band into `out` `[rows, columns]`; the caller keeps `rows` within [`tile_rows`].
///
/// `DEGREE` is that of the table, `TERMS` counts the cosine's coefficients (the sine has one less),
/// `CUBIC` adds the third order of the range within a vector, and `TILT` takes the antenna's pattern from the
/// boresights of `job.tilt`.
#[inline(always)]
pub(crate) fn band<
    S: Lanes,
    const DEGREE: usize,
    const TERMS: usize,
    const CUBIC: bool,
    const TILT: bool,
>(
    s: S,
    job: &Job,
    band: &Band,
    out: &mut [Complex32],
) -> Tally {
    assert!(band.rows <= tile_rows(S::N) && out.len() == band.rows * band.columns);
    assert!(job.table.degree == DEGREE && TILT == job.tilt.is_some());
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
        // Gathers touch a cache line a lane: fewer pulses keep theirs in the first level.
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
                sum_block::<S, DEGREE, TERMS, CUBIC, TILT>(&block, &mut setup, sums, &mut tally);
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
    const TILT: bool,
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
    setup.measure::<S, TILT>(block);
    let paths = expand::<S, CUBIC, TILT>(block, setup);

    let mut lane = [0f32; MAX_LANES];
    for (l, v) in lane.iter_mut().enumerate() {
        *v = l as f32 - 0.5 * (n - 1) as f32;
    }
    let sum = BlockSum::<S, DEGREE, TERMS, CUBIC, TILT> {
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
    tally.gather += count(paths.gathered().len());
    tally.reference += count(paths.reference().len());
    if !paths.reference().is_empty() {
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
    const TILT: bool,
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

impl<S: Lanes, const DEGREE: usize, const TERMS: usize, const CUBIC: bool, const TILT: bool>
    BlockSum<'_, S, DEGREE, TERMS, CUBIC, TILT>
{
    /// Sums from windows of group `k`, one pair of real and imaginary parts a vector.
    #[inline(always)]
    fn windows(&self, k: usize) -> [[S::V; 2]; 2] {
        let (s, n) = (self.block.s, S::N);
        let pair = vectors_a_group(n);
        let shift = s.splat(0.5 * ((pair - 1) * n) as f32);
        let lanes_of = [s.sub(self.lanes, shift), s.add(self.lanes, shift)];
        let mut sums = [[s.splat(0.0); 2]; 2];
        let row_length = parameter_rows(TILT) * n;
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
                    self.evaluator.windowed(window, t, weight, &mut sums[side]);
                }
                at = next;
            }
        }
        sums
    }

    /// The antenna's pattern beside that of one that looks straight down, where the cosines have a ratio.
    #[inline(always)]
    fn weight(&self, ratio: impl FnOnce() -> S::V) -> Option<S::V> {
        match &self.block.job.tilt {
            Some(tilt) if TILT => Some(tilt.power.of(self.block.s, ratio())),
            _ => None,
        }
    }

    /// Adds the pulses that gather to the sums of a vector.
    #[inline(always)]
    fn gathers(&self, vector: usize, sums: &mut [S::V; 2]) {
        let (s, table) = (self.block.s, &self.block.job.table);
        let tiny = s.splat(1e-30);
        let bins = s.splat((1.0 / table.bin_m) as f32);
        for &m in self.paths.gathered() {
            let m = usize::from(m);
            let origin = self.origin(m, vector);
            let (along0, range0) = (s.splat(origin.along_m), s.splat(origin.range_m));
            let offset = origin.offset_m;
            let square_difference = s.mul(offset, s.add(s.add(along0, offset), along0));
            let square = s.max(s.mul_add(range0, range0, square_difference), tiny);
            let difference = s.div(square_difference, s.add(s.sqrt(square), range0));
            let t = s.mul_add(difference, bins, s.splat(origin.fraction));
            let slope = s.splat(self.setup.ratio_slope[m]);
            let weight = self.weight(|| s.mul_add(offset, slope, s.splat(origin.ratio)));
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

    /// The point from which exact ranges of a vector are counted: the block's centre, or the vector's
    /// own middle where single precision would not carry so far.
    #[inline(always)]
    fn origin(&self, m: usize, vector: usize) -> Origin<S> {
        let (s, n, block) = (self.block.s, S::N, self.block);
        let (job, setup) = (block.job, self.setup);
        let pixel = s.splat(job.pixel_m as f32);
        // From the block's centre to the vector's middle: half pixels, and so exact.
        let middle = (vector * n) as f32 + 0.5 * (n - 1) as f32 - 0.5 * (block_width(n) - 1) as f32;
        if job.near_centre {
            return Origin {
                range_m: setup.range_m[m],
                along_m: setup.along_m[m],
                whole: setup.whole[m],
                fraction: setup.fraction[m],
                offset_m: s.mul(s.add(self.lanes, s.splat(middle)), pixel),
                ratio: setup.ratio[m],
            };
        }
        let ([x, y, z], unit) = (block.centre_m(), block.unit());
        let (along, pulse) = (f64::from(middle) * job.pixel_m, block.pulses.start + m);
        let (dx, dy, dz) = (
            x + along * unit[0] - job.antenna_m[0][pulse],
            y + along * unit[1] - job.antenna_m[1][pulse],
            z + along * unit[2] - job.antenna_m[2][pulse],
        );
        let range = (dx * dx + dy * dy + dz * dz).sqrt();
        let t = range * (1.0 / job.table.bin_m) - job.table.first_bin[pulse];
        let whole = t as i32;
        Origin {
            range_m: range as f32,
            along_m: (dx * unit[0] + dy * unit[1] + dz * unit[2]) as f32,
            whole,
            fraction: (t - f64::from(whole)) as f32,
            offset_m: s.mul(self.lanes, pixel),
            ratio: setup.ratio[m] + setup.ratio_slope[m] * along as f32,
        }
    }
}

/// A point near a vector, seen from an antenna, and the vector's pixels seen from it.
struct Origin<S: Lanes> {
    range_m: f32,
    along_m: f32,
    /// The range in bins: whole bins past the pulse's entry 0, and the rest.
    whole: i32,
    fraction: f32,
    /// Offsets of the pixels along the row, m.
    offset_m: S::V,
    /// Ratio of the cosines from boresight and vertical there.
    ratio: f32,
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
    for &m in paths.reference() {
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
