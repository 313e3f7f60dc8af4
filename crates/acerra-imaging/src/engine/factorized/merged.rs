//! Sub-apertures imaged on coarse grids, then merged.
//!
//! Neighbouring pulses see a pixel from nearly the same direction. Without the carrier's phase of the range
//! to a sub-aperture's centre, the sum of its pulses varies slowly over the image: its spatial frequencies
//! are bounded by (2/c)·|f·u_m − f_c·u_s|, u being the unit vectors from pulse and centre to the pixel
//! projected on the grid's axes. The direct engine images each sub-aperture on a grid just fine enough for
//! that; rows of the fine grid follow by separable least-squares interpolation, and their phase is restored.
//! Any trajectory and any height is admissible: a scattered track has a wide bound, and uses the direct
//! engine.
//!
//! Long sub-apertures may themselves be merged from shorter ones, on whose coarser grids the direct engine then
//! images.

use super::aperture::{centre_m, divided};
use super::coarse_rows::{CoarseRows, Counter};
use super::heights::CoarseGround;
use super::lattice::Lattice;
use super::merging::{CoarseImage, Merger};
use super::spec::{FactorizedSpec, Stage};
use crate::control::Meter;
use crate::engine::direct::{Direct, DirectSpec};
use crate::engine::weights::WeightedPulses;
use crate::error::ImagingError;
use crate::grid::image::Patch;
use crate::grid::tilted::TiltedGrid;
use crate::kernel::level::SimdLevel;
use acerra_control::Control;
use num_complex::Complex32;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// Range tables and interpolation weights, ready for any number of runs.
#[derive(Debug)]
pub(crate) struct Factorized {
    pub(super) lattice: Arc<Lattice>,
    pub(super) source: Source,
    pub(super) level: SimdLevel,
    /// Sub-apertures.
    pub(super) parts: Vec<Range<usize>>,
}

/// Engine of the sub-apertures' images on their coarse grids.
#[derive(Debug)]
pub(super) enum Source {
    /// Sums of range tables.
    Tables(Box<Direct>),
    /// Shorter sub-apertures.
    SubApertures(Box<Factorized>),
}

/// Instruction set and control of a construction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Setting<'a> {
    pub level: SimdLevel,
    pub control: Control<'a>,
}

