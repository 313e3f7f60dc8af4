//! Tiles whose groups are squares of 4 × 4 pixels instead of pieces of a row.
//!
//! Sixteen pixels in a row of 4 cm extend over 60 cm of range, a square of four by four over a third of 60
//! cm: where pixels are coarse, squares still find their range bins in a window of registers. The range over
//! a square is a polynomial in both directions about its middle.

use super::evaluator::Evaluator;
use super::job::{Band, CHUNK, GROUP, Job, PixelWeight, SIDE, TILE, Tally, square_rows};
use super::rays::Rays;
use super::square_ground::SquareGround;
use super::square_paths::{SquarePaths, expand};
use super::square_setup::{
    CUBE_ROW, FLAT_ROW, Frame, Origin, Seen, SquareBlock, SquareSetup, WEIGHT_ROW,
};
use super::tile_corners::TileCorners;
use super::unwindowed::whole_and_rest;
use crate::grid::relief::Relief;
use crate::kernel::aligned::Aligned;
use crate::kernel::lanes::{Lanes, MAX_LANES};
use crate::kernel::profile::DELAYS;
use crate::kernel::two_ways::{mean, spreading};
use num_complex::Complex32;
use std::ops::Range;

/// Most strips of a tile: those of the shortest vectors.
const MOST_STRIPS: usize = square_rows(8) / SIDE;

/// Images a band into `out` `[rows, columns]`; the caller keeps `rows` within [`square_rows`].
///
/// `DEGREE` is the degree of the table, `TERMS` the number of the cosine's coefficients (the sine has one
/// fewer); `CUBIC` adds the third order of the range within a square, `WIDE` permits windows of two
/// registers, `RELIEF` reads the heights of the pixels in `relief`, and `RAYS` follows the rays of `job.rays` or those below
/// `job.ground`.
#[inline(always)]
pub(crate) fn square_band<
    S: Lanes,
    const DEGREE: usize,
    const TERMS: usize,
    const CUBIC: bool,
    const WIDE: bool,
    const RELIEF: bool,
    const RAYS: bool,
>(
    s: S,
    job: &Job,
    band: &Band,
    relief: Option<Relief>,
    out: &mut [Complex32],
) -> Tally {
    assert!(band.rows <= square_rows(S::N) && out.len() == band.rows * band.columns);
    assert!(job.table.degree == DEGREE && relief.is_some() == RELIEF);
    assert!((job.rays.is_some() || job.ground.is_some()) == RAYS && !(RAYS && RELIEF));
    assert!(!matches!(job.weight, Some(PixelWeight::Tilt(_))));
    // Windows hold bins side by side.
    assert!(!(job.windows && job.table.interleaved));
    let width = SIDE * S::N;
    let strip = width * SIDE;
    let strips = band.rows.div_ceil(SIDE);
    let mut ground = [SquareGround::LEVEL; MOST_STRIPS];
    assert!(strips <= MOST_STRIPS);
    let (mut real, mut imag) = (Aligned([0f32; TILE]), Aligned([0f32; TILE]));
    let (real, imag) = (&mut real.0, &mut imag.0);
    let mut setup = SquareSetup::new(band);
    let lanes = Offsets::of(s);
    let mut tally = Tally::default();
    let mut corners = (job.ground)
        .filter(|_| RAYS)
        .map(|ground| TileCorners::new(ground, S::N));
    let mut column = 0;
    while column < band.columns && !job.control.is_cancelled() {
        let kept = (band.columns - column).min(width);
        real.fill(0.0);
        imag.fill(0.0);
        if RELIEF && let Some(relief) = relief {
            for (k, ground) in ground.iter_mut().enumerate().take(strips) {
                let rows = SIDE.min(band.rows - SIDE * k);
                let from = relief.seen_from(column, SIDE * k);
                let groups = kept.div_ceil(SIDE);
                ground.fit(&from, setup.frame.pixel_m, [kept, rows], groups);
            }
        }
        if let Some(corners) = &mut corners {
            let first_m =
                std::array::from_fn(|axis| band.origin_m[axis] + column as f64 * band.u_m[axis]);
            let squares = [kept.div_ceil(SIDE), strips];
            corners.turn_to(first_m, [band.u_m, band.v_m], squares);
        }
        let mut first = job.pulses.start;
        while first < job.pulses.end {
            let mut count = (job.pulses.end - first).min(CHUNK);
            if let Some(corners) = &mut corners {
                if job.control.is_cancelled() {
                    break;
                }
                let begins;
                (count, begins) = corners.advance(s, job, first);
                if begins {
                    let squares = corners.squares(false);
                    let evaluator = Evaluator::<S, DEGREE, TERMS>::of(s, job);
                    let sums = (&mut real[..], &mut imag[..]);
                    let pulses = corners.segment();
                    let of = (&*corners, squares.as_slice(), pulses);
                    tally.gather += sum_pixels(
                        s,
                        (job, &evaluator),
                        of,
                        |[i, j]| j * strip + i * GROUP,
                        sums,
                    );
                }
            }
            for (k, ground) in ground.iter().enumerate().take(strips) {
                let block = SquareBlock {
                    s,
                    job,
                    band,
                    column,
                    row: SIDE * k,
                    groups: kept.div_ceil(SIDE),
                    pulses: first..first + count,
                    ground,
                    corners: corners.as_ref(),
                };
                let at = k * strip..(k + 1) * strip;
                let sums = (&mut real[at.clone()], &mut imag[at]);
                sum_block::<S, DEGREE, TERMS, CUBIC, WIDE, RELIEF, RAYS>(
                    &block, &lanes, &mut setup, sums, &mut tally,
                );
            }
            first += count;
        }
        let unscale = (1.0 / job.table.scale) as f32;
        for (j, row) in out.chunks_exact_mut(band.columns).enumerate() {
            let from = j / SIDE * strip + j % SIDE * SIDE;
            for (i, o) in row[column..][..kept].iter_mut().enumerate() {
                let at = from + i / SIDE * GROUP + i % SIDE;
                *o = Complex32::new(real[at] * unscale, imag[at] * unscale);
            }
        }
        column += width;
    }
    tally
}

