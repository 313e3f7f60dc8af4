//! The transposed direct kernel for pixels that are coarse relative to a range bin: every pixel is added to
//! its own bin, and the range over groups of neighbouring pixels is expanded about the groups' middles.
//!
//! The kernel adds the same terms to bins as [`spread_row`](super::spread::spread_row). Lanes are
//! neighbouring groups, and so some pixels apart: an addition seldom waits for a previous addition to the
//! same bin, as it would from pixel to pixel.

use super::lanes::{Lanes, MAX_LANES, ROUNDING};
use super::spread::step;
use super::spread_expansion::{Expanded, Fallback, Strip, StripGeometry};

/// Groups of a strip, a pulse, and the bins between them.
pub(crate) struct SpreadSquares<'a> {
    pub geometry: StripGeometry<'a>,
    /// Real and imaginary parts `[strips, blocks, ROWS, COLUMNS, MAX_LANES]`: pixels of the same place in
    /// their groups side by side, zeros beyond the image.
    pub real: &'a [f32],
    pub imag: &'a [f32],
    /// Error allowed to the range expansion, bins.
    pub tolerance_bins: f64,
    /// cos αδ and sin(αδ)/δ in powers of δ², |δ| ≤ ½ bin.
    pub cosine: [f32; 4],
    pub sine: [f32; 4],
}

/// Adds the groups to `bins` `[entries, step]`. Blocks for which the expansion does not hold go to
/// `fallback`.
///
/// Groups hold `COLUMNS` × `ROWS` pixels, `DEGREE` is the degree of the bins, `TERMS` the number of the
/// cosine's coefficients (the sine has one fewer).
#[inline(always)]
pub(crate) fn spread_squares<
    S: Lanes,
    const COLUMNS: usize,
    const ROWS: usize,
    const DEGREE: usize,
    const TERMS: usize,
>(
    s: S,
    job: &SpreadSquares,
    bins: &mut [f32],
    fallback: &mut Fallback,
) {
    let n = S::N;
    let geometry = &job.geometry;
    let entries = geometry.entries;
    geometry.check::<S>(
        COLUMNS * ROWS,
        [job.real, job.imag],
        bins.len(),
        step(DEGREE),
    );
    const { assert!((COLUMNS == 2 || COLUMNS == 4) && TERMS <= 4 && TERMS >= 2) };

    let units = 1.0 / geometry.bin_m;
    let shared = Strip::<S, COLUMNS, ROWS, true>::of(s, geometry, units, job.tolerance_bins);
    let carrier = Carrier::<S, DEGREE, TERMS> {
        s,
        cosine: job.cosine.map(|c| s.splat(c)),
        sine: job.sine.map(|c| s.splat(c)),
    };
    for (strip, first) in geometry.blocks(n) {
        let expanded = shared
            .expand(strip, first)
            .filter(|at| within(s, at, entries));
        let Some(at) = expanded else {
            fallback((strip, geometry.block(first, n)), bins);
            continue;
        };
        let start = geometry.start(strip, first, COLUMNS * ROWS);
        let rows = Rows::<S, ROWS>::of(s, &at);
        // SAFETY: `first` is a multiple of N and less than the groups' end, so that N lanes of its block
        // lie within both parts, for each of the block's places. Every lane's ranges were found to lie
        // within the bins, each of which holds `step` numbers.
        unsafe {
            let (real, imag) = (job.real.as_ptr().add(start), job.imag.as_ptr().add(start));
            let to = bins.as_mut_ptr().add(at.whole as usize * step(DEGREE));
            for row in 0..ROWS {
                let place = row * COLUMNS * MAX_LANES;
                let (real, imag) = (real.add(place), imag.add(place));
                let cubic = rows.at(row);
                let bins = (to, rows.rounding);
                carrier.add_pair::<COLUMNS>(0, &cubic, [real, imag], bins, at.weight);
                if COLUMNS > 2 {
                    carrier.add_pair::<COLUMNS>(1, &cubic, [real, imag], bins, at.weight);
                }
            }
        }
    }
}

