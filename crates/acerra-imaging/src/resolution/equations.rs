//! The paper's closed forms, one function an equation.

use std::f64::consts::FRAC_PI_2;

use super::geometry::Aperture;
use crate::checks::check_positive;
use crate::error::ImagingError;

fn view(half_view_rad: f64) -> Result<(), ImagingError> {
    let expected = "above 0 and at most π/2 rad";
    check_positive("half_view_rad", expected, half_view_rad)?;
    if half_view_rad > FRAC_PI_2 {
        let what = "half_view_rad";
        return Err(ImagingError::OutOfRange {
            what,
            expected,
            found: half_view_rad,
        });
    }
    Ok(())
}

/// Eq. (6): along-track resolution c/(4 f_c sin θ), m, for views from −θ to θ = `half_view_rad`.
///
/// Exact for a narrow band seen by a straight, evenly sampled aperture; it holds up to θ = π/2,
/// where it gives a quarter of the wavelength.
///
/// # Errors
/// A frequency or speed that is not positive, an angle outside (0, π/2].
///
/// ```
/// let along_m = acerra_imaging::resolution::along_track_m(3.95e9, 0.540, 3e8)?;
/// assert!((along_m - 0.0369).abs() < 1e-4);
/// # Ok::<(), acerra_imaging::ImagingError>(())
/// ```
pub fn along_track_m(
    centre_hz: f64,
    half_view_rad: f64,
    light_speed_m_s: f64,
) -> Result<f64, ImagingError> {
    check_positive("centre_hz", "above 0 Hz", centre_hz)?;
    check_positive("light_speed_m_s", "above 0 m/s", light_speed_m_s)?;
    view(half_view_rad)?;
    Ok(light_speed_m_s / (4.0 * centre_hz * half_view_rad.sin()))
}

/// Eq. (7): Eq. (6) with θ for sin θ.
///
/// Smaller than Eq. (6), by less than 5 % for θ < 0.54 rad (see [`SMALL_ANGLE_LIMIT_RAD`]).
///
/// # Errors
/// As [`along_track_m`].
pub fn along_track_small_angle_m(
    centre_hz: f64,
    half_view_rad: f64,
    light_speed_m_s: f64,
) -> Result<f64, ImagingError> {
    let along_m = along_track_m(centre_hz, half_view_rad, light_speed_m_s)?;
    Ok(along_m * half_view_rad.sin() / half_view_rad)
}

/// Above this half view Eq. (7) is more than 5 % below Eq. (6).
pub const SMALL_ANGLE_LIMIT_RAD: f64 = 0.54;

/// The half view θ of a target at range √(h² + d²) abeam the middle of an aperture of half-length
/// L: tan θ = L/√(h² + d²).
///
/// # Errors
/// A half-aperture or height that is not positive, a negative offset.
pub fn half_view_rad(
    half_aperture_m: f64,
    height_m: f64,
    offset_m: f64,
) -> Result<f64, ImagingError> {
    check_positive("half_aperture_m", "above 0 m", half_aperture_m)?;
    let aperture = Aperture::new(height_m, offset_m)?;
    Ok(half_aperture_m.atan2(aperture.range_m()))
}

/// Eq. (8): range resolution c/(2B), m.
///
/// # Errors
/// A bandwidth or speed that is not positive: with no bandwidth there is no range resolution.
pub fn range_m(bandwidth_hz: f64, light_speed_m_s: f64) -> Result<f64, ImagingError> {
    check_positive("bandwidth_hz", "above 0 Hz", bandwidth_hz)?;
    check_positive("light_speed_m_s", "above 0 m/s", light_speed_m_s)?;
    Ok(light_speed_m_s / (2.0 * bandwidth_hz))
}

