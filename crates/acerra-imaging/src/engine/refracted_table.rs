//! Range tables of a level plane below level ground.
//!
//! At the straight distance R = (i + δ)·b a bin holds, as in other tables, the least-squares polynomial in δ
//! of the pulse's contribution without the carrier's phase advance αδ in air. The faster advance of the
//! optical length P(R) widens the band of the polynomials by at most the refractive index. Contributions come
//! from a table over optical lengths in double precision; the polynomial is found by Gauss's quadrature with
//! four nodes a bin.

use super::double::DoubleTables;
use super::level_law::{Knots, LevelLaw};
use super::tables::build::{RangeTable, power_of_two_scale};
use super::tables::spec::TableSpec;
use super::ways::WayTolerance;
use super::weights::WeightedPulses;
use crate::error::ImagingError;
use crate::kernel::level::SimdLevel;
use crate::kernel::profile::DELAYS;
use crate::pulses::{Pulses, Spreading};
use acerra_control::Control;
use num_complex::Complex64;
use rayon::prelude::*;

/// Nodes of Gauss and Legendre on [−1, 1], and halves of their weights (Abramowitz and Stegun, table 25.4).
const NODES: [f64; 4] = [
    -0.861_136_311_594_052_6,
    -0.339_981_043_584_856_3,
    0.339_981_043_584_856_3,
    0.861_136_311_594_052_6,
];
const HALF_WEIGHTS: [f64; 4] = [
    0.173_927_422_568_726_93,
    0.326_072_577_431_273_07,
    0.326_072_577_431_273_07,
    0.173_927_422_568_726_93,
];

/// Share of the polynomials' error that the table over optical lengths may add.
const SOURCE_SHARE: f64 = 0.1;
const LEAST_SOURCE_ERROR: f64 = 1e-9;
/// Longest period of the table over optical lengths, in frequencies.
const MOST_BINS_PER_FREQUENCY: usize = 64;
/// Pulses whose tables over optical lengths are held at a time.
const CHUNK: usize = 64;

/// The table of `spec` over `ranges_m`, least and greatest straight distance of every pulse; frequencies are even.
///
/// # Errors
/// Cancellation.
pub(crate) fn refracted_table(
    echoes: &WeightedPulses,
    law: &LevelLaw,
    (spec, ranges_m): (TableSpec, &[[f64; 2]]),
    level: SimdLevel,
    control: Control,
) -> Result<RangeTable, ImagingError> {
    let pulses = &echoes.pulses;
    let mut table = RangeTable {
        spec,
        carrier_rad: spec.carrier_rad(pulses),
        first_bin: RangeTable::first_bins(&spec, ranges_m),
        stride: RangeTable::stride_for(&spec, ranges_m),
        coefficients: Vec::new(),
        scale: power_of_two_scale(pulses, ranges_m, echoes.weights.spreading),
    };
    let length = table.pulse_stride();
    table.coefficients = vec![0f32; ranges_m.len() * length];
    let source_spec = source_spec(pulses, &spec);
    let mut out = std::mem::take(&mut table.coefficients);
    for (chunk, out) in out.chunks_mut(CHUNK * length).enumerate() {
        let first = chunk * CHUNK;
        let which = first..first + out.len() / length;
        let end_m = |m: usize| (table.first_bin[m] + table.stride as i64) as f64 * spec.bin_m;
        let (knots, of_pulse) = law.tabulated(which.clone(), end_m);
        let knots: Vec<&Knots> = of_pulse.into_iter().map(|k| &knots[k]).collect();
        let optical_m: Vec<[f64; 2]> = (which.clone().zip(&knots))
            .map(|(m, knots)| {
                let first_m = table.first_bin[m].max(0) as f64 * spec.bin_m;
                [first_m, end_m(m)].map(|range_m| knots.at(range_m).optical_m)
            })
            .map(|[a, b]| [a.min(b).max(0.0), a.max(b).max(0.0)])
            .collect();
        let of_chunk = pulses.slice(which.clone())?;
        let source = (source_spec, WayTolerance::EXACT);
        let source = DoubleTables::build(&of_chunk, level, source, &optical_m, control)?;
        out.par_chunks_mut(length).enumerate().for_each(|(k, out)| {
            let pulse = Pulse {
                echoes,
                pulse: first + k,
                knots: knots[k],
                profiles: &|optical_m| source.profiles_of(k, optical_m),
            };
            pulse.fill(&table, out);
        });
    }
    control.check()?;
    table.coefficients = out;
    Ok(table)
}