/// Adds the contributions of a chunk of pulses to a block; sums are stored group by group.
#[inline(always)]
fn sum_block<
    S: Lanes,
    const DEGREE: usize,
    const TERMS: usize,
    const CUBIC: bool,
    const WIDE: bool,
    const RELIEF: bool,
    const RAYS: bool,
>(
    block: &SquareBlock<S>,
    lanes: &Offsets<S>,
    setup: &mut SquareSetup,
    (real, imag): (&mut [f32], &mut [f32]),
    tally: &mut Tally,
) {
    let (s, n, job) = (block.s, S::N, block.job);
    let vectors = GROUP / n;
    assert!(real.len() >= GROUP * n && imag.len() >= GROUP * n && block.groups <= n);
    setup.measure::<S, RAYS>(block);
    let paths = expand::<S, CUBIC, WIDE, RELIEF, RAYS>(block, setup);
    let sum = BlockSum::<S, DEGREE, TERMS, CUBIC, WIDE, RELIEF, RAYS> {
        block,
        setup,
        paths: &paths,
        lanes,
        chunk_table: &job.table.coefficients[block.pulses.start * job.table.pulse_stride..]
            [..block.pulses.len() * job.table.pulse_stride],
        evaluator: Evaluator::of(s, job),
    };
    for k in 0..block.groups {
        let mut sums = sum.windows(k);
        sum.gathers(k, &mut sums);
        for (side, sums) in sums.iter().enumerate().take(vectors) {
            // SAFETY: k < N, and `real`, `imag` hold N groups of 16 numbers.
            unsafe {
                let at = k * GROUP + side * n;
                let (re, im) = (real.as_mut_ptr().add(at), imag.as_mut_ptr().add(at));
                s.store(re, s.add(s.load(re), sums[0]));
                s.store(im, s.add(s.load(im), sums[1]));
            }
        }
    }
    let groups = match block.corners {
        Some(corners) => corners.polynomials(block.row / SIDE),
        None => block.groups,
    };
    let count = |pulses: usize| (pulses * vectors * groups) as u64;
    tally.window += count(paths.narrow + paths.wide);
    tally.gather += count(paths.others.gathered().len());
    tally.reference += count(paths.others.reference().len());
    if let Some(corners) = block.corners {
        let mut squares = corners.squares(true);
        squares.retain(|[_, j]| *j == block.row / SIDE);
        for &m in paths.others.reference() {
            let pulse = block.pulses.start + usize::from(m);
            let of = (corners, squares.as_slice(), pulse..pulse + 1);
            let sums = (&mut *real, &mut *imag);
            sum_pixels(s, (job, &sum.evaluator), of, |[i, _]| i * GROUP, sums);
        }
        return;
    }
    if !paths.others.reference().is_empty() {
        sum_reference::<S, RELIEF>(block, &setup.frame, &paths, real, imag);
    }
}

