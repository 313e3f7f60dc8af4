//! The direct kernel for surfaces: rows evenly spaced on the map, every pixel at its own height.
//!
//! As on planes ([`super::rows`]), with heights carried beside the distances along the row: from a
//! block's centre (in double precision) to a group's, R² changes by o(2d + o) + h(2e + h), o and h
//! being offset and height of the group, d and e those of the block from the antenna. Through a
//! group's heights runs a straight line, whose range is again a quadratic or cubic; what heights
//! leave beside the line enters to second order. The ground between the knots of a height raster is
//! straight, so most groups need no more than a plane does. Each group decides for itself between
//! windows and gathers: a boulder does not slow its whole block.

use super::lanes::{Lanes, MAX_LANES, ROUNDING};
use super::rows::{
    Band, CHUNK, Job, Kernel, TILE, Tally, block_width, place_windows, tile_rows, vectors_a_group,
};
use crate::grid::relief::Relief;
use num_complex::Complex32;

/// Rows of parameters a pulse: as on planes, and what heights beside the line do.
const ROWS: usize = 11;
/// Stands for the start of a window where a group has none: the bits of −1, which no start has.
const NO_WINDOW: f32 = f32::from_bits(u32::MAX);
/// Most rows of a tile: those of the shortest vectors.
const MOST_ROWS: usize = 16;

/// Heights of one block of one row.
#[derive(Clone, Copy)]
struct Profile {
    /// Height at the block's centre above the plane, m.
    centre_m: f64,
    /// Line through each group: height at its middle above the centre (m), slope, and the largest
    /// departure from it (m); one lane a group.
    line_m: [f32; MAX_LANES],
    slope: [f32; MAX_LANES],
    uneven_m: [f32; MAX_LANES],
}

impl Profile {
    const LEVEL: Self = Self {
        centre_m: 0.0,
        line_m: [0.0; MAX_LANES],
        slope: [0.0; MAX_LANES],
        uneven_m: [0.0; MAX_LANES],
    };

    /// Fits lines to `heights_m` (at most a block; the last goes on where it ends), and stores every
    /// pixel's height above the block's centre and beside its line.
    fn fit(
        heights_m: &[f32],
        pixel_m: f64,
        group: usize,
        above_m: &mut [f32],
        beside_m: &mut [f32],
    ) -> Self {
        let mut profile = Self::LEVEL;
        let width = above_m.len();
        let last = heights_m.len() - 1;
        profile.centre_m = f64::from(heights_m[(width / 2).min(last)]);
        for (k, above) in above_m.iter_mut().enumerate() {
            *above = (f64::from(heights_m[k.min(last)]) - profile.centre_m) as f32;
        }
        let half = 0.5 * (group - 1) as f64;
        let spread: f64 = (0..group).map(|k| (k as f64 - half).powi(2)).sum();
        for (k, (above, beside)) in above_m
            .chunks(group)
            .zip(beside_m.chunks_mut(group))
            .enumerate()
        {
            let moment: f64 = above
                .iter()
                .enumerate()
                .map(|(i, z)| (i as f64 - half) * f64::from(*z))
                .sum();
            let rise = moment / spread;
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for (i, z) in above.iter().enumerate() {
                let left = f64::from(*z) - rise * (i as f64 - half);
                low = low.min(left);
                high = high.max(left);
            }
            let middle = 0.5 * (low + high);
            for (i, (z, b)) in above.iter().zip(beside).enumerate() {
                *b = (f64::from(*z) - rise * (i as f64 - half) - middle) as f32;
            }
            profile.line_m[k] = middle as f32;
            profile.slope[k] = (rise / pixel_m) as f32;
            profile.uneven_m[k] = (0.5 * (high - low)) as f32;
        }
        profile
    }
}

/// Parameters of the pulses of a chunk for one block.
struct Setup {
    /// As on planes, then change of range with height (bins a metre) and of that along the row.
    windowed: [f32; CHUNK * ROWS * MAX_LANES],
    range_m: [f32; CHUNK],
    along_m: [f32; CHUNK],
    up_m: [f32; CHUNK],
    fraction: [f32; CHUNK],
    whole: [i32; CHUNK],
}

