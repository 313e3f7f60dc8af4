//! The direct engine: every pulse summed at every pixel.

use crate::rows::{TiltedGrid, norm};
use crate::simd::rows::{Band, Job, Tally, band, block_width, tile_rows};
use crate::simd::surface::{Relief, surface_band};
use crate::simd::{SimdLevel, dispatch};
use crate::table::{RangeTable, TableSpec};
use crate::weights::Weights;
use crate::{Pulses, Spreading, reference};
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Mutex;

/// Columns by which ranges are widened so that the last vector of a row stays inside the table.
pub(crate) const MARGIN_COLUMNS: f64 = 16.0; // a vector, or two of eight

/// What of the accuracy each approximation may take, chosen once for a plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DirectSpec {
    pub table: TableSpec,
    /// Four trigonometric coefficients instead of three.
    pub fine_carrier: bool,
    /// Third order of the range within a vector.
    pub cubic: bool,
    /// Phase error that the range expansion may make, rad.
    pub phase_tolerance_rad: f64,
    /// See [`TableSpec::folding_range_m`].
    pub plain_below_m: f64,
}

/// Antenna positions and table, ready for any number of runs.
#[derive(Debug)]
pub(crate) struct Direct {
    spec: DirectSpec,
    level: SimdLevel,
    antenna_m: [Vec<f64>; 3],
    table: RangeTable,
    cosine: [f32; 4],
    sine: [f32; 4],
}

/// Least and greatest range of every pulse that imaging `grid` may ask for.
pub(crate) fn table_ranges_m(pulses: &Pulses, grid: &TiltedGrid) -> Vec<[f64; 2]> {
    pulses
        .position_m()
        .iter()
        .map(|p| grid.ranges_m(*p, MARGIN_COLUMNS))
        .collect()
}

impl Direct {
    pub fn new(
        pulses: &Pulses,
        ranges_m: &[[f64; 2]],
        spec: DirectSpec,
        weights: &Weights,
        level: SimdLevel,
    ) -> Self {
        let table = RangeTable::build(pulses, spec.table, ranges_m, weights);
        let (cosine, sine) = carrier_polynomials(table.carrier_rad, spec.fine_carrier);
        Self {
            spec,
            level,
            antenna_m: std::array::from_fn(|a| pulses.position_m().iter().map(|p| p[a]).collect()),
            table,
            cosine,
            sine,
        }
    }

    /// Turn of the carrier across a bin, rad.
    pub fn carrier_rad(&self) -> f64 {
        self.table.carrier_rad
    }

    /// Images `grid` from the pulses `which` into `out` `[rows, columns]`; `done` hears of every
    /// finished share of pixels.
    pub fn run_pulses(
        &self,
        pulses: &Pulses,
        which: Range<usize>,
        weights: &Weights,
        grid: &TiltedGrid,
        out: &mut [Complex32],
        done: &(dyn Fn(u64) + Sync),
    ) -> Tally {
        self.run_over(pulses, which, weights, grid, None, out, done)
    }

    /// As [`Direct::run_pulses`], with heights over the grid.
    #[allow(clippy::too_many_arguments)]
    pub fn run_over(
        &self,
        pulses: &Pulses,
        which: Range<usize>,
        weights: &Weights,
        grid: &TiltedGrid,
        relief: Option<Relief>,
        out: &mut [Complex32],
        done: &(dyn Fn(u64) + Sync),
    ) -> Tally {
        let plain = |pulse: usize, point: [f64; 3]| -> Complex64 {
            let range = reference::range_m(pulses.position_m()[pulse], point);
            reference::pulse_at_range(pulses, pulse, range)
                * (pulses.weight()[pulse] * weights.at(pulse, range))
        };
        let pixel_m = norm(grid.u_m).max(1e-12);
        let tolerance_bins = self.spec.phase_tolerance_rad / self.table.carrier_rad;
        let half_block_m = 0.5 * pixel_m * block_width(self.level.lanes()) as f64;
        let job = Job {
            pulses: which,
            near_centre: half_block_m / self.table.spec.bin_m * f64::from(f32::EPSILON)
                < 0.2 * tolerance_bins,
            antenna_m: [&self.antenna_m[0], &self.antenna_m[1], &self.antenna_m[2]],
            table: &self.table,
            cosine: self.cosine,
            sine: self.sine,
            pixel_m,
            tolerance_bins,
            plain_below_m: match weights.spreading {
                Spreading::InverseSquare => self.spec.plain_below_m,
                Spreading::None => 0.0,
            },
            plain: &plain,
        };
        let tally = Mutex::new(Tally::default());
        let share = |(i, j): (usize, usize), columns: usize, out: &mut [Complex32]| {
            let one = Band {
                origin_m: grid.point_m(i as f64, j as f64),
                u_m: grid.u_m,
                v_m: grid.v_m,
                columns,
                rows: out.len() / columns,
            };
            let relief = relief.map(|r| r.seen_from(i, j));
            let counted = self.band(&job, &one, relief, out);
            if let Ok(mut sum) = tally.lock() {
                sum.add(counted);
            }
            done(out.len() as u64);
        };
        let height = tile_rows(self.level.lanes());
        if grid.rows >= 2 * height {
            out.par_chunks_mut(height * grid.columns)
                .enumerate()
                .for_each(|(k, out)| {
                    share((0, k * height), grid.columns, out);
                });
        } else {
            // Few rows: share out pieces of rows.
            let piece = 2 * block_width(self.level.lanes());
            out.par_chunks_mut(grid.columns)
                .enumerate()
                .for_each(|(j, row)| {
                    row.par_chunks_mut(piece).enumerate().for_each(|(k, out)| {
                        share((k * piece, j), out.len(), out);
                    });
                });
        }
        tally.into_inner().unwrap_or_default()
    }