/// Offsets of a group's pixels from the group's middle along the row and across, and products of these
/// offsets, for both vectors of the group.
struct Offsets<S: Lanes> {
    along: [S::V; 2],
    across: [S::V; 2],
    along_square: [S::V; 2],
    product: [S::V; 2],
    across_square: [S::V; 2],
}

impl<S: Lanes> Offsets<S> {
    #[inline(always)]
    fn of(s: S) -> Self {
        let mut lanes = [[[0f32; MAX_LANES]; 2]; 5];
        for p in 0..GROUP {
            let middle = 0.5 * (SIDE - 1) as f32;
            let (i, j) = ((p % SIDE) as f32 - middle, (p / SIDE) as f32 - middle);
            for (lanes, value) in lanes.iter_mut().zip([i, j, i * i, i * j, j * j]) {
                lanes[p / S::N][p % S::N] = value;
            }
        }
        // SAFETY: every array has MAX_LANES ≥ N numbers.
        let [along, across, along_square, product, across_square] =
            lanes.map(|sides| unsafe { [s.load(sides[0].as_ptr()), s.load(sides[1].as_ptr())] });
        Self {
            along,
            across,
            along_square,
            product,
            across_square,
        }
    }
}

/// Sums over the pulses of a chunk, group by group.
struct BlockSum<
    'a,
    S: Lanes,
    const DEGREE: usize,
    const TERMS: usize,
    const CUBIC: bool,
    const WIDE: bool,
    const RELIEF: bool,
    const RAYS: bool,
> {
    block: &'a SquareBlock<'a, S>,
    setup: &'a SquareSetup,
    paths: &'a SquarePaths,
    lanes: &'a Offsets<S>,
    /// Coefficients of the chunk's pulses.
    chunk_table: &'a [f32],
    evaluator: Evaluator<S, DEGREE, TERMS>,
}

impl<
    S: Lanes,
    const DEGREE: usize,
    const TERMS: usize,
    const CUBIC: bool,
    const WIDE: bool,
    const RELIEF: bool,
    const RAYS: bool,