/// Images a band with its relief into `out` `[rows, columns]`; the caller keeps `rows` within
/// [`tile_rows`]. Constants as in [`super::rows::band`].
#[inline(always)]
pub(crate) fn surface_band<S: Lanes, const DEGREE: usize, const TERMS: usize, const CUBIC: bool>(
    s: S,
    job: &Job,
    band: &Band,
    relief: Relief,
    out: &mut [Complex32],
) -> Tally {
    assert!(band.rows <= tile_rows(S::N) && out.len() == band.rows * band.columns);
    assert!(tile_rows(S::N) <= MOST_ROWS && job.table.spec.degree == DEGREE);
    let width = block_width(S::N);
    let mut real = [0f32; TILE];
    let mut imag = [0f32; TILE];
    let mut above = [0f32; TILE];
    let mut beside = [0f32; TILE];
    let mut profiles = [Profile::LEVEL; MOST_ROWS];
    let mut setup = Setup {
        windowed: [0.0; CHUNK * ROWS * MAX_LANES],
        range_m: [0.0; CHUNK],
        along_m: [0.0; CHUNK],
        up_m: [0.0; CHUNK],
        fraction: [0.0; CHUNK],
        whole: [0; CHUNK],
    };
    let mut tally = Tally::default();
    let unscale = (1.0 / job.table.scale) as f32;
    let group = S::N * vectors_a_group(S::N);
    let mut column = 0;
    while column < band.columns && !job.control.is_cancelled() {
        let kept = (band.columns - column).min(width);
        let groups = kept.div_ceil(group);
        real.fill(0.0);
        imag.fill(0.0);
        for (row, profile) in profiles.iter_mut().enumerate().take(band.rows) {
            let heights_m = &relief.heights_m[row * relief.stride + column..][..kept];
            let (above, beside) = (&mut above[row * width..], &mut beside[row * width..]);
            *profile = Profile::fit(
                heights_m,
                job.pixel_m,
                group,
                &mut above[..width],
                &mut beside[..width],
            );
        }
        let mut first = job.pulses.start;
        while first < job.pulses.end {
            let count = (job.pulses.end - first).min(CHUNK);
            for (row, profile) in profiles.iter().enumerate().take(band.rows) {
                let at = row * width..(row + 1) * width;
                block::<S, DEGREE, TERMS, CUBIC>(
                    s,
                    job,
                    band,
                    (column, row, groups),
                    first..first + count,
                    Ground {
                        profile,
                        above_m: &above[at.clone()],
                        beside_m: &beside[at.clone()],
                    },
                    &mut setup,
                    (&mut real[at.clone()], &mut imag[at]),
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

/// The ground under one block.
struct Ground<'a> {
    profile: &'a Profile,
    /// Every pixel's height above the block's centre, m.
    above_m: &'a [f32],
    /// Every pixel's height beside the line of its group, m.
    beside_m: &'a [f32],
}

#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn block<S: Lanes, const DEGREE: usize, const TERMS: usize, const CUBIC: bool>(
    s: S,
    job: &Job,
    band: &Band,
    (column, row, groups): (usize, usize, usize),
    pulses: std::ops::Range<usize>,
    ground: Ground,
    setup: &mut Setup,
    (real, imag): (&mut [f32], &mut [f32]),
    tally: &mut Tally,
) {
    let n = S::N;
    let table = job.table;
    let count = pulses.len();
    let chunk_table =
        &table.coefficients[pulses.start * table.pulse_stride()..][..count * table.pulse_stride()];
    // Pulses that go through gathers, with the groups that do.
    let (mut exact, mut plain) = ([(0u8, 0u32); CHUNK], [0u8; CHUNK]);
    let (mut fasts, mut exacts, mut plains) = (0, 0, 0);
    assert!(ground.above_m.len() >= block_width(n) && ground.beside_m.len() >= block_width(n));
    assert!(real.len() >= block_width(n) && imag.len() >= block_width(n));

    // Double precision: range, along-row offset and height at the block's centre.
    let centre = column as f64 + 0.5 * (block_width(n) - 1) as f64;
    let at =
        |axis: usize| band.origin_m[axis] + centre * band.u_m[axis] + row as f64 * band.v_m[axis];
    let (x, y, z) = (at(0), at(1), at(2) + ground.profile.centre_m);
    let inverse_bin = 1.0 / table.spec.bin_m;
    let unit = band.u_m.map(|u| u / job.pixel_m);
    for m in 0..count {
        let pulse = pulses.start + m;
        let (dx, dy, dz) = (
            x - job.antenna_m[0][pulse],
            y - job.antenna_m[1][pulse],
            z - job.antenna_m[2][pulse],
        );
        let range = (dx * dx + dy * dy + dz * dz).sqrt();
        let t = range * inverse_bin - table.first_bin[pulse] as f64;
        #[allow(clippy::manual_clamp)] // `clamp` would keep NaN
        let whole = t.max(-1e9).min(1e9) as i32;
        setup.range_m[m] = range as f32;
        setup.along_m[m] = (dx * unit[0] + dy * unit[1]) as f32;
        setup.up_m[m] = dz as f32;
        setup.whole[m] = whole;
        setup.fraction[m] = (t - f64::from(whole)) as f32;
    }

    // Single precision: one lane a group of the block.
    let pair = vectors_a_group(n);
    let pixel = job.pixel_m as f32;
    let bins = inverse_bin as f32;
    let half = 0.5 * (pair * n - 1) as f32;
    let half_vector = 0.5 * (n - 1) as f32;
    let shift = 0.5 * ((pair - 1) * n) as f32;
    let mut offsets = [0f32; MAX_LANES];
    for (k, o) in offsets.iter_mut().enumerate() {
        let k = k.min(groups - 1) as f32;
        *o = (k - 0.5 * (n - 1) as f32) * (pair * n) as f32 * pixel;
    }
    let per_pixel = s.splat(pixel * bins);
    let per_pixel2 = s.splat(0.5 * pixel * pixel * bins);
    let per_pixel3 = s.splat(-0.5 * pixel * pixel * pixel * bins);
    let tolerance = s.splat(job.tolerance_bins as f32);
    let last_window = s.splat(table.stride as f32 - 2.0 - n as f32);
    let widest = s.splat((n - 1) as f32 - 0.05);
    let (one, zero, tiny) = (s.splat(1.0), s.splat(0.0), s.splat(1e-30));
    let rounding = s.splat(ROUNDING);
    // SAFETY: all four have MAX_LANES ≥ N numbers.
    let (along_block, line, slope, uneven) = unsafe {
        (
            s.load(offsets.as_ptr()),
            s.load(ground.profile.line_m.as_ptr()),
            s.load(ground.profile.slope.as_ptr()),
            s.load(ground.profile.uneven_m.as_ptr()),
        )
    };
    let steep = s.mul_add(slope, slope, one);
    // A group reaches so far from its middle, and farther where it is steep.
    let reach_m = s.mul(s.splat((half + 1.0) * pixel), s.sqrt(steep));
    let near = s.add(
        s.splat(job.reference_below_m as f32),
        s.add(reach_m, uneven),
    );
    let uneven_bins = s.mul(uneven, s.splat(bins));
    let half_m = s.splat(half * pixel);
    let all = u32::MAX >> (32 - groups as u32);
    for m in 0..count {
        let range0 = s.splat(setup.range_m[m]);
        let (along0, up0) = (s.splat(setup.along_m[m]), s.splat(setup.up_m[m]));
        let (along, up) = (s.add(along0, along_block), s.add(up0, line));
        let square_difference = s.mul_add(
            line,
            s.add(up, up0),
            s.mul(along_block, s.add(along, along0)),
        );
        let square = s.max(s.mul_add(range0, range0, square_difference), tiny);
        let range = s.sqrt(square);
        let sum = s.add(range, range0);
        let reciprocal = s.div(one, s.mul(sum, range));
        let inverse_range = s.mul(reciprocal, sum);
        let difference = s.mul(s.mul(square_difference, reciprocal), range);
        let rise = s.mul(up, inverse_range);
        let gradient = s.mul_add(slope, rise, s.mul(along, inverse_range));
        let curvature = s.mul(
            s.max(s.neg_mul_add(gradient, gradient, steep), zero),
            inverse_range,
        );
        let t = s.mul_add(difference, s.splat(bins), s.splat(setup.fraction[m]));
        let first = s.mul(gradient, per_pixel);
        let second = s.mul(curvature, per_pixel2);
        let third = s.mul(s.mul(s.mul(gradient, curvature), inverse_range), per_pixel3);
        let (first, left_out) = if CUBIC {
            // The fourth derivative is at most 12 (steep − gradient²) steep / R³.
            let fourth = s.mul(s.mul(s.mul(second, steep), inverse_range), inverse_range);
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
        // Beside the line the second order is kept; the third is at most 0.6 b(a + b)²/R² at b beside
        // and a along the line.
        let away = s.add(reach_m, uneven);
        let third_order = s.mul(s.mul(away, away), s.mul(inverse_range, inverse_range));
        let left_out = s.mul_add(s.mul(uneven_bins, s.splat(0.6)), third_order, left_out);
        let turn = s.mul(s.neg_mul_add(gradient, rise, slope), inverse_range);
        let bow = s.mul(
            s.mul(s.neg_mul_add(rise, rise, one), inverse_range),
            s.splat(0.5),
        );
        let wobble = s.mul(
            uneven_bins,
            s.mul_add(bow, uneven, s.mul_add(s.abs(turn), half_m, s.abs(rise))),
        );
        let mut steepest = s.mul_add(second, s.splat(2.0 * shift), s.abs(first));
        if CUBIC {
            steepest = s.mul_add(s.abs(third), s.splat(3.0 * half * half), steepest);
        }
        let reach = s.mul_add(steepest, s.splat(half_vector), wobble);
        let (span, [window, window2]) = place_windows(s, [t, first, second], reach);
        let whole = s.splat(setup.whole[m] as f32);
        let least = s.sub(whole, s.max(s.sub(zero, window), s.sub(zero, window2)));
        let most = s.add(whole, s.max(window, window2));
        if !s.all_le(near, range) {
            plain[plains] = m as u8;
            plains += 1;
            continue;
        }
        let fits = s.all_le(span, widest)
            && s.all_le(left_out, tolerance)
            && s.all_le(zero, least)
            && s.all_le(most, last_window);
        let mut gathers = 0;
        if !fits {
            let mut tests = [[0f32; MAX_LANES]; 4];
            // SAFETY: each row has MAX_LANES ≥ N numbers.
            unsafe {
                s.store(tests[0].as_mut_ptr(), s.sub(widest, span));
                s.store(tests[1].as_mut_ptr(), s.sub(tolerance, left_out));
                s.store(tests[2].as_mut_ptr(), least);
                s.store(tests[3].as_mut_ptr(), s.sub(last_window, most));
            }
            for k in 0..groups {
                let fits = tests.iter().all(|t| t[k] >= 0.0); // false for NaN
                gathers |= u32::from(!fits) << k;
            }
            exact[exacts] = (m as u8, gathers);
            exacts += 1;
            if gathers == all {
                continue;
            }
        }
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
            s.store(at.add(8 * n), s.mul(rise, s.splat(bins)));
            s.store(at.add(9 * n), s.mul(turn, per_pixel));
            s.store(at.add(10 * n), s.mul(bow, s.splat(bins)));
        }
        for k in 0..groups {
            if gathers >> k & 1 == 1 {
                rows[5 * n + k] = NO_WINDOW;
            }
        }
        fasts += 1;
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
        let mut windows = 0;
        let rough = ground.profile.uneven_m[k] * bins > 0.05 * job.tolerance_bins as f32;
        // SAFETY: the first `fasts` parameter sets were written above, k < N; windows that are
        // there were checked to lie within their pulse's rows; vector pair·k + side lies within the block.
        unsafe {
            let beside_of =
                |side: usize| s.load(ground.beside_m.as_ptr().add((pair * k + side) * n));
            let beside = [beside_of(0), beside_of(pair - 1)];
            let mut at = setup.windowed.as_ptr().add(k);
            let end = at.add(fasts * ROWS * n);
            while at < end {
                let term = |row: usize| s.splat(*at.add(row * n));
                let next = at.add(ROWS * n);
                if (*at.add(5 * n)).to_bits() == NO_WINDOW.to_bits() {
                    at = next;
                    continue;
                }
                windows += 1;
                for side in 0..pair {
                    let lanes = lanes_of[side];
                    let t = s.sub(term(0), term(4 + 2 * side));
                    let slope = if CUBIC {
                        s.mul_add(lanes, s.mul_add(lanes, term(3), term(2)), term(1))
                    } else {
                        s.mul_add(lanes, term(2), term(1))
                    };
                    let mut t = s.mul_add(lanes, slope, t);
                    if rough {
                        let b = beside[side];
                        let change = s.mul_add(b, term(10), s.mul_add(lanes, term(9), term(8)));
                        t = s.mul_add(b, change, t);
                    }
                    let start = (*at.add((5 + 2 * side) * n)).to_bits() as i32;
                    let window = chunk_table.as_ptr().offset(start as isize);
                    kernel.windowed(window, t, &mut sums[side]);
                }
                at = next;
            }
        }
        for (side, sum) in sums.iter_mut().enumerate().take(pair) {
            let vector = pair * k + side;
            // From the block's centre to the vector's middle: half pixels, and so exact.
            let middle = (vector * n) as f32 + half_vector - 0.5 * (block_width(n) - 1) as f32;
            // SAFETY: the vector lies within the block.
            let height = unsafe { s.load(ground.above_m.as_ptr().add(vector * n)) };
            let middle_m = ground.above_m[vector * n + n / 2];
            for &(m, gathers) in &exact[..exacts] {
                if gathers >> k & 1 == 0 {
                    continue;
                }
                let m = m as usize;
                let pulse = pulses.start + m;
                let (range0, along0, up0, whole, fraction, offset, height) = if job.near_centre {
                    (
                        setup.range_m[m],
                        setup.along_m[m],
                        setup.up_m[m],
                        setup.whole[m],
                        setup.fraction[m],
                        s.mul(s.add(lanes, s.splat(middle)), s.splat(pixel)),
                        height,
                    )
                } else {
                    // From the vector's own middle, so that what single precision holds stays small.
                    let along = f64::from(middle) * job.pixel_m;
                    let (dx, dy, dz) = (
                        x + along * unit[0] - job.antenna_m[0][pulse],
                        y + along * unit[1] - job.antenna_m[1][pulse],
                        z + f64::from(middle_m) - job.antenna_m[2][pulse],
                    );
                    let range0 = (dx * dx + dy * dy + dz * dz).sqrt();
                    let t0 = range0 * inverse_bin - table.first_bin[pulse] as f64;
                    let whole = t0 as i32;
                    (
                        range0 as f32,
                        (dx * unit[0] + dy * unit[1]) as f32,
                        dz as f32,
                        whole,
                        (t0 - f64::from(whole)) as f32,
                        s.mul(lanes, s.splat(pixel)),
                        s.sub(height, s.splat(middle_m)),
                    )
                };
                let (along0, up0) = (s.splat(along0), s.splat(up0));
                let range0 = s.splat(range0);
                let square_difference = s.mul_add(
                    height,
                    s.add(s.add(up0, height), up0),
                    s.mul(offset, s.add(s.add(along0, offset), along0)),
                );
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
        tally.window += (pair * windows) as u64;
        tally.gather += (pair * (count - plains - windows)) as u64;
        tally.reference += (pair * plains) as u64;
    }
    for &m in &plain[..plains] {
        for i in 0..(groups * pair * n).min(band.columns - column) {
            let along = (column + i) as f64;
            let mut point: [f64; 3] = std::array::from_fn(|axis| {
                band.origin_m[axis] + along * band.u_m[axis] + row as f64 * band.v_m[axis]
            });
            point[2] += ground.profile.centre_m + f64::from(ground.above_m[i]);
            let value = job.reference.contribution(pulses.start + m as usize, point) * table.scale;
            real[i] += value.re as f32;
            imag[i] += value.im as f32;
        }
    }
}
