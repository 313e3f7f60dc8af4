//! Estimated run time of a factorized image.

use super::aperture::centre_m;
use super::coarse_rows::{CoarseRows, Counter};
use super::heights::CoarseGround;
use super::merged::{Factorized, Source};
use super::merging::CoarseImage;
use crate::control::Meter;
use crate::engine::direct::Direct;
use crate::engine::planar::padded;
use crate::engine::weights::WeightedPulses;
use crate::grid::image::Patch;
use crate::sampling::{Random, best_of_two};
use acerra_control::Control;
use num_complex::Complex32;
use rayon::prelude::*;

impl Factorized {
    /// Estimated run time on the threads of the current pool, from a few rows of coarse images and a
    /// few cells of merging, s.
    pub fn estimate_run_time_s(
        &self,
        echoes: &WeightedPulses,
        patch: &Patch,
        control: Control,
    ) -> f64 {
        let ground = CoarseGround::under(&self.lattice, patch);
        let on = CoarseRows::new(&self.lattice, self.level, &patch.grid, ground.as_ref());
        let imaging_s = match &self.source {
            Source::Tables(direct) => self.estimate_imaging_s(direct, echoes, &on, control),
            Source::SubApertures(shorter) => {
                shorter.estimate_run_time_s(echoes, &on.patch(patch.terrain), control)
            }
        };
        imaging_s + self.estimate_merging_s(echoes, patch, control)
    }

    /// Estimated time of the coarse images.
    fn estimate_imaging_s(
        &self,
        direct: &Direct,
        echoes: &WeightedPulses,
        on: &CoarseRows,
        control: Control,
    ) -> f64 {
        let threads = rayon::current_num_threads();
        let (coarse, parts) = (&on.grid, &self.parts);
        let mut random = Random(0x7e57);

        // Full rows, two tiles of them, as in the run: neighbours share cached data.
        let tile_rows = on.shape(direct).tile_rows(self.level.lanes());
        let rows = (2 * tile_rows).min(coarse.rows);
        let count = (coarse.rows * parts.len() / (100 * rows))
            .clamp(2, 64)
            .next_multiple_of(threads);
        let places: Vec<_> = (0..count)
            .map(|_| {
                (
                    random.below(parts.len()),
                    random.below(coarse.rows - rows + 1),
                )
            })
            .collect();
        let mut sampled = 0;
        for (part, _) in &places {
            sampled += parts[*part].len() * rows;
        }
        let silent = Counter {
            meter: &Meter::silent(control),
            contributions: 0,
        };
        let mut images: Vec<_> = places.iter().map(|_| CoarseImage::default()).collect();
        best_of_two(|| {
            let work = places.par_iter().zip(&mut images);
            work.for_each(|(&(part, row), image)| {
                let some = on.some(row, rows);
                some.sum_tables(direct, echoes, &parts[part], image, &silent);
            });
        }) * (echoes.len() * coarse.rows) as f64
            / sampled as f64
    }

    /// Estimated time of merging the coarse images.
    fn estimate_merging_s(&self, echoes: &WeightedPulses, patch: &Patch, control: Control) -> f64 {
        let (grid, coarse) = (&patch.grid, &self.lattice.stage.coarse);
        let across = coarse.cells[1];
        let dy = across.pixels;
        let threads = rayon::current_num_threads();
        let cells = threads.min(grid.rows.div_ceil(dy));
        let stride = padded(coarse.row_samples(grid));
        let length = stride * (cells * across.samples + coarse.taps);
        let images: Vec<CoarseImage> = (self.parts)
            .iter()
            .map(|part| CoarseImage {
                centre_m: centre_m(&echoes.pulses, part.clone()),
                real: vec![1e-3; length],
                imag: vec![1e-3; length],
            })
            .collect();
        let few = patch.rows_from(0, (cells * dy).min(grid.rows));
        let mut out = vec![Complex32::ZERO; few.grid.columns * few.grid.rows];
        let meter = Meter::silent(control);
        let merging = || self.merge(&images, echoes.len(), &few, &mut out, &meter);
        best_of_two(merging) * grid.rows as f64 / few.grid.rows as f64
    }
}
