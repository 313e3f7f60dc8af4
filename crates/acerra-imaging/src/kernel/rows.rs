//! The direct kernel for images whose rows are straight lines of evenly spaced pixels.
//!
//! Work is cut into blocks of N groups of one or two vectors of N pixels of a row. For a pulse and a block the range to
//! the block's centre is taken in double precision; the range to the centre of each group follows
//! as R₀ + (R² − R₀²)/(R + R₀), whose correction is a few decimetres and so exact to nanometres in
//! single precision at any distance; within a group the range is a quadratic or cubic. Neighbouring
//! pixels see few range bins: a window of N table entries is loaded once and each lane picks its
//! entry inside registers. A pulse and block where the expansion or the window would not do goes
//! through exact ranges and gathers, and pixels next to an antenna through the plain sum.

use super::lanes::{Lanes, MAX_LANES, ROUNDING};
use crate::control::Control;
use crate::engine::tables::build::RangeTable;
use num_complex::{Complex32, Complex64};

/// Pulses handled together, so that their table entries stay in the first-level cache.
pub(crate) const CHUNK: usize = 8;
/// Pixels of a tile held in accumulators.
pub(super) const TILE: usize = 2048;

/// What every block of a job needs to know.
pub(crate) struct Job<'a> {
    /// Antenna positions, one array an axis, m.
    pub antenna_m: [&'a [f64]; 3],
    pub table: &'a RangeTable,
    /// Pulses summed.
    pub pulses: std::ops::Range<usize>,
    /// Whether single precision may carry ranges from a block's centre to its ends: small pixels.
    pub near_centre: bool,
    /// cos αδ in powers of δ².
    pub cosine: [f32; 4],
    /// sin(αδ)/δ in powers of δ².
    pub sine: [f32; 4],
    /// Distance of the lanes, m (never negative).
    pub pixel_m: f64,
    /// Largest range error that the expansion may make, bins.
    pub tolerance_bins: f64,
    /// Ranges below this are summed in double precision, m; zero where no spreading is folded in.
    pub reference_below_m: f64,
    pub reference: &'a dyn ReferenceContribution,
    pub control: Control<'a>,
}

/// The weighted contribution of a pulse at a point, in double precision.
pub(crate) trait ReferenceContribution: Sync {
    fn contribution(&self, pulse: usize, point_m: [f64; 3]) -> Complex64;
}

/// Some rows of an image: pixel (i, j) stands at `origin_m + i·u_m + j·v_m`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Band {
    pub origin_m: [f64; 3],
    pub u_m: [f64; 3],
    pub v_m: [f64; 3],
    pub columns: usize,
    pub rows: usize,
}

/// How many vectors went which way.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Tally {
    pub window: u64,
    pub gather: u64,
    pub reference: u64,
}

impl Tally {
    pub fn add(&mut self, other: Self) {
        self.window += other.window;
        self.gather += other.gather;
        self.reference += other.reference;
    }
}

/// Vectors in a group: two share the setup where vectors are short.
pub(super) const fn vectors_a_group(lanes: usize) -> usize {
    if lanes <= 8 { 2 } else { 1 }
}

/// Pixels of a block for vectors of `lanes`.
pub(crate) const fn block_width(lanes: usize) -> usize {
    lanes * lanes * vectors_a_group(lanes)
}

/// Rows that a tile holds at most for vectors of `lanes`.
pub(crate) const fn tile_rows(lanes: usize) -> usize {
    TILE / block_width(lanes)
}

/// Parameters of the pulses of a chunk for one block.
struct Setup {
    /// Of each pulse that goes by windows, [`ROWS`] rows of N, one lane a group: range at its middle
    /// in bins past `whole`, the first, second and third power's coefficients a pixel, and for either
    /// vector the whole bins from `whole` to its window and the bits of the integer at which that
    /// window starts in the chunk's table.
    windowed: [f32; CHUNK * ROWS * MAX_LANES],
    range_m: [f32; CHUNK],
    along_m: [f32; CHUNK],
    fraction: [f32; CHUNK],
    whole: [i32; CHUNK],
}

