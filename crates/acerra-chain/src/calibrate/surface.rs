//! The surface echo after calibration: an independent check, as it takes no part in the adjustment.
//! The height of the ground is seldom known as well as the place of a reflector.

use acerra_radar::clean::{SurfaceOptions, track_surface};

use super::echo::median;
use super::parameter::Values;
use super::result::Calibrated;
use super::rounds::Survey;
use super::track::TrackEchoes;
use crate::journal::warnings::Warnings;
use crate::scene::Scene;

/// Distance of the surface echo from 2h/c beyond which it is reported (s).
const TOLD_S: f64 = 0.3e-9;

/// Scatter about the median beyond which the followed echo is no level surface (s): the crest of a surface
/// echo scatters by hundredths, a reflector's hyperbola by nanoseconds.
const LEVEL_S: f64 = 0.15e-9;
/// Contrast that a surface echo needs (dB).
const NEEDED_DB: f64 = 6.0;

/// Warns where the surface echo lies away from 2h/c.
pub(super) fn compare(
    survey: &Survey<'_>,
    calibrated: &Calibrated,
    scene: &Scene,
    warnings: &mut Warnings,
) {
    for (number, track) in survey.tracks.iter().enumerate() {
        if track.at_rest {
            continue;
        }
        let Some(residual_s) = residual_s(track, number, &calibrated.values, scene) else {
            continue;
        };
        if residual_s.abs() > TOLD_S {
            warnings.add(format!(
                "track {}: after calibration the surface echo lies {:+.2} ns from 2h/c: the height \
                 of the ground ([image] z_m), the reflectors' heights or the lever arm up are off \
                 by {:.0} mm",
                track.name,
                residual_s * 1e9,
                residual_s.abs() * 0.5e3 * scene.light_speed_m_s
            ));
        }
    }
}

/// Median of the surface echo less 2h/c; none where no surface echo is seen.
fn residual_s(track: &TrackEchoes, number: usize, values: &Values, scene: &Scene) -> Option<f64> {
    let sampler = track.path.sampler();
    let scale = 1.0 + values.range_scale;
    let height_m: Vec<f64> = track
        .raw
        .time_s
        .iter()
        .map(|t| {
            let pose = sampler.at(*t, values.time_offset_s[number])?;
            let [x, y, z] = pose.phase_centre_m(values.lever_arm_m);
            Some(scale * (z - scene.ground.below_m(x, y)))
        })
        .map(|height| height.unwrap_or(f64::NAN))
        .collect();
    let delay_s = values.delay_s + track.known_delay_s;
    let mut options = SurfaceOptions::default();
    options.approximate_delay_s = Some(delay_s);
    let surface = track_surface(&track.raw, &height_m, &options).ok()?;
    let residuals: Vec<f64> = surface
        .picks
        .iter()
        .zip(&height_m)
        .filter_map(|(pick, h)| Some(pick.as_ref()?.fast_time_s - 2.0 * h / scene.light_speed_m_s))
        .map(|t| t - delay_s)
        .collect();
    let middle_s = median(residuals.iter().copied());
    let spread_s = median(residuals.iter().map(|r| (r - middle_s).abs()));
    (spread_s <= LEVEL_S && surface.contrast_db >= NEEDED_DB).then_some(middle_s)
}