/// Eq. (9): across-track resolution √(d² + Δr² + 2Δr√(h² + d²)) − d, m: where the shell one range
/// resolution beyond the target cuts the image plane.
///
/// Eq. (9) is the outer half of the lobe of a straight track, single look; the inner half is longer (see
/// Table 1's evaluated columns). Eq. (9) presumes Δr well below the range.
///
/// # Errors
/// A range resolution or height that is not positive, a negative offset.
///
/// ```
/// use acerra_imaging::resolution::{across_track_m, range_m};
/// let range_m = range_m(1.7e9, 3e8)?;
/// assert!((across_track_m(range_m, 5.0, 2.0)? - 0.227).abs() < 5e-4);
/// assert!((across_track_m(range_m, 4.0, 0.0)? - 0.845).abs() < 5e-4);
/// # Ok::<(), acerra_imaging::ImagingError>(())
/// ```
pub fn across_track_m(
    range_resolution_m: f64,
    height_m: f64,
    offset_m: f64,
) -> Result<f64, ImagingError> {
    check_positive("range_resolution_m", "above 0 m", range_resolution_m)?;
    let target_range_m = Aperture::new(height_m, offset_m)?.range_m();
    let beyond = range_resolution_m * (range_resolution_m + 2.0 * target_range_m);
    // √(d² + q) − d without cancellation at large d.
    Ok(beyond / ((offset_m * offset_m + beyond).sqrt() + offset_m))
}

/// Eq. (10): Eq. (9) at nadir, Δr √(1 + 2h/Δr), m; also the upper bound of Eq. (12).
///
/// # Errors
/// As [`across_track_m`].
pub fn across_track_nadir_m(range_resolution_m: f64, height_m: f64) -> Result<f64, ImagingError> {
    across_track_m(range_resolution_m, height_m, 0.0)
}

/// Eqs. (11) and (12): least and greatest across-track resolution from height h, m: Δr far from the
/// track, Eq. (10) below it.
///
/// # Errors
/// As [`across_track_m`].
pub fn across_track_bounds_m(
    range_resolution_m: f64,
    height_m: f64,
) -> Result<[f64; 2], ImagingError> {
    Ok([
        range_resolution_m,
        across_track_nadir_m(range_resolution_m, height_m)?,
    ])
}

/// Eq. (14): outward displacement, m, of the image of a target at horizontal distance d from the track on a
/// plane z above it: √(d² + 2hz − z²) − d, h being the height of the flight above the target.
///
/// `None` when the shell about the track does not reach the plane: the plane is too far below the target,
/// which is then not seen on the plane. z < 0 is a plane below the target; at d = 0 every such plane is
/// blind.
///
/// # Errors
/// A height that is not positive, a negative offset, a plane not below the flight.
///
/// ```
/// use acerra_imaging::resolution::displacement_m;
/// assert!((displacement_m(5.0, 0.0, 0.4)?.unwrap() - 1.96).abs() < 5e-3);
/// assert_eq!(displacement_m(5.0, 0.0, -0.2)?, None);
/// # Ok::<(), acerra_imaging::ImagingError>(())
/// ```
pub fn displacement_m(
    height_m: f64,
    offset_m: f64,
    plane_above_target_m: f64,
) -> Result<Option<f64>, ImagingError> {
    Aperture::new(height_m, offset_m)?;
    let z = plane_above_target_m;
    if !(z.is_finite() && z < height_m) {
        let expected = "a plane below the flight (less than height_m)";
        let what = "plane_above_target_m";
        return Err(ImagingError::OutOfRange {
            what,
            expected,
            found: z,
        });
    }
    let seen2 = offset_m * offset_m + z * (2.0 * height_m - z);
    Ok((seen2 >= 0.0).then(|| seen2.sqrt() - offset_m))
}

/// The longest distance between pulses, m, that keeps the phase between neighbours unambiguous for
/// every direction within the view: λ_min/(4 sin θ).
///
/// Longer distances cause grating lobes, which the band spreads out but does not remove.
///
/// # Errors
/// A frequency or speed that is not positive, an angle outside (0, π/2].
pub fn longest_step_m(
    highest_hz: f64,
    half_view_rad: f64,
    light_speed_m_s: f64,
) -> Result<f64, ImagingError> {
    along_track_m(highest_hz, half_view_rad, light_speed_m_s)
}

/// The range, m, beyond which evenly spaced frequencies repeat: c/(2Δf).
///
/// # Errors
/// A step or speed that is not positive.
pub fn unambiguous_range_m(step_hz: f64, light_speed_m_s: f64) -> Result<f64, ImagingError> {
    range_m(step_hz, light_speed_m_s)
}