/// Whether all ranges of a block of groups, with a bin to spare, lie within the bins.
#[inline(always)]
fn within<S: Lanes>(s: S, at: &Expanded<S>, entries: usize) -> bool {
    // The third order is at most a fifth of the second.
    let reach = s.mul_add(at.reach, s.splat(1.2), s.splat(1.0));
    let (least, most) = (s.sub(at.t, reach), s.add(at.t, reach));
    s.all_le(s.splat(-(at.whole as f32)), least)
        && s.all_le(most, s.splat((entries as i32 - 1 - at.whole) as f32))
}

/// The range over each group as polynomials in both directions, bins.
struct Rows<S: Lanes, const ROWS: usize> {
    s: S,
    /// [`ROUNDING`] past the whole bins of the middle, and the rest.
    rounding: S::V,
    rest: S::V,
    slope: [S::V; 2],
    squares: [S::V; 3],
    cubes: [S::V; 4],
}

/// The range along a row in powers of the pixel from the group's middle.
struct Cubic<S: Lanes>([S::V; 4]);

impl<S: Lanes, const ROWS: usize> Rows<S, ROWS> {
    #[inline(always)]
    fn of(s: S, at: &Expanded<S>) -> Self {
        let rounding = s.add(at.t, s.splat(ROUNDING));
        let middle = s.sub(rounding, s.splat(ROUNDING));
        let [along, across] = at.slope;
        let (a, b, c) = (at.along_square, at.product, at.across_square);
        let inverse = s.sub(s.splat(0.0), at.inverse_range);
        // −LQ/R
        let cubes = [
            s.mul(along, a),
            s.mul_add(along, b, s.mul(across, a)),
            s.mul_add(along, c, s.mul(across, b)),
            s.mul(across, c),
        ];
        Self {
            s,
            rounding,
            rest: s.sub(at.t, middle),
            slope: at.slope,
            squares: [a, b, c],
            cubes: cubes.map(|k| s.mul(k, inverse)),
        }
    }

    #[inline(always)]
    fn at(&self, row: usize) -> Cubic<S> {
        let s = self.s;
        let y = s.splat(row as f32 - 0.5 * (ROWS - 1) as f32);
        let ([along, across], [a, b, c]) = (self.slope, self.squares);
        let rise = s.mul_add(y, s.mul_add(y, self.cubes[3], c), across);
        Cubic([
            s.mul_add(y, rise, self.rest),
            s.mul_add(y, s.mul_add(y, self.cubes[2], b), along),
            s.mul_add(y, self.cubes[1], a),
            self.cubes[0],
        ])
    }
}

impl<S: Lanes> Cubic<S> {
    /// The range at `x` pixels before the middle and after the middle.
    #[inline(always)]
    fn either_side(&self, s: S, x: f32) -> [S::V; 2] {
        let Self([c0, c1, c2, c3]) = *self;
        let square = s.splat(x * x);
        let (even, odd) = (s.mul_add(square, c2, c0), s.mul_add(square, c3, c1));
        let x = s.splat(x);
        [s.neg_mul_add(x, odd, even), s.mul_add(x, odd, even)]
    }
}

/// The carrier's phase over a bin.
struct Carrier<S: Lanes, const DEGREE: usize, const TERMS: usize> {
    s: S,
    cosine: [S::V; 4],
    sine: [S::V; 4],
}

impl<S: Lanes, const DEGREE: usize, const TERMS: usize> Carrier<S, DEGREE, TERMS> {
    /// Adds the two pixels of a row that are `k` pixels from those next to the middle, row `at` past
    /// `rounding`, times `weight` where there is one, to the bins from `to` on.
    ///
    /// # Safety
    /// N numbers must be readable at the places of both columns, the bins at all lanes writable.
    #[inline(always)]
    unsafe fn add_pair<const COLUMNS: usize>(
        &self,
        k: usize,
        row: &Cubic<S>,
        [real, imag]: [*const f32; 2],
        (to, rounding): (*mut f32, S::V),
        weight: Option<S::V>,
    ) {
        let s = self.s;
        let ranges = row.either_side(s, 0.5 + k as f32);
        let columns = [COLUMNS / 2 - 1 - k, COLUMNS / 2 + k];
        for (t, column) in ranges.into_iter().zip(columns) {
            let place = column * MAX_LANES;
            // SAFETY: the caller vouches for all.
            unsafe {
                let mut value = [s.load(real.add(place)), s.load(imag.add(place))];
                if let Some(weight) = weight {
                    value = [s.mul(value[0], weight), s.mul(value[1], weight)];
                }
                self.add(to, (rounding, t), value);
            }
        }
    }

