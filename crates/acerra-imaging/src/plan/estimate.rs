//! How long a plan will take: pieces of its own work are done and timed.

use super::{Method, Plan, exact};
use crate::TiltedGrid;
use crate::simd::rows::tile_rows;
use crate::trial::{Random, best_of_two};
use num_complex::Complex32;
use rayon::prelude::*;

/// Contributions below which the whole image is made to learn how long that takes.
const SMALL: u64 = 60_000_000;

impl Plan<'_> {
    /// Seconds that [`Plan::run`] will take on the threads of the pool it is called from, found by
    /// doing about a hundredth of the work (small images are made whole).
    #[must_use]
    pub fn estimate_s(&self) -> f64 {
        let threads = rayon::current_num_threads();
        match &self.method {
            Method::Reference => {
                let pixels = (2 * threads).min(self.pixels());
                let mut random = Random(0x7e57);
                let places: Vec<_> = (0..pixels)
                    .map(|_| {
                        (
                            random.below(self.grid.columns),
                            random.below(self.grid.rows),
                        )
                    })
                    .collect();
                let work = || {
                    places
                        .par_iter()
                        .map(|&(i, j)| exact(&self.pulses, self.point_m(i, j), &self.weights).re)
                        .sum::<f64>()
                };
                best_of_two(work) * self.pixels() as f64 / pixels as f64
            }
            _ if (self.pixels() as u64).saturating_mul(self.pulses.len() as u64) < SMALL => {
                let mut image = vec![Complex32::ZERO; self.pixels()];
                best_of_two(|| self.run(&mut image, &|_| ()))
            }
            Method::Direct(direct) => {
                // Bands of full rows, as the run makes them: neighbours share the tables' entries in
                // the caches. An even number, so that none lies right under a track in the middle.
                let least = tile_rows(self.options.level.lanes()) * threads;
                let work = (least * self.grid.columns * self.pulses.len()) as u64;
                let rows = (least * (SMALL / work.max(1)).clamp(1, 8) as usize).min(self.grid.rows);
                let mut out = vec![Complex32::ZERO; rows * self.grid.columns];
                let count = (self.grid.rows / (200 * rows)).clamp(2, 6) * 2;
                let mut bands = 0.0;
                for k in 0..count {
                    let j = (self.grid.rows - rows) * (2 * k + 1) / (2 * count);
                    let band = TiltedGrid {
                        origin_m: self.grid.point_m(0.0, j as f64),
                        rows,
                        ..self.grid
                    };
                    bands += best_of_two(|| {
                        direct.run_over(
                            &self.pulses,
                            0..self.pulses.len(),
                            &self.weights,
                            &band,
                            self.relief().map(|r| r.seen_from(0, j)),
                            &mut out,
                            &|_| (),
                        )
                    });
                }
                bands * self.grid.rows as f64 / (count * rows) as f64
            }
            Method::Factorized(factorized) => {
                factorized.estimate_s(&self.pulses, &self.weights, &self.grid)
            }
        }
    }
}
