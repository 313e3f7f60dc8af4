//! Range profiles from tables in double precision, at several ranges side by side.

use super::dispatch::dispatch;
use super::lanes::Lanes;
use super::level::SimdLevel;
use super::phasor::{Phasors, phasors};
use super::profile::DELAYS;
use num_complex::Complex64;

/// Terms of a bin's polynomial.
pub(crate) const TERMS: usize = 4;

/// The polynomial of a bin in δ, the distance from its centre in bins: real and imaginary part of every
/// coefficient.
pub(crate) type Bin = [[f64; 2]; TERMS];

/// Bins of two real functions of the range, or of one complex function.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bins<'a> {
    pub bins: &'a [Bin],
    /// Absolute number of the first bin.
    pub first_bin: f64,
    /// Bins in a metre.
    pub bins_per_m: f64,
}

/// The bins of a pulse, without the carrier's phase from a bin's centre on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row<'a> {
    pub bins: Bins<'a>,
    /// Two-way phase advance of the carrier a bin, in turns.
    pub carrier_turns: f64,
}

/// Values of both functions of some bins, and the distances from the centres of the bins, in bins.
pub(super) struct LookedUp {
    pub first: [f64; DELAYS],
    pub second: [f64; DELAYS],
    pub delta: [f64; DELAYS],
}

impl Bins<'_> {
    /// The polynomials at every range; ranges beyond the bins take the polynomial of the nearest bin.
    #[inline(always)]
    pub(super) fn at(&self, ranges_m: &[f64; DELAYS]) -> LookedUp {
        let mut found = LookedUp {
            first: [0.0; DELAYS],
            second: [0.0; DELAYS],
            delta: [0.0; DELAYS],
        };
        if self.bins.is_empty() {
            return found;
        }
        let last = i32::try_from(self.bins.len() - 1).unwrap_or(i32::MAX);
        let mut index = [0i32; DELAYS];
        for (k, range) in ranges_m.iter().enumerate() {
            let at = range * self.bins_per_m - self.first_bin;
            // Casts saturate, and no table has 2³¹ bins.
            index[k] = ((at + 0.5) as i32).clamp(0, last);
            found.delta[k] = at - f64::from(index[k]);
        }
        for (k, delta) in found.delta.into_iter().enumerate() {
            let [c0, c1, c2, c3] = self.bins[index[k] as usize];
            found.first[k] = ((c3[0] * delta + c2[0]) * delta + c1[0]) * delta + c0[0];
            found.second[k] = ((c3[1] * delta + c2[1]) * delta + c1[1]) * delta + c0[1];
        }
        found
    }
}

/// The profile at every range; ranges beyond the bins take the value of the nearest bin.
pub(crate) fn profiles(
    level: SimdLevel,
    row: &Row,
    ranges_m: &[f64; DELAYS],
) -> [Complex64; DELAYS] {
    dispatch!(level, s => profiles_by(s, row, ranges_m))
}

#[inline(always)]
fn profiles_by<S: Lanes>(s: S, row: &Row, ranges_m: &[f64; DELAYS]) -> [Complex64; DELAYS] {
    let found = row.bins.at(ranges_m);
    let mut turns = found.delta;
    for turns in &mut turns {
        *turns *= row.carrier_turns;
    }
    let envelope = Phasors {
        re: s.load_f64(found.first),
        im: s.load_f64(found.second),
    };
    envelope.times(s, phasors(s, turns)).numbers(s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_level_evaluates_polynomial_and_carrier() {
        let bins: Vec<Bin> = (0..9)
            .map(|i| {
                let part = |k: usize| (0.7 * (3 * i + k) as f64).sin();
                std::array::from_fn(|p| [part(p), part(p + 5)])
            })
            .collect();
        let row = Row {
            bins: Bins {
                bins: &bins,
                first_bin: 1000.0,
                bins_per_m: 200.0,
            },
            carrier_turns: 0.17,
        };
        // Bins 1000 to 1008, their edges, and ranges outside them.
        let bin_numbers = [
            1000.0, 1000.49, 1003.3, 1004.51, 1007.9, 1008.2, 999.7, 1008.9,
        ];
        for &level in SimdLevel::available() {
            let found = profiles(level, &row, &bin_numbers.map(|bin| bin / 200.0));
            for (bin, found) in bin_numbers.iter().zip(found) {
                let index = (bin - 1000.0).round().clamp(0.0, 8.0);
                let delta = bin - 1000.0 - index;
                let polynomial: Complex64 = bins[index as usize]
                    .iter()
                    .rev()
                    .fold(Complex64::ZERO, |sum, c| {
                        sum * delta + Complex64::new(c[0], c[1])
                    });
                let expected = polynomial * Complex64::cis(std::f64::consts::TAU * 0.17 * delta);
                assert!((found - expected).norm() < 1e-12, "{level:?} {bin}");
            }
        }
    }
}
