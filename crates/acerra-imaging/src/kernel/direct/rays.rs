//! Tabulated rays from antennas apart to a level plane below level ground, read lane by lane.

use crate::kernel::lanes::{Lanes, MAX_LANES, ROUNDING};

/// Terms of the polynomials of a record.
pub(crate) const TERMS: usize = 4;

/// Numbers of a record: polynomials in the distance δ from the record's place, in records. The first is the excess of the
/// optical length over the straight distance and over [`RayRow::beyond_m`], in range bins, the second one over
/// the weight of one way, which follows a power of the distance that squares of pixels expand well. The last number is the greatest magnitude of the fourth coefficient of the excess within the reach of a
/// square of pixels.
pub(crate) type RayRecord = [f32; NUMBERS];

/// Numbers of a record.
const NUMBERS: usize = 2 * TERMS + 1;

/// Records before the first and after the last one of a row, which windows may load.
pub(crate) const RECORD_PADDING: usize = MAX_LANES;

/// Last record of a row, at most: places within rows are exact in single precision.
pub(crate) const MOST_RECORDS: usize = 1 << 21;

/// Tabulated rays of all pulses.
#[derive(Clone, Copy)]
pub(crate) struct RaysView<'a> {
    /// Rows of records, each with the first numbers of all its records, then the second ones, and so on.
    pub numbers: &'a [f32],
    /// Rows of the transmitter and of the receiver of each pulse.
    pub rows: [&'a [RayRow]; 2],
    /// Largest relative error of a weight by its expansion.
    pub weight_tolerance: f32,
}

/// Records of an antenna: record i holds the rays about the straight distance (`first` + i)/`per_m`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RayRow {
    /// Place of the first number of record 0.
    pub start: usize,
    /// Numbers from a record's first number to its second one.
    pub stride: usize,
    /// Number of the last record, at most [`MOST_RECORDS`].
    pub last: usize,
    pub first: f64,
    /// Records in a metre.
    pub per_m: f64,
    /// Length of a record, in metres and in range bins.
    pub record_m: f32,
    pub record_bins: f32,
    /// Excess that the records leave out, m.
    pub beyond_m: f64,
}

impl RayRow {
    /// Numbers from a record's first number to its second one in a row of some records.
    pub const fn stride_of(records: usize) -> usize {
        records + 2 * RECORD_PADDING
    }
}

/// The place of a straight distance in a row: a record, and the distance from it in records.
#[derive(Clone, Copy, Default)]
pub(super) struct Place {
    record: i32,
    rest: f32,
}

impl RayRow {
    /// The place of a straight distance.
    #[inline(always)]
    pub(super) fn place(&self, range_m: f64) -> Place {
        let at = range_m * self.per_m - self.first;
        let record = at.max(0.0).min(self.last as f64) as i32;
        Place {
            record,
            rest: (at - f64::from(record)) as f32,
        }
    }
}

/// Rays at the straight distances of a vector.
#[derive(Clone, Copy)]
pub(super) struct Rays<S: Lanes> {
    excess: [S::V; TERMS],
    inverse: [S::V; TERMS],
    /// Greatest fourth coefficient of the excess within the reach of a square, bins.
    pub fourth: S::V,
    delta: S::V,
}

impl<S: Lanes> Rays<S> {
    /// The rays at `difference_m` beyond a place.
    #[inline(always)]
    pub fn at(s: S, view: &RaysView, (row, place): (&RayRow, Place), difference_m: S::V) -> Self {
        let (zero, rounding) = (s.splat(0.0), s.splat(ROUNDING));
        let per_m = row.per_m as f32;
        let rest = s.mul_add(difference_m, s.splat(per_m), s.splat(place.rest));
        let highest = row.last as i32 - place.record;
        // max(·, −lowest) and −max(−·, −highest) also turn NaN into a number within the limits.
        let kept = s.max(rest, s.splat(-(place.record as f32)));
        let kept = s.sub(zero, s.max(s.sub(zero, kept), s.splat(-(highest as f32))));
        let i = s.sub(s.add(kept, rounding), rounding);
        let delta = s.sub(rest, i);
        let (first, stride) = (row.start + place.record as usize, row.stride);
        let end = row.start + row.last + RECORD_PADDING + (NUMBERS - 1) * stride;
        assert!(row.start >= RECORD_PADDING && end < view.numbers.len());
        let number = view.numbers.as_ptr().wrapping_add(first);
        let zeros = [zero; TERMS];
        let ([mut excess, mut inverse], fourth) = ([zeros; 2], 2 * TERMS * stride);
        let fourth = number.wrapping_add(fourth);
        let greatest;
        let window = s.splat((S::N - 1) as f32);
        // SAFETY: `record` + i is a whole number between 0 and the row's last record. Windows begin N records before
        // `record` and are 2N long; padding holds N records on either side of the row.
        unsafe {
            if s.all_le(s.abs(i), window) {
                let i = s.add(i, s.splat(ROUNDING + S::N as f32));
                let at = number.sub(S::N);
                for k in 0..TERMS {
                    excess[k] = picked(s, at.add(k * stride), i);
                    inverse[k] = picked(s, at.add((TERMS + k) * stride), i);
                }
                greatest = picked(s, fourth.sub(S::N), i);
            } else {
                let i = s.add(i, rounding);
                for k in 0..TERMS {
                    excess[k] = s.gather(number.add(k * stride), i);
                    inverse[k] = s.gather(number.add((TERMS + k) * stride), i);
                }
                greatest = s.gather(fourth, i);
            }
        }
        Self {
            excess,
            inverse,
            fourth: greatest,
            delta,
        }
    }

    /// Excess of the optical length, bins.
    #[inline(always)]
    pub fn excess(&self, s: S) -> S::V {
        value(s, &self.excess, self.delta)
    }

    /// One over the weight of one way.
    #[inline(always)]
    pub fn inverse_weight(&self, s: S) -> S::V {
        value(s, &self.inverse, self.delta)
    }

    /// Coefficients of the powers 0 to 3 of a further distance in records: of the excess and of one over the weight of one
    /// way.
    #[inline(always)]
    pub fn powers(&self, s: S) -> [[S::V; TERMS]; 2] {
        let triple = s.mul(self.delta, s.splat(3.0));
        [
            powers(s, &self.excess, [self.delta, triple]),
            powers(s, &self.inverse, [self.delta, triple]),
        ]
    }
}

#[inline(always)]
fn powers<S: Lanes>(s: S, c: &[S::V; TERMS], [delta, triple]: [S::V; 2]) -> [S::V; TERMS] {
    let second = s.mul_add(c[3], triple, c[2]);
    let first = s.mul_add(s.add(c[2], second), delta, c[1]);
    [value(s, c, delta), first, second, c[3]]
}

/// Entries of a window of 2N numbers.
///
/// # Safety
/// The window must be readable.
#[inline(always)]
unsafe fn picked<S: Lanes>(s: S, window: *const f32, i: S::V) -> S::V {
    // SAFETY: the caller vouches for the window.
    unsafe { s.pick2([s.load(window), s.load(window.add(S::N))], i) }
}

#[inline(always)]
fn value<S: Lanes>(s: S, c: &[S::V; TERMS], delta: S::V) -> S::V {
    let [c0, c1, c2, c3] = *c;
    s.mul_add(s.mul_add(s.mul_add(c3, delta, c2), delta, c1), delta, c0)
}
