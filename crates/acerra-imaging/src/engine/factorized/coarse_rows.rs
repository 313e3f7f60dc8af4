//! Computation of the coarse images of sub-apertures.

use super::aperture::centre_m;
use super::heights::CoarseGround;
use super::lattice::Lattice;
use super::merging::{CoarseImage, Merger};
use crate::control::Meter;
use crate::engine::direct::Direct;
use crate::engine::planar::padded;
use crate::engine::weights::WeightedPulses;
use crate::grid::image::Patch;
use crate::grid::terrain::Terrain;
use crate::grid::tilted::TiltedGrid;
use crate::kernel::direct::job::Shape;
use crate::kernel::dispatch::dispatch;
use crate::kernel::level::SimdLevel;
use crate::kernel::phase::remove_phase;
use num_complex::Complex32;
use rayon::prelude::*;
use std::ops::Range;

/// Contributions that count as done while a coarse image is made.
pub(super) struct Counter<'m, 'c> {
    pub meter: &'m Meter<'c>,
    pub contributions: u64,
}

impl Counter<'_, '_> {
    /// Counts `rows` rows of `all`, from row `first` on.
    fn count(&self, first: usize, rows: usize, all: usize) {
        let before =
            |row: usize| (u128::from(self.contributions) * row as u128 / all as u128) as u64;
        self.meter.add(before(first + rows) - before(first));
    }
}

/// The coarse grid for an image, and the data shared by the rows of the grid.
pub(super) struct CoarseRows<'a> {
    lattice: &'a Lattice,
    level: SimdLevel,
    /// The coarse grid, or some of its rows.
    pub grid: TiltedGrid,
    row_samples: usize,
    /// Uneven ground under the whole coarse grid; `None` over a plane.
    ground: Option<&'a CoarseGround>,
    /// Row of the ground under the first row of `grid`.
    first_row: usize,
}

impl<'a> CoarseRows<'a> {
    /// The coarse rows for an image on `grid`, over the ground under the coarse grid.
    pub fn new(
        lattice: &'a Lattice,
        level: SimdLevel,
        grid: &TiltedGrid,
        ground: Option<&'a CoarseGround>,
    ) -> Self {
        let coarse = &lattice.stage.coarse;
        Self {
            lattice,
            level,
            grid: coarse.grid(grid),
            row_samples: coarse.row_samples(grid),
            ground,
            first_row: 0,
        }
    }

    /// The part of `rows` rows from row `first` on.
    pub fn some(&self, first: usize, rows: usize) -> Self {
        Self {
            grid: self.grid.rows_from(first, rows),
            first_row: self.first_row + first,
            ..*self
        }
    }

    /// The coarse grid, to be imaged.
    pub fn patch<'s>(&'s self, terrain: Terrain<'s>) -> Patch<'s> {
        let relief = self.ground.map(|ground| ground.heights.relief());
        Patch {
            grid: self.grid,
            relief: relief.map(|relief| relief.seen_from(0, self.first_row)),
            terrain,
        }
    }

    /// The arrangement of samples in which range tables are summed.
    pub fn shape(&self, direct: &Direct) -> Shape {
        direct.spec.shape_on(self.ground.is_some())
    }

    /// The image of the pulses `part`, from range tables.
    pub fn sum_tables(
        &self,
        direct: &Direct,
        echoes: &WeightedPulses,
        part: &Range<usize>,
        image: &mut CoarseImage,
        counter: &Counter,
    ) {
        let control = counter.meter.control();
        image.centre_m = centre_m(&echoes.pulses, part.clone());
        let columns = self.grid.columns;
        // Few rows at a time, which the caches hold until their phase is removed.
        let height = 2 * self.shape(direct).tile_rows(self.level.lanes());
        let patch = self.patch(Terrain::LEVEL);
        self.fill(
            height,
            image,
            counter,
            || vec![Complex32::ZERO; columns * height],
            |values, (first, rows), lines| {
                let values = &mut values[..columns * rows];
                let some = patch.rows_from(first, rows);
                let silent = Meter::silent(control);
                direct.run(echoes, part.clone(), &some, values, &silent);
                for (row, [re, im]) in values.chunks_exact(columns).zip(lines) {
                    self.sort(row, re, |v| v.re);
                    self.sort(row, im, |v| v.im);
                }
            },
        );
    }

