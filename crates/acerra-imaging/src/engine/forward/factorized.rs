//! The transposed factorized engine: the fine image is split into coarse ones, one a sub-aperture,
//! whose pixels the transposed direct engine adds to range bins.

use super::direct::DirectForward;
use super::filling::Echo;
use crate::control::Meter;
use crate::engine::direct::DirectSpec;
use crate::engine::factorized::aperture::{centre_m, partition_aperture};
use crate::engine::factorized::coarse::coarse_grid;
use crate::engine::factorized::lattice::Lattice;
use crate::engine::factorized::spec::FactorizedSpec;
use crate::engine::planar::{Planar, padded};
use crate::engine::weights::WeightedPulses;
use crate::grid::tilted::TiltedGrid;
use crate::kernel::dispatch::dispatch;
use crate::kernel::level::SimdLevel;
use crate::kernel::merge::TAPS;
use crate::kernel::phase::apply_phase;
use crate::kernel::split::{SplitRow, split_row};
use num_complex::Complex32;
use rayon::prelude::*;
use std::ops::Range;

/// Coarse rows that are filled as one piece of work.
const STRIPE: usize = 96;

/// Weights and bins, ready for any number of images.
pub(crate) struct FactorizedForward {
    pub lattice: Lattice,
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
        Self {
            lattice: Lattice::new(&echoes.pulses, grid, spec, carrier_hz),
            direct: DirectForward::new(echoes, ranges_m, direct, level),
            level,
        }
    }

    /// The sub-apertures.
    pub fn parts(&self, echoes: &WeightedPulses) -> Vec<Range<usize>> {
        partition_aperture(&echoes.pulses, self.lattice.spec.pulses)
    }

    /// The engine that takes the coarse images, and its bins.
    pub fn direct(&self) -> &DirectForward {
        &self.direct
    }

    /// Adds to `echo` what the pulses `which`, whole sub-apertures, see of an image on a grid. After cancellation it
    /// is incomplete.
    pub fn run_on(
        &self,
        echoes: &WeightedPulses,
        which: &Range<usize>,
        (grid, image): (&TiltedGrid, &[Complex32]),
        echo: Echo,
        meter: &Meter,
    ) {
        let spec = &self.lattice.spec;
        let coarse = coarse_grid(grid, spec.coarse);
        let intervals = coarse.columns - TAPS;
        let (real, imag) = by_phase(image, grid.columns, spec.coarse[0], intervals);
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
        let [dx, dy] = self.lattice.spec.coarse;
        let stride = padded(coarse.columns);
        let rows = stripe_re.len() / stride;
        // Rows before the stripe and after it are filled in part, and dropped.
        let length = (rows + 2 * TAPS) * coarse.columns;
        let (mut re, mut im) = (vec![0f32; length], vec![0f32; length]);
        let mut scratch = vec![0f32; 2 * dx * (intervals + 2 * TAPS)];
        let from = (first + 1).saturating_sub(TAPS) * dy;
        let to = ((first + rows) * dy).min(grid.rows);
        for j in from..to {
            let (cell, phase) = (j / dy, j % dy);
            let job = SplitRow {
                phase: self.lattice.phase_row(grid, j, centre),
                weights: &self.lattice.weights[0],
                across: self.lattice.weights[1][phase],
                intervals: grid.columns.div_ceil(dx),
                padded: intervals,
            };
            let row = j * dx * intervals..(j + 1) * dx * intervals;
            let fine = (&fine.real[row.clone()], &fine.imag[row]);
            let at = (cell + TAPS - first) * coarse.columns;
            let rows = at..at + TAPS * coarse.columns;
            let to = (&mut re[rows.clone()], &mut im[rows]);
            dispatch!(self.level, s => split_row(s, &job, fine, &mut scratch, to));
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
            let job = self.lattice.phase_row(coarse, first + row, centre);
            dispatch!(self.level, s => apply_phase(s, &job, false, to_re, to_im));
        }
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
