//! Sub-apertures imaged on coarse grids, then merged.
//!
//! Neighbouring pulses look at a pixel from nearly the same direction. Without the carrier's phase
//! of the range to a sub-aperture's centre, the sum of its pulses varies slowly over the image: its spatial frequencies are bounded by (2/c)·|f·u_m − f_c·u_s|, u being the unit
//! vectors from pulse and centre to the pixel projected on the grid's axes. The direct engine
//! images each sub-aperture on a grid just fine enough for that; rows of the fine grid follow by
//! separable least-squares interpolation, and their phase is restored. Any trajectory and any height
//! is admissible: a scattered track has a wide bound, and is left to the direct engine.

use super::aperture::centre_m;
use super::cell::Cell;
use super::lattice::Lattice;
use super::spec::FactorizedSpec;
use crate::control::{Control, Meter};
use crate::engine::direct::{Direct, DirectSpec};
use crate::engine::planar::padded;
use crate::engine::weights::WeightedPulses;
use crate::error::ImagingError;
use crate::grid::tilted::TiltedGrid;
use crate::kernel::dispatch::dispatch;
use crate::kernel::level::SimdLevel;
use crate::kernel::merge::{MOST_TAPS, MergeRow, TAPS, merge_row};
use crate::kernel::phase::apply_phase;
use num_complex::Complex32;
use rayon::prelude::*;
use std::ops::Range;

/// Range tables and interpolation weights, ready for any number of runs.
#[derive(Debug)]
pub(crate) struct Factorized {
    pub lattice: Lattice,
    pub(super) direct: Direct,
    pub(super) level: SimdLevel,
    /// Sub-apertures.
    pub(super) parts: Vec<Range<usize>>,
}

/// Instruction set and control of a construction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Setting<'a> {
    pub level: SimdLevel,
    pub control: Control<'a>,
}

/// A sub-aperture's coarse image, real and imaginary, and its phase centre.
pub(super) struct CoarseImage {
    pub centre_m: [f64; 3],
    pub real: Vec<f32>,
    pub imag: Vec<f32>,
}

impl Factorized {
    /// Builds range tables over `ranges_m`, those of the coarse grids of all planes to be imaged, and
    /// interpolation weights, for the sub-apertures `parts`.
    ///
    /// # Errors
    /// Cancellation.
    pub fn new(
        echoes: &WeightedPulses,
        grid: &TiltedGrid,
        ranges_m: &[[f64; 2]],
        (spec, direct): (FactorizedSpec, DirectSpec),
        parts: Vec<Range<usize>>,
        setting: Setting,
    ) -> Result<Self, ImagingError> {
        let carrier_hz = echoes.pulses.frequency_hz()[direct.table.carrier];
        let level = setting.level;
        Ok(Self {
            lattice: Lattice::new(&echoes.pulses, grid, spec, carrier_hz),
            direct: Direct::new(echoes, ranges_m, direct, level, setting.control)?,
            level,
            parts,
        })
    }

    /// Images `grid` (or a piece of the grid that the plan was made for) into `out`. After
    /// cancellation `out` is incomplete.
    pub fn run(
        &self,
        echoes: &WeightedPulses,
        grid: &TiltedGrid,
        out: &mut [Complex32],
        meter: &Meter,
    ) {
        let spec = &self.lattice.spec;
        let coarse = spec.coarse.grid(grid);
        let row_samples = spec.coarse.row_samples(grid);
        let images: Vec<CoarseImage> = self
            .parts
            .par_iter()
            .map(|part| self.coarse_image(echoes, (&coarse, row_samples), part, meter.control()))
            .collect();
        self.merge(&images, grid, out, meter);
    }

    /// The image of the pulses `part` on the coarse grid or some of its rows, without the carrier's
    /// phase of the range to their centre; rows of at least `row_samples`, zeros at their end.
    pub(super) fn coarse_image(
        &self,
        echoes: &WeightedPulses,
        (coarse, row_samples): (&TiltedGrid, usize),
        part: &Range<usize>,
        control: Control,
    ) -> CoarseImage {
        let centre = centre_m(&echoes.pulses, part.clone());
        let stride = padded(row_samples);
        let mut image = vec![Complex32::ZERO; coarse.columns * coarse.rows];
        let (patch, meter) = ((*coarse).into(), Meter::silent(control));
        self.direct
            .run(echoes, part.clone(), &patch, &mut image, &meter);
        let (mut real, mut imag) = (
            vec![0f32; stride * coarse.rows],
            vec![0f32; stride * coarse.rows],
        );
        let samples = self.lattice.spec.coarse.cells[0].samples;
        real.par_chunks_mut(stride)
            .zip(imag.par_chunks_mut(stride))
            .zip(image.par_chunks(coarse.columns))
            .enumerate()
            .for_each_init(
                || vec![0f32; 2 * stride],
                |scratch, (j, ((real, imag), row))| {
                    let (re, im) = scratch.split_at_mut(stride);
                    for ((re, im), v) in re.iter_mut().zip(im.iter_mut()).zip(row) {
                        (*re, *im) = (v.re, v.im);
                    }
                    let job = self.lattice.phase_row(coarse, j, centre);
                    dispatch!(self.level, s => apply_phase(s, &job, true, re, im));
                    sorted(&re[..row_samples], samples, real);
                    sorted(&im[..row_samples], samples, imag);
                },
            );
        CoarseImage {
            centre_m: centre,
            real,
            imag,
        }
    }

