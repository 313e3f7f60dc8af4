//! Images in groups, tile by tile: the bins that a tile reaches stay in the first-level cache.

use super::direct::{DirectForward, Piece};
use super::filling::{Echo, Steps};
use super::grouped::{GroupWay, Grouped};
use crate::control::Meter;
use crate::engine::weights::WeightedPulses;
use crate::kernel::dispatch::dispatch;
use crate::kernel::lanes::MAX_LANES;
use crate::kernel::spread::step;
use crate::kernel::spread_expansion::{Fallback, StripGeometry};
use crate::kernel::spread_groups::{SpreadStrip, spread_strip};
use crate::kernel::spread_squares::{SpreadSquares, spread_squares};
use crate::vector::norm;
use num_complex::Complex64;
use std::ops::Range;

/// Columns of the widest block of groups.
const MOST_COLUMNS: usize = 4 * MAX_LANES;
/// Bytes of the bins that a tile of grazing lines of sight reaches.
const BIN_BYTES: f64 = 12e3;
/// Rows of groups of a tile.
const STRIPS: usize = 8;

/// Groups of an image that are added to a pulse's bins one after another.
struct Tile<'a> {
    image: &'a Grouped,
    way: GroupWay,
    groups: Range<usize>,
    strips: Range<usize>,
}

impl DirectForward {
    /// Adds to `echo` the echoes that the pulses `which` receive from an image in groups.
    pub(super) fn add_groups(
        &self,
        echoes: &WeightedPulses,
        which: Range<usize>,
        (image, way): (&Grouped, GroupWay),
        echo: Echo,
        meter: &Meter,
    ) {
        let (grid, shape) = (&image.grid, image.shape);
        let bin_bytes = 4.0 * step(self.spec.table.degree) as f64;
        let reached_m = BIN_BYTES / bin_bytes * self.spec.table.bin_m;
        let groups = (reached_m / (shape[0] as f64 * norm(grid.u_m).max(1e-12))) as usize;
        let groups = (groups.min(image.groups()) / MAX_LANES).max(1) * MAX_LANES;
        let bands = image.strips().div_ceil(STRIPS);
        let steps = Steps {
            count: bands * image.groups().div_ceil(groups),
            pixels: groups * shape[0] * shape[1] * STRIPS,
            all_pixels: grid.columns * grid.rows,
        };
        let add = |(step, pulse): (usize, usize), bins: &mut [f32], out: &mut [Complex64]| {
            let (column, strip) = (step / bands * groups, step % bands * STRIPS);
            let tile = Tile {
                image,
                way,
                groups: column..(column + groups).min(image.groups()),
                strips: strip..(strip + STRIPS).min(image.strips()),
            };
            self.add_tile(echoes, pulse, &tile, bins, out);
        };
        self.add_steps(echoes, which, &steps, &add, echo, meter);
    }

