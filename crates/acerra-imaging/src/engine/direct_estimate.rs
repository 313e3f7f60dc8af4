//! Estimated run time of the direct engine.

use super::direct::Direct;
use super::weights::WeightedPulses;
use crate::control::Meter;
use crate::grid::image::ImageGrid;
use crate::sampling::best_of_two;
use acerra_control::Control;
use num_complex::Complex32;

/// Contributions of a band that is long enough to be timed.
const ENOUGH: u64 = 60_000_000;

impl Direct {
    /// Estimated run time on the threads of the current pool, s: from bands of full rows, as the run
    /// makes them, since neighbours share the tables' entries in the caches. An even number of bands, so
    /// that none lies right under a track in the middle.
    pub fn estimate_run_time_s(
        &self,
        echoes: &WeightedPulses,
        grid: &ImageGrid,
        control: Control,
    ) -> f64 {
        let lanes = self.level.lanes();
        let least =
            self.spec.shape_on(grid.is_uneven()).tile_rows(lanes) * rayon::current_num_threads();
        let work = (least * grid.columns() * echoes.len()) as u64;
        let rows = (least * (ENOUGH / work.max(1)).clamp(1, 8) as usize).min(grid.rows());
        let mut out = vec![Complex32::ZERO; rows * grid.columns()];
        let count = (grid.rows() / (200 * rows)).clamp(2, 6) * 2;
        let meter = Meter::silent(control);
        let mut seconds = 0.0;
        for k in 0..count {
            let j = (grid.rows() - rows) * (2 * k + 1) / (2 * count);
            let band = grid.patch([0, j], [grid.columns(), rows]);
            seconds += best_of_two(|| self.run(echoes, 0..echoes.len(), &band, &mut out, &meter));
        }
        seconds * grid.rows() as f64 / (count * rows) as f64
    }
}
