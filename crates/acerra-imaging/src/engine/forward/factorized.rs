//! The transposed factorized engine: the fine image is split into coarse ones, one a sub-aperture,
//! whose pixels the transposed direct engine adds to range bins.

use super::direct::DirectForward;
use super::filling::Echo;
use crate::control::Meter;
use crate::engine::direct::DirectSpec;
use crate::engine::factorized::aperture::{centre_m, partition_aperture};
use crate::engine::factorized::cell::Cell;
use crate::engine::factorized::coarse::Coarse;
use crate::engine::factorized::lattice::Lattice;
use crate::engine::factorized::spec::FactorizedSpec;
use crate::engine::planar::{Planar, padded};
use crate::engine::weights::WeightedPulses;
use crate::grid::tilted::TiltedGrid;
use crate::kernel::dispatch::dispatch;
use crate::kernel::level::SimdLevel;
use crate::kernel::merge::MOST_TAPS;
use crate::kernel::phase::apply_phase;
use crate::kernel::split::{Share, SplitRow, split_row, split_scratch};
use num_complex::Complex32;
use rayon::prelude::*;
use std::ops::Range;

/// Coarse rows that are filled as one piece of work.
const STRIPE: usize = 96;

/// Weights and bins, ready for any number of images.
pub(crate) struct FactorizedForward {
    pub lattice: Lattice,
    /// Weights of the pixels along the row in each sample of a cell.
    shares: Vec<Vec<Share>>,
    direct: DirectForward,
    level: SimdLevel,
}

/// A fine image for splitting: rows with pixels `interval` apart side by side,
/// `[rows, interval, intervals]`.
struct Fine<'a> {
    grid: &'a TiltedGrid,
    intervals: usize,
    real: Vec<f32>,
    imag: Vec<f32>,
}

impl FactorizedForward {
    pub fn new(
        echoes: &WeightedPulses,
        grid: &TiltedGrid,
        ranges_m: &[[f64; 2]],
        (spec, direct): (FactorizedSpec, DirectSpec),
        level: SimdLevel,
    ) -> Self {
        let carrier_hz = echoes.pulses.frequency_hz()[direct.table.carrier];
        let lattice = Lattice::new(&echoes.pulses, grid, spec.outer, carrier_hz);
        let Coarse { cells, taps } = spec.outer.coarse;
        Self {
            shares: shares(cells[0], taps, &lattice.weights[0]),
            lattice,
            direct: DirectForward::new(echoes, ranges_m, direct, level),
            level,
        }
    }

    /// The sub-apertures.
    pub fn parts(&self, echoes: &WeightedPulses) -> Vec<Range<usize>> {
        partition_aperture(&echoes.pulses, self.lattice.stage.pulses)
    }

    /// The engine that takes the coarse images, and its bins.
    pub fn direct(&self) -> &DirectForward {
        &self.direct
    }

    /// Adds to `echo` the spectra of an image on a grid as the pulses `which`, whole sub-apertures, see it.
    /// After cancellation `echo` is incomplete.
    pub fn run_on(
        &self,
        echoes: &WeightedPulses,
        which: &Range<usize>,
        (grid, image): (&TiltedGrid, &[Complex32]),
        echo: Echo,
        meter: &Meter,
    ) {
        let stage = &self.lattice.stage;
        let coarse = TiltedGrid {
            columns: stage.coarse.row_samples(grid),
            ..stage.coarse.grid(grid)
        };
        let intervals = stage.coarse.padded_cells(grid);
        let (real, imag) = by_phase(image, grid.columns, stage.coarse.cells[0].pixels, intervals);
        let fine = Fine {
            grid,
            intervals,
            real,
            imag,
        };
        let lengths = [
            self.direct.bins_of_pulse(),
            echoes.pulses.frequency_hz().len(),
        ];
        let mut rest = echo;
        let mut work = Vec::new();
        for part in self.parts(echoes) {
            if which.start <= part.start && part.end <= which.end {
                let (own, after) = rest.split(part.len(), lengths);
                work.push((own, part));
                rest = after;
            }
        }
        work.into_par_iter().for_each(|(echo, part)| {
            let centre = centre_m(&echoes.pulses, part.clone());
            let stride = padded(coarse.columns);
            let mut coarse_re = vec![0f32; stride * coarse.rows];
            let mut coarse_im = vec![0f32; stride * coarse.rows];
            coarse_re
                .par_chunks_mut(STRIPE * stride)
                .zip(coarse_im.par_chunks_mut(STRIPE * stride))
                .enumerate()
                .for_each(|(k, stripe)| {
                    if !meter.is_cancelled() {
                        self.split_stripe(&fine, &coarse, (k * STRIPE, centre), stripe);
                    }
                });
            let planar = Planar {
                grid: coarse,
                stride,
                real: &coarse_re,
                imag: &coarse_im,
            };
            let silent = Meter::silent(meter.control());
            self.direct
                .add(echoes, part.clone(), &planar, echo, &silent);
            meter.add((grid.columns * grid.rows * part.len()) as u64);
        });
    }

