//! Estimated run time of a factorized image.

use super::aperture::centre_m;
use super::merged::{CoarseImage, Factorized};
use crate::control::{Control, Meter};
use crate::engine::planar::padded;
use crate::engine::weights::WeightedPulses;
use crate::grid::tilted::TiltedGrid;
use crate::sampling::{Random, best_of_two};
use num_complex::Complex32;
use rayon::prelude::*;

impl Factorized {
    /// Estimated run time on the threads of the current pool, from a few rows of coarse images and a
    /// few cells of merging, s.
    pub fn estimate_run_time_s(
        &self,
        echoes: &WeightedPulses,
        grid: &TiltedGrid,
        control: Control,
    ) -> f64 {
        let pulses = &echoes.pulses;
        let spec = &self.lattice.spec;
        let across = spec.coarse.cells[1];
        let dy = across.pixels;
        let threads = rayon::current_num_threads();
        let coarse = spec.coarse.grid(grid);
        let row_samples = spec.coarse.row_samples(grid);
        let parts = &self.parts;
        let mut random = Random(0x7e57);

        // Full rows, two tiles of them, as in the run: neighbours share what the caches hold.
        let rows = (2 * self
            .direct
            .spec
            .shape_on(false)
            .tile_rows(self.level.lanes()))
        .min(coarse.rows);
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
        let imaging = best_of_two(|| {
            places.par_iter().for_each(|&(part, row)| {
                let piece = TiltedGrid {
                    origin_m: coarse.point_m(0.0, row as f64),
                    rows,
                    ..coarse
                };
                std::hint::black_box(self.coarse_image(
                    echoes,
                    (&piece, row_samples),
                    &parts[part],
                    control,
                ));
            });
        }) * (pulses.len() * coarse.rows) as f64
            / sampled as f64;

        let cells = threads.min(grid.rows.div_ceil(dy));
        let stride = padded(row_samples);
        let length = stride * (cells * across.samples + spec.coarse.taps);
        let images: Vec<CoarseImage> = parts
            .iter()
            .map(|part| CoarseImage {
                centre_m: centre_m(pulses, part.clone()),
                real: vec![1e-3; length],
                imag: vec![1e-3; length],
            })
            .collect();
        let few = TiltedGrid {
            rows: (cells * dy).min(grid.rows),
            ..*grid
        };
        let mut out = vec![Complex32::ZERO; few.columns * few.rows];
        let meter = Meter::silent(control);
        let merging = best_of_two(|| self.merge(&images, &few, &mut out, &meter))
            * grid.rows as f64
            / few.rows as f64;
        imaging + merging
    }
}
