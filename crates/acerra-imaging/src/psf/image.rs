//! Eqs. (4) and (5) on a whole grid.

use num_complex::Complex32;

use super::spread::PointSpread;
use crate::engine::reference::{Scatterer, forward};
use crate::error::ImagingError;
use crate::grid::plane::PlaneGrid;
use crate::plan::imaging::image;
use crate::plan::options::PlanOptions;
use crate::pulses::{PulseArrays, Pulses, Spreading};
use acerra_control::Control;
use num_complex::Complex64;

/// The image of unit points at `target_m` on `grid`, row-major `[ny, nx]`: the data of Eq. (4),
/// imaged by Eq. (3) like measured ones, to a relative error of 10⁻³ over the grid.
///
/// # Errors
/// When there is no target, an antenna is exactly on a target or a pixel, or the image does
/// not fit memory; cancellation.
///
/// ```
/// use acerra_imaging::{Control, PlaneGrid};
/// use acerra_imaging::psf::{PointSpread, TrackShape, psf_image, synthetic_track};
/// let track = synthetic_track(TrackShape::Straight, 1.0, 0.02, 3.0)?;
/// let frequency_hz = (0..35).map(|n| 3.1e9 + 5e7 * f64::from(n)).collect();
/// let spread = PointSpread::new(track, None, frequency_hz, 3e8)?;
/// let grid = PlaneGrid::from_ranges([-0.3, 0.3], [0.7, 1.3], 0.0, 0.02)?;
/// let image = psf_image(&spread, &[[0.0, 1.0, 0.0]], grid, Control::default())?;
/// let peak = spread.response([0.0, 1.0, 0.0], [0.0, 1.0, 0.0]).norm();
/// assert!((f64::from(image[15 * 31 + 15].norm()) / peak - 1.0).abs() < 2e-3);
/// # Ok::<(), acerra_imaging::ImagingError>(())
/// ```
pub fn psf_image(
    spread: &PointSpread,
    target_m: &[[f64; 3]],
    grid: PlaneGrid,
    control: Control,
) -> Result<Vec<Complex32>, ImagingError> {
    if target_m.is_empty() {
        return Err(ImagingError::Empty { what: "target_m" });
    }
    let scatterers: Vec<Scatterer> = target_m
        .iter()
        .map(|t| Scatterer {
            position_m: *t,
            reflectivity: Complex64::ONE,
        })
        .collect();
    let (position_m, frequency_hz) = (spread.position_m(), spread.frequency_hz());
    let c = spread.light_speed_m_s();
    let spectrum = forward(
        position_m,
        frequency_hz,
        &scatterers,
        c,
        Spreading::InverseSquare,
    )?;
    let pulses = Pulses::new(PulseArrays {
        position_m,
        frequency_hz,
        spectrum: &spectrum,
        weight: spread.weight(),
        light_speed_m_s: c,
    })?;
    image(pulses, grid, &PlanOptions::default(), control)
}
