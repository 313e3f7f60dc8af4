//! The phase of the carrier along a row of pixels, for the range to a sub-aperture's centre.

use super::lanes::{Lanes, MAX_LANES, ROUNDING};

/// Truncation error allowed to a cubic range, cycles of the carrier, and to the series over uneven ground: it is
/// reached at the ends of a cell alone, and falls with the fourth power.
const CUBIC_CYCLES: f64 = 2e-7;
const SERIES_CYCLES: f64 = 2e-6;

/// A row of pixels as seen from a sub-aperture's centre.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PhaseRow {
    /// Vector from the centre to pixel 0 of the row, m.
    pub from_centre_m: [f64; 3],
    /// Unit vector along the row and distance of the pixels, m.
    pub unit: [f64; 3],
    pub pixel_m: f64,
    /// Two-way carrier cycles per metre of range, 2f/c.
    pub cycles_per_m: f64,
    /// cos and sin(2πx)/x in powers of x², |x| ≤ ½.
    pub cosine: [f32; 6],
    pub sine: [f32; 6],
}

/// Heights of a row of pixels in intervals, above the plane of the row, m: the first pixels of all intervals
/// contiguously, then the second pixels, and so on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RowHeights<'a> {
    /// `[pixels of an interval, intervals]`.
    pub above_m: &'a [f32],
    /// Middle of the heights of each interval, m.
    pub middle_m: &'a [f32],
    /// Greatest departure of heights from the middle, m.
    pub departure_m: f32,
    /// Least and greatest height of the row, m.
    pub span_m: [f32; 2],
}

/// Multiplies a row, padded to a multiple of [`MAX_LANES`], by e^{jφ}, or by e^{−jφ} where `back`.
#[inline(always)]
pub(crate) fn apply_phase<S: Lanes>(
    s: S,
    job: &PhaseRow,
    back: bool,
    real: &mut [f32],
    imag: &mut [f32],
) {
    assert!(real.len().is_multiple_of(MAX_LANES) && imag.len() == real.len());
    let carrier = RowCarrier::new(s, job, 1, None);
    let sign = s.splat(if back { -1.0 } else { 1.0 });
    for q in (0..real.len()).step_by(S::N) {
        let (cosine, sine) = carrier.phase::<false>(&carrier.intervals::<false>(q), 0);
        let sine = s.mul(sine, sign);
        // SAFETY: q + N does not exceed the length of either part, a multiple of N.
        unsafe {
            let (to_re, to_im) = (real.as_mut_ptr().add(q), imag.as_mut_ptr().add(q));
            let (re, im) = (s.load(to_re), s.load(to_im));
            s.store(to_re, s.neg_mul_add(im, sine, s.mul(re, cosine)));
            s.store(to_im, s.mul_add(re, sine, s.mul(im, cosine)));
        }
    }
}

/// Writes a row times e^{−jφ}. Both rows, and the heights of uneven ground, contain first the first pixels of
/// all cells of `pixels`, then the second pixels, and so on.
#[inline(always)]
pub(crate) fn remove_phase<S: Lanes>(
    s: S,
    (job, heights): (&PhaseRow, Option<RowHeights>),
    pixels: usize,
    from: (&[f32], &[f32]),
    to: (&mut [f32], &mut [f32]),
) {
    match heights {
        None => remove_phase_on::<S, false>(s, (job, None), pixels, from, to),
        Some(_) => remove_phase_on::<S, true>(s, (job, heights), pixels, from, to),
    }
}

#[inline(always)]
fn remove_phase_on<S: Lanes, const RELIEF: bool>(
    s: S,
    (job, heights): (&PhaseRow, Option<RowHeights>),
    pixels: usize,
    from: (&[f32], &[f32]),
    to: (&mut [f32], &mut [f32]),
) {
    let length = from.0.len();
    let cells = length / pixels;
    assert!(cells >= S::N && from.1.len() == length);
    assert!(to.0.len() >= length && to.1.len() >= length);
    let carrier = RowCarrier::new(s, job, pixels, heights);
    assert!(carrier.has_heights(RELIEF, pixels, cells));
    let mut q = 0;
    while q < cells {
        // Whole vectors: the last one begins where it ends with the row.
        let first = q.min(cells - S::N);
        let at_middle = carrier.intervals::<RELIEF>(first);
        for p in 0..pixels {
            let (cosine, sine) = carrier.phase::<RELIEF>(&at_middle, p);
            let at = p * cells + first;
            // SAFETY: first + N ≤ cells, and every part has `cells` numbers of each of the cell's pixels.
            unsafe {
                let (re, im) = (
                    s.load(from.0.as_ptr().add(at)),
                    s.load(from.1.as_ptr().add(at)),
                );
                let rotated = s.mul_add(im, sine, s.mul(re, cosine));
                s.store(to.0.as_mut_ptr().add(at), rotated);
                let rotated = s.neg_mul_add(re, sine, s.mul(im, cosine));
                s.store(to.1.as_mut_ptr().add(at), rotated);
            }
        }
        q += S::N;
    }
}

