//! Quantities of the whole flight that an autofocus leaves free in addition to the places: delay, clock,
//! lever arm, height above the scene, propagation speed; for each track, instrument errors and the common
//! error of its positions ([`tracks`](super::tracks)).

use acerra_autofocus::{Effect, Global, GlobalFound};
use acerra_geo::interpolate::Interpolator;
use acerra_geo::lever_arm::{HeadingOptions, apply_lever_arm};
use acerra_geo::trajectory::Trajectory;

use super::options::{AutofocusFailure, AutofocusOptions};
use super::tracks::moved;
use crate::align::interpolator;
use crate::align::quantity::{GlobalCorrection, Quantity};
use crate::position::Positions;
use crate::prepare::{Prepared, Track};

/// Half the time over which velocity and acceleration are taken (s): noise of the positions must not pass for
/// motion.
const HALF_WINDOW_S: f64 = 0.5;

/// A quantity and its effect on the estimate.
pub(super) struct Free {
    quantity: Quantity,
    track: Option<usize>,
    pub global: Global,
}

impl Free {
    /// Correction of the quantity by the estimate `found`.
    pub fn corrected(&self, found: &GlobalFound, light_speed_m_s: f64) -> GlobalCorrection {
        let factor = self.quantity.per_estimated(light_speed_m_s);
        GlobalCorrection {
            quantity: self.quantity,
            track: self.track,
            moves_zero: matches!(self.global.effect, Effect::RiseOverSurface(_)),
            value: factor * found.value,
            sigma: factor * found.sigma,
            prior_sigma: factor * found.prior_sigma,
        }
    }
}

impl Prepared {
    /// The quantities that the options leave free.
    pub(super) fn free(&self, options: &AutofocusOptions) -> Result<Vec<Free>, AutofocusFailure> {
        let light_speed_m_s = self.scene.light_speed_m_s;
        let traces = self.aligned.position_m.len();
        let mut free = Vec::new();
        let mut add = |quantity: Quantity, track, sigma: f64, effect| {
            let sigma = sigma / quantity.per_estimated(light_speed_m_s);
            if sigma > 0.0 {
                let name = quantity.name().to_owned();
                let global = Global {
                    name,
                    sigma,
                    effect,
                };
                free.push(Free {
                    quantity,
                    track,
                    global,
                });
            }
        };
        let delay = Effect::Delay(0..traces);
        add(Quantity::Delay, None, self.delay_sigma_ns(options), delay);
        for (number, track) in self.tracks.iter().enumerate() {
            let which = (self.tracks.len() > 1).then_some(number);
            for (quantity, sigma, effect) in self.free_of(track, options)? {
                add(quantity, which, sigma, effect);
            }
            for (quantity, sigma, effect) in self.in_common(number, options) {
                add(quantity, which, sigma, effect);
            }
        }
        // Tracks share the height above the scene; the surface echo defines range zero for all tracks or for
        // none.
        let up = match self.tracks.iter().all(Track::has_zero_by_surface) {
            true => Effect::RiseOverSurface(0..traces),
            false => moved(traces, 0..traces, 2, |_| 1.0),
        };
        add(Quantity::Height, None, options.height_sigma_m, up);
        let speed_sigma_m_s = options.light_speed_sigma_m_s;
        add(Quantity::LightSpeed, None, speed_sigma_m_s, Effect::Speed);
        Ok(free)
    }

    /// Clock and lever arm of one track.
    fn free_of(
        &self,
        track: &Track,
        options: &AutofocusOptions,
    ) -> Result<Vec<(Quantity, f64, Effect)>, AutofocusFailure> {
        let offset_sigma_s = clock_sigma_s(track, options);
        let drift_sigma_ppm = options.clock_drift_sigma_ppm;
        let arm_sigma_m = options.lever_arm_sigma_m;
        let mut free = Vec::new();
        if offset_sigma_s + drift_sigma_ppm + arm_sigma_m.iter().sum::<f64>() == 0.0 {
            return Ok(free);
        }
        let Positions::Trajectory(trajectory) = &track.positions else {
            return Err(AutofocusFailure::PlacedByTrace);
        };
        let flown = Flown {
            prepared: self,
            track,
            trajectory,
        };
        if offset_sigma_s > 0.0 {
            let effect = flown.later(|_| 1.0);
            free.push((Quantity::ClockOffset, offset_sigma_s, effect));
        }
        if drift_sigma_ppm > 0.0 {
            let own_s = &self.aligned.time_s[track.range.clone()];
            let ends = [own_s.first(), own_s.last()].map(|t| t.copied().unwrap_or(0.0));
            let middle_s = 0.5 * (ends[0] + ends[1]);
            let effect = flown.later(|time_s| 1e-6 * (time_s - middle_s));
            free.push((Quantity::ClockDrift, drift_sigma_ppm, effect));
        }
        let arms = [
            Quantity::LeverForward,
            Quantity::LeverLeft,
            Quantity::LeverUp,
        ];
        for (axis, (quantity, sigma_m)) in arms.into_iter().zip(arm_sigma_m).enumerate() {
            if sigma_m > 0.0 {
                free.push((quantity, sigma_m, flown.longer_arm(axis)?));
            }
        }
        Ok(free)
    }
}

