//! The factorized engine: sub-apertures imaged on coarse grids, then merged.
//!
//! Neighbouring pulses look at a pixel from nearly the same direction. Once the carrier's phase of
//! the range to a sub-aperture's centre is taken out, what its pulses add up to varies slowly over
//! the image: its spatial frequencies are bounded by (2/c)·|f·u_m − f_c·u_s|, u being the unit
//! vectors from pulse and centre to the pixel projected on the grid's axes. The direct engine
//! images each sub-aperture on a grid just fine enough for that; rows of the fine grid follow by
//! separable least-squares interpolation, and get their phase back. Any trajectory and any height
//! will do: a scattered track merely has a wide bound, and is left to the direct engine.

mod estimate;
mod interpolation;
mod lattice;
mod spec;

pub(crate) use interpolation::TAPS;
pub(crate) use lattice::{Lattice, coarse_bytes, coarse_grid};
pub(crate) use spec::{FactorizedSpec, centre_m, cut};

use crate::Pulses;
use crate::direct::{Direct, DirectSpec, table_ranges_m};
use crate::planar::{padded, split_parts};
use crate::rows::TiltedGrid;
use crate::simd::merge::{MergeRow, merge_row};
use crate::simd::turn::turn_row;
use crate::simd::{SimdLevel, dispatch};
use crate::weights::Weights;
use num_complex::Complex32;
use rayon::prelude::*;
use std::ops::Range;

/// Everything that does not depend on the pixels: tables of the direct engine and weights.
#[derive(Debug)]
pub(crate) struct Factorized {
    pub lattice: Lattice,
    direct: Direct,
    level: SimdLevel,
}

/// A sub-aperture's coarse image, real and imaginary, and its phase centre.
struct Coarse {
    centre_m: [f64; 3],
    real: Vec<f32>,
    imag: Vec<f32>,
}

impl Factorized {
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
            direct: Direct::new(pulses, &ranges_m, direct, weights, level),
            level,
        }
    }

    /// Images `grid` (or a piece of the grid that the plan was made for) into `out`.
    pub fn run(
        &self,
        pulses: &Pulses,
        weights: &Weights,
        grid: &TiltedGrid,
        out: &mut [Complex32],
        done: &(dyn Fn(u64) + Sync),
    ) {
        let spec = &self.lattice.spec;
        let coarse = coarse_grid(grid, spec.coarse);
        let parts = cut(pulses, spec.pulses);
        let images: Vec<Coarse> = parts
            .par_iter()
            .map(|part| self.coarse_image(pulses, weights, &coarse, part))
            .collect();
        self.merge(&images, &coarse, grid, out, done);
    }

    /// The image of the pulses `part` on the coarse grid or some of its rows, without the phase of the
    /// range to their centre.
    fn coarse_image(
        &self,
        pulses: &Pulses,
        weights: &Weights,
        coarse: &TiltedGrid,
        part: &Range<usize>,
    ) -> Coarse {
        let centre = centre_m(pulses, part.clone());
        let stride = padded(coarse.columns);
        let mut image = vec![Complex32::ZERO; coarse.columns * coarse.rows];
        self.direct
            .run_pulses(pulses, part.clone(), weights, coarse, &mut image, &|_| ());
        let (mut real, mut imag) = split_parts(&image, coarse.columns);
        real.par_chunks_mut(stride)
            .zip(imag.par_chunks_mut(stride))
            .enumerate()
            .for_each(|(j, (real, imag))| {
                let job = self.lattice.turn(coarse, j, centre);
                dispatch!(self.level, s => turn_row(s, &job, true, real, imag));
            });
        Coarse {
            centre_m: centre,
            real,
            imag,
        }
    }

    /// Adds up all coarse images on `grid`.
    fn merge(
        &self,
        images: &[Coarse],
        coarse: &TiltedGrid,
        grid: &TiltedGrid,
        out: &mut [Complex32],
        done: &(dyn Fn(u64) + Sync),
    ) {
        let stride = padded(coarse.columns);
        let [dx, dy] = self.lattice.spec.coarse;
        let intervals = coarse.columns - TAPS;
        let line_length = 2 * coarse.columns;
        let row_length = dx * intervals;
        // A cell of rows at a time: they share their coarse rows, which then stay in the cache.
        out.par_chunks_mut(grid.columns * dy)
            .enumerate()
            .for_each_init(
                || vec![0f32; line_length + 2 * dy * row_length],
                |scratch, (cell, out)| {
                    let (line, sums) = scratch.split_at_mut(line_length);
                    sums.fill(0.0);
                    for image in images {
                        for (phase, sums) in sums
                            .chunks_exact_mut(2 * row_length)
                            .enumerate()
                            .take(out.len() / grid.columns)
                        {
                            let (real, imag) = sums.split_at_mut(row_length);
                            let job = MergeRow {
                                turn: self.lattice.turn(grid, cell * dy + phase, image.centre_m),
                                rows: std::array::from_fn(|k| {
                                    let at = (cell + k) * stride;
                                    let end = at + coarse.columns;
                                    (
                                        &image.real[at..end],
                                        &image.imag[at..end],
                                        self.lattice.weights[1][phase][k],
                                    )
                                }),
                                weights: &self.lattice.weights[0],
                                intervals: grid.columns.div_ceil(dx),
                            };
                            dispatch!(self.level, s => {
                                merge_row(s, &job, intervals, line, real, imag)
                            });
                        }
                    }
                    for (row, sums) in out
                        .chunks_exact_mut(grid.columns)
                        .zip(sums.chunks_exact(2 * row_length))
                    {
                        let (real, imag) = sums.split_at(row_length);
                        for (q, cell) in row.chunks_mut(dx).enumerate() {
                            for (p, v) in cell.iter_mut().enumerate() {
                                let at = p * intervals + q;
                                *v = Complex32::new(real[at], imag[at]);
                            }
                        }
                    }
                    done(out.len() as u64);
                },
            );
    }
}
