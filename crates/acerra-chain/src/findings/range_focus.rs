//! The fast time of range zero, against the one at which the strongest targets are sharpest.
//!
//! An error of range bends the phases along a target's path as the wrong distance does, while its
//! envelope stays where it is: the image blurs. So that targets keep their places meanwhile, the
//! plane is moved along with the range: by Δz where ranges grow by Δz.

use acerra_imaging::{ImagingError, PlaneGrid, TrialImage, TrialImages};
use acerra_radar::Spectrum;
use rayon::prelude::*;

use super::preferred::{PreferredSetting, preferred_setting};
use super::strongest::strongest;
use crate::control::{Cancelled, Control};
use crate::echoes::Searched;
use crate::echoes::sharpen::{log_fourth_moment, sharpest};
use crate::focus::Focused;
use crate::journal::finding::{Finding, Setting};
use crate::position::aligned::Aligned;
use crate::prepare::{Prepared, Track};

/// Ranges tried, to either side (m).
const REACH_M: f64 = 0.6;
const STEP_M: f64 = 0.05;

/// Targets further than this below the strongest are not judged (dB).
const FLOOR_DB: f64 = -6.0;

/// Half of the side of the patch about a target (m), and its pixels (m).
const HALF_SIDE_M: f64 = 0.6;
const PIXEL_M: f64 = 0.025;

/// Logarithm of the fourth moment by which the sharpest must exceed every range a step away; a smaller
/// difference is not significant.
const LEAST_MARGIN: f64 = 0.3;

/// Ranges nearer than this belong to the sharpest (m).
const APART_M: f64 = 0.3;

/// Least deviation of a delay (ns): errors of the positions bend phases as well, 2 cm over the flight.
const LEAST_SIGMA_NS: f64 = 0.2;

/// Largest deviation of a delay that counts as determined (ns).
const LARGEST_SIGMA_NS: f64 = 0.5;

/// Judges the delay in force by the sharpness of the strongest targets above ground, where rays are straight.
///
/// # Errors
/// The caller asked to stop.
pub(super) fn weigh(
    prepared: &Prepared,
    focused: &Focused,
    track: &Track,
    control: &Control<'_>,
) -> Result<Option<Finding>, Cancelled> {
    let Some(traces) = &track.cleaned else {
        return Ok(None);
    };
    let is_flat = focused.pixels.surface.is_none() && focused.underground.is_none();
    if !is_flat || prepared.tracks.len() > 1 {
        return Ok(None);
    }
    let bench = Bench {
        aligned: &prepared.aligned,
        spectrum: &prepared.spectrum,
        light_speed_m_s: prepared.scene.light_speed_m_s,
    };
    let about = |v: f64| [v - HALF_SIDE_M, v + HALF_SIDE_M];
    let patches: Vec<PlaneGrid> = strongest(focused, FLOOR_DB)
        .into_iter()
        .filter_map(|[x_m, y_m, z_m]| {
            PlaneGrid::from_ranges(about(x_m), about(y_m), z_m, PIXEL_M).ok()
        })
        .collect();
    let longer_m = bench.sharpest_m(&patches, control)?;
    let targets = patches.len();
    Ok(longer_m.map(|[longer_m, sigma_m]| {
        let ns = |range_m: f64| 2e9 * range_m / prepared.scene.light_speed_m_s;
        let in_force = -1e9 * traces.shift_s;
        preferred_setting(&PreferredSetting {
            name: "delay_focus",
            in_force,
            preferred: in_force - ns(longer_m),
            sigma: ns(sigma_m).hypot(LEAST_SIGMA_NS),
            unit: "ns",
            key: "[radar] delay_ns, [preprocess] zero_timing, [image] z_m, light_speed_m_s, \
                  [trajectory] origin_deg_m, lever_arm_m: heights",
            targets,
            setting: Setting::Heights,
            largest_sigma: LARGEST_SIGMA_NS,
        })
    }))
}

struct Bench<'a> {
    aligned: &'a Aligned,
    spectrum: &'a Spectrum,
    light_speed_m_s: f64,
}

impl Bench<'_> {
    /// Increase of all ranges at which the targets are sharpest, with its deviation (m); none where no range
    /// is clearly the sharpest.
    fn sharpest_m(
        &self,
        patches: &[PlaneGrid],
        control: &Control<'_>,
    ) -> Result<Option<[f64; 2]>, Cancelled> {
        let steps = (REACH_M / STEP_M).round() as i32;
        let tried_m: Vec<f64> = (-steps..=steps).map(|k| f64::from(k) * STEP_M).collect();
        let searched = Searched::new(
            &self.aligned.position_m,
            self.spectrum,
            self.light_speed_m_s,
        );
        // The plane moves as far as the range grows.
        let looks = |patch: &PlaneGrid| searched.looks(*patch, 2.0 * REACH_M);
        // Ranges that cannot be imaged give no comparison.
        let Ok(looks) = (patches.iter().map(looks)).collect::<Result<Vec<_>, ImagingError>>()
        else {
            return Ok(None);
        };
        let scores_at = |longer_m: &f64| {
            control.check()?;
            let score = |(patch, looks): (&PlaneGrid, &TrialImages)| {
                let image = looks.image(&TrialImage {
                    position_m: &self.aligned.position_m,
                    beyond_m: -longer_m,
                    grid: PlaneGrid {
                        z_m: patch.z_m - longer_m,
                        ..*patch
                    },
                })?;
                Ok::<_, ImagingError>(log_fourth_moment(&image))
            };
            Ok(patches
                .iter()
                .zip(&looks)
                .map(score)
                .collect::<Result<Vec<f64>, _>>()
                .ok())
        };
        let scores: Vec<Option<Vec<f64>>> = tried_m
            .par_iter()
            .map(scores_at)
            .collect::<Result<_, Cancelled>>()?;
        let Some(scores) = scores.into_iter().collect::<Option<Vec<Vec<f64>>>>() else {
            return Ok(None);
        };
        let Some(best) = sharpest(&tried_m, &scores) else {
            return Ok(None);
        };
        let mean = |score: &Vec<f64>| score.iter().sum::<f64>() / score.len().max(1) as f64;
        let top = scores.iter().map(mean).fold(f64::NEG_INFINITY, f64::max);
        let rival = tried_m
            .iter()
            .zip(&scores)
            .filter(|(m, _)| (*m - best.value).abs() > APART_M)
            .map(|(_, score)| mean(score))
            .fold(f64::NEG_INFINITY, f64::max);
        Ok((top - rival >= LEAST_MARGIN).then_some([best.value, best.sigma]))
    }
}
