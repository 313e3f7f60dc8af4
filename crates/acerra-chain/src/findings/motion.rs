//! Findings on settings that move the traces: clock offset and lever arm, compared with the values that the
//! phases of the strongest targets prefer.

use acerra_geo::interpolate::Interpolator;
use acerra_geo::lever_arm::{HeadingOptions, apply_lever_arm};
use acerra_geo::trajectory::Trajectory;

use super::preferred::{PreferredSetting, preferred_setting};
use super::strongest::strongest;
use super::wander::{Preferred, Trial};
use crate::align::interpolator;
use crate::control::{Cancelled, Control};
use crate::echoes::history::Measured;
use crate::focus::Focused;
use crate::journal::finding::{Finding, Setting};
use crate::position::Positions;
use crate::prepare::{Prepared, Track};

/// Targets further than this below the strongest are not judged (dB).
const FLOOR_DB: f64 = -12.0;

/// Changes of the clock offset that are tried (s): half a wander's period at most, beyond which height and
/// motion of the whole flight are more precise.
const OFFSET_REACH_S: f64 = 0.4;
const OFFSET_STEP_S: f64 = 0.01;

/// Lever arms that are tried, to either side (m): the size of a small drone.
const ARM_REACH_M: f64 = 1.0;
const ARM_STEP_M: f64 = 0.02;

/// Largest deviations of an offset (s) and a lever arm (m) that count as determined: three deviations are a
/// resolution cell and a few.
const LARGEST_OFFSET_SIGMA_S: f64 = 0.015;
const LARGEST_ARM_SIGMA_M: f64 = 0.1;

/// Judges clock offset and lever arm of every track by the echoes of the image's strongest targets above ground, where
/// rays are straight.
///
/// # Errors
/// The caller asked to stop.
pub(super) fn weigh(
    prepared: &Prepared,
    focused: &Focused,
    track: &Track,
    control: &Control<'_>,
) -> Result<Vec<Finding>, Cancelled> {
    let Positions::Trajectory(trajectory) = &track.positions else {
        return Ok(Vec::new());
    };
    if focused.underground.is_some() {
        return Ok(Vec::new());
    }
    let measured = Measured::part(
        &prepared.aligned.position_m,
        &prepared.spectrum,
        track.range.clone(),
        prepared.scene.light_speed_m_s,
    );
    let time_s = prepared.aligned.time_s.get(track.range.clone());
    let (Some(measured), Some(time_s)) = (measured, time_s) else {
        return Ok(Vec::new());
    };
    let bench = Bench {
        measured,
        time_s,
        trajectory,
        offset_s: track.time_offset_s,
        point_m: strongest(focused, FLOOR_DB),
    };
    control.check()?;
    let mut findings = Vec::new();
    findings.extend(bench.clock_offset());
    for axis in [0, 1] {
        control.check()?;
        findings.extend(bench.lever_arm(axis));
    }
    Ok(findings)
}

/// Everything that a setting is tried on.
struct Bench<'a> {
    measured: Measured<'a>,
    time_s: &'a [f64],
    trajectory: &'a Trajectory,
    offset_s: f64,
    point_m: Vec<[f64; 3]>,
}

impl Bench<'_> {
    fn clock_offset(&self) -> Option<Finding> {
        let at = interpolator(None, self.trajectory);
        let places = |change: f64| places_on(&at, self.time_s, self.offset_s + change);
        let steps = (OFFSET_REACH_S / OFFSET_STEP_S).round() as i32;
        let changes = (-steps..=steps)
            .map(|k| f64::from(k) * OFFSET_STEP_S)
            .collect();
        let found = self.trial(changes, &places)?;
        (found.sigma < 0.5 * OFFSET_REACH_S).then(|| {
            preferred_setting(&PreferredSetting {
                name: "clock_offset_focus",
                in_force: self.offset_s,
                preferred: self.offset_s + found.change,
                sigma: found.sigma,
                unit: "s",
                key: "[trajectory] time_offset_s; a wrong lever_arm_m has the same effect",
                targets: found.targets,
                setting: Setting::ClockOffset,
                largest_sigma: LARGEST_OFFSET_SIGMA_S,
            })
        })
    }

    /// The lever arm forward (axis 0) or left (axis 1), as a change of the one in force.
    fn lever_arm(&self, axis: usize) -> Option<Finding> {
        let mut unit = [0.0; 3];
        unit[axis] = 1.0;
        let (ahead, _) = apply_lever_arm(self.trajectory, unit, &HeadingOptions::default()).ok()?;
        let [here, there] = [self.trajectory, &ahead].map(|t| {
            let at = interpolator(None, t);
            places_on(&at, self.time_s, self.offset_s)
        });
        let (here, there) = (here?, there?);
        let places = |change: f64| {
            let along = here.iter().zip(&there);
            let moved = along.map(|(a, b)| [0, 1, 2].map(|i| a[i] + change * (b[i] - a[i])));
            Some(moved.collect())
        };
        let steps = (ARM_REACH_M / ARM_STEP_M).round() as i32;
        let changes = (-steps..=steps)
            .map(|k| f64::from(k) * ARM_STEP_M)
            .collect();
        let found = self.trial(changes, &places)?;
        let name = ["lever_arm_forward", "lever_arm_left"][axis];
        (found.sigma < 0.5 * ARM_REACH_M).then(|| {
            preferred_setting(&PreferredSetting {
                name,
                in_force: 0.0,
                preferred: found.change,
                sigma: found.sigma,
                unit: "m",
                key: "[trajectory] lever_arm_m; a wrong time_offset_s has the same effect",
                targets: found.targets,
                setting: [Setting::LeverArmForward, Setting::LeverArmLeft][axis],
                largest_sigma: LARGEST_ARM_SIGMA_M,
            })
        })
    }

    fn trial(
        &self,
        changes: Vec<f64>,
        places: &dyn Fn(f64) -> Option<Vec<[f64; 3]>>,
    ) -> Option<Preferred> {
        Trial {
            measured: self.measured,
            time_s: self.time_s,
            changes,
            places,
        }
        .preferred(&self.point_m)
    }
}

/// Places of the traces at an offset; none where one trace has no place.
fn places_on(at: &Interpolator<'_>, time_s: &[f64], offset_s: f64) -> Option<Vec<[f64; 3]>> {
    time_s
        .iter()
        .map(|t| {
            let place = at.at(t + offset_s);
            place.flag.is_covered().then_some(place.position_m)
        })
        .collect()
}
