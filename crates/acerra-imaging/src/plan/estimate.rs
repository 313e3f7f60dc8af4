//! Estimated run time of a plan, from timed pieces of the plan's work.

use super::imaging::ImagingPlan;
use super::planner::Method;
use crate::control::Meter;
use crate::engine::double::{DoubleTables, rows_together};
use crate::kernel::profile::DELAYS;
use crate::sampling::{Random, best_of_two};
use acerra_control::Control;
use num_complex::Complex32;

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
            Method::Double(tables) => self.time_double(tables, control),
            _ if self.contributions() < SMALL => {
                let mut image = vec![Complex32::ZERO; self.pixels()];
                best_of_two(|| self.run(&mut image, control))
            }
            Method::Direct(direct) => direct.estimate_s(echoes, grid, control),
            Method::Factorized(factorized) => factorized.estimate_s(echoes, grid, control),
        }
    }

    /// Estimated seconds of the engine in double precision, from some rows.
    fn time_double(&self, tables: &DoubleTables, control: Control) -> f64 {
        let (echoes, grid) = (&self.request.echoes, &self.request.grid);
        let rows = (rayon::current_num_threads() * rows_together(echoes)).min(grid.rows());
        let mut image = vec![Complex32::ZERO; rows * grid.columns()];
        let meter = Meter::silent(control);
        let work = || tables.run(echoes, grid, &mut image, &meter);
        best_of_two(work) * grid.rows() as f64 / rows as f64
    }

    /// Estimated seconds of the reference, from as many pixels a thread as are summed side by side.
    fn time_reference(&self, control: Control) -> f64 {
        let grid = &self.request.grid;
        let pixels = (DELAYS * rayon::current_num_threads()).min(self.pixels());
        let mut random = Random(0x7e57);
        let points_m: Vec<_> = (0..pixels)
            .map(|_| grid.point_m(random.below(grid.columns()), random.below(grid.rows())))
            .collect();
        let echoes = &self.request.echoes;
        let work = || echoes.adjoint_at(&points_m, || control.is_cancelled());
        best_of_two(work) * self.pixels() as f64 / pixels as f64
    }
}
