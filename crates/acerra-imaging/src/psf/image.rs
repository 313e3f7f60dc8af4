//! Eqs. (4) and (5) on a whole grid.

use num_complex::Complex32;
use rayon::prelude::*;

use super::{PointSpread, PsfField};
use crate::{ImagingError, PlaneGrid};

/// The image of unit points at `target_m` on `grid`, row-major `[ny, nx]`.
///
/// # Errors
/// When there is no target, or an antenna stands exactly on a target or a pixel.
pub fn psf_image(
    spread: &PointSpread,
    target_m: &[[f64; 3]],
    grid: PlaneGrid,
) -> Result<Vec<Complex32>, ImagingError> {
    if target_m.is_empty() {
        return Err(ImagingError::Empty { what: "target_m" });
    }
    let field = PsfField::new(spread, target_m, grid.z_m);
    let image: Vec<Complex32> = (0..grid.len())
        .into_par_iter()
        .map(|k| {
            let at = grid.point_m(k);
            let v = field.value(at[0], at[1]);
            Complex32::new(v.re as f32, v.im as f32)
        })
        .collect();
    crate::pulses::check_finite("image", image.iter().map(|v| f64::from(v.re + v.im)))?;
    Ok(image)
}
