//! The restored image of CLEAN: components under a beam without sidelobes, over the residual image.

use crate::clean::CleanSolution;
use crate::flight::Flight;
use acerra_imaging::metrics::LocalTrack;
use acerra_imaging::psf::Cell;
use acerra_imaging::reference::range_m;
use acerra_imaging::{Complex64, ImageGrid};
use std::f64::consts::PI;

/// Full width at −3 dB of the main lobe of a flat band or aperture over its Rayleigh distance.
const WIDTH_OVER_RAYLEIGH: f64 = 0.886;
/// Extent of a drawn beam in standard deviations of amplitude.
const REACH: f64 = 3.5;

/// Puts every component back as a Gaussian of the widths that theory expects at its place (Eqs. (6) and
/// (9)), with the phase of its range, onto the residual image.
///
/// The width of a restored target is therefore the theoretical width, not a measurement.
#[must_use]
pub fn restore(solution: &CleanSolution, flight: &Flight, grid: &ImageGrid) -> Vec<Complex64> {
    let mut image = solution.residual.clone();
    let (low_hz, high_hz) = flight.spread().band_hz();
    let wavenumber = 2.0 * PI * (low_hz + high_hz) / flight.light_speed_m_s();
    let origin_m = grid.point_m(0, 0);
    let step = |i: usize, j: usize| {
        let at = grid.point_m(i.min(grid.columns() - 1), j.min(grid.rows() - 1));
        (at[0] - origin_m[0]).hypot(at[1] - origin_m[1])
    };
    let pixel_m = step(1, 0).max(step(0, 1)).max(1e-6);
    for component in &solution.components {
        let Some(track) = LocalTrack::at(flight.position_m(), component.point_m) else {
            continue;
        };
        let cell = Cell::expected(flight.spread(), &track, component.point_m);
        // Power e^{−x²/s²} falls to a half over the full width 2s√ln 2.
        let deviation =
            |rayleigh_m: f64| WIDTH_OVER_RAYLEIGH * rayleigh_m / (2.0 * 2f64.ln().sqrt());
        let (along_m, across_m) = (deviation(cell.along_m), deviation(cell.across_m));
        let reach = (REACH * along_m.max(across_m) / pixel_m).ceil() as usize;
        let (i0, j0) = (
            component.pixel % grid.columns(),
            component.pixel / grid.columns(),
        );
        let nearest_m = range_m(track.closest_m, component.point_m);
        let left = track.left();
        for j in j0.saturating_sub(reach)..(j0 + reach + 1).min(grid.rows()) {
            for i in i0.saturating_sub(reach)..(i0 + reach + 1).min(grid.columns()) {
                let at_m = grid.point_m(i, j);
                let off = [
                    at_m[0] - component.point_m[0],
                    at_m[1] - component.point_m[1],
                ];
                let on = |axis: [f64; 2]| off[0] * axis[0] + off[1] * axis[1];
                let exponent =
                    (on(track.tangent) / along_m).powi(2) + (on(left) / across_m).powi(2);
                if exponent > REACH * REACH {
                    continue;
                }
                let foot_m = [
                    track.closest_m[0] + track.tangent[0] * on(track.tangent),
                    track.closest_m[1] + track.tangent[1] * on(track.tangent),
                    track.closest_m[2],
                ];
                let phase = wavenumber * (range_m(foot_m, at_m) - nearest_m);
                image[j * grid.columns() + i] +=
                    component.reflectivity * Complex64::from_polar((-0.5 * exponent).exp(), phase);
            }
        }
    }
    image
}