> BlockSum<'_, S, DEGREE, TERMS, CUBIC, WIDE, RELIEF, RAYS>
{
    /// Sums of group `k` over the pulses read from windows: real and imaginary part of each vector.
    #[inline(always)]
    fn windows(&self, k: usize) -> [[S::V; 2]; 2] {
        let s = self.block.s;
        let mut sums = [[s.splat(0.0); 2]; 2];
        let (narrow, wide) = (self.paths.narrow, self.paths.wide);
        // SAFETY: parameter sets of the first `narrow` slots and the last `wide` ones were written.
        unsafe {
            if RAYS && !self.paths.is_bent {
                self.windows_of::<false, false>(k, 0..narrow, &mut sums);
                self.windows_of::<true, false>(k, CHUNK - wide..CHUNK, &mut sums);
                return sums;
            }
            self.windows_of::<false, true>(k, 0..narrow, &mut sums);
            if WIDE {
                self.windows_of::<true, true>(k, CHUNK - wide..CHUNK, &mut sums);
            }
        }
        sums
    }

    /// Adds the pulses whose parameters are in `slots` to the sums of group `k`; windows are of two
    /// registers where `TWO`, and rays have their last order where `BENT`.
    ///
    /// # Safety
    /// `k` < N, and the slots were written by [`expand`], for windows of no more registers.
    #[inline(always)]
    unsafe fn windows_of<const TWO: bool, const BENT: bool>(
        &self,
        k: usize,
        slots: Range<usize>,
        sums: &mut [[S::V; 2]; 2],
    ) {
        let (s, n, lanes) = (self.block.s, S::N, self.lanes);
        let row_length = SquareSetup::rows(RELIEF, RAYS) * n;
        let residual = self.block.ground.residual_m[k].as_ptr();
        let rows = self.setup.windowed.0.as_ptr();
        let is_weighted = self.block.job.weight.is_some();
        // SAFETY: the caller vouches for the slots; windows were checked to lie within their pulse's rows.
        unsafe {
            let mut at = rows.add(slots.start * row_length + k);
            for _ in slots {
                let term = |row: usize| s.splat(*at.add(row * n));
                for (side, sums) in sums.iter_mut().enumerate().take(GROUP / n) {
                    let (i, j) = (lanes.along[side], lanes.across[side]);
                    let slope = if RAYS && !BENT { FLAT_ROW } else { 0 };
                    let mut linear = s.mul_add(i, term(slope), s.mul(j, term(slope + 1)));
                    let mut square = s.mul_add(
                        lanes.along_square[side],
                        term(2),
                        s.mul_add(
                            lanes.product[side],
                            term(3),
                            s.mul(lanes.across_square[side], term(4)),
                        ),
                    );
                    if RELIEF {
                        let b = s.load(residual.add(side * n));
                        linear = s.mul_add(b, term(10), linear);
                        let change =
                            s.mul_add(i, term(11), s.mul_add(j, term(12), s.mul(b, term(13))));
                        square = s.mul_add(b, change, square);
                    }
                    let mut t = s.add(term(6 + 2 * side), linear);
                    if RAYS {
                        t = s.add(t, square);
                        if BENT {
                            let [ii, ij, jj] = [
                                lanes.along_square[side],
                                lanes.product[side],
                                lanes.across_square[side],
                            ];
                            let along =
                                s.mul_add(ii, term(CUBE_ROW), s.mul(ij, term(CUBE_ROW + 1)));
                            let along = s.mul_add(jj, term(CUBE_ROW + 2), along);
                            t = s.mul_add(i, along, t);
                            t = s.mul_add(j, s.mul(jj, term(CUBE_ROW + 3)), t);
                        }
                    } else if CUBIC {
                        // G + Q − GQ/R
                        let damped = s.neg_mul_add(linear, term(5), s.splat(1.0));
                        t = s.mul_add(square, damped, t);
                    } else {
                        t = s.add(t, square);
                    }
                    let start = (*at.add((7 + 2 * side) * n)).to_bits() as i32;
                    let window = self.chunk_table.as_ptr().offset(start as isize);
                    let weight = match is_weighted {
                        _ if RAYS => Some(self.ray_weight::<BENT>(side, term)),
                        true => Some(term(SquareSetup::weight_row(RELIEF))),
                        false => None,
                    };
                    self.evaluator.windowed::<TWO>(window, t, weight, sums);
                }
                at = at.wrapping_add(row_length);
            }
        }
    }

    /// The weight of the pixels of a vector from its expansion about the group's middle, or from that of its inverse.
    #[inline(always)]
    fn ray_weight<const BENT: bool>(&self, side: usize, term: impl Fn(usize) -> S::V) -> S::V {
        let (s, lanes) = (self.block.s, self.lanes);
        let (i, j) = (lanes.along[side], lanes.across[side]);
        let first = if BENT { WEIGHT_ROW } else { FLAT_ROW + 2 };
        let linear = s.mul_add(j, term(first + 2), term(first));
        let linear = s.mul_add(i, term(first + 1), linear);
        if !BENT {
            return linear;
        }
        let inverse = s.mul_add(lanes.along_square[side], term(WEIGHT_ROW + 3), linear);
        let inverse = s.mul_add(lanes.product[side], term(WEIGHT_ROW + 4), inverse);
        let inverse = s.mul_add(lanes.across_square[side], term(WEIGHT_ROW + 5), inverse);
        s.reciprocal(inverse)
    }

    /// Adds the pulses that gather to the sums of group `k`.
    #[inline(always)]
    fn gathers(&self, k: usize, sums: &mut [[S::V; 2]; 2]) {
        let (s, block, lanes) = (self.block.s, self.block, self.lanes);
        let table = &block.job.table;
        let bins = s.splat((1.0 / table.bin_m) as f32);
        let frame = &self.setup.frame;
        let pixel = frame.pixel_m.map(|p| s.splat(p as f32));
        let ground = block.ground;
        let [su, sv] = ground.slope.map(|slope| s.splat(slope[k]));
        let is_apart = block.job.antennas_m.len() > 1;
        let is_weighted = block.job.weight.is_some();
        for &m in self.paths.others.gathered() {
            let m = usize::from(m);
            // Ranges count from the middle of the group, computed in double precision: squares of coarse
            // pixels are large.
            let origin = Origin::of(block, frame, k, m);
            for (side, sums) in sums.iter_mut().enumerate().take(GROUP / S::N) {
                let (i, j) = (
                    s.mul(lanes.along[side], pixel[0]),
                    s.mul(lanes.across[side], pixel[1]),
                );
                let mut height = s.splat(0.0);
                if RELIEF {
                    // SAFETY: a group has as many numbers as its vectors together.
                    let residual =
                        unsafe { s.load(ground.residual_m[k].as_ptr().add(side * S::N)) };
                    height = s.mul_add(i, su, s.mul_add(j, sv, residual));
                }
                let offset = [i, j, height];
                let [sent, mut difference] = self.exact(&origin.from[0], offset);
                let mut weight = None;
                let mut excess = s.splat(0.0);
                if RAYS && let Some(view) = &block.job.rays {
                    let pulse = block.pulses.start + m;
                    let [_, of_received] = self.exact(&origin.from[1], offset);
                    let row = |k: usize| (&view.rows[k][pulse], origin.places[k]);
                    let sent = Rays::at(s, view, row(0), difference);
                    let received = Rays::at(s, view, row(1), of_received);
                    difference = mean(s, difference, of_received);
                    excess = mean(s, sent.excess(s), received.excess(s));
                    let inverse = s.mul(sent.inverse_weight(s), received.inverse_weight(s));
                    weight = Some(s.reciprocal(inverse));
                } else if is_apart {
                    let [received, of_received] = self.exact(&origin.from[1], offset);
                    difference = mean(s, difference, of_received);
                    if is_weighted {
                        weight = Some(spreading(s, sent, received));
                    }
                }
                let mut t = s.mul_add(difference, bins, s.splat(origin.fraction));
                if RAYS {
                    t = s.add(t, excess);
                }
                let lowest = s.splat(-(origin.whole as f32));
                let highest = s.splat((table.stride as i32 - 1 - origin.whole) as f32);
                // SAFETY: the rounded index, counted from the start of the pulse's row, is clamped
                // into the row.
                unsafe {
                    let row = self.chunk_table.as_ptr().add(m * table.pulse_stride);
                    self.evaluator
                        .gathered(row, origin.whole, t, (lowest, highest), weight, sums);
                }
            }
        }
    }

    /// Ranges of pixels from an antenna, and their excess over the range of the group's middle, m. The last
    /// argument is the offset of the pixels from the middle along the row, across, and in height.
    #[inline(always)]
    fn exact(&self, seen: &Seen, [i, j, height]: [S::V; 3]) -> [S::V; 2] {
        let s = self.block.s;
        let skew = s.splat(2.0 * self.setup.frame.skew as f32);
        let range0 = s.splat(seen.range_m);
        let along = s.add(i, s.splat(2.0 * seen.along_m));
        let across = s.mul_add(skew, i, s.add(j, s.splat(2.0 * seen.across_m)));
        let mut square_difference = s.mul_add(i, along, s.mul(j, across));
        if RELIEF {
            let up = s.add(height, s.splat(2.0 * seen.up_m));
            square_difference = s.mul_add(height, up, square_difference);
        }
        let square = s.max(s.mul_add(range0, range0, square_difference), s.splat(1e-30));
        let range = s.sqrt(square);
        [range, s.div(square_difference, s.add(range, range0))]
    }
}

