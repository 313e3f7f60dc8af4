//! The highest point of a lobe whose crest is long and nearly flat.

use super::field::{Field, best_on_line, climb_to_peak};
use crate::psf::cell::Cell;

/// Samples of the crest on either side, within half a Rayleigh distance across.
const LOOKS: i32 = 8;
/// Step of the search along the track, as a share of the Rayleigh distance along it: small enough
/// for a parabola, large enough to follow a crest askew to the track.
const ALONG_SHARE: f64 = 0.1;
/// A crest that still rises at the end of one search is followed in the next.
const SEARCHES: usize = 4;
/// The crest ends where it falls below this share of its top: an image's errors of up to 10⁻² make dips of up
/// to 2·10⁻², and beyond a deeper dip lies another target.
const FLAT: f64 = 0.98;

/// Climbs to the maximum nearest to `start_m` and follows its crest across the track, up to half a Rayleigh
/// distance to either side while the crest is flat, to the highest point.
///
/// The lobe of a target under the track is several decimetres long across the track and flat to fractions of
/// a per cent, so that errors of the image (10⁻³ of the peak by default) cause several maxima on the crest,
/// and the start pixel decides which of these maxima a plain climb finds. Arguments and result as
/// [`climb_to_peak`]; `tangent` is the horizontal unit vector of the flight direction at the lobe
/// ([`LocalTrack::tangent`](super::LocalTrack::tangent)), `cell` its Rayleigh distances.
///
/// # Example
/// ```
/// use acerra_imaging::metrics::{Field, climb_crest, climb_to_peak};
/// use acerra_imaging::psf::Cell;
///
/// /// A crest along y whose top is at −0.1 m, with ripples of 0.2 %.
/// struct Crest;
/// impl Field for Crest {
///     fn amplitude(&self, x_m: f64, y_m: f64) -> Option<f64> {
///         let y = y_m + 0.1;
///         let along_crest = 1.0 - 0.02 * (y / 0.3).powi(2) + 0.002 * (62.8 * y).cos();
///         Some((1.0 - (x_m / 0.02).powi(2)) * along_crest)
///     }
/// }
/// let cell = Cell { along_m: 0.05, across_m: 0.6 };
/// let (alone, _) = climb_to_peak(&Crest, [0.0, 0.12], 0.01).unwrap();
/// let (top, _) = climb_crest(&Crest, [0.0, 0.12], 0.01, [1.0, 0.0], cell).unwrap();
/// assert!(alone[1] > 0.0 && (top[1] + 0.1).abs() < 0.001);
/// ```
pub fn climb_crest(
    field: &dyn Field,
    start_m: [f64; 2],
    step_m: f64,
    tangent: [f64; 2],
    cell: Cell,
) -> Option<([f64; 2], f64)> {
    let mut top = climb_to_peak(field, start_m, step_m)?;
    for _ in 0..SEARCHES {
        let highest = highest_on_crest(field, top, tangent, cell);
        if highest.1 <= top.1 {
            break;
        }
        top = climb_to_peak(field, highest.0, step_m)?;
    }
    Some(top)
}

/// The highest sample of the crest through `top`.
fn highest_on_crest(
    field: &dyn Field,
    top: ([f64; 2], f64),
    tangent: [f64; 2],
    cell: Cell,
) -> ([f64; 2], f64) {
    let left = [-tangent[1], tangent[0]];
    let look_m = 0.5 * cell.across_m / f64::from(LOOKS);
    let mut highest = top;
    for side in [-look_m, look_m] {
        let mut here = top.0;
        for _ in 0..LOOKS {
            let next = [here[0] + side * left[0], here[1] + side * left[1]];
            let Some(level) = field.amplitude(next[0], next[1]) else {
                break;
            };
            let mut crest = (next, level);
            for share in [ALONG_SHARE, 0.25 * ALONG_SHARE] {
                crest = best_on_line(field, crest, tangent, share * cell.along_m);
            }
            if crest.1 < FLAT * highest.1 {
                break;
            }
            if crest.1 > highest.1 {
                highest = crest;
            }
            here = crest.0;
        }
    }
    highest
}