/// Bins over optical lengths, of third degree, whose error is small relative to that of `spec`.
fn source_spec(pulses: &Pulses, spec: &TableSpec) -> TableSpec {
    let frequencies = pulses.frequency_hz().len();
    let power = vec![1.0; frequencies];
    let allowed = (SOURCE_SHARE * spec.fit_error(pulses, &power)).max(LEAST_SOURCE_ERROR);
    let period_m = match spec.period {
        Some(period) => period as f64 * spec.bin_m,
        None => spec.bin_m,
    };
    let of = |length: usize| TableSpec {
        bin_m: period_m / length as f64,
        degree: 3,
        period: Some(length),
        carrier: spec.carrier,
        interleaved: false,
        reach: 1.0,
    };
    let mut length = (2 * frequencies).next_power_of_two();
    while of(length).fit_error(pulses, &power) > allowed
        && length < MOST_BINS_PER_FREQUENCY * frequencies
    {
        length *= 2;
    }
    of(length)
}

/// A pulse whose rows of a table are filled.
struct Pulse<'a> {
    echoes: &'a WeightedPulses<'a>,
    pulse: usize,
    knots: &'a Knots,
    /// The pulse's profile at optical lengths, m.
    profiles: &'a (dyn Fn(&[f64; DELAYS]) -> [Complex64; DELAYS] + Sync),
}

impl Pulse<'_> {
    fn fill(&self, table: &RangeTable, out: &mut [f32]) {
        let spec = &table.spec;
        let weights = &self.echoes.weights;
        let factor = self.echoes.pulses.weight()[self.pulse] * table.scale;
        let back = NODES.map(|u| Complex64::cis(-0.5 * u * table.carrier_rad));
        // Bins this close to the antenna are never read: see `TableSpec::folding_range_m`.
        let nearest = match weights.spreading {
            Spreading::InverseSquare => 2,
            Spreading::None => 0,
        };
        const BINS: usize = DELAYS / NODES.len();
        for first in (0..table.stride).step_by(BINS) {
            let mut optical_m = [0.0; DELAYS];
            let mut weight = [0.0; DELAYS];
            for (k, (optical, weight)) in optical_m.iter_mut().zip(&mut weight).enumerate() {
                let bin = table.first_bin[self.pulse] + (first + k / NODES.len()) as i64;
                if bin < nearest {
                    continue;
                }
                let delta = 0.5 * NODES[k % NODES.len()];
                let point = self.knots.at((bin as f64 + delta) * spec.bin_m);
                *optical = point.optical_m;
                *weight = factor * weights.of_law(&point);
            }
            let values = (self.profiles)(&optical_m);
            for b in 0..BINS.min(table.stride - first) {
                let at = b * NODES.len();
                let value = |q: usize| values[at + q] * back[q] * weight[at + q];
                let coefficients = least_squares(std::array::from_fn(value), spec.degree);
                for (p, c) in coefficients.iter().enumerate().take(spec.degree + 1) {
                    let (re, im) = if spec.interleaved {
                        let at = (spec.degree + 1) * 2 * (first + b) + 2 * p;
                        (at, at + 1)
                    } else {
                        (
                            2 * p * table.stride + first + b,
                            (2 * p + 1) * table.stride + first + b,
                        )
                    };
                    out[re] = c.re as f32;
                    out[im] = c.im as f32;
                }
            }
        }
    }
}

/// Monomial coefficients in δ of the polynomial of least squares on [−½, ½] through values at the nodes: of the
/// expansion in Legendre polynomials P_l(2δ) the terms up to the degree.
fn least_squares(values: [Complex64; 4], degree: usize) -> [Complex64; 4] {
    let [a0, a1, a2, a3]: [Complex64; 4] = std::array::from_fn(|l| {
        if l > degree {
            return Complex64::ZERO;
        }
        let legendre = |u: f64| match l {
            0 => 1.0,
            1 => u,
            2 => 1.5 * u * u - 0.5,
            _ => (2.5 * u * u - 1.5) * u,
        };
        let terms = values.iter().zip(NODES).zip(HALF_WEIGHTS);
        let sum: Complex64 = terms.map(|((v, u), w)| v * (w * legendre(u))).sum();
        sum * (2 * l + 1) as f64
    });
    [a0 - a2 * 0.5, a1 * 2.0 - a3 * 3.0, a2 * 6.0, a3 * 20.0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_of_the_degree_are_kept_and_higher_powers_projected() {
        for degree in 1..=3 {
            let power = |p: usize| NODES.map(|u| Complex64::new((0.5 * u).powi(p as i32), 0.0));
            for p in 0..=degree {
                for (q, c) in least_squares(power(p), degree).iter().enumerate() {
                    let expected = if p == q { 1.0 } else { 0.0 };
                    assert!((c - expected).norm() < 1e-12, "{degree} {p} {q} {c}");
                }
            }
        }
        // The line nearest to δ³ on [−½, ½] is 3δ/20.
        let cube = NODES.map(|u| Complex64::new((0.5 * u).powi(3), 0.0));
        assert!((least_squares(cube, 1)[1] - 0.15).norm() < 1e-12);
    }
}