    /// The image of a sub-aperture centred at `centre_m`, merged from the images of shorter sub-apertures.
    pub fn merge(
        &self,
        merger: &Merger,
        shorter: &[CoarseImage],
        centre_m: [f64; 3],
        image: &mut CoarseImage,
        counter: &Counter,
    ) {
        let control = counter.meter.control();
        image.centre_m = centre_m;
        let columns = self.grid.columns;
        let height = merger.rows_of_cell();
        self.fill(
            height,
            image,
            counter,
            || (merger.scratch(), vec![Complex32::ZERO; columns]),
            |(scratch, row), (first, rows), lines| {
                let here = (first / height, rows);
                let merged = merger.cell(shorter, here, scratch, control);
                for (merged, [re, im]) in merged.zip(lines) {
                    merged.write(row, Complex32::new);
                    self.sort(row, re, |v| v.re);
                    self.sort(row, im, |v| v.im);
                }
            },
        );
    }

    /// Fills an image, `height` rows at a time: `make` fills as many lines (real and imaginary) from a given
    /// row on, and their phase is then removed.
    fn fill<T>(
        &self,
        height: usize,
        image: &mut CoarseImage,
        counter: &Counter,
        scratch: impl Fn() -> T + Sync + Send,
        make: impl Fn(&mut T, (usize, usize), Lines) + Sync + Send,
    ) {
        let (samples, stride) = (self.row_samples, padded(self.row_samples));
        let pixels = self.lattice.stage.coarse.cells[0].samples;
        let centre_m = image.centre_m;
        let mut parts = [&mut image.real, &mut image.imag];
        for part in &mut parts {
            part.resize(stride * self.grid.rows, 0.0);
        }
        let [real, imag] = parts.map(|part| part.par_chunks_mut(stride * height));
        let lines = || (scratch(), vec![0f32; 2 * samples * height]);
        (real.zip(imag))
            .enumerate()
            .for_each_init(lines, |(scratch, lines), (k, (real, imag))| {
                let (first, rows) = (k * height, real.len() / stride);
                if counter.meter.is_cancelled() {
                    return;
                }
                make(
                    scratch,
                    (first, rows),
                    Lines {
                        samples,
                        rest: lines,
                    },
                );
                let to = real
                    .chunks_exact_mut(stride)
                    .zip(imag.chunks_exact_mut(stride));
                for (j, (line, to)) in lines.chunks_exact(2 * samples).zip(to).enumerate() {
                    let job = self.lattice.phase_row(&self.grid, first + j, centre_m);
                    let from = line.split_at(samples);
                    let heights = self
                        .ground
                        .map(|g| g.rows[self.first_row + first + j].row());
                    let job = (&job, heights);
                    dispatch!(self.level, s => remove_phase(s, job, pixels, from, to));
                }
                counter.count(first, rows, self.grid.rows);
            });
    }

    /// Copies a row so that the first samples of all cells are adjacent, then the second ones, and so on.
    fn sort(&self, row: &[Complex32], out: &mut [f32], part: impl Fn(&Complex32) -> f32) {
        let samples = self.lattice.stage.coarse.cells[0].samples;
        let kinds = out.chunks_exact_mut(out.len() / samples).enumerate();
        for (first, out) in kinds {
            let of_kind = row[first.min(row.len())..].iter().step_by(samples);
            for (to, from) in out.iter_mut().zip(of_kind) {
                *to = part(from);
            }
        }
    }
}

/// Lines of samples one after another, real and imaginary.
struct Lines<'l> {
    samples: usize,
    rest: &'l mut [f32],
}

impl<'l> Iterator for Lines<'l> {
    type Item = [&'l mut [f32]; 2];

    fn next(&mut self) -> Option<Self::Item> {
        let (line, rest) = std::mem::take(&mut self.rest).split_at_mut_checked(2 * self.samples)?;
        self.rest = rest;
        let (re, im) = line.split_at_mut(self.samples);
        Some([re, im])
    }
}
