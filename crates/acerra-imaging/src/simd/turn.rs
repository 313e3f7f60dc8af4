//! The phase of the carrier along a row of pixels, for the range to a sub-aperture's centre.

use super::{Lanes, MAX_LANES, ROUNDING};

/// A row of pixels as seen from a sub-aperture's centre.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TurnRow {
    /// From the centre to pixel 0 of the row, m.
    pub from_centre_m: [f64; 3],
    /// Unit vector along the row and distance of the pixels, m.
    pub unit: [f64; 3],
    pub pixel_m: f64,
    /// Turns of the carrier a metre of range, 2f/c.
    pub turns_a_metre: f64,
    /// cos and sin(2πx)/x in powers of x², |x| ≤ ½.
    pub cosine: [f32; 6],
    pub sine: [f32; 6],
}

/// Multiplies a row, padded to a multiple of [`MAX_LANES`], by e^{jφ}, or by e^{−jφ} where `back`.
#[inline(always)]
pub(crate) fn turn_row<S: Lanes>(
    s: S,
    job: &TurnRow,
    back: bool,
    real: &mut [f32],
    imag: &mut [f32],
) {
    assert!(real.len().is_multiple_of(MAX_LANES) && imag.len() == real.len());
    let carrier = RowCarrier::new(s, job, 1);
    let sign = s.splat(if back { -1.0 } else { 1.0 });
    for q in (0..real.len()).step_by(S::N) {
        let (cosine, sine) = carrier.turn(&carrier.centre(q), 0);
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

/// The carrier's phase along a row whose pixels are taken in intervals of some pixels.
pub(crate) struct RowCarrier<'a, S: Lanes> {
    s: S,
    job: &'a TurnRow,
    lanes: S::V,
    turns: S::V,
    interval_m: f64,
}

/// The middle of N intervals, in double precision so far as single would not do.
pub(crate) struct Centre<S: Lanes> {
    fraction: S::V,
    range: S::V,
    along: S::V,
}

impl<'a, S: Lanes> RowCarrier<'a, S> {
    #[inline(always)]
    pub fn new(s: S, job: &'a TurnRow, interval: usize) -> Self {
        let mut lane = [0f32; MAX_LANES];
        let interval_m = job.pixel_m * interval as f64;
        for (l, v) in lane.iter_mut().enumerate() {
            *v = ((l as f64 - 0.5 * (S::N - 1) as f64) * interval_m) as f32;
        }
        Self {
            s,
            job,
            // SAFETY: `lane` has MAX_LANES ≥ N numbers.
            lanes: unsafe { s.load(lane.as_ptr()) },
            turns: s.splat(job.turns_a_metre as f32),
            interval_m,
        }
    }

    /// The middle of the N intervals from `q` on.
    #[inline(always)]
    pub fn centre(&self, q: usize) -> Centre<S> {
        let (s, job) = (self.s, self.job);
        let along = (q as f64 + 0.5 * (S::N - 1) as f64) * self.interval_m;
        let d: [f64; 3] = std::array::from_fn(|a| job.from_centre_m[a] + along * job.unit[a]);
        let range = crate::rows::norm(d);
        let turn = range * job.turns_a_metre;
        Centre {
            fraction: s.splat((turn - turn.round()) as f32),
            range: s.splat(range as f32),
            along: s.splat(crate::rows::dot(d, job.unit) as f32),
        }
    }

    /// Cosine and sine of the phase at pixel `p` of each of those intervals.
    #[inline(always)]
    pub fn turn(&self, centre: &Centre<S>, p: usize) -> (S::V, S::V) {
        let (s, job) = (self.s, self.job);
        let (rounding, tiny) = (s.splat(ROUNDING), s.splat(1e-30));
        let offset = s.add(self.lanes, s.splat((p as f64 * job.pixel_m) as f32));
        let square_difference = s.mul(offset, s.add(s.add(centre.along, offset), centre.along));
        let square = s.max(
            s.mul_add(centre.range, centre.range, square_difference),
            tiny,
        );
        let difference = s.div(
            square_difference,
            s.max(s.add(s.sqrt(square), centre.range), tiny),
        );
        let t = s.mul_add(difference, self.turns, centre.fraction);
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
