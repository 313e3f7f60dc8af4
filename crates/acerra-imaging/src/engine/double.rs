//! The double-precision engine: every pulse at every pixel from range tables in double precision, for
//! accuracies that single precision cannot keep.
//!
//! A bin holds the least-squares polynomial of third degree of the pulse's profile without the carrier's phase
//! from the bin's centre on ([`super::tables`] has the equations); ranges, carrier and weights are evaluated at
//! every pixel.

use super::level_ways::LevelWays;
use super::relief_ways::{RUN, ReliefTile, TILE_ROWS};
use super::tables::build::RangeTable;
use super::tables::phases::BinPhases;
use super::tables::spec::TableSpec;
use super::ways::{BLOCK, WayTolerance, Ways};
use super::weights::WeightedPulses;
use crate::control::Meter;
use crate::error::ImagingError;
use crate::grid::image::ImageGrid;
use crate::kernel::level::SimdLevel;
use crate::kernel::profile::DELAYS;
use crate::kernel::tabulated::{Bin, Bins, Row, TERMS, profiles};
use crate::pulses::Pulses;
use crate::vector::range_m;
use acerra_control::Control;
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;
use rustfft::FftPlanner;
use std::f64::consts::TAU;

/// Pulses between looks at the flag that cancels.
const PULSES_A_LOOK: usize = 64;

/// Pieces of an image for every thread, at least.
const PIECES_A_THREAD: usize = 4;
/// Pixels of a piece, where the image has many: the bins of a pulse are read once for all of them.
const PIECE: usize = 2048;

/// Range profiles of all pulses in double precision.
#[derive(Debug)]
pub(crate) struct DoubleTables {
    level: SimdLevel,
    spec: TableSpec,
    carrier_turns: f64,
    /// Of ways along rays, where these are interpolated.
    tolerance: WayTolerance,
    /// Most bytes of tabulated rays.
    ray_bytes: u128,
    first_bin: Vec<i64>,
    /// Bins of a pulse.
    stride: usize,
    /// `[pulse, bin]`.
    bins: Vec<Bin>,
}

/// Fills an image with the values that `values` computes for the points of a piece: parts of rows, `pulses`
/// contributions to each point. Pieces begin at multiples of [`BLOCK`] columns and of `together` rows.
pub(crate) fn image_by_pieces(
    grid: &ImageGrid,
    image: &mut [Complex32],
    (pulses, together): (usize, usize),
    meter: &Meter,
    values: impl Fn(&[Vec<[f64; 3]>]) -> Vec<Vec<Complex64>> + Sync,
) {
    let columns = grid.columns();
    let total = image.len() / columns.max(1);
    let pieces = PIECES_A_THREAD * rayon::current_num_threads();
    let rows = (PIECE / columns.max(1))
        .min(total / pieces)
        .next_multiple_of(together)
        .max(together);
    let strips = total.div_ceil(rows).max(1);
    // Part of a row, or all columns of a strip of several rows.
    let length = match rows {
        1 => columns
            .div_ceil(pieces.div_ceil(strips))
            .next_multiple_of(BLOCK),
        _ => columns,
    };
    let fill = |[row, column]: [usize; 2], out: &mut [Complex32]| {
        if meter.is_cancelled() {
            return;
        }
        let points_of = |(j, part): (usize, &[Complex32])| -> Vec<[f64; 3]> {
            let columns = column..column + part.len();
            columns.map(|i| grid.point_m(i, row + j)).collect()
        };
        let parts_m: Vec<_> = out.chunks(columns).enumerate().map(points_of).collect();
        for (out, v) in out.iter_mut().zip(values(&parts_m).into_iter().flatten()) {
            *out = Complex32::new(v.re as f32, v.im as f32);
        }
        meter.add((out.len() * pulses) as u64);
    };
    let strips = image.par_chunks_mut(rows * columns).enumerate();
    strips.for_each(|(k, strip)| {
        let pieces = strip.par_chunks_mut(rows * length).enumerate();
        pieces.for_each(|(piece, out)| fill([k * rows, piece * length], out));
    });
}

/// Whether rays cross an uneven surface.
pub(crate) fn has_relief(echoes: &WeightedPulses) -> bool {
    let ground = echoes.pulses.ground();
    ground.is_some_and(|ground| ground.level_m().is_none())
}

/// Rows whose ways are found together.
pub(crate) fn rows_together(echoes: &WeightedPulses) -> usize {
    if has_relief(echoes) { TILE_ROWS } else { 1 }
}

impl DoubleTables {
    /// Bytes of tables over `ranges_m` (least and greatest a pulse).
    pub fn bytes_for(spec: &TableSpec, ranges_m: &[[f64; 2]]) -> u128 {
        (ranges_m.len() * size_of::<Bin>()) as u128 * RangeTable::stride_for(spec, ranges_m) as u128
    }

