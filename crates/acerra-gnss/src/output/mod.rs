//! Output formats of a solution other than [RTKLIB's solution files](crate::pos): NMEA sentences, residuals,
//! positions of images, headings of baselines.

mod attitude;
mod images;
mod nmea;
mod residuals;

pub use attitude::write_attitudes;
pub use images::{ImageError, ImagePosition, position_images, write_images};
pub use nmea::write_nmea;
pub use residuals::write_residuals;

use crate::solution::PpkSolution;

/// A solution without the epochs whose standard deviation along any axis (ECEF; of the baseline with a moving
/// base) is larger than `max_m`, and the number of these epochs (RTKLIB's `out-maxsolstd`).
#[must_use]
pub fn within_sigma(solution: &PpkSolution, max_m: f64) -> (PpkSolution, usize) {
    let mut kept = solution.clone();
    kept.epochs.retain(|epoch| {
        let c = &epoch.relative_covariance_ecef_m2();
        let largest = c[0][0].max(c[1][1]).max(c[2][2]).max(0.0);
        largest.sqrt() <= max_m
    });
    let dropped = solution.epochs.len() - kept.epochs.len();
    (kept, dropped)
}
