//! Figure 6: across-track resolution over offset and height.

use super::equations::across_track_m;
use crate::error::ImagingError;

/// Eq. (9) on a grid of offsets and heights: `[heights, offsets]` row-major, m.
///
/// # Errors
/// As [`across_track_m`], for any of the pairs.
pub fn across_track_map_m(
    range_resolution_m: f64,
    offset_m: &[f64],
    height_m: &[f64],
) -> Result<Vec<f64>, ImagingError> {
    let mut map = Vec::with_capacity(offset_m.len().saturating_mul(height_m.len()));
    for h in height_m {
        for d in offset_m {
            map.push(across_track_m(range_resolution_m, *h, *d)?);
        }
    }
    Ok(map)
}
