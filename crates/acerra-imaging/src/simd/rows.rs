//! The direct kernel for images whose rows are straight lines of evenly spaced pixels.
//!
//! Work is cut into blocks of N vectors of N pixels of a row. For a pulse and a block the range to
//! the block's centre is taken in double precision; the range to the centre of each vector follows
//! as R₀ + (R² − R₀²)/(R + R₀), whose correction is a few decimetres and so exact to nanometres in
//! single precision at any distance; within a vector the range is a quadratic or cubic. Neighbouring
//! pixels see few range bins: a window of N table entries is loaded once and each lane picks its
//! entry inside registers. A pulse and block where the expansion or the window would not do goes
//! through exact ranges and gathers, and pixels next to an antenna through the plain sum.

use super::{Lanes, MAX_LANES, ROUNDING};
use crate::table::RangeTable;
use num_complex::{Complex32, Complex64};

/// Pulses handled together, so that their table entries stay in the first-level cache.
pub(crate) const CHUNK: usize = 32;
/// Pixels of a tile held in accumulators.
const TILE: usize = 2048;

/// What every block of a job needs to know.
pub(crate) struct Job<'a> {
    /// Antenna positions, one array an axis, m.
    pub antenna_m: [&'a [f64]; 3],
    pub table: &'a RangeTable,
    /// cos αδ in powers of δ².
    pub cosine: [f32; 4],
    /// sin(αδ)/δ in powers of δ².
    pub sine: [f32; 4],
    /// Distance of the lanes, m (never negative).
    pub pixel_m: f64,
    /// Largest range error that the expansion may make, bins.
    pub tolerance_bins: f64,
    /// Ranges below this go through `plain`, m; zero where no spreading is folded in.
    pub plain_below_m: f64,
    /// Weighted contribution of a pulse at a point, in full precision.
    pub plain: &'a (dyn Fn(usize, [f64; 3]) -> Complex64 + Sync),
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
    pub plain: u64,
}

impl Tally {
    pub fn add(&mut self, other: Self) {
        self.window += other.window;
        self.gather += other.gather;
        self.plain += other.plain;
    }
}

/// Rows that a tile holds at most for vectors of `lanes`.
pub(crate) fn tile_rows(lanes: usize) -> usize {
    TILE / (lanes * lanes)
}

/// Single-precision parameters of the pulses of a chunk for one block.
struct Setup {
    /// Range in bins, its first, second and third differences a pixel; `[pulse][term][vector]`.
    terms: [[[f32; MAX_LANES]; 4]; CHUNK],
    /// Start of each vector's window within the chunk's table.
    window: [[i32; MAX_LANES]; CHUNK],
    range_m: [f32; CHUNK],
    along_m: [f32; CHUNK],
    fraction: [f32; CHUNK],
    whole: [i32; CHUNK],
}