impl Factorized {
    /// Builds range tables and interpolation weights for the sub-apertures `parts`; `ranges_m` bounds the
    /// ranges to the coarse grids of all planes to be imaged.
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
        let direct = Direct::new(echoes, ranges_m, direct, level, setting.control)?;
        let tables = Source::Tables(Box::new(direct));
        let merged = |on: &TiltedGrid, of: Stage, source, parts| Self {
            lattice: Arc::new(Lattice::new(&echoes.pulses, on, of, carrier_hz)),
            source,
            level,
            parts,
        };
        let source = match spec.shorter {
            None => tables,
            Some(stage) => {
                let coarse = spec.outer.coarse.grid(grid);
                let pieces = divided(&parts, stage.pulses);
                Source::SubApertures(Box::new(merged(&coarse, stage, tables, pieces)))
            }
        };
        Ok(merged(grid, spec.outer, source, parts))
    }

    /// These tables and grids for echoes that come from `beyond_m` further away than the pixels; the tables
    /// must include ranges longer by `beyond_m`.
    pub fn beyond(&self, position_m: &[[f64; 3]], beyond_m: f64) -> Self {
        Self {
            lattice: Arc::clone(&self.lattice),
            source: match &self.source {
                Source::Tables(direct) => {
                    Source::Tables(Box::new(direct.moved(position_m, beyond_m)))
                }
                Source::SubApertures(shorter) => {
                    Source::SubApertures(Box::new(shorter.beyond(position_m, beyond_m)))
                }
            },
            level: self.level,
            parts: self.parts.clone(),
        }
    }

    /// Images `patch` (a piece of the grid that the plan was made for, or all of it) into `out`. After
    /// cancellation `out` is incomplete.
    pub fn run(
        &self,
        echoes: &WeightedPulses,
        patch: &Patch,
        out: &mut [Complex32],
        meter: &Meter,
    ) {
        let ground = CoarseGround::under(&self.lattice, patch);
        let on = CoarseRows::new(&self.lattice, self.level, &patch.grid, ground.as_ref());
        let mut images = Vec::new();
        let pixels = before_merging(out.len());
        self.image_parts(
            echoes,
            &self.parts,
            (&on, patch),
            &mut images,
            (meter, pixels),
        );
        self.merge(&images, echoes.len(), patch, out, meter);
    }

    /// Adds up coarse images, of `pulses` together, on the pixels of `patch`.
    pub(super) fn merge(
        &self,
        images: &[CoarseImage],
        pulses: usize,
        patch: &Patch,
        out: &mut [Complex32],
        meter: &Meter,
    ) {
        let (grid, merger) = (&patch.grid, Merger::new(&self.lattice, self.level, patch));
        let rows = merger.rows_of_cell();
        out.par_chunks_mut(grid.columns * rows)
            .enumerate()
            .for_each_init(
                || merger.scratch(),
                |scratch, (cell, out)| {
                    let here = (cell, out.len() / grid.columns);
                    let merged = merger.cell(images, here, scratch, meter.control());
                    for (row, merged) in out.chunks_exact_mut(grid.columns).zip(merged) {
                        merged.write(row, Complex32::new);
                    }
                    let first = cell * rows * grid.columns;
                    let before = before_merging(first + out.len()) - before_merging(first);
                    meter.add(((out.len() - before) * pulses) as u64);
                },
            );
    }

    /// Computes the coarse images of the sub-apertures `parts` for an image of `patch` into the first of
    /// `images`, and allocates missing images. Progress advances by the contributions of the given number of
    /// pixels.
    fn image_parts(
        &self,
        echoes: &WeightedPulses,
        parts: &[Range<usize>],
        (on, patch): (&CoarseRows, &Patch),
        images: &mut Vec<CoarseImage>,
        (meter, pixels): (&Meter, usize),
    ) {
        if images.len() < parts.len() {
            images.resize_with(parts.len(), CoarseImage::default);
        }
        let counter = |part: &Range<usize>| Counter {
            meter,
            contributions: (pixels * part.len()) as u64,
        };
        match &self.source {
            Source::Tables(direct) => images.par_iter_mut().zip(parts).for_each(|(image, part)| {
                on.sum_tables(direct, echoes, part, image, &counter(part));
            }),
            Source::SubApertures(shorter) => {
                let coarse = on.patch(patch.terrain);
                let ground = CoarseGround::under(&shorter.lattice, &coarse);
                let below =
                    CoarseRows::new(&shorter.lattice, self.level, &coarse.grid, ground.as_ref());
                let merger = Merger::new(&shorter.lattice, self.level, &coarse);
                let silent = Meter::silent(meter.control());
                // One after the other: memory holds the images of the shorter sub-apertures of one longer
                // one, and is reused.
                let mut of_part = Vec::new();
                for (image, part) in images.iter_mut().zip(parts) {
                    let within = shorter.parts_of(part);
                    let of = (&below, &coarse);
                    shorter.image_parts(echoes, within, of, &mut of_part, (&silent, 0));
                    let centre_m = centre_m(&echoes.pulses, part.clone());
                    on.merge(
                        &merger,
                        &of_part[..within.len()],
                        centre_m,
                        image,
                        &counter(part),
                    );
                }
            }
        }
    }

    /// The sub-apertures within `part`.
    fn parts_of(&self, part: &Range<usize>) -> &[Range<usize>] {
        let from = self.parts.partition_point(|p| p.start < part.start);
        let to = self.parts.partition_point(|p| p.end <= part.end);
        &self.parts[from..to.max(from)]
    }
}

/// Number of the `pixels` whose contributions count as done before merging: a third. Coarse images advance
/// progress in a few large steps, merging row after row.
fn before_merging(pixels: usize) -> usize {
    pixels / 3
}