    /// Tables of polynomials of third degree over `ranges_m`, for even frequencies, read at ways within `tolerance`.
    ///
    /// # Errors
    /// Cancellation.
    pub fn build(
        pulses: &Pulses,
        level: SimdLevel,
        (spec, tolerance): (TableSpec, WayTolerance),
        ranges_m: &[[f64; 2]],
        control: Control,
    ) -> Result<Self, ImagingError> {
        let stride = RangeTable::stride_for(&spec, ranges_m);
        let first_bin = RangeTable::first_bins(&spec, ranges_m);
        let first = first_bin.iter().copied().min().unwrap_or(0);
        let last = first_bin.iter().copied().max().unwrap_or(0) + stride as i64;
        let phases = BinPhases::unweighted(pulses, &spec, [first, last]);
        let length = spec.period.unwrap_or(stride);
        let fft = FftPlanner::new().plan_fft_inverse(length);
        let mut bins = vec![[[0.0; 2]; TERMS]; ranges_m.len() * stride];
        bins.par_chunks_mut(stride).enumerate().for_each_init(
            || {
                let profile = vec![Complex64::ZERO; length * TERMS];
                let scratch = vec![Complex64::ZERO; fft.get_immutable_scratch_len()];
                (profile.clone(), profile, scratch)
            },
            |(padded, profile, scratch), (m, row)| {
                if control.is_cancelled() {
                    return;
                }
                phases.even(pulses, m, &spec, padded);
                fft.process_immutable_with_scratch(padded, profile, scratch);
                for (i, bin) in (first_bin[m]..).zip(row) {
                    let slot = i.rem_euclid(length as i64) as usize;
                    let carrier = phases.carrier_at(i);
                    for (p, c) in bin.iter_mut().enumerate() {
                        let value = profile[p * length + slot] * carrier;
                        *c = [value.re, value.im];
                    }
                }
            },
        );
        control.check()?;
        Ok(Self {
            level,
            spec,
            carrier_turns: spec.carrier_rad(pulses) / TAU,
            tolerance,
            ray_bytes: 0,
            first_bin,
            stride,
            bins,
        })
    }

    /// These tables with tabulated rays in at most `ray_bytes`.
    pub fn with_ray_bytes(self, ray_bytes: u128) -> Self {
        Self { ray_bytes, ..self }
    }

    /// Computes the image of `grid`, whose ranges the tables hold.
    pub fn run(
        &self,
        echoes: &WeightedPulses,
        grid: &ImageGrid,
        image: &mut [Complex32],
        meter: &Meter,
    ) {
        let level_ways = LevelWays::new(echoes, grid, self.level, self.ray_bytes);
        let task = (echoes.len(), rows_together(echoes));
        image_by_pieces(grid, image, task, meter, |parts_m| {
            self.sums(echoes, level_ways.as_ref(), parts_m, || {
                meter.is_cancelled()
            })
        });
    }

    /// Values at pieces of `grid`, whose ranges the tables hold, in single precision as an image has them; a piece is a
    /// list of rows. Once cancelled they have no meaning.
    pub fn values_at(
        &self,
        echoes: &WeightedPulses,
        grid: &ImageGrid,
        pieces_m: &[Vec<Vec<[f64; 3]>>],
        control: Control,
    ) -> Vec<Vec<Complex32>> {
        let level_ways = LevelWays::new(echoes, grid, self.level, self.ray_bytes);
        let rounded = |v: Complex64| Complex32::new(v.re as f32, v.im as f32);
        let sums = |piece_m: &Vec<Vec<[f64; 3]>>| {
            self.sums(echoes, level_ways.as_ref(), piece_m, || {
                control.is_cancelled()
            })
        };
        (pieces_m.par_iter().map(sums))
            .map(|sums| sums.into_iter().flatten().map(rounded).collect())
            .collect()
    }

    /// Sums over all pulses at the points of parts of rows that have the same columns.
    fn sums(
        &self,
        echoes: &WeightedPulses,
        level_ways: Option<&LevelWays>,
        parts_m: &[Vec<[f64; 3]>],
        is_cancelled: impl Fn() -> bool,
    ) -> Vec<Vec<Complex64>> {
        let zeros = |part_m: &Vec<[f64; 3]>| vec![Complex64::ZERO; part_m.len()];
        let mut sums: Vec<Vec<Complex64>> = parts_m.iter().map(zeros).collect();
        if has_relief(echoes) {
            self.add_tiles(echoes, parts_m, &mut sums, is_cancelled);
            return sums;
        }
        // Pulse by pulse, so that the bins of a pulse stay in the caches.
        for pulse in 0..echoes.len() {
            if pulse % PULSES_A_LOOK == 0 && is_cancelled() {
                break;
            }
            for (points_m, sums) in parts_m.iter().zip(&mut sums) {
                if echoes.pulses.is_plain() {
                    self.add_straight(echoes, pulse, points_m, sums);
                } else {
                    self.add_along_rays(echoes, pulse, level_ways, points_m, sums);
                }
            }
        }
        sums
    }

