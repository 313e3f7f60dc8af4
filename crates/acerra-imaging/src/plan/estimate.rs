//! Estimated run time of a plan: pieces of its own work are done and timed.

use super::imaging::ImagingPlan;
use super::planner::Method;
use crate::control::{Control, Meter};
use crate::engine::direct::Direct;
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
        match &self.method {
            Method::Reference => self.time_reference(control),
            _ if self.contributions() < SMALL => {
                let mut image = vec![Complex32::ZERO; self.pixels()];
                best_of_two(|| self.run(&mut image, control))
            }
            Method::Direct(direct) => self.time_bands(direct, control),
            Method::Factorized(factorized) => {
                let (echoes, grid) = (&self.request.echoes, self.request.grid.plane());
                factorized.estimate_run_time_s(echoes, grid, control)
            }
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

    /// From bands of full rows, as the run makes them: neighbours share the tables' entries in the
    /// caches. An even number, so that none lies right under a track in the middle.
    fn time_bands(&self, direct: &Direct, control: Control) -> f64 {
        let (echoes, grid) = (&self.request.echoes, &self.request.grid);
        let lanes = self.request.options.level.lanes();
        let least =
            direct.spec.shape_on(grid.is_uneven()).tile_rows(lanes) * rayon::current_num_threads();
        let work = (least * grid.columns() * echoes.len()) as u64;
        let rows = (least * (SMALL / work.max(1)).clamp(1, 8) as usize).min(grid.rows());
        let mut out = vec![Complex32::ZERO; rows * grid.columns()];
        let count = (grid.rows() / (200 * rows)).clamp(2, 6) * 2;
        let meter = Meter::silent(control);
        let mut seconds = 0.0;
        for k in 0..count {
            let j = (grid.rows() - rows) * (2 * k + 1) / (2 * count);
            let band = grid.patch([0, j], [grid.columns(), rows]);
            seconds += best_of_two(|| direct.run(echoes, 0..echoes.len(), &band, &mut out, &meter));
        }
        seconds * grid.rows() as f64 / (count * rows) as f64
    }
}
