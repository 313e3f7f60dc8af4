//! The transposed direct engine: every pixel added to the range bins of every pulse.

use super::bins::{BinsToSpectrum, FilledBins, Workspace};
use super::filling::{AddStep, Echo, Filling, Steps};
use super::grouped::{GroupWay, Grouped};
use crate::control::Meter;
use crate::engine::direct::DirectSpec;
use crate::engine::planar::{Planar, padded, split_parts};
use crate::engine::polynomials::{carrier_polynomials, even_polynomial};
use crate::engine::tables::build::RangeTable;
use crate::engine::weights::WeightedPulses;
use crate::grid::tilted::TiltedGrid;
use crate::kernel::direct::job::PixelWeight;
use crate::kernel::dispatch::dispatch;
use crate::kernel::lanes::MAX_LANES;
use crate::kernel::level::SimdLevel;
use crate::kernel::spread::{RowTilt, RowWeight, SpreadRow, spread_row, step};
use crate::kernel::spread_groups::MAX_TERMS;
use crate::pulses::Spreading;
use crate::vector::{dot, norm};
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;
use std::f64::consts::PI;
use std::ops::Range;

/// Pulses to which a row of pixels is added while it stays in the first-level cache.
const CHUNK: usize = 4;
/// Bins and polynomials, ready for any number of images.
pub(crate) struct DirectForward {
    pub(super) spec: DirectSpec,
    pub(super) level: SimdLevel,
    pub(super) first_bin: Vec<i64>,
    pub(super) entries: usize,
    pub(super) cosine: [f32; 4],
    pub(super) sine: [f32; 4],
    /// Cosine and sine over half a turn, for sums of groups.
    pub(super) turn: [[f32; MAX_TERMS]; 2],
    finish: BinsToSpectrum,
}

impl DirectForward {
    /// Lays out the bins of every pulse.
    pub fn new(
        echoes: &WeightedPulses,
        ranges_m: &[[f64; 2]],
        spec: DirectSpec,
        level: SimdLevel,
    ) -> Self {
        let pulses = &echoes.pulses;
        let first_bin = RangeTable::first_bins(&spec.table, ranges_m);
        let entries = RangeTable::stride_for(&spec.table, ranges_m);
        let (cosine, sine) = carrier_polynomials(spec.table.carrier_rad(pulses), spec.fine_carrier);
        let terms = match spec.groups.map(|groups| groups.way) {
            Some(GroupWay::Summed { terms, .. }) => terms,
            _ => 2,
        };
        let first = first_bin.iter().copied().min().unwrap_or(0);
        let last = first_bin.iter().copied().max().unwrap_or(0) + entries as i64;
        Self {
            finish: BinsToSpectrum::new(echoes, spec.table, first..last),
            spec,
            level,
            first_bin,
            entries,
            cosine,
            sine,
            turn: [
                even_polynomial(|r| (PI * r).cos(), terms),
                even_polynomial(|r| (PI * r).sin() / r, terms - 1),
            ],
        }
    }

    /// Bytes of scratch memory a thread.
    pub fn bytes_a_thread(spec: &DirectSpec, ranges_m: &[[f64; 2]]) -> u128 {
        let entries = RangeTable::stride_for(&spec.table, ranges_m) as u128;
        entries * step(spec.table.degree) as u128 * (4 + 8) * CHUNK as u128
    }

    /// Adds to `echo` the echoes that the pulses `which` receive from an image on a grid. After cancellation
    /// `echo` is incomplete.
    pub fn run_on(
        &self,
        echoes: &WeightedPulses,
        which: Range<usize>,
        (grid, image): (&TiltedGrid, &[Complex32]),
        echo: Echo,
        meter: &Meter,
    ) {
        if let Some(groups) = self.spec.groups {
            let grouped = Grouped::new(grid, groups.shape, image);
            self.add_groups(echoes, which, (&grouped, groups.way), echo, meter);
            return;
        }
        let (real, imag) = split_parts(image, grid.columns, padded(grid.columns));
        let planar = Planar {
            grid: *grid,
            stride: padded(grid.columns),
            real: &real,
            imag: &imag,
        };
        self.add(echoes, which, &planar, echo, meter);
    }

    /// Count of numbers in the bins of a pulse.
    pub fn bins_of_pulse(&self) -> usize {
        self.entries * step(self.spec.table.degree)
    }

    /// Adds the spectra of the bins `sums` `[which.len(), bins]` of the pulses `which` to `out`
    /// `[which.len(), N]`.
    pub fn finish(
        &self,
        echoes: &WeightedPulses,
        which: Range<usize>,
        sums: &[f64],
        out: &mut [Complex64],
    ) {
        let n = echoes.pulses.frequency_hz().len();
        sums.par_chunks_exact(self.bins_of_pulse())
            .zip(out.par_chunks_exact_mut(n))
            .enumerate()
            .for_each_init(Workspace::default, |room, (m, (sums, out))| {
                self.finish_pulse(echoes, which.start + m, sums, (room, out));
            });
    }

    fn finish_pulse(
        &self,
        echoes: &WeightedPulses,
        pulse: usize,
        sums: &[f64],
        (room, out): (&mut Workspace, &mut [Complex64]),
    ) {
        let filled = FilledBins {
            pulse,
            first_bin: self.first_bin[pulse],
            values: sums,
            step: step(self.spec.table.degree),
        };
        self.finish.add(echoes, &filled, room, out);
    }