    /// Adds a value to the bin at `t` bins past the whole bins that `rounding` is past [`ROUNDING`],
    /// counted from `to`.
    ///
    /// # Safety
    /// The bins at all lanes must be writable.
    #[inline(always)]
    unsafe fn add(&self, to: *mut f32, (rounding, t): (S::V, S::V), [re, im]: [S::V; 2]) {
        let s = self.s;
        let i = s.add(t, rounding);
        let delta = s.sub(t, s.sub(i, rounding));
        let square = s.mul(delta, delta);
        let (mut cosine, mut sine) = (self.cosine[TERMS - 1], self.sine[TERMS - 2]);
        for k in (0..TERMS - 1).rev() {
            cosine = s.mul_add(cosine, square, self.cosine[k]);
        }
        for k in (0..TERMS - 2).rev() {
            sine = s.mul_add(sine, square, self.sine[k]);
        }
        sine = s.mul(sine, delta);
        let (re, im) = (
            s.mul_add(im, sine, s.mul(re, cosine)),
            s.neg_mul_add(re, sine, s.mul(im, cosine)),
        );
        let (re1, im1) = (s.mul(re, delta), s.mul(im, delta));
        // SAFETY: the caller vouches for the bins.
        unsafe {
            if DEGREE <= 1 {
                s.scatter_add4(to, i, step(DEGREE), [re, im, re1, im1]);
                return;
            }
            let (re2, im2) = (s.mul(re, square), s.mul(im, square));
            let (mut re3, mut im3) = (s.splat(0.0), s.splat(0.0));
            if DEGREE > 2 {
                (re3, im3) = (s.mul(re1, square), s.mul(im1, square));
            }
            s.scatter_add8(to, i, [re, im, re1, im1, re2, im2, re3, im3]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::polynomials::carrier_polynomials;
    use crate::kernel::dispatch::{dispatch, wide_token};
    use crate::kernel::level::SimdLevel;
    use crate::sampling::Random;
    use crate::vector::norm;
    use num_complex::Complex64;

    const CARRIER_RAD: f64 = 1.4;
    const BIN_M: f64 = 0.01;
    /// Number of groups of a strip, not a whole number of blocks.
    const GROUPS: usize = 37;
    const STRIPS: usize = 3;

    fn geometry<const COLUMNS: usize, const ROWS: usize>(
        from_antennas_m: &[[f64; 3]],
    ) -> StripGeometry<'_> {
        let height_m = -from_antennas_m[0][2];
        let (u, v) = ([0.98, 0.1, 0.05], [-0.2, 0.95, 0.0]);
        StripGeometry {
            from_antennas_m,
            two_spreadings: from_antennas_m.len() > 1,
            strips: STRIPS,
            stride: GROUPS.next_multiple_of(MAX_LANES) * COLUMNS * ROWS * MAX_LANES,
            unit: [u.map(|x| x / norm(u)), v.map(|x| x / norm(v))],
            pixel_m: [0.03, 0.04],
            groups: 0..GROUPS,
            bin_m: BIN_M,
            first_bin: (0.9 * height_m / BIN_M) as i64,
            entries: 1200,
            reference_below_m: 0.0,
        }
    }

    /// Relative error of Σ v e^{−j(α + θ)t}, t being the range in bins, from the bins, of which polynomials in
    /// θ may drop `DEGREE` + 1 powers; and the blocks that went to the fallback.
    fn error<S: Lanes, const COLUMNS: usize, const ROWS: usize, const DEGREE: usize>(
        s: S,
        geometry: &StripGeometry,
    ) -> (f64, usize) {
        let mut random = Random(7);
        let length = geometry.stride * STRIPS;
        let (mut real, mut imag) = (vec![0f32; length], vec![0f32; length]);
        let ramp_rad = [0.0, 0.01, 0.05, 0.15][DEGREE];
        let mut expected = Complex64::ZERO;
        let mut size = 0.0;
        for strip in 0..STRIPS {
            for group in 0..GROUPS {
                for place in 0..COLUMNS * ROWS {
                    let at = geometry.start(strip, group, COLUMNS * ROWS) + place * MAX_LANES;
                    let mut part = || random.below(2001) as f32 * 1e-3 - 1.0;
                    (real[at], imag[at]) = (part(), part());
                    let value = Complex64::new(f64::from(real[at]), f64::from(imag[at]));
                    let i = (group * COLUMNS + place % COLUMNS) as f64 * geometry.pixel_m[0];
                    let j = (strip * ROWS + place / COLUMNS) as f64 * geometry.pixel_m[1];
                    let [u, v] = geometry.unit;
                    let ranges_m: Vec<f64> = (geometry.from_antennas_m.iter())
                        .map(|from_m| {
                            norm(std::array::from_fn(|a| from_m[a] + i * u[a] + j * v[a]))
                        })
                        .collect();
                    let (first, last) = (ranges_m[0], ranges_m[ranges_m.len() - 1]);
                    let mean_m = 0.5 * (first + last);
                    let t = mean_m / BIN_M - geometry.first_bin as f64;
                    let spreading = mean_m * mean_m / (first * last);
                    expected += value * spreading * Complex64::cis(-(CARRIER_RAD + ramp_rad) * t);
                    size += value.norm_sqr();
                }
            }
        }
        let (cosine, sine) = carrier_polynomials(CARRIER_RAD, true);
        let job = SpreadSquares {
            geometry: geometry.clone(),
            real: &real,
            imag: &imag,
            tolerance_bins: 1e-3,
            cosine,
            sine,
        };
        let mut bins = vec![0f32; geometry.entries * step(DEGREE)];
        let mut fallbacks = 0;
        s.vectorize(
            #[inline(always)]
            |s| {
                spread_squares::<_, COLUMNS, ROWS, DEGREE, 4>(s, &job, &mut bins, &mut |_, _| {
                    fallbacks += 1;
                });
            },
        );
        let mut found = Complex64::ZERO;
        for (bin, entry) in bins.chunks_exact(step(DEGREE)).enumerate() {
            let mut power = Complex64::cis(-(CARRIER_RAD + ramp_rad) * bin as f64);
            for p in 0..=DEGREE {
                let (re, im) = (entry[2 * p], entry[2 * p + 1]);
                found += Complex64::new(f64::from(re), f64::from(im)) * power;
                power *= Complex64::new(0.0, -ramp_rad / (p + 1) as f64);
            }
        }
        ((found - expected).norm() / size.sqrt(), fallbacks)
    }

    fn check<S: Lanes>(s: S) {
        let one = |height_m: f64| vec![[-0.7, 0.4, -height_m]];
        let apart = |height_m: f64| vec![[-0.8, 0.4, -height_m], [-0.6, 0.3, -height_m]];
        for from_m in [one(4.0), one(40.0), apart(4.0), apart(40.0)] {
            let errors = [
                error::<S, 4, 4, 1>(s, &geometry::<4, 4>(&from_m)),
                error::<S, 4, 4, 2>(s, &geometry::<4, 4>(&from_m)),
                error::<S, 4, 4, 3>(s, &geometry::<4, 4>(&from_m)),
                error::<S, 2, 2, 1>(s, &geometry::<2, 2>(&from_m)),
                error::<S, 2, 2, 3>(s, &geometry::<2, 2>(&from_m)),
            ];
            for (error, fallbacks) in errors {
                assert!(error < 3e-4, "{errors:?} from {from_m:?}");
                assert_eq!(fallbacks, 0);
            }
        }
        // Blocks near the antenna, past the last bin or before the first one are left to the fallback.
        let blocks = STRIPS * GROUPS.div_ceil(S::N);
        let from_m = one(4.0);
        let usual = geometry::<4, 4>(&from_m);
        let near = StripGeometry {
            reference_below_m: 9.0,
            ..usual.clone()
        };
        let past = StripGeometry {
            entries: 10,
            ..usual.clone()
        };
        let before = StripGeometry {
            first_bin: 2000,
            ..usual
        };
        for geometry in [near, past, before] {
            assert_eq!(error::<S, 4, 4, 1>(s, &geometry).1, blocks);
        }
    }

    #[test]
    fn pixels_go_to_their_bins_at_every_level() {
        for &level in SimdLevel::available() {
            dispatch!(level, s => check(s));
        }
        check(wide_token());
    }
}