/// Adds the contributions of pulses along rays to all pixels of squares below uneven ground to the sums of the squares,
/// which begin `at` some number, and counts the vectors.
fn sum_pixels<S: Lanes, const DEGREE: usize, const TERMS: usize>(
    s: S,
    (job, evaluator): (&Job, &Evaluator<S, DEGREE, TERMS>),
    (corners, squares, pulses): (&TileCorners, &[[usize; 2]], Range<usize>),
    at: impl Fn([usize; 2]) -> usize,
    (real, imag): (&mut [f32], &mut [f32]),
) -> u64 {
    let table = &job.table;
    let count = (pulses.len() * squares.len() * GROUP / S::N) as u64;
    let of = (squares, pulses);
    corners.sum_pixels(s, job, of, |square, pulse, half_m, weight| {
        let at = at(squares[square]);
        let sums = (&mut real[at..at + GROUP], &mut imag[at..at + GROUP]);
        let row = &table.coefficients[pulse * table.pulse_stride..][..table.pulse_stride];
        let bins = half_m.map(|half_m| half_m / table.bin_m - table.first_bin[pulse]);
        let (whole, _) = whole_and_rest(bins[0]);
        let whole = whole.clamp(0, table.stride as i32 - 1);
        let t = bins.map(|bins| (bins - f64::from(whole)) as f32);
        let limits = [-whole, table.stride as i32 - 1 - whole];
        s.vectorize(
            #[inline(always)]
            |s| add_group((s, evaluator), (row, whole, limits), (&t, weight), sums),
        );
    });
    count
}