/// The carrier's phase along a row whose pixels are taken in intervals of some pixels, N intervals at
/// a time.
pub(crate) struct RowCarrier<'a, S: Lanes> {
    s: S,
    job: &'a PhaseRow,
    heights: Option<RowHeights<'a>>,
    lanes: S::V,
    cycles: S::V,
    interval_m: f64,
    /// Distance from the first pixel of an interval to the middle, m.
    half_m: f64,
    /// Whether the range within an interval may be a cubic, or over uneven ground a series.
    cubic: bool,
}

/// N intervals: carrier cycles at their middles and the coefficients of their expansion.
pub(crate) struct Intervals<S: Lanes> {
    cycles: S::V,
    slope: S::V,
    bend: S::V,
    third: S::V,
    fraction: S::V,
    range: S::V,
    along: S::V,
    /// First of the intervals.
    first: usize,
    /// Height from which heights are counted, m.
    from_height: S::V,
    up: S::V,
}

impl<'a, S: Lanes> RowCarrier<'a, S> {
    #[inline(always)]
    pub fn new(s: S, job: &'a PhaseRow, interval: usize, heights: Option<RowHeights<'a>>) -> Self {
        let mut lane = [0f32; MAX_LANES];
        let interval_m = job.pixel_m * interval as f64;
        let half_m = 0.5 * (interval - 1) as f64 * job.pixel_m;
        for (l, v) in lane.iter_mut().enumerate() {
            *v = ((l as f64 - 0.5 * (S::N - 1) as f64) * interval_m) as f32;
        }
        // No range is shorter than the distance from the line of the row; the truncation error of
        // the cubic is at most half the fourth power over the third.
        let d = job.from_centre_m;
        let along = crate::vector::dot(d, job.unit);
        let beside_m = (crate::vector::dot(d, d) - along * along).max(0.0).sqrt();
        let cubic = match heights {
            None => {
                let truncation_error_m = 0.5 * half_m.powi(4) / beside_m.max(1e-9).powi(3);
                truncation_error_m * job.cycles_per_m < CUBIC_CYCLES
            }
            // Of the series R(√(1 + x) − 1) the term in x⁴ is dropped, x being at most (2a + a²/R)/R at a metres
            // from the middle.
            Some(heights) => {
                let [low, high] = heights.span_m.map(|h| d[2] + f64::from(h));
                let level_m = (beside_m * beside_m - d[2] * d[2]).max(0.0).sqrt();
                let least_m = level_m.hypot(low.max(-high).max(0.0)).max(1e-9);
                let away_m = half_m + f64::from(heights.departure_m);
                let x = (2.0 + away_m / least_m) * away_m / least_m;
                0.04 * x.powi(4) * least_m * job.cycles_per_m < SERIES_CYCLES
            }
        };
        Self {
            s,
            job,
            heights,
            // SAFETY: `lane` has MAX_LANES ≥ N numbers.
            lanes: unsafe { s.load(lane.as_ptr()) },
            cycles: s.splat(job.cycles_per_m as f32),
            interval_m,
            half_m,
            // Single pixels need no expansion.
            cubic: interval > 1 && cubic,
        }
    }

    /// Whether heights for `intervals` intervals of `pixels` pixels exist where `relief` requires them.
    pub fn has_heights(&self, relief: bool, pixels: usize, intervals: usize) -> bool {
        match self.heights {
            Some(of) => {
                relief && of.above_m.len() >= pixels * intervals && of.middle_m.len() == intervals
            }
            None => !relief,
        }
    }

