//! Estimated run time of a plan: pieces of its own work are done and timed.

use super::imaging::ImagingPlan;
use super::planner::Method;
use crate::control::Control;
use crate::sampling::{Random, best_of_two};
use num_complex::Complex32;
use rayon::prelude::*;

/// Contributions below which the whole image is computed to time it.
const SMALL: u64 = 60_000_000;

impl ImagingPlan<'_> {
    /// Estimated seconds of [`ImagingPlan::run`] on the threads of the pool it is called from, found
    /// by doing about a hundredth of the work (small images are computed whole). Once cancelled, the
    /// value has no meaning.
    #[must_use]
    pub fn estimate_run_time_s(&self, control: Control) -> f64 {
        let control = control.silent();
        let (echoes, grid) = (&self.request.echoes, &self.request.grid);
        match &self.method {
            Method::Reference => self.time_reference(control),
            _ if self.contributions() < SMALL => {
                let mut image = vec![Complex32::ZERO; self.pixels()];
                best_of_two(|| self.run(&mut image, control))
            }
            Method::Direct(direct) => direct.estimate_s(echoes, grid, control),
            Method::Factorized(factorized) => factorized.estimate_s(echoes, grid, control),
        }
    }

    /// From two pixels a thread.
    fn time_reference(&self, control: Control) -> f64 {
        let grid = &self.request.grid;
        let pixels = (2 * rayon::current_num_threads()).min(self.pixels());
        let mut random = Random(0x7e57);
        let places: Vec<_> = (0..pixels)
            .map(|_| (random.below(grid.columns()), random.below(grid.rows())))
            .collect();
        let work = || {
            places
                .par_iter()
                .filter(|_| !control.is_cancelled())
                .map(|&(i, j)| self.request.echoes.adjoint_at(grid.point_m(i, j)).re)
                .sum::<f64>()
        };
        best_of_two(work) * self.pixels() as f64 / pixels as f64
    }
}