/// Adds the contributions of a pulse at `t` bins beyond `whole` ones past the start of its row, kept within `limits` of
/// these, to the sums of a group.
#[inline(always)]
fn add_group<S: Lanes, const DEGREE: usize, const TERMS: usize>(
    (s, evaluator): (S, &Evaluator<S, DEGREE, TERMS>),
    (row, whole, limits): (&[f32], i32, [i32; 2]),
    (t, weight): (&[f32; GROUP], &[f32; GROUP]),
    (real, imag): (&mut [f32], &mut [f32]),
) {
    assert!(real.len() >= GROUP && imag.len() >= GROUP);
    let [lowest, highest] = limits.map(|x| s.splat(x as f32));
    for at in (0..GROUP).step_by(S::N) {
        // SAFETY: all arrays hold a group's numbers; the index counted from the start of the pulse's row is clamped into
        // the row.
        unsafe {
            let (t, weight) = (s.load(t[at..].as_ptr()), s.load(weight[at..].as_ptr()));
            let (re, im) = (real[at..].as_mut_ptr(), imag[at..].as_mut_ptr());
            let mut sums = [s.load(re), s.load(im)];
            let row = row.as_ptr();
            evaluator.gathered(row, whole, t, (lowest, highest), Some(weight), &mut sums);
            s.store(re, sums[0]);
            s.store(im, sums[1]);
        }
    }
}

/// Adds the pulses next to a block in double precision.
fn sum_reference<S: Lanes, const RELIEF: bool>(
    block: &SquareBlock<S>,
    frame: &Frame,
    paths: &SquarePaths,
    real: &mut [f32],
    imag: &mut [f32],
) {
    let (job, band) = (block.job, block.band);
    let columns = (SIDE * block.groups).min(band.columns - block.column);
    let rows = SIDE.min(band.rows - block.row);
    let point_m = |i: usize, j: usize| -> [f64; 3] {
        let (k, p) = (i / SIDE, j * SIDE + i % SIDE);
        let up_m = match RELIEF && k < block.groups {
            true => block.ground.height_m(frame.pixel_m, k, p),
            false => 0.0,
        };
        block.point_m(i as f64, j as f64, up_m)
    };
    for &m in paths.others.reference() {
        let pulse = block.pulses.start + usize::from(m);
        for (j, first) in (0..rows).flat_map(|j| (0..columns).step_by(DELAYS).map(move |i| (j, i)))
        {
            let count = DELAYS.min(columns - first);
            let points_m: [[f64; 3]; DELAYS] = std::array::from_fn(|k| point_m(first + k, j));
            let values = job.reference.contributions(pulse, &points_m[..count]);
            for (i, value) in (first..).zip(&values[..count]) {
                let at = i / SIDE * GROUP + j * SIDE + i % SIDE;
                real[at] += (value.re * job.table.scale) as f32;
                imag[at] += (value.im * job.table.scale) as f32;
            }
        }
    }
}
