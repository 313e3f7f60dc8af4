//! Width and number of the bins of range tables.

use crate::engine::tables::fit_error::FitErrors;
use crate::engine::tables::spec::TableSpec;
use crate::engine::travel_time::TravelTime;
use crate::pulses::Pulses;

/// Largest error of the carrier's polynomials over a bin of phase advance `alpha` (rad): the cosine has
/// `terms` terms, the sine one fewer, both interpolated at Chebyshev nodes.
pub(super) fn carrier_error(alpha: f64, terms: i32) -> f64 {
    let x = 0.5 * alpha;
    let remainder = |power: i32| {
        let factorial: f64 = (1..=power).map(f64::from).product();
        x.powi(power) / factorial
    };
    let cosine = remainder(2 * terms) / 2f64.powi(2 * terms - 1);
    let sine = remainder(2 * terms - 1) / 2f64.powi(2 * terms - 3);
    cosine.max(sine)
}

/// Bins of a fortieth of the shortest wavelength, m.
pub(super) fn fine_bin_m(pulses: &Pulses) -> f64 {
    let top = pulses.frequency_hz().iter().copied().fold(0.0, f64::max);
    pulses.light_speed_m_s() / top / 40.0
}

/// Greatest reach of a bin's polynomials, bins: for groups of wider pixels the sums in registers save less
/// than the longer reach costs.
const MOST_REACH: f64 = 12.0;

/// The widest bins of a degree that keep `accuracy` where pixels up to half `extent_m` beyond a bin's edge
/// are added to the bin.
pub(super) fn choose_table(
    pulses: &Pulses,
    errors: &FitErrors,
    degree: usize,
    (accuracy, extent_m): (f64, f64),
) -> Option<TableSpec> {
    let accurate = |spec: &TableSpec| {
        let alpha = spec.carrier_rad(pulses);
        alpha < 2.6 && carrier_error(alpha, 4) <= 0.3 * accuracy && errors.of(spec) <= accuracy
    };
    let near = |spec: &TableSpec| spec.reach <= MOST_REACH;
    let spec = |bin_m, period| TableSpec {
        bin_m,
        degree,
        period,
        carrier: errors.carrier,
        interleaved: false,
        reach: 1.0 + extent_m / bin_m,
    };
    if let Some(step) = pulses.frequency_step_hz() {
        let period_m = TravelTime::of(pulses).period_m(step);
        let shortest = (pulses.frequency_hz().len() + 1).max(16);
        // Longer periods have narrower bins and less error.
        let lengths = smooth_lengths(shortest, shortest * 4096);
        let of = |length: usize| spec(period_m / length as f64, Some(length));
        let first = lengths.partition_point(|length| !accurate(&of(*length)));
        return lengths.get(first).map(|length| of(*length)).filter(near);
    }
    let mut bin_m = 20.0 * fine_bin_m(pulses);
    for _ in 0..80 {
        if accurate(&spec(bin_m, None)) {
            return Some(spec(bin_m, None)).filter(near);
        }
        bin_m *= 0.93;
    }
    None
}

/// Lengths 2^a·3^b·5^c from `from` to `to`, about 4 % apart, rising.
fn smooth_lengths(from: usize, to: usize) -> Vec<usize> {
    let mut lengths = Vec::new();
    for b in 0..3 {
        for c in 0..3 {
            let mut length = 4 * 3usize.pow(b) * 5usize.pow(c);
            while length <= to {
                if length >= from {
                    lengths.push(length);
                }
                length *= 2;
            }
        }
    }
    lengths.sort_unstable();
    lengths
}