    /// The N intervals from `q` on, for which the caller checked [`Self::has_heights`].
    #[inline(always)]
    pub fn intervals<const RELIEF: bool>(&self, q: usize) -> Intervals<S> {
        let (s, job) = (self.s, self.job);
        // The middle of all intervals is computed in double precision, the others relative to it.
        let along = (q as f64 + 0.5 * (S::N - 1) as f64) * self.interval_m + self.half_m;
        let mut d: [f64; 3] = std::array::from_fn(|a| job.from_centre_m[a] + along * job.unit[a]);
        let middle_m = self.heights.map_or(&[][..], |heights| heights.middle_m);
        let mut from_height = 0.0;
        if RELIEF {
            from_height = middle_m[q + S::N / 2];
            d[2] += f64::from(from_height);
        }
        let range = crate::vector::norm(d);
        let cycles = range * job.cycles_per_m;
        let mut found = Intervals {
            cycles: s.splat(0.0),
            slope: s.splat(0.0),
            bend: s.splat(0.0),
            third: s.splat(0.0),
            fraction: s.splat((cycles - cycles.round()) as f32),
            range: s.splat(range as f32),
            along: s.splat(crate::vector::dot(d, job.unit) as f32),
            first: q,
            from_height: s.splat(from_height),
            up: s.splat(d[2] as f32),
        };
        if RELIEF && self.cubic {
            // SAFETY: N middles follow the one that was read N/2 before.
            let height = unsafe { s.load(middle_m[q..q + S::N].as_ptr()) };
            let rise = s.sub(height, found.from_height);
            let difference = self.difference::<RELIEF>(&found, self.lanes, rise);
            let range = s.add(difference, found.range);
            let inverse = s.div(s.splat(1.0), range);
            let square = s.mul(inverse, inverse);
            let along = s.add(found.along, self.lanes);
            found.cycles = s.mul_add(difference, self.cycles, found.fraction);
            found.slope = s.mul(s.mul(inverse, s.splat(0.5)), self.cycles);
            found.bend = s.mul(s.mul(found.slope, s.splat(-0.25)), square);
            found.third = s.mul(s.mul(found.bend, s.splat(-0.5)), square);
            found.along = s.add(along, along);
            found.from_height = height;
            found.up = s.add(found.up, rise);
            found.up = s.add(found.up, found.up);
        } else if self.cubic {
            let one = s.splat(1.0);
            let difference = self.difference::<false>(&found, self.lanes, self.lanes);
            let inverse = s.div(one, s.add(difference, found.range));
            let sine = s.mul(s.add(found.along, self.lanes), inverse);
            let curvature = s.mul(s.neg_mul_add(sine, sine, one), inverse);
            found.cycles = s.mul_add(difference, self.cycles, found.fraction);
            found.slope = s.mul(sine, self.cycles);
            found.bend = s.mul(s.mul(curvature, s.splat(0.5)), self.cycles);
            found.third = s.neg_mul_add(s.mul(sine, inverse), found.bend, s.splat(0.0));
        }
        found
    }

    /// Excess of the ranges at `offset` along the row (and `rise` in height over uneven ground) over the
    /// range of the middle.
    #[inline(always)]
    fn difference<const RELIEF: bool>(&self, at: &Intervals<S>, offset: S::V, rise: S::V) -> S::V {
        let s = self.s;
        let tiny = s.splat(1e-30);
        let mut more = s.mul(offset, s.add(s.add(at.along, offset), at.along));
        if RELIEF {
            more = s.mul_add(rise, s.add(s.add(at.up, rise), at.up), more);
        }
        let square = s.max(s.mul_add(at.range, at.range, more), tiny);
        let sum = s.max(s.add(s.sqrt(square), at.range), tiny);
        s.div(more, sum)
    }

    /// Cosine and sine of the phase at pixel `p` of each of the intervals `at`.
    #[inline(always)]
    pub fn phase<const RELIEF: bool>(&self, at: &Intervals<S>, p: usize) -> (S::V, S::V) {
        let (s, job) = (self.s, self.job);
        let rounding = s.splat(ROUNDING);
        let within_m = (p as f64 * job.pixel_m - self.half_m) as f32;
        let within = s.splat(within_m);
        let rise = match self.heights {
            Some(heights) if RELIEF => {
                let first = p * heights.middle_m.len() + at.first;
                // SAFETY: the slice has N heights.
                let height = unsafe { s.load(heights.above_m[first..first + S::N].as_ptr()) };
                s.sub(height, at.from_height)
            }
            _ => within,
        };
        let t = if RELIEF && self.cubic {
            // R(√(1 + x) − 1) in powers of R²x = w(2d + w) + h(2e + h).
            let along = s.mul_add(within, at.along, s.splat(within_m * within_m));
            let more = s.mul_add(rise, s.add(at.up, rise), along);
            let slope = s.mul_add(s.mul_add(at.third, more, at.bend), more, at.slope);
            s.mul_add(slope, more, at.cycles)
        } else if self.cubic {
            let slope = s.mul_add(s.mul_add(at.third, within, at.bend), within, at.slope);
            s.mul_add(slope, within, at.cycles)
        } else {
            let difference = self.difference::<RELIEF>(at, s.add(self.lanes, within), rise);
            s.mul_add(difference, self.cycles, at.fraction)
        };
        let x = s.sub(t, s.sub(s.add(t, rounding), rounding));
        let x2 = s.mul(x, x);
        let (mut cosine, mut sine) = (s.splat(job.cosine[5]), s.splat(job.sine[5]));
        for k in (0..5).rev() {
            cosine = s.mul_add(cosine, x2, s.splat(job.cosine[k]));
            sine = s.mul_add(sine, x2, s.splat(job.sine[k]));
        }
        (cosine, s.mul(sine, x))
    }
}