    /// Fills coarse rows from row `first` on, for the sub-aperture centred at `centre`.
    fn split_stripe(
        &self,
        fine: &Fine,
        coarse: &TiltedGrid,
        (first, centre): (usize, [f64; 3]),
        (stripe_re, stripe_im): (&mut [f32], &mut [f32]),
    ) {
        let (grid, intervals) = (fine.grid, fine.intervals);
        let Coarse {
            cells: [along, across],
            taps,
        } = self.lattice.stage.coarse;
        let dx = along.pixels;
        let stride = padded(coarse.columns);
        let rows = stripe_re.len() / stride;
        // Rows before and after the stripe are filled only in part, and are dropped.
        let length = (rows + 2 * taps) * coarse.columns;
        let (mut re, mut im) = (vec![0f32; length], vec![0f32; length]);
        let mut scratch = vec![0f32; split_scratch(dx, intervals)];
        let cell_of = |sample: usize| sample / across.samples;
        let from = cell_of((first + 1).saturating_sub(taps)) * across.pixels;
        let to = ((cell_of(first + rows) + 1) * across.pixels).min(grid.rows);
        for j in from..to {
            let (cell, phase) = (j / across.pixels, j % across.pixels);
            // The first coarse row to which this row contributes.
            let sample = cell * across.samples + across.sample_before(phase);
            if sample + taps <= first || sample >= first + rows {
                continue;
            }
            let job = SplitRow {
                phase: self.lattice.phase_row(grid, j, centre),
                pixels: dx,
                shares: &self.shares,
                across: &self.lattice.weights[1][phase][..taps],
                intervals: grid.columns.div_ceil(dx),
                padded: intervals,
            };
            let row = j * dx * intervals..(j + 1) * dx * intervals;
            let fine = (&fine.real[row.clone()], &fine.imag[row]);
            let at = (sample + taps - first) * coarse.columns;
            let rows = at..at + taps * coarse.columns;
            let to = (&mut re[rows.clone()], &mut im[rows]);
            dispatch!(self.level, s => split_row(s, &job, fine, &mut scratch, to));
        }
        for (row, (to_re, to_im)) in stripe_re
            .chunks_exact_mut(stride)
            .zip(stripe_im.chunks_exact_mut(stride))
            .enumerate()
        {
            let at = (row + taps) * coarse.columns;
            let columns = at..at + coarse.columns;
            in_order(&re[columns.clone()], along.samples, to_re);
            in_order(&im[columns], along.samples, to_im);
            let job = self.lattice.phase_row(coarse, first + row, centre);
            dispatch!(self.level, s => apply_phase(s, &job, false, to_re, to_im));
        }
    }
}

/// Copies a row that holds the first sample of every cell, then the second of every cell, and so on, in the order of
/// the samples in space.
fn in_order(sorted: &[f32], samples: usize, out: &mut [f32]) {
    if samples == 1 {
        return out[..sorted.len()].copy_from_slice(sorted);
    }
    for (first, line) in sorted.chunks_exact(sorted.len() / samples).enumerate() {
        for (to, from) in out[first..].iter_mut().step_by(samples).zip(line) {
            *to = *from;
        }
    }
}

/// Weights of the pixels in each sample of a cell, the transpose of the interpolation weights.
fn shares(cell: Cell, taps: usize, weights: &[[f32; MOST_TAPS]]) -> Vec<Vec<Share>> {
    let mut shares = vec![Vec::new(); cell.samples];
    for (pixel, weights) in weights.iter().enumerate() {
        for (k, weight) in weights.iter().enumerate().take(taps) {
            let sample = cell.sample_before(pixel) + k;
            shares[sample % cell.samples].push(Share {
                pixel,
                cells: sample / cell.samples,
                weight: *weight,
            });
        }
    }
    shares
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