/// Deviation of a track's clock offset: as stated, else that of an estimated or recorded offset.
fn clock_sigma_s(track: &Track, options: &AutofocusOptions) -> f64 {
    let searched = track.search.as_ref().map(|search| search.estimate.sigma_s);
    let recorded = track.recorded_clock.as_ref().map(|clock| clock.sigma_s);
    let stated = options.clock_offset_sigma_s;
    stated.or(searched).or(recorded).unwrap_or(0.0)
}

/// A track on its trajectory.
struct Flown<'a> {
    prepared: &'a Prepared,
    track: &'a Track,
    trajectory: &'a Trajectory,
}

impl Flown<'_> {
    /// Effect of a later trajectory time: places move along the path, by `scale` of the radar time a unit.
    fn later(&self, scale: impl Fn(f64) -> f64) -> Effect {
        let aligned = &self.prepared.aligned;
        let at = interpolator(None, self.trajectory);
        let mut first = vec![[0.0; 3]; aligned.time_s.len()];
        let mut second = first.clone();
        for m in self.track.range.clone() {
            let scale = scale(aligned.time_s[m]);
            let (mut rate, mut bend) = motion(&at, aligned.time_s[m] + self.track.time_offset_s);
            if aligned.radar_height.is_some() {
                // Heights by the radar belong to the trace, whatever the clock.
                (rate[2], bend[2]) = (0.0, 0.0);
            }
            first[m] = rate.map(|v| v * scale);
            second[m] = bend.map(|a| a * scale * scale);
        }
        Effect::Position { first, second }
    }

    /// Effect of a longer lever arm along an axis: forward, left, up.
    fn longer_arm(&self, axis: usize) -> Result<Effect, AutofocusFailure> {
        let aligned = &self.prepared.aligned;
        let mut arm_m = [0.0; 3];
        arm_m[axis] = 1.0;
        let (end, _) = apply_lever_arm(self.trajectory, arm_m, &HeadingOptions::default())
            .map_err(AutofocusFailure::LeverArm)?;
        let (from, to) = (
            interpolator(None, self.trajectory),
            interpolator(None, &end),
        );
        let mut first = vec![[0.0; 3]; aligned.time_s.len()];
        for m in self.track.range.clone() {
            let time_s = aligned.time_s[m] + self.track.time_offset_s;
            first[m] = difference(to.at(time_s).position_m, from.at(time_s).position_m);
            if aligned.radar_height.is_some() {
                first[m][2] = 0.0;
            }
        }
        let second = vec![[0.0; 3]; first.len()];
        Ok(Effect::Position { first, second })
    }
}

/// Velocity and acceleration (m/s, m/s²) by the parabola through the places half a window before and after;
/// by the covered part of the window at the ends of a trajectory and next to its gaps.
fn motion(at: &Interpolator<'_>, time_s: f64) -> ([f64; 3], [f64; 3]) {
    let own = at.at(time_s).position_m;
    let [before, after] = [-1.0, 1.0].map(|side| {
        let place = at.at(time_s + side * HALF_WINDOW_S);
        place.flag.is_covered().then_some(place.position_m)
    });
    let rate = |to, from, over_s: f64| difference(to, from).map(|d| d / over_s);
    match (before, after) {
        (Some(before), Some(after)) => {
            let bend = difference(
                rate(after, own, HALF_WINDOW_S),
                rate(own, before, HALF_WINDOW_S),
            );
            let velocity = rate(after, before, 2.0 * HALF_WINDOW_S);
            (velocity, bend.map(|d| d / HALF_WINDOW_S))
        }
        (Some(before), None) => (rate(own, before, HALF_WINDOW_S), [0.0; 3]),
        (None, Some(after)) => (rate(after, own, HALF_WINDOW_S), [0.0; 3]),
        (None, None) => ([0.0; 3], [0.0; 3]),
    }
}

fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i] - b[i])
}
