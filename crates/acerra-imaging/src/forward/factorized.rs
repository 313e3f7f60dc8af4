//! The transposed factorized engine: the fine image is split off to coarse ones, a sub-aperture each,
//! whose pixels the transposed direct engine spreads over bins.

use super::direct::Spreader;
use crate::Pulses;
use crate::direct::{DirectSpec, table_ranges_m};
use crate::factorized::{FactorizedSpec, Lattice, TAPS, centre_m, coarse_grid, cut};
use crate::planar::{Planar, padded};
use crate::rows::TiltedGrid;
use crate::simd::split::{SplitRow, split_row};
use crate::simd::turn::turn_row;
use crate::simd::{SimdLevel, dispatch};
use crate::weights::Weights;
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;

/// Coarse rows that are filled as one piece of work.
const STRIPE: usize = 96;

/// Weights and bins, ready for any number of images.
pub(crate) struct FactorizedForward {
    pub lattice: Lattice,
    spreader: Spreader,
    level: SimdLevel,
}

impl FactorizedForward {
    pub fn new(
        pulses: &Pulses,
        grid: &TiltedGrid,
        spec: FactorizedSpec,
        direct: DirectSpec,
        weights: &Weights,
        level: SimdLevel,
    ) -> Self {
        let ranges_m = table_ranges_m(pulses, &coarse_grid(grid, spec.coarse));
        let carrier_hz = pulses.frequency_hz()[direct.table.carrier];
        Self {
            lattice: Lattice::new(pulses, grid, spec, carrier_hz),
            spreader: Spreader::new(pulses, &ranges_m, direct, weights, level),
            level,
        }
    }

    /// Adds to `out` `[M, N]` what all pulses see of `image` on `grid`.
    pub fn run(
        &self,
        pulses: &Pulses,
        grid: &TiltedGrid,
        image: &[Complex32],
        out: &mut [Complex64],
        done: &(dyn Fn(u64) + Sync),
    ) {
        let spec = &self.lattice.spec;
        let [dx, dy] = spec.coarse;
        let coarse = coarse_grid(grid, spec.coarse);
        let intervals = coarse.columns - TAPS;
        let (real, imag) = by_phase(image, grid.columns, dx, intervals);
        let parts = cut(pulses, spec.pulses);
        let n = pulses.frequency_hz().len();
        let mut rest = out;
        let mut work = Vec::with_capacity(parts.len());
        for part in parts {
            let (own, after) = rest.split_at_mut(part.len() * n);
            work.push((own, part));
            rest = after;
        }
        work.into_par_iter().for_each(|(out, part)| {
            let centre = centre_m(pulses, part.clone());
            let stride = padded(coarse.columns);
            let mut coarse_re = vec![0f32; stride * coarse.rows];
            let mut coarse_im = vec![0f32; stride * coarse.rows];
            coarse_re
                .par_chunks_mut(STRIPE * stride)
                .zip(coarse_im.par_chunks_mut(STRIPE * stride))
                .enumerate()
                .for_each(|(k, (stripe_re, stripe_im))| {
                    let first = k * STRIPE;
                    let rows = stripe_re.len() / stride;
                    // Rows before the stripe and after it are filled in part, and left out.
                    let length = (rows + 2 * TAPS) * coarse.columns;
                    let (mut re, mut im) = (vec![0f32; length], vec![0f32; length]);
                    let mut scratch = vec![0f32; 2 * dx * (intervals + 2 * TAPS)];
                    let from = (first + 1).saturating_sub(TAPS) * dy;
                    let to = ((first + rows) * dy).min(grid.rows);
                    for j in from..to {
                        let (cell, phase) = (j / dy, j % dy);
                        let job = SplitRow {
                            turn: self.lattice.turn(grid, j, centre),
                            weights: &self.lattice.weights[0],
                            across: self.lattice.weights[1][phase],
                            intervals: grid.columns.div_ceil(dx),
                        };
                        let row = j * dx * intervals..(j + 1) * dx * intervals;
                        let fine = (&real[row.clone()], &imag[row]);
                        let at = (cell + TAPS - first) * coarse.columns;
                        let rows = at..at + TAPS * coarse.columns;
                        let to = (&mut re[rows.clone()], &mut im[rows]);
                        dispatch!(self.level, s => {
                            split_row(s, &job, intervals, fine, &mut scratch, to)
                        });
                    }
                    for (row, (to_re, to_im)) in stripe_re
                        .chunks_exact_mut(stride)
                        .zip(stripe_im.chunks_exact_mut(stride))
                        .enumerate()
                    {
                        let at = (row + TAPS) * coarse.columns;
                        let columns = at..at + coarse.columns;
                        to_re[..coarse.columns].copy_from_slice(&re[columns.clone()]);
                        to_im[..coarse.columns].copy_from_slice(&im[columns]);
                        let job = self.lattice.turn(&coarse, first + row, centre);
                        dispatch!(self.level, s => turn_row(s, &job, false, to_re, to_im));
                    }
                });
            let planar = Planar {
                grid: coarse,
                stride,
                real: &coarse_re,
                imag: &coarse_im,
            };
            self.spreader
                .run(pulses, part.clone(), &[planar], out, &|_| ());
            done((grid.columns * grid.rows * part.len()) as u64);
        });
    }
}

/// Rows of an image with pixels `interval` apart side by side, `[rows, interval, intervals]`, real and
/// imaginary.
fn by_phase(
    image: &[Complex32],
    columns: usize,
    interval: usize,
    intervals: usize,
) -> (Vec<f32>, Vec<f32>) {
    let stride = interval * intervals;
    let length = image.len() / columns.max(1) * stride;
    let (mut real, mut imag) = (vec![0f32; length], vec![0f32; length]);
    real.par_chunks_mut(stride)
        .zip(imag.par_chunks_mut(stride))
        .zip(image.par_chunks(columns))
        .for_each(|((real, imag), row)| {
            for (q, cell) in row.chunks(interval).enumerate() {
                for (p, v) in cell.iter().enumerate() {
                    real[p * intervals + q] = v.re;
                    imag[p * intervals + q] = v.im;
                }
            }
        });
    (real, imag)
}