/// Rows of parameters a pulse.
const ROWS: usize = 8;

/// Images a band into `out` `[rows, columns]`; the caller keeps `rows` within [`tile_rows`].
///
/// `DEGREE` is that of the table, `TERMS` counts the cosine's coefficients (the sine has one less), `CUBIC` adds the third
/// order of the range within a vector.
#[inline(always)]
pub(crate) fn band<S: Lanes, const DEGREE: usize, const TERMS: usize, const CUBIC: bool>(
    s: S,
    job: &Job,
    band: &Band,
    out: &mut [Complex32],
) -> Tally {
    assert!(band.rows <= tile_rows(S::N) && out.len() == band.rows * band.columns);
    assert!(job.table.spec.degree == DEGREE);
    let width = block_width(S::N);
    let mut real = [0f32; TILE];
    let mut imag = [0f32; TILE];
    let mut setup = Setup {
        windowed: [0.0; CHUNK * ROWS * MAX_LANES],
        range_m: [0.0; CHUNK],
        along_m: [0.0; CHUNK],
        fraction: [0.0; CHUNK],
        whole: [0; CHUNK],
    };
    let mut tally = Tally::default();
    let unscale = (1.0 / job.table.scale) as f32;
    let mut column = 0;
    while column < band.columns && !job.control.is_cancelled() {
        let kept = (band.columns - column).min(width);
        let groups = kept.div_ceil(S::N * vectors_a_group(S::N));
        real.fill(0.0);
        imag.fill(0.0);
        // Gathers touch a cache line a lane: fewer pulses keep theirs in the first level.
        let chunk = if job.table.spec.interleaved { 2 } else { CHUNK };
        let mut first = job.pulses.start;
        while first < job.pulses.end {
            let count = (job.pulses.end - first).min(chunk);
            for row in 0..band.rows {
                let at = row * width;
                block::<S, DEGREE, TERMS, CUBIC>(
                    s,
                    job,
                    band,
                    (column, row, groups),
                    first..first + count,
                    &mut setup,
                    &mut real[at..at + width],
                    &mut imag[at..at + width],
                    &mut tally,
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

#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn block<S: Lanes, const DEGREE: usize, const TERMS: usize, const CUBIC: bool>(
    s: S,
    job: &Job,
    band: &Band,
    (column, row, groups): (usize, usize, usize),
    pulses: std::ops::Range<usize>,
    setup: &mut Setup,
    real: &mut [f32],
    imag: &mut [f32],
    tally: &mut Tally,
) {
    let n = S::N;
    let table = job.table;
    let count = pulses.len();
    let chunk_table =
        &table.coefficients[pulses.start * table.pulse_stride()..][..count * table.pulse_stride()];
    let (mut exact, mut plain) = ([0u8; CHUNK], [0u8; CHUNK]);
    let (mut fasts, mut exacts, mut plains) = (0, 0, 0);

    // Double precision: range and along-row offset at the block's centre.
    let centre = column as f64 + 0.5 * (block_width(n) - 1) as f64;
    let at =
        |axis: usize| band.origin_m[axis] + centre * band.u_m[axis] + row as f64 * band.v_m[axis];
    let (x, y, z) = (at(0), at(1), at(2));
    let inverse_bin = 1.0 / table.spec.bin_m;
    let unit = band.u_m.map(|u| u / job.pixel_m);
    {
        let px = &job.antenna_m[0][pulses.clone()];
        let py = &job.antenna_m[1][pulses.clone()];
        let pz = &job.antenna_m[2][pulses.clone()];
        let start = &table.first_bin[pulses.clone()];
        for m in 0..count {
            let (dx, dy, dz) = (x - px[m], y - py[m], z - pz[m]);
            let range = (dx * dx + dy * dy + dz * dz).sqrt();
            let along = dx * unit[0] + dy * unit[1] + dz * unit[2];
            let t = range * inverse_bin - start[m] as f64;
            #[allow(clippy::manual_clamp)] // `clamp` would keep NaN
            // SAFETY: the bounds keep it within an i32, and replace NaN.
            let whole = unsafe { t.max(-1e9).min(1e9).to_int_unchecked::<i32>() };
            setup.range_m[m] = range as f32;
            setup.along_m[m] = along as f32;
            setup.whole[m] = whole;
            setup.fraction[m] = (t - f64::from(whole)) as f32;
        }
    }

    // Single precision: one lane a group of the block.
    let pair = vectors_a_group(n);
    let pixel = job.pixel_m as f32;
    let bins = inverse_bin as f32;
    // Pixels from the middle of a group to its end, of a vector to its end, and between the two.
    let half = 0.5 * (pair * n - 1) as f32;
    let half_vector = 0.5 * (n - 1) as f32;
    let shift = 0.5 * ((pair - 1) * n) as f32;
    let mut offsets = [0f32; MAX_LANES];
    for (k, o) in offsets.iter_mut().enumerate() {
        let k = k.min(groups - 1) as f32;
        *o = (k - 0.5 * (n - 1) as f32) * (pair * n) as f32 * pixel;
    }
    let (per_pixel, per_pixel2, per_pixel3) = (
        s.splat(pixel * bins),
        s.splat(0.5 * pixel * pixel * bins),
        s.splat(-0.5 * pixel * pixel * pixel * bins),
    );
    let tolerance = s.splat(job.tolerance_bins as f32);
    let near = s.splat(job.reference_below_m as f32 + (half + 1.0) * pixel);
    let last_window = s.splat(table.stride as f32 - 2.0 - n as f32);
    let widest = s.splat((n - 1) as f32 - 0.05);
    let (one, zero, tiny) = (s.splat(1.0), s.splat(0.0), s.splat(1e-30));
    let rounding = s.splat(ROUNDING);
    // SAFETY: `offsets` has MAX_LANES ≥ N numbers.
    let along_block = unsafe { s.load(offsets.as_ptr()) };
    let half_block = 0.5 * block_width(n) as f32 * pixel;
    for m in 0..count {
        if table.spec.interleaved && setup.range_m[m] - half_block > job.reference_below_m as f32 {
            exact[exacts] = m as u8;
            exacts += 1;
            continue;
        }
        let range0 = s.splat(setup.range_m[m]);
        let along0 = s.splat(setup.along_m[m]);
        let along = s.add(along0, along_block);
        let square_difference = s.mul(along_block, s.add(along, along0));
        let square = s.max(s.mul_add(range0, range0, square_difference), tiny);
        let range = s.sqrt(square);
        let sum = s.add(range, range0);
        let reciprocal = s.div(one, s.mul(sum, range));
        let inverse_range = s.mul(reciprocal, sum);
        let difference = s.mul(s.mul(square_difference, reciprocal), range);
        let sine = s.mul(along, inverse_range);
        let curvature = s.mul(s.neg_mul_add(sine, sine, one), inverse_range);
        let t = s.mul_add(difference, s.splat(bins), s.splat(setup.fraction[m]));
        let first = s.mul(sine, per_pixel);
        let second = s.mul(curvature, per_pixel2);
        let third = s.mul(s.mul(s.mul(sine, curvature), inverse_range), per_pixel3);
        let (first, left_out) = if CUBIC {
            // The fourth derivative is at most 12 (1 − sin²)/R³.
            let fourth = s.mul(s.mul(second, inverse_range), inverse_range);
            let left_out = s.mul(fourth, s.splat(pixel * pixel * half.powi(4)));
            (first, left_out)
        } else {
            // The line nearest to x³ over |x| ≤ h is 3h²x/5; at most 2h³/5 is left.
            let left_out = s.mul(s.abs(third), s.splat(0.4 * half.powi(3)));
            (
                s.mul_add(third, s.splat(0.6 * half * half), first),
                left_out,
            )
        };
        // The range is convex: over a vector it stays above its tangent at the vector's middle.
        let mut steepest = s.mul_add(second, s.splat(2.0 * shift), s.abs(first));
        if CUBIC {
            steepest = s.mul_add(s.abs(third), s.splat(3.0 * half * half), steepest);
        }
        let reach = s.mul(steepest, s.splat(half_vector));
        let (span, [window, window2]) = place_windows(s, [t, first, second], reach);
        let whole = s.splat(setup.whole[m] as f32);
        let least = s.sub(whole, s.max(s.sub(zero, window), s.sub(zero, window2)));
        let most = s.add(whole, s.max(window, window2));
        let fits = !table.spec.interleaved
            && s.all_le(span, widest)
            && s.all_le(left_out, tolerance)
            && s.all_le(near, range)
            && s.all_le(zero, least)
            && s.all_le(most, last_window);
        if fits {
            let rows = &mut setup.windowed[fasts * ROWS * n..][..ROWS * n];
            let start = (m * table.pulse_stride()) as i32 + setup.whole[m];
            // SAFETY: `rows` holds ROWS rows of N numbers.
            unsafe {
                let at = rows.as_mut_ptr();
                s.store(at, t);
                s.store(at.add(n), first);
                s.store(at.add(2 * n), second);
                if CUBIC {
                    s.store(at.add(3 * n), third);
                }
                s.store(at.add(4 * n), window);
                s.store_rounded(at.add(5 * n).cast(), s.add(window, rounding), start);
                if pair > 1 {
                    s.store(at.add(6 * n), window2);
                    s.store_rounded(at.add(7 * n).cast(), s.add(window2, rounding), start);
                }
            }
            fasts += 1;
        } else if s.all_le(near, range) {
            exact[exacts] = m as u8;
            exacts += 1;
        } else {
            plain[plains] = m as u8;
            plains += 1;
        }
    }

    let mut lane = [0f32; MAX_LANES];
    for (l, v) in lane.iter_mut().enumerate() {
        *v = l as f32 - half_vector;
    }
    // SAFETY: `lane` has MAX_LANES ≥ N numbers.
    let lanes = unsafe { s.load(lane.as_ptr()) };
    let kernel = Kernel::<S, DEGREE, TERMS> {
        s,
        rounding,
        cosine: job.cosine.map(|c| s.splat(c)),
        sine: job.sine.map(|c| s.splat(c)),
        stride: table.stride,
        interleaved: table.spec.interleaved,
    };
    let lanes_of = [s.sub(lanes, s.splat(shift)), s.add(lanes, s.splat(shift))];
    for k in 0..groups {
        let mut sums = [[zero; 2]; 2];
        // SAFETY: the first `fasts` parameter sets were written above, k < N; the windows were
        // checked to lie within their pulse's rows.
        unsafe {
            let mut at = setup.windowed.as_ptr().add(k);
            let end = at.add(fasts * ROWS * n);
            while at < end {
                let term = |row: usize| s.splat(*at.add(row * n));
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
                    let window = chunk_table.as_ptr().offset(start as isize);
                    kernel.windowed(window, t, &mut sums[side]);
                }
                at = at.add(ROWS * n);
            }
        }
        for (side, sum) in sums.iter_mut().enumerate().take(pair) {
            let vector = pair * k + side;
            // From the block's centre to the vector's middle: half pixels, and so exact.
            let middle = (vector * n) as f32 + half_vector - 0.5 * (block_width(n) - 1) as f32;
            for &m in &exact[..exacts] {
                let m = m as usize;
                let pulse = pulses.start + m;
                let (range0, along0, whole, fraction, offset) = if job.near_centre {
                    (
                        setup.range_m[m],
                        setup.along_m[m],
                        setup.whole[m],
                        setup.fraction[m],
                        s.mul(s.add(lanes, s.splat(middle)), s.splat(pixel)),
                    )
                } else {
                    // From the vector's own centre, so that what single precision holds stays small.
                    let along = f64::from(middle) * job.pixel_m;
                    let (dx, dy, dz) = (
                        x + along * unit[0] - job.antenna_m[0][pulse],
                        y + along * unit[1] - job.antenna_m[1][pulse],
                        z + along * unit[2] - job.antenna_m[2][pulse],
                    );
                    let range0 = (dx * dx + dy * dy + dz * dz).sqrt();
                    let t0 = range0 * inverse_bin - table.first_bin[pulse] as f64;
                    let whole = t0 as i32;
                    (
                        range0 as f32,
                        (dx * unit[0] + dy * unit[1] + dz * unit[2]) as f32,
                        whole,
                        (t0 - f64::from(whole)) as f32,
                        s.mul(lanes, s.splat(pixel)),
                    )
                };
                let (along0, range0) = (s.splat(along0), s.splat(range0));
                let square_difference = s.mul(offset, s.add(s.add(along0, offset), along0));
                let square = s.max(s.mul_add(range0, range0, square_difference), tiny);
                let difference = s.div(square_difference, s.add(s.sqrt(square), range0));
                let t = s.mul_add(difference, s.splat(bins), s.splat(fraction));
                // SAFETY: the rounded index, taken from the start of the pulse's row, is clamped
                // into the row.
                unsafe {
                    let row = chunk_table.as_ptr().add(m * table.pulse_stride());
                    let lowest = s.splat(-(whole as f32));
                    let highest = s.splat((table.stride as i32 - 1 - whole) as f32);
                    kernel.gathered(row, whole, t, (lowest, highest), sum);
                }
            }
            // SAFETY: `vector` < pair·N, and `real`, `imag` hold pair·N·N numbers.
            unsafe {
                let at = vector * n;
                let (re, im) = (real.as_mut_ptr().add(at), imag.as_mut_ptr().add(at));
                s.store(re, s.add(s.load(re), sum[0]));
                s.store(im, s.add(s.load(im), sum[1]));
            }
        }
        tally.window += (pair * fasts) as u64;
        tally.gather += (pair * exacts) as u64;
        tally.reference += (pair * plains) as u64;
    }
    for &m in &plain[..plains] {
        for i in 0..(groups * pair * n).min(band.columns - column) {
            let along = (column + i) as f64;
            let point: [f64; 3] = std::array::from_fn(|axis| {
                band.origin_m[axis] + along * band.u_m[axis] + row as f64 * band.v_m[axis]
            });
            let value = job.reference.contribution(pulses.start + m as usize, point) * table.scale;
            real[i] += value.re as f32;
            imag[i] += value.im as f32;
        }
    }
}

/// Bins that either vector of a group spans, and the whole bins from which its window must reach, for
/// ranges `[t, first, second]` (bins at the group's middle and the powers' coefficients a pixel) that
/// depart by at most `reach` from a vector's middle beside the second power.
#[inline(always)]
pub(super) fn place_windows<S: Lanes>(
    s: S,
    [t, first, second]: [S::V; 3],
    reach: S::V,
) -> (S::V, [S::V; 2]) {
    let pair = vectors_a_group(S::N);
    let half_vector = 0.5 * (S::N - 1) as f32;
    let shift = 0.5 * ((pair - 1) * S::N) as f32;
    let span = s.mul_add(
        second,
        s.splat(half_vector * half_vector),
        s.add(reach, reach),
    );
    // Half a bin up for rounding, a little down for safety.
    let lowest = s.mul_add(
        second,
        s.splat(shift * shift),
        s.sub(t, s.sub(reach, s.splat(0.499))),
    );
    let windows = if pair > 1 {
        [
            s.floor(s.neg_mul_add(first, s.splat(shift), lowest)),
            s.floor(s.mul_add(first, s.splat(shift), lowest)),
        ]
    } else {
        [s.floor(lowest), s.floor(lowest)]
    };
    (span, windows)
}

/// The part of a contribution after its range is known.
pub(crate) struct Kernel<S: Lanes, const DEGREE: usize, const TERMS: usize> {
    pub s: S,
    pub rounding: S::V,
    pub cosine: [S::V; 4],
    pub sine: [S::V; 4],
    pub stride: usize,
    pub interleaved: bool,
}

impl<S: Lanes, const DEGREE: usize, const TERMS: usize> Kernel<S, DEGREE, TERMS> {
    /// Adds the contribution at `t` bins past the window.
    ///
    /// # Safety
    /// N entries must be readable at `window` and at every coefficient row after it.
    #[inline(always)]
    pub(super) unsafe fn windowed(&self, window: *const f32, t: S::V, sum: &mut [S::V; 2]) {
        let s = self.s;
        let i = s.add(t, self.rounding);
        let delta = s.sub(t, s.sub(i, self.rounding));
        // SAFETY: the caller vouches for the rows.
        let entry = |row: usize| unsafe { s.pick(s.load(window.add(row * self.stride)), i) };
        self.add(delta, entry, sum);
    }

    /// Adds the contribution at `whole` + `t` bins past the start of a pulse's `row`, the index past
    /// `whole` kept within the limits.
    ///
    /// # Safety
    /// Entries `whole` + the limits must be readable in every coefficient row of `row`.
    #[inline(always)]
    pub(super) unsafe fn gathered(
        &self,
        row: *const f32,
        whole: i32,
        t: S::V,
        (lowest, highest): (S::V, S::V),
        sum: &mut [S::V; 2],
    ) {
        let s = self.s;
        let i = s.sub(s.add(t, self.rounding), self.rounding);
        let delta = s.sub(t, i);
        // max(lowest, ·) and −max(−highest, −·) also turn NaN into a number within the limits.
        let zero = s.splat(0.0);
        let i = s.max(i, lowest);
        let i = s.sub(zero, s.max(s.sub(zero, i), s.sub(zero, highest)));
        let i = s.add(i, self.rounding);
        if self.interleaved {
            let step = 2 * (DEGREE + 1);
            // SAFETY: the caller vouches for the entries; those of even degree, of which the last
            // half of the second four is none, are read singly.
            unsafe {
                let row = row.offset(whole as isize * step as isize);
                let first = s.gather4(row, i, step);
                let last = match DEGREE {
                    1 => first,
                    3 => s.gather4(row.add(4), i, step),
                    _ => {
                        let i = s.mul(s.sub(i, self.rounding), s.splat(step as f32));
                        let i = s.add(i, self.rounding);
                        let (re, im) = (s.gather(row.add(4), i), s.gather(row.add(5), i));
                        [re, im, re, im]
                    }
                };
                let entry = |k: usize| if k < 4 { first[k] } else { last[k - 4] };
                self.add(delta, entry, sum);
            }
        } else {
            // SAFETY: the caller vouches for the entries within the limits.
            let entry =
                |k: usize| unsafe { s.gather(row.offset(whole as isize).add(k * self.stride), i) };
            self.add(delta, entry, sum);
        }
    }

    #[inline(always)]
    fn add(&self, delta: S::V, entry: impl Fn(usize) -> S::V, sum: &mut [S::V; 2]) {
        let s = self.s;
        let (mut re, mut im) = (entry(2 * DEGREE), entry(2 * DEGREE + 1));
        for p in (0..DEGREE).rev() {
            re = s.mul_add(re, delta, entry(2 * p));
            im = s.mul_add(im, delta, entry(2 * p + 1));
        }
        let square = s.mul(delta, delta);
        // One term less than the cosine's: its error is smaller by itself.
        let (mut cosine, mut sine) = (self.cosine[TERMS - 1], self.sine[TERMS - 2]);
        for k in (0..TERMS - 1).rev() {
            cosine = s.mul_add(cosine, square, self.cosine[k]);
        }
        for k in (0..TERMS - 2).rev() {
            sine = s.mul_add(sine, square, self.sine[k]);
        }
        sine = s.mul(sine, delta);
        sum[0] = s.neg_mul_add(im, sine, s.mul_add(re, cosine, sum[0]));
        sum[1] = s.mul_add(im, cosine, s.mul_add(re, sine, sum[1]));
    }
}