    /// Adds to `echo` the echoes that the pulses `which` receive from an image, row by row.
    pub fn add(
        &self,
        echoes: &WeightedPulses,
        which: Range<usize>,
        image: &Planar,
        echo: Echo,
        meter: &Meter,
    ) {
        let (columns, rows) = (image.grid.columns, image.grid.rows);
        let steps = Steps {
            count: rows,
            pixels: columns,
            all_pixels: columns * rows,
        };
        let add = |(row, pulse): (usize, usize), bins: &mut [f32], out: &mut [Complex64]| {
            let at = row * image.stride..(row + 1) * image.stride;
            let piece = Piece {
                grid: &image.grid,
                column: 0,
                row,
                real: &image.real[at.clone()],
                imag: &image.imag[at],
            };
            self.add_piece(echoes, pulse, &piece, bins, out);
        };
        self.add_steps(echoes, which, &steps, &add, echo, meter);
    }

    /// Runs `add`, which takes a step of an image and a pulse, its bins and its spectrum, for all steps
    /// and the pulses `which`.
    pub(super) fn add_steps(
        &self,
        echoes: &WeightedPulses,
        which: Range<usize>,
        steps: &Steps,
        add: &AddStep,
        echo: Echo,
        meter: &Meter,
    ) {
        let n = echoes.pulses.frequency_hz().len();
        let length = self.bins_of_pulse();
        let filling = Filling { steps, add, meter };
        let first = |chunk: usize| which.start + chunk * CHUNK;
        match echo {
            Echo::Spectra(out) => {
                out.par_chunks_mut(CHUNK * n).enumerate().for_each_init(
                    || {
                        let bins = (vec![0f32; CHUNK * length], vec![0f64; CHUNK * length]);
                        (bins, Workspace::default())
                    },
                    |((bins, sums), room), (chunk, out)| {
                        sums.fill(0.0);
                        if !filling.fill(first(chunk), (length, n), bins, (sums, out)) {
                            return;
                        }
                        for (m, (sums, out)) in sums
                            .chunks_exact(length)
                            .zip(out.chunks_exact_mut(n))
                            .enumerate()
                        {
                            self.finish_pulse(echoes, first(chunk) + m, sums, (room, out));
                        }
                    },
                );
            }
            Echo::Bins { sums, near_spectra } => {
                sums.par_chunks_mut(CHUNK * length)
                    .zip(near_spectra.par_chunks_mut(CHUNK * n))
                    .enumerate()
                    .for_each_init(
                        || vec![0f32; CHUNK * length],
                        |bins, (chunk, (sums, out))| {
                            filling.fill(first(chunk), (length, n), bins, (sums, out));
                        },
                    );
            }
        }
    }

    /// Pixels nearer than this are modelled in double precision, m.
    pub(super) fn reference_below_m(&self, echoes: &WeightedPulses) -> f64 {
        match echoes.weights.spreading {
            Spreading::InverseSquare => self.spec.reference_below_m,
            Spreading::None => 0.0,
        }
    }

    /// Adds a piece of a row to the bins of one pulse; pixels next to the antenna are added to the pulse's
    /// spectrum `out` directly.
    pub(super) fn add_piece(
        &self,
        echoes: &WeightedPulses,
        pulse: usize,
        piece: &Piece,
        bins: &mut [f32],
        out: &mut [Complex64],
    ) {
        let (grid, real, imag) = (piece.grid, piece.real, piece.imag);
        let start = grid.point_m(piece.column as f64, piece.row as f64);
        let (from_antennas_m, antennas) = echoes.pulses.antennas_to_m(pulse, start);
        let pixel_m = norm(grid.u_m).max(1e-12);
        // Single precision carries ranges from a segment's centre to its ends.
        let carrier_rad = self.spec.table.carrier_rad(&echoes.pulses);
        let tolerance_bins = self.spec.phase_tolerance_rad / carrier_rad;
        let reach_bins = 32.0 * pixel_m / self.spec.table.bin_m * f64::from(f32::EPSILON);
        let job = SpreadRow {
            from_antennas_m: &from_antennas_m[..antennas],
            unit: grid.u_m.map(|u| u / pixel_m),
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
            reference_below_m: self.reference_below_m(echoes),
            cosine: self.cosine,
            sine: self.sine,
            weight: echoes.pixel_weight().map(|weight| match weight {
                PixelWeight::Ways => RowWeight::Ways,
                PixelWeight::Tilt(tilt) => {
                    let b = tilt.per_metre[pulse];
                    RowWeight::Tilt(RowTilt {
                        ratio: dot(from_antennas_m[0], b),
                        slope: dot(grid.u_m, b),
                        power: tilt.power,
                    })
                }
            }),
        };
        let mut reference = |columns: Range<usize>| {
            let kept = grid.columns - piece.column;
            for i in columns.start..columns.end.min(kept) {
                let value = Complex64::new(f64::from(real[i]), f64::from(imag[i]));
                let point = grid.point_m((piece.column + i) as f64, piece.row as f64);
                echoes.add_echo(pulse, point, value, out);
            }
        };
        dispatch!(self.level, s => match (self.spec.table.degree, self.spec.fine_carrier) {
            (1, false) => spread_row::<_, 1, 3>(s, &job, bins, &mut reference),
            (1, true) => spread_row::<_, 1, 4>(s, &job, bins, &mut reference),
            (2, _) => spread_row::<_, 2, 4>(s, &job, bins, &mut reference),
            _ => spread_row::<_, 3, 4>(s, &job, bins, &mut reference),
        });
    }
}

/// Pixels of a row from `column` on, zeros beyond the row.
pub(super) struct Piece<'a> {
    pub grid: &'a TiltedGrid,
    pub column: usize,
    pub row: usize,
    pub real: &'a [f32],
    pub imag: &'a [f32],
}