    /// Adds a tile to the bins of one pulse; blocks for which expansions do not hold go pixel by pixel.
    fn add_tile(
        &self,
        echoes: &WeightedPulses,
        pulse: usize,
        tile: &Tile,
        bins: &mut [f32],
        out: &mut [Complex64],
    ) {
        let (image, shape) = (tile.image, tile.image.shape);
        let grid = &image.grid;
        let pixel_m = [grid.u_m, grid.v_m].map(|v| norm(v).max(1e-12));
        let start = grid.point_m(0.0, (tile.strips.start * shape[1]) as f64);
        let (from_antennas_m, antennas) = echoes.pulses.antennas_to_m(pulse, start);
        let geometry = StripGeometry {
            from_antennas_m: &from_antennas_m[..antennas],
            two_spreadings: echoes.has_two_spreadings(),
            strips: tile.strips.len(),
            stride: image.stride(),
            unit: [
                grid.u_m.map(|x| x / pixel_m[0]),
                grid.v_m.map(|x| x / pixel_m[1]),
            ],
            pixel_m,
            groups: tile.groups.clone(),
            bin_m: self.spec.table.bin_m,
            first_bin: self.first_bin[pulse],
            entries: self.entries,
            reference_below_m: self.reference_below_m(echoes),
        };
        let mut rows = |(strip, block): (usize, Range<usize>), bins: &mut [f32]| {
            let strip = tile.strips.start + strip;
            let columns = block.start * shape[0]..block.end * shape[0];
            let width = columns.len().next_multiple_of(MAX_LANES);
            let (mut real, mut imag) = ([0f32; MOST_COLUMNS], [0f32; MOST_COLUMNS]);
            for row in strip * shape[1]..((strip + 1) * shape[1]).min(grid.rows) {
                image.copy_row(row, columns.start, &mut real[..width], &mut imag[..width]);
                let piece = Piece {
                    grid,
                    column: columns.start,
                    row,
                    real: &real[..width],
                    imag: &imag[..width],
                };
                self.add_piece(echoes, pulse, &piece, bins, out);
            }
        };
        let (real, imag) = image.strips_from(tile.strips.start);
        match tile.way {
            GroupWay::Summed { terms, reach_m } => {
                let job = SpreadStrip {
                    geometry,
                    real,
                    imag,
                    carrier_rad: self.spec.table.carrier_rad(&echoes.pulses),
                    phase_tolerance_rad: self.spec.phase_tolerance_rad,
                    reach_m,
                    cosine: self.cosine,
                    sine: self.sine,
                    turn_cosine: self.turn[0],
                    turn_sine: self.turn[1],
                };
                self.sum_groups(shape, terms, &job, bins, &mut rows);
            }
            GroupWay::Spread => {
                let carrier_rad = self.spec.table.carrier_rad(&echoes.pulses);
                let job = SpreadSquares {
                    geometry,
                    real,
                    imag,
                    tolerance_bins: self.spec.phase_tolerance_rad / carrier_rad,
                    cosine: self.cosine,
                    sine: self.sine,
                };
                self.spread_groups(shape, &job, bins, &mut rows);
            }
        }
    }

    fn sum_groups(
        &self,
        shape: [usize; 2],
        terms: usize,
        job: &SpreadStrip,
        bins: &mut [f32],
        rows: &mut Fallback,
    ) {
        dispatch!(self.level, s => match (shape, terms) {
            ([4, 4], 4) => spread_strip::<_, 4, 4, 4>(s, job, bins, rows),
            ([4, 4], _) => spread_strip::<_, 4, 4, 5>(s, job, bins, rows),
            ([4, _], 4) => spread_strip::<_, 4, 2, 4>(s, job, bins, rows),
            ([4, _], _) => spread_strip::<_, 4, 2, 5>(s, job, bins, rows),
            (_, 4) => spread_strip::<_, 2, 2, 4>(s, job, bins, rows),
            (_, _) => spread_strip::<_, 2, 2, 5>(s, job, bins, rows),
        });
    }

    fn spread_groups(
        &self,
        shape: [usize; 2],
        job: &SpreadSquares,
        bins: &mut [f32],
        rows: &mut Fallback,
    ) {
        let quality = (self.spec.table.degree, self.spec.fine_carrier);
        dispatch!(self.level, s => match (shape, quality) {
            ([4, _], (1, false)) => spread_squares::<_, 4, 4, 1, 3>(s, job, bins, rows),
            ([4, _], (1, true)) => spread_squares::<_, 4, 4, 1, 4>(s, job, bins, rows),
            ([4, _], (2, _)) => spread_squares::<_, 4, 4, 2, 4>(s, job, bins, rows),
            ([4, _], _) => spread_squares::<_, 4, 4, 3, 4>(s, job, bins, rows),
            (_, (1, false)) => spread_squares::<_, 2, 2, 1, 3>(s, job, bins, rows),
            (_, (1, true)) => spread_squares::<_, 2, 2, 1, 4>(s, job, bins, rows),
            (_, (2, _)) => spread_squares::<_, 2, 2, 2, 4>(s, job, bins, rows),
            (_, _) => spread_squares::<_, 2, 2, 3, 4>(s, job, bins, rows),
        });
    }
}