/// Images a band into `out` `[rows, columns]`; the caller keeps `rows` within [`tile_rows`].
///
/// `DEGREE` is that of the table, `TERMS` counts trigonometric coefficients, `CUBIC` adds the third
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
    let width = S::N * S::N;
    let mut real = [0f32; TILE];
    let mut imag = [0f32; TILE];
    let mut setup = Setup {
        terms: [[[0.0; MAX_LANES]; 4]; CHUNK],
        window: [[0; MAX_LANES]; CHUNK],
        range_m: [0.0; CHUNK],
        along_m: [0.0; CHUNK],
        fraction: [0.0; CHUNK],
        whole: [0; CHUNK],
    };
    let mut tally = Tally::default();
    let pulses = job.antenna_m[0].len();
    let unscale = (1.0 / job.table.scale) as f32;
    let mut column = 0;
    while column < band.columns {
        let kept = (band.columns - column).min(width);
        let vectors = kept.div_ceil(S::N);
        real.fill(0.0);
        imag.fill(0.0);
        let mut first = 0;
        while first < pulses {
            let count = (pulses - first).min(CHUNK);
            for row in 0..band.rows {
                let at = row * width;
                block::<S, DEGREE, TERMS, CUBIC>(
                    s,
                    job,
                    band,
                    (column, row, vectors),
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
    (column, row, vectors): (usize, usize, usize),
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
    let (mut fast, mut exact, mut plain) = ([0u8; CHUNK], [0u8; CHUNK], [0u8; CHUNK]);
    let (mut fasts, mut exacts, mut plains) = (0, 0, 0);

    // Double precision: range and along-row offset at the block's centre.
    let centre = column as f64 + 0.5 * (n * n - 1) as f64;
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
            let whole = t as i32;
            setup.range_m[m] = range as f32;
            setup.along_m[m] = along as f32;
            setup.whole[m] = whole;
            setup.fraction[m] = (t - f64::from(whole)) as f32;
        }
    }

    // Single precision: one lane a vector of the block.
    let half = 0.5 * (n - 1) as f32;
    let pixel = job.pixel_m as f32;
    let bins = inverse_bin as f32;
    let mut offsets = [0f32; MAX_LANES];
    for (k, o) in offsets.iter_mut().enumerate() {
        let k = k.min(vectors - 1) as f32;
        *o = (k - half) * n as f32 * pixel;
    }
    let (per_pixel, per_pixel2, per_pixel3) = (
        s.splat(pixel * bins),
        s.splat(0.5 * pixel * pixel * bins),
        s.splat(-0.5 * pixel * pixel * pixel * bins),
    );
    let tolerance = s.splat(job.tolerance_bins as f32);
    let near = s.splat(job.plain_below_m as f32 + (half + 1.0) * pixel);
    let last_window = s.splat(table.stride as f32 - 1.0 - n as f32);
    let (one, zero, tiny) = (s.splat(1.0), s.splat(0.0), s.splat(1e-30));
    let (half_v, half2_v) = (s.splat(half), s.splat(half * half));
    // SAFETY: `offsets` has MAX_LANES ≥ N numbers.
    let along_block = unsafe { s.load(offsets.as_ptr()) };
    for m in 0..count {
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
        let mut reach = s.mul(s.abs(first), half_v);
        if CUBIC {
            reach = s.mul_add(s.abs(third), s.splat(half * half * half), reach);
        }
        // Half a bin up for rounding, a little down for safety.
        let window = s.floor(s.add(s.sub(t, reach), s.splat(0.499)));
        let span = s.mul_add(second, half2_v, s.add(reach, reach));
        let window_absolute = s.add(window, s.splat(setup.whole[m] as f32));
        let left_out = if CUBIC {
            // Fourth order: |R''''|/24 ≤ (1 − sin²)/(2R³).
            let fourth = s.mul(s.mul(second, inverse_range), inverse_range);
            s.mul(
                fourth,
                s.splat(pixel * pixel * (half * half) * (half * half)),
            )
        } else {
            s.mul(s.abs(third), s.splat(half * half * half))
        };
        let fits = s.all_le(span, s.splat((n - 1) as f32 - 0.05))
            && s.all_le(left_out, tolerance)
            && s.all_le(near, range)
            && s.all_le(zero, window_absolute)
            && s.all_le(window_absolute, last_window);
        if fits {
            let terms = &mut setup.terms[m];
            // SAFETY: every row of `terms` and `window` has MAX_LANES ≥ N places.
            unsafe {
                s.store(terms[0].as_mut_ptr(), s.sub(t, window));
                s.store(terms[1].as_mut_ptr(), first);
                s.store(terms[2].as_mut_ptr(), second);
                if CUBIC {
                    s.store(terms[3].as_mut_ptr(), third);
                }
                s.store_rounded(
                    setup.window[m].as_mut_ptr(),
                    s.add(window, s.splat(ROUNDING)),
                );
            }
            let start = (m * table.pulse_stride()) as i32 + setup.whole[m];
            for w in &mut setup.window[m][..n] {
                *w += start;
            }
            fast[fasts] = m as u8;
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
        *v = l as f32 - half;
    }
    // SAFETY: `lane` has MAX_LANES ≥ N numbers.
    let lanes = unsafe { s.load(lane.as_ptr()) };
    let kernel = Kernel::<S, DEGREE, TERMS> {
        s,
        rounding: s.splat(ROUNDING),
        cosine: job.cosine.map(|c| s.splat(c)),
        sine: job.sine.map(|c| s.splat(c)),
        stride: table.stride,
    };
    for k in 0..vectors {
        let mut sum = (zero, zero);
        for &m in &fast[..fasts] {
            let m = m as usize;
            let terms = &setup.terms[m];
            let t = if CUBIC {
                let a = s.mul_add(lanes, s.splat(terms[3][k]), s.splat(terms[2][k]));
                let a = s.mul_add(lanes, a, s.splat(terms[1][k]));
                s.mul_add(lanes, a, s.splat(terms[0][k]))
            } else {
                let a = s.mul_add(lanes, s.splat(terms[2][k]), s.splat(terms[1][k]));
                s.mul_add(lanes, a, s.splat(terms[0][k]))
            };
            // SAFETY: `fits` above checked 0 ≤ window ≤ stride − 1 − N within the pulse's rows.
            unsafe {
                let window = chunk_table.as_ptr().offset(setup.window[m][k] as isize);
                kernel.windowed(window, t, &mut sum);
            }
        }
        for &m in &exact[..exacts] {
            let m = m as usize;
            // From the vector's own centre, so that what single precision holds stays small.
            let pulse = pulses.start + m;
            let (dx, dy, dz) = (
                x + f64::from(offsets[k]) * unit[0] - job.antenna_m[0][pulse],
                y + f64::from(offsets[k]) * unit[1] - job.antenna_m[1][pulse],
                z + f64::from(offsets[k]) * unit[2] - job.antenna_m[2][pulse],
            );
            let range0 = (dx * dx + dy * dy + dz * dz).sqrt();
            let t0 = range0 * inverse_bin - table.first_bin[pulse] as f64;
            let whole = t0 as i32;
            let along0 = s.splat((dx * unit[0] + dy * unit[1] + dz * unit[2]) as f32);
            let range0 = s.splat(range0 as f32);
            let offset = s.mul(lanes, s.splat(pixel));
            let square_difference = s.mul(offset, s.add(s.add(along0, offset), along0));
            let square = s.max(s.mul_add(range0, range0, square_difference), tiny);
            let difference = s.div(square_difference, s.add(s.sqrt(square), range0));
            let fraction = s.splat((t0 - f64::from(whole)) as f32);
            let t = s.mul_add(difference, s.splat(bins), fraction);
            // SAFETY: the rounded index, taken from the start of the pulse's row, is clamped
            // into the row.
            unsafe {
                let row = chunk_table.as_ptr().add(m * table.pulse_stride());
                let lowest = s.splat(-(whole as f32));
                let highest = s.splat((table.stride as i32 - 1 - whole) as f32);
                kernel.gathered(row.offset(whole as isize), t, (lowest, highest), &mut sum);
            }
        }
        // SAFETY: k < vectors ≤ N, and `real`, `imag` hold N·N numbers.
        unsafe {
            let (re, im) = (real.as_mut_ptr().add(k * n), imag.as_mut_ptr().add(k * n));
            s.store(re, s.add(s.load(re), sum.0));
            s.store(im, s.add(s.load(im), sum.1));
        }
        tally.window += fasts as u64;
        tally.gather += exacts as u64;
        tally.plain += plains as u64;
    }
    for &m in &plain[..plains] {
        for i in 0..(vectors * n).min(band.columns - column) {
            let along = (column + i) as f64;
            let point: [f64; 3] = std::array::from_fn(|axis| {
                band.origin_m[axis] + along * band.u_m[axis] + row as f64 * band.v_m[axis]
            });
            let value = (job.plain)(pulses.start + m as usize, point) * table.scale;
            real[i] += value.re as f32;
            imag[i] += value.im as f32;
        }
    }
}

/// The part of a contribution after its range is known.
pub(crate) struct Kernel<S: Lanes, const DEGREE: usize, const TERMS: usize> {
    pub s: S,
    pub rounding: S::V,
    pub cosine: [S::V; 4],
    pub sine: [S::V; 4],
    pub stride: usize,
}

impl<S: Lanes, const DEGREE: usize, const TERMS: usize> Kernel<S, DEGREE, TERMS> {
    /// Adds the contribution at `t` bins past the window.
    ///
    /// # Safety
    /// N entries must be readable at `window` and at every coefficient row after it.
    #[inline(always)]
    unsafe fn windowed(&self, window: *const f32, t: S::V, sum: &mut (S::V, S::V)) {
        let s = self.s;
        let i = s.add(t, self.rounding);
        let delta = s.sub(t, s.sub(i, self.rounding));
        // SAFETY: the caller vouches for the rows.
        let entry = |row: usize| unsafe { s.pick(s.load(window.add(row * self.stride)), i) };
        self.add(delta, entry, sum);
    }

    /// Adds the contribution at `t` bins past `row`, the index kept within `limits`.
    ///
    /// # Safety
    /// Entries within the limits must be readable at `row` and at every coefficient row after it.
    #[inline(always)]
    pub unsafe fn gathered(
        &self,
        row: *const f32,
        t: S::V,
        (lowest, highest): (S::V, S::V),
        sum: &mut (S::V, S::V),
    ) {
        let s = self.s;
        let i = s.sub(s.add(t, self.rounding), self.rounding);
        let delta = s.sub(t, i);
        // max(lowest, ·) and −max(−highest, −·) also turn NaN into a number within the limits.
        let zero = s.splat(0.0);
        let i = s.max(i, lowest);
        let i = s.sub(zero, s.max(s.sub(zero, i), s.sub(zero, highest)));
        let i = s.add(i, self.rounding);
        // SAFETY: the caller vouches for the entries within the limits.
        let entry = |k: usize| unsafe { s.gather(row.add(k * self.stride), i) };
        self.add(delta, entry, sum);
    }

    #[inline(always)]
    fn add(&self, delta: S::V, entry: impl Fn(usize) -> S::V, sum: &mut (S::V, S::V)) {
        let s = self.s;
        let (mut re, mut im) = (entry(2 * DEGREE), entry(2 * DEGREE + 1));
        for p in (0..DEGREE).rev() {
            re = s.mul_add(re, delta, entry(2 * p));
            im = s.mul_add(im, delta, entry(2 * p + 1));
        }
        let square = s.mul(delta, delta);
        let (mut cosine, mut sine) = (self.cosine[TERMS - 1], self.sine[TERMS - 1]);
        for k in (0..TERMS - 1).rev() {
            cosine = s.mul_add(cosine, square, self.cosine[k]);
            sine = s.mul_add(sine, square, self.sine[k]);
        }
        sine = s.mul(sine, delta);
        sum.0 = s.neg_mul_add(im, sine, s.mul_add(re, cosine, sum.0));
        sum.1 = s.mul_add(im, cosine, s.mul_add(re, sine, sum.1));
    }
}
