//! The transposed direct engine: every pixel spread over the range bins of every pulse.

use super::bins::BinsToSpectrum;
use crate::direct::{DirectSpec, carrier_polynomials};
use crate::planar::Planar;
use crate::rows::norm;
use crate::simd::spread::{SpreadRow, spread_row, step};
use crate::simd::{MAX_LANES, SimdLevel, dispatch};
use crate::table::RangeTable;
use crate::weights::Weights;
use crate::{Pulses, Spreading, reference};
use num_complex::Complex64;
use rayon::prelude::*;
use std::f64::consts::PI;
use std::ops::Range;

/// Pulses that take a row of pixels while it stays in the first-level cache.
const CHUNK: usize = 4;
/// Pixels after which single-precision bins are emptied into double precision.
const EMPTY_AFTER: usize = 1 << 16;

/// Bins and polynomials, ready for any number of images.
pub(crate) struct Spreader {
    spec: DirectSpec,
    weights: Weights,
    level: SimdLevel,
    first_bin: Vec<i64>,
    entries: usize,
    cosine: [f32; 4],
    sine: [f32; 4],
    finish: BinsToSpectrum,
}

impl Spreader {
    pub fn new(
        pulses: &Pulses,
        ranges_m: &[[f64; 2]],
        spec: DirectSpec,
        weights: &Weights,
        level: SimdLevel,
    ) -> Self {
        let first_bin = RangeTable::first_bins(&spec.table, ranges_m);
        let entries = RangeTable::stride_for(&spec.table, ranges_m);
        let (cosine, sine) = carrier_polynomials(spec.table.carrier_rad(pulses), spec.fine_carrier);
        let first = first_bin.iter().copied().min().unwrap_or(0);
        let last = first_bin.iter().copied().max().unwrap_or(0) + entries as i64;
        Self {
            finish: BinsToSpectrum::new(pulses, spec.table, weights, first, last),
            spec,
            weights: weights.clone(),
            level,
            first_bin,
            entries,
            cosine,
            sine,
        }
    }

    /// Bytes that a working thread takes.
    pub fn bytes_a_thread(spec: &DirectSpec, ranges_m: &[[f64; 2]]) -> u128 {
        let entries = RangeTable::stride_for(&spec.table, ranges_m) as u128;
        entries * step(spec.table.degree) as u128 * (4 + 8) * CHUNK as u128
    }

    /// Adds to `out` `[which.len(), N]` what the pulses `which` see of the `parts`.
    pub fn run(
        &self,
        pulses: &Pulses,
        which: Range<usize>,
        parts: &[Planar],
        out: &mut [Complex64],
        done: &(dyn Fn(u64) + Sync),
    ) {
        let n = pulses.frequency_hz().len();
        let step = step(self.spec.table.degree);
        let length = self.entries * step;
        out.par_chunks_mut(CHUNK * n).enumerate().for_each_init(
            || (vec![0f32; CHUNK * length], vec![0f64; CHUNK * length]),
            |(bins, sums), (chunk, out)| {
                let first = which.start + chunk * CHUNK;
                let count = out.len() / n;
                bins.fill(0.0);
                sums.fill(0.0);
                let empty = |bins: &mut [f32], sums: &mut [f64]| {
                    for (sum, v) in sums.iter_mut().zip(bins) {
                        *sum += f64::from(std::mem::take(v));
                    }
                };
                let mut pixels = 0;
                for part in parts {
                    for row in 0..part.grid.rows {
                        for (m, (bins, out)) in bins
                            .chunks_exact_mut(length)
                            .zip(out.chunks_exact_mut(n))
                            .enumerate()
                        {
                            self.row(pulses, first + m, part, row, bins, out);
                        }
                        pixels += part.grid.columns;
                        if pixels >= EMPTY_AFTER {
                            empty(bins, sums);
                            pixels = 0;
                        }
                    }
                    done((part.grid.rows * part.grid.columns * count) as u64);
                }
                empty(bins, sums);
                for (m, (sums, out)) in sums
                    .chunks_exact(length)
                    .zip(out.chunks_exact_mut(n))
                    .enumerate()
                {
                    let pulse = first + m;
                    let start = self.first_bin[pulse];
                    self.finish.add(pulses, pulse, start, sums, step, out);
                }
            },
        );
    }

    fn row(
        &self,
        pulses: &Pulses,
        pulse: usize,
        part: &Planar,
        row: usize,
        bins: &mut [f32],
        out: &mut [Complex64],
    ) {
        let antenna = pulses.position_m()[pulse];
        let start = part.grid.point_m(0.0, row as f64);
        let pixel_m = norm(part.grid.u_m).max(1e-12);
        let at = row * part.stride;
        let (real, imag) = (
            &part.real[at..at + part.stride],
            &part.imag[at..at + part.stride],
        );
        // Single precision carries ranges from a segment's centre to its ends.
        let tolerance_bins = self.spec.phase_tolerance_rad / self.spec.table.carrier_rad(pulses);
        let reach_bins = 32.0 * pixel_m / self.spec.table.bin_m * f64::from(f32::EPSILON);
        let job = SpreadRow {
            from_antenna_m: std::array::from_fn(|a| start[a] - antenna[a]),
            unit: part.grid.u_m.map(|u| u / pixel_m),
            pixel_m,
            real,
            imag,
            segment: if reach_bins < 0.2 * tolerance_bins {
                4 * MAX_LANES
            } else {
                MAX_LANES
            },
            bin_m: self.spec.table.bin_m,
            first_bin: self.first_bin[pulse],
            plain_below_m: match self.weights.spreading {
                Spreading::InverseSquare => self.spec.plain_below_m,
                Spreading::None => 0.0,
            },
            cosine: self.cosine,
            sine: self.sine,
        };
        let mut plain = |columns: Range<usize>| {
            for i in columns.start..columns.end.min(part.grid.columns) {
                let value = Complex64::new(f64::from(real[i]), f64::from(imag[i]));
                let point = part.grid.point_m(i as f64, row as f64);
                add_plain(pulses, pulse, point, &self.weights, value, out);
            }
        };
        dispatch!(self.level, s => match (self.spec.table.degree, self.spec.fine_carrier) {
            (1, false) => spread_row::<_, 1, 3>(s, &job, bins, &mut plain),
            (1, true) => spread_row::<_, 1, 4>(s, &job, bins, &mut plain),
            (2, _) => spread_row::<_, 2, 4>(s, &job, bins, &mut plain),
            _ => spread_row::<_, 3, 4>(s, &job, bins, &mut plain),
        });
    }
}

/// Adds the spectrum of one scatterer, Eq. (1) in double precision, times the pulse's weight.
pub(crate) fn add_plain(
    pulses: &Pulses,
    pulse: usize,
    point: [f64; 3],
    weights: &Weights,
    value: Complex64,
    out: &mut [Complex64],
) {
    const RENEW: usize = 32;
    let range = reference::range_m(pulses.position_m()[pulse], point);
    let amplitude = value * (pulses.weight()[pulse] * weights.at(pulse, range));
    let delay = 4.0 * PI * range / pulses.light_speed_m_s();
    let f = pulses.frequency_hz();
    let Some(step) = pulses.frequency_step_hz() else {
        for (e, f) in out.iter_mut().zip(f) {
            *e += amplitude * Complex64::cis(-f * delay);
        }
        return;
    };
    let turn = Complex64::cis(-step * delay);
    for (out, f) in out.chunks_mut(RENEW).zip(f.chunks(RENEW)) {
        let mut phasor = amplitude * Complex64::cis(-f[0] * delay);
        for e in out {
            *e += phasor;
            phasor *= turn;
        }
    }
}