    fn band(&self, job: &Job, one: &Band, relief: Option<Relief>, out: &mut [Complex32]) -> Tally {
        let quality = (
            self.spec.table.degree,
            self.spec.fine_carrier,
            self.spec.cubic,
        );
        if let Some(relief) = relief {
            return dispatch!(self.level, s => match quality {
                (1, false, false) => surface_band::<_, 1, 3, false>(s, job, one, relief, out),
                (1, false, true) => surface_band::<_, 1, 3, true>(s, job, one, relief, out),
                (1, _, _) => surface_band::<_, 1, 4, true>(s, job, one, relief, out),
                (2, _, _) => surface_band::<_, 2, 4, true>(s, job, one, relief, out),
                _ => surface_band::<_, 3, 4, true>(s, job, one, relief, out),
            });
        }
        dispatch!(self.level, s => match quality {
            (1, false, false) => band::<_, 1, 3, false>(s, job, one, out),
            (1, false, true) => band::<_, 1, 3, true>(s, job, one, out),
            (1, _, _) => band::<_, 1, 4, true>(s, job, one, out),
            (2, _, _) => band::<_, 2, 4, true>(s, job, one, out),
            _ => band::<_, 3, 4, true>(s, job, one, out),
        })
    }
}

/// Polynomials in δ² of cos αδ and sin(αδ)/δ over |δ| ≤ ½; the sine's has a term less.
pub(crate) fn carrier_polynomials(carrier_rad: f64, fine: bool) -> ([f32; 4], [f32; 4]) {
    let terms = if fine { 4 } else { 3 };
    (
        even_polynomial(|d| (carrier_rad * d).cos(), terms),
        even_polynomial(|d| (carrier_rad * d).sin() / d, terms - 1),
    )
}

/// The polynomial in x² of an even function on |x| ≤ ½, by interpolation at Chebyshev nodes.
pub(crate) fn even_polynomial<const N: usize>(f: impl Fn(f64) -> f64, terms: usize) -> [f32; N] {
    // Newton's divided differences in q = x² ∈ [0, ¼], then expanded into powers.
    let node = |k: usize| {
        let angle = std::f64::consts::PI * (k as f64 + 0.5) / terms as f64;
        0.125 * (1.0 + angle.cos())
    };
    let mut divided: Vec<f64> = (0..terms).map(|k| f(node(k).sqrt())).collect();
    for order in 1..terms {
        for k in (order..terms).rev() {
            divided[k] = (divided[k] - divided[k - 1]) / (node(k) - node(k - order));
        }
    }
    let mut powers = [0.0; N];
    for k in (0..terms).rev() {
        for p in (1..N).rev() {
            powers[p] = powers[p - 1] - node(k) * powers[p];
        }
        powers[0] = divided[k] - node(k) * powers[0];
    }
    powers.map(|p| p as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn carrier_polynomials_are_close() {
        for (fine, bound) in [(false, 3e-3), (true, 4e-5)] {
            let (cosine, sine) = carrier_polynomials(2.4, fine);
            for k in 0..=100 {
                let d = k as f32 / 100.0 - 0.5;
                let q = d * d;
                let at = |c: [f32; 4]| c[0] + q * (c[1] + q * (c[2] + q * c[3]));
                assert!((at(cosine) - (2.4 * d).cos()).abs() < bound);
                assert!((at(sine) * d - (2.4 * d).sin()).abs() < bound);
            }
        }
    }
}