    /// Adds the contributions of all pulses along interpolated rays, tile by tile.
    fn add_tiles(
        &self,
        echoes: &WeightedPulses,
        parts_m: &[Vec<[f64; 3]>],
        sums: &mut [Vec<Complex64>],
        is_cancelled: impl Fn() -> bool,
    ) {
        let columns = parts_m.first().map_or(0, Vec::len);
        for first in (0..echoes.len()).step_by(RUN) {
            let pulses = first..(first + RUN).min(echoes.len());
            for (parts_m, sums) in parts_m.chunks(TILE_ROWS).zip(sums.chunks_mut(TILE_ROWS)) {
                for column in (0..columns).step_by(BLOCK) {
                    if is_cancelled() {
                        return;
                    }
                    let block = column..(column + BLOCK).min(columns);
                    let rows_m: Vec<&[[f64; 3]]> = parts_m
                        .iter()
                        .map(|part_m| &part_m[block.clone()])
                        .collect();
                    let mut of_tile = vec![Complex64::ZERO; rows_m.len() * block.len()];
                    let tolerance_m = self.tolerance.half_m();
                    let tolerance_m = (tolerance_m > 0.0).then_some(tolerance_m);
                    let Some(tile) = ReliefTile::new(echoes, &rows_m, tolerance_m) else {
                        return;
                    };
                    tile.ways(pulses.clone(), |pulse, half_m, weight| {
                        let of_pulse = echoes.pulses.weight()[pulse];
                        self.add(pulse, half_m, (weight, of_pulse), &mut of_tile);
                    });
                    for (sums, of_row) in sums.iter_mut().zip(of_tile.chunks(block.len())) {
                        for (sum, value) in sums[block.clone()].iter_mut().zip(of_row) {
                            *sum += value;
                        }
                    }
                }
            }
        }
    }

    /// Adds the contribution of a pulse to points of a row along straight lines.
    fn add_straight(
        &self,
        echoes: &WeightedPulses,
        pulse: usize,
        points_m: &[[f64; 3]],
        sums: &mut [Complex64],
    ) {
        let antenna_m = echoes.pulses.position_m()[pulse];
        let row = self.row(pulse);
        for (some, sums) in points_m.chunks(DELAYS).zip(sums.chunks_mut(DELAYS)) {
            let mut ranges_m = [0.0; DELAYS];
            for (range, point) in ranges_m.iter_mut().zip(some) {
                *range = range_m(antenna_m, *point);
            }
            let profiles = profiles(self.level, &row, &ranges_m);
            for (k, (sum, point)) in sums.iter_mut().zip(some).enumerate() {
                *sum += profiles[k] * echoes.factor(pulse, ranges_m[k], *point);
            }
        }
    }

    /// Adds the contribution of a pulse to points of a row along tabulated or interpolated rays.
    fn add_along_rays(
        &self,
        echoes: &WeightedPulses,
        pulse: usize,
        level_ways: Option<&LevelWays>,
        points_m: &[[f64; 3]],
        sums: &mut [Complex64],
    ) {
        for (some, sums) in points_m.chunks(BLOCK).zip(sums.chunks_mut(BLOCK)) {
            let ways = match level_ways {
                Some(level_ways) => level_ways.ways(echoes, pulse, some),
                None => Ways::along(echoes, pulse, some, self.tolerance),
            };
            self.add(pulse, &ways.half_m, (&ways.weight, 1.0), sums);
        }
    }

    /// Adds the contribution of a pulse at half ways (m) with their weights and a further weight of all, as many as there
    /// are sums at least.
    fn add(
        &self,
        pulse: usize,
        half_m: &[f64],
        (weight, of_all): (&[f64], f64),
        sums: &mut [Complex64],
    ) {
        let row = self.row(pulse);
        let ways = half_m.chunks(DELAYS).zip(weight.chunks(DELAYS));
        for ((half_m, weight), sums) in ways.zip(sums.chunks_mut(DELAYS)) {
            let mut ranges_m = [half_m[0]; DELAYS];
            ranges_m[..half_m.len()].copy_from_slice(half_m);
            let profiles = profiles(self.level, &row, &ranges_m);
            for ((sum, profile), weight) in sums.iter_mut().zip(profiles).zip(weight) {
                *sum += profile * (weight * of_all);
            }
        }
    }

    /// The profiles of a pulse at several ranges, without weights.
    pub fn profiles_of(&self, pulse: usize, ranges_m: &[f64; DELAYS]) -> [Complex64; DELAYS] {
        profiles(self.level, &self.row(pulse), ranges_m)
    }

    fn row(&self, pulse: usize) -> Row<'_> {
        Row {
            bins: Bins {
                bins: &self.bins[pulse * self.stride..(pulse + 1) * self.stride],
                first_bin: self.first_bin[pulse] as f64,
                bins_per_m: 1.0 / self.spec.bin_m,
            },
            carrier_turns: self.carrier_turns,
        }
    }
}