    /// Adds up all coarse images on `grid`.
    pub(super) fn merge(
        &self,
        images: &[CoarseImage],
        grid: &TiltedGrid,
        out: &mut [Complex32],
        meter: &Meter,
    ) {
        let row_samples = self.lattice.spec.coarse.row_samples(grid);
        let stride = padded(row_samples);
        let pulses: usize = self.parts.iter().map(Range::len).sum();
        let [along, across] = self.lattice.spec.coarse.cells;
        let [dx, dy] = [along.pixels, across.pixels];
        let taps = self.lattice.spec.coarse.taps;
        let intervals = self.lattice.spec.coarse.padded_cells(grid);
        let offsets = tap_offsets(along, row_samples);
        let line_length = 2 * row_samples;
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
                        if meter.is_cancelled() {
                            return;
                        }
                        for (phase, sums) in sums
                            .chunks_exact_mut(2 * row_length)
                            .enumerate()
                            .take(out.len() / grid.columns)
                        {
                            let (real, imag) = sums.split_at_mut(row_length);
                            let job = MergeRow {
                                phase: self.lattice.phase_row(
                                    grid,
                                    cell * dy + phase,
                                    image.centre_m,
                                ),
                                rows: std::array::from_fn(|k| {
                                    let row = cell * across.samples + across.sample_before(phase);
                                    // Those beyond the taps do not count.
                                    let at = (row + k.min(taps - 1)) * stride;
                                    let end = at + row_samples;
                                    (
                                        &image.real[at..end],
                                        &image.imag[at..end],
                                        self.lattice.weights[1][phase][k],
                                    )
                                }),
                                weights: &self.lattice.weights[0],
                                offsets: &offsets,
                                samples: along.samples,
                                intervals: grid.columns.div_ceil(dx),
                                padded: intervals,
                            };
                            dispatch!(self.level, s => match (taps, along.samples) {
                                (TAPS, 1) => merge_row::<_, TAPS, true>(s, &job, line, real, imag),
                                (TAPS, _) => merge_row::<_, TAPS, false>(s, &job, line, real, imag),
                                (_, 1) => {
                                    merge_row::<_, MOST_TAPS, true>(s, &job, line, real, imag)
                                }
                                _ => merge_row::<_, MOST_TAPS, false>(s, &job, line, real, imag),
                            });
                        }
                    }
                    for (row, sums) in out
                        .chunks_exact_mut(grid.columns)
                        .zip(sums.chunks_exact(2 * row_length))
                    {
                        let (real, imag) = sums.split_at(row_length);
                        let phases = real
                            .chunks_exact(intervals)
                            .zip(imag.chunks_exact(intervals));
                        for (p, (real, imag)) in phases.enumerate() {
                            let pixels = row.iter_mut().skip(p).step_by(dx);
                            for ((v, re), im) in pixels.zip(real).zip(imag) {
                                *v = Complex32::new(*re, *im);
                            }
                        }
                    }
                    meter.add((out.len() * pulses) as u64);
                },
            );
    }
}

/// Copies a row so that the first samples of all cells stand side by side, then the second ones, and so on.
fn sorted(row: &[f32], samples: usize, out: &mut [f32]) {
    if samples == 1 {
        return out[..row.len()].copy_from_slice(row);
    }
    for (first, out) in out[..row.len()]
        .chunks_exact_mut(row.len() / samples)
        .enumerate()
    {
        for (to, from) in out.iter_mut().zip(row[first..].iter().step_by(samples)) {
            *to = *from;
        }
    }
}

/// Where the samples that each pixel of the first cell takes stand in such a row of `columns`.
fn tap_offsets(cell: Cell, columns: usize) -> Vec<[usize; MOST_TAPS]> {
    let cells = columns / cell.samples;
    let of = |pixel: usize| {
        std::array::from_fn(|k| {
            let sample = cell.sample_before(pixel) + k;
            sample % cell.samples * cells + sample / cell.samples
        })
    };
    (0..cell.pixels).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn taps_find_their_samples_in_sorted_rows() {
        for (pixels, samples) in [(3, 1), (3, 2), (4, 3), (5, 3)] {
            let cell = Cell { pixels, samples };
            let natural: Vec<f32> = (0..20 * samples).map(|k| k as f32).collect();
            let mut row = vec![0f32; natural.len()];
            sorted(&natural, samples, &mut row);
            for (pixel, offsets) in tap_offsets(cell, row.len()).iter().enumerate() {
                for (k, at) in offsets.iter().enumerate() {
                    for n in 0..4 {
                        let sample = n * samples + cell.sample_before(pixel) + k;
                        assert_eq!(row[n + at], sample as f32);
                    }
                }
            }
        }
    }
}
