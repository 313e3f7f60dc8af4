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

/// The bins of a pulse, without the carrier's phase from a bin's centre on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row<'a> {
    pub bins: &'a [Bin],
    /// Absolute number of the first bin.
    pub first_bin: f64,
    /// Bins in a metre.
    pub bins_per_m: f64,
    /// Two-way phase advance of the carrier a bin, in turns.
    pub carrier_turns: f64,
}

/// The profile at every range; ranges beyond the bins take the value of the nearest bin.
pub(crate) fn profiles(
    level: SimdLevel,
    row: &Row,
    ranges_m: &[f64; DELAYS],
) -> [Complex64; DELAYS] {
    dispatch!(level, s => looked_up(s, row, ranges_m))
}

#[inline(always)]
fn looked_up<S: Lanes>(s: S, row: &Row, ranges_m: &[f64; DELAYS]) -> [Complex64; DELAYS] {
    let Some(last) = row.bins.len().checked_sub(1) else {
        return [Complex64::ZERO; DELAYS];
    };
    let mut turns = [0.0; DELAYS];
    let (mut re, mut im) = ([0.0; DELAYS], [0.0; DELAYS]);
    for (k, range) in ranges_m.iter().enumerate() {
        let at = range * row.bins_per_m - row.first_bin;
        // Casts saturate: values below 0 become 0.
        let index = ((at + 0.5) as usize).min(last);
        let delta = at - index as f64;
        let [c0, c1, c2, c3] = row.bins[index];
        re[k] = ((c3[0] * delta + c2[0]) * delta + c1[0]) * delta + c0[0];
        im[k] = ((c3[1] * delta + c2[1]) * delta + c1[1]) * delta + c0[1];
        turns[k] = delta * row.carrier_turns;
    }
    let envelope = Phasors {
        re: s.load_f64(re),
        im: s.load_f64(im),
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
            bins: &bins,
            first_bin: 1000.0,
            bins_per_m: 200.0,
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
