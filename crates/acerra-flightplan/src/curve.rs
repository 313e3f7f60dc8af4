//! Amplitude of the bends of a line at which the ghost on its other side fades.
//!
//! A straight line cannot distinguish left from right. A sideways wave of the line changes the range to a
//! target and to its mirror image by opposite amounts, by 2dA/R for an amplitude A; once this exceeds the
//! wavelength sufficiently the mirror image no longer adds up. The necessary amplitude is found by the exact
//! point spread function, not by a rule of thumb. The wave is flown from waypoint to waypoint on straight
//! legs, as few as the required level of the ghosts allows.

use std::f64::consts::TAU;

use acerra_imaging::psf::{Analysis, PointSpread};

use super::swath::View;
use super::{LIGHT_SPEED_M_S, PlanError, PlanFile, Swath};

/// A sideways wave of all lines: left = A cos(2π along / P), flown on straight legs.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Curve {
    /// A (m).
    pub amplitude_m: f64,
    /// P (m): the length under which the nearest targets are seen.
    pub period_m: f64,
    /// Waypoints in each period, crest and trough among them.
    pub waypoints_per_period: usize,
    /// Largest distance of the straight legs from the wave (m).
    pub waypoint_tolerance_m: f64,
    /// Distance from the line (m) and largest ghost there, relative to its target, with the legs as
    /// they are flown.
    pub ghost: Vec<[f64; 2]>,
}

/// Smallest amplitude that is tried (m).
const LEAST_AMPLITUDE_M: f64 = 0.02;
/// From one amplitude to the next.
const AMPLITUDE_STEP: f64 = 1.3;
/// Numbers of waypoints in a period that are tried where two, a zigzag, will not do.
const MORE_WAYPOINTS: [usize; 3] = [6, 12, 24];

/// One wave as it is flown.
#[derive(Clone, Copy, Debug)]
struct Wave {
    amplitude_m: f64,
    period_m: f64,
    /// None for the smooth wave.
    waypoints: Option<usize>,
}

impl Wave {
    /// Offset to the left of the straight line (m).
    fn left_m(&self, along_m: f64) -> f64 {
        let periods = along_m / self.period_m;
        let smooth = |periods: f64| self.amplitude_m * (TAU * periods).cos();
        match self.waypoints {
            None => smooth(periods),
            Some(n) => {
                let legs = periods * n as f64;
                let (before, share) = (legs.floor(), legs - legs.floor());
                let [from, to] = [before, before + 1.0].map(|leg| smooth(leg / n as f64));
                from + share * (to - from)
            }
        }
    }

    /// Largest distance of the legs from the smooth wave, across the line (m).
    fn tolerance_m(&self) -> f64 {
        let smooth = Self {
            waypoints: None,
            ..*self
        };
        (0..1_000)
            .map(|i| self.period_m * f64::from(i) / 1_000.0)
            .map(|along| (self.left_m(along) - smooth.left_m(along)).abs())
            .fold(0.0, f64::max)
    }
}

/// Most pulses of a point spread function computed here.
const MOST_PULSES: f64 = 1_200.0;

impl Curve {
    /// Offset to the left of the straight line, on its legs (m).
    #[must_use]
    pub fn left_m(&self, along_m: f64) -> f64 {
        let wave = Wave {
            amplitude_m: self.amplitude_m,
            period_m: self.period_m,
            waypoints: Some(self.waypoints_per_period),
        };
        wave.left_m(along_m)
    }

    /// Places along the line (m) of the waypoints of a line from `start_m` to `end_m`, both among
    /// them.
    pub(super) fn waypoints_along_m(&self, start_m: f64, end_m: f64) -> Vec<f64> {
        let leg_m = self.period_m / self.waypoints_per_period as f64;
        let (low, high) = (start_m.min(end_m), start_m.max(end_m));
        // Legs shorter than a tenth of the others at the ends would only be hovered over.
        let least_m = 0.1 * leg_m;
        let first = ((low + least_m) / leg_m).ceil();
        let inner = (0_u32..)
            .map(|k| leg_m * (first + f64::from(k)))
            .take_while(|along| *along <= high - least_m);
        let mut along: Vec<f64> = [low].into_iter().chain(inner).chain([high]).collect();
        if end_m < start_m {
            along.reverse();
        }
        along
    }

    /// The largest ghost at a distance from the line, between those computed.
    #[must_use]
    pub fn ghost_at(&self, distance_m: f64) -> f64 {
        let after = self.ghost.partition_point(|[d, _]| *d <= distance_m);
        match (
            after.checked_sub(1).map(|i| self.ghost[i]),
            self.ghost.get(after),
        ) {
            (Some([d0, g0]), Some([d1, g1])) => g0 + (g1 - g0) * (distance_m - d0) / (d1 - d0),
            (Some([_, g]), None) | (None, Some(&[_, g])) => g,
            (None, None) => 1.0,
        }
    }

    /// The least amplitude whose ghosts are all below the required level; none when straight lines suffice.
    pub(super) fn choose(
        file: &PlanFile,
        view: &View,
        swath: &Swath,
        spacing_m: Option<f64>,
        speed_m_s: f64,
    ) -> Result<Option<Self>, PlanError> {
        let Some(wanted) = file.want.ghost.filter(|g| *g < 1.0) else {
            return Ok(None);
        };
        let near_m = swath.near_m.max(file.want.across_m);
        let offsets = [near_m, (near_m * swath.far_m).sqrt(), swath.far_m];
        let period_m = 2.0 * swath.height_m.hypot(near_m) * view.half_rad.tan();
        let by_acceleration =
            file.drone.lateral_acceleration_m_s2 * (period_m / (TAU * speed_m_s)).powi(2);
        let by_spacing = spacing_m.map_or(f64::INFINITY, |s| 0.25 * s);
        let most_m = by_acceleration.min(by_spacing).min(0.25 * swath.height_m);

        let ghosts = |wave: Wave| {
            offsets
                .iter()
                .map(|d| Ok([*d, worst_ghost(file, view, swath, wave, *d)?]))
                .collect::<Result<Vec<[f64; 2]>, PlanError>>()
        };
        let largest = |ghost: &[[f64; 2]]| ghost.iter().fold(0.0, |worst, [_, g]| g.max(worst));
        let legs = |amplitude_m: f64, n: usize| -> Result<Option<Self>, PlanError> {
            let wave = Wave {
                amplitude_m,
                period_m,
                waypoints: Some(n),
            };
            let ghost = ghosts(wave)?;
            Ok((largest(&ghost) <= wanted).then(|| Self {
                amplitude_m,
                period_m,
                waypoints_per_period: n,
                waypoint_tolerance_m: wave.tolerance_m(),
                ghost,
            }))
        };
        let mut best = f64::INFINITY;
        let mut amplitude_m = LEAST_AMPLITUDE_M;
        while amplitude_m <= most_m {
            let smooth = Wave {
                amplitude_m,
                period_m,
                waypoints: None,
            };
            let least = largest(&ghosts(smooth)?);
            best = best.min(least);
            if least <= wanted {
                // A zigzag of a slightly larger amplitude is easier to fly than many legs.
                let larger_m = amplitude_m * AMPLITUDE_STEP;
                let zigzags = [amplitude_m, larger_m].map(|a| (a, 2));
                let rounder = MORE_WAYPOINTS.map(|n| (amplitude_m, n));
                for (amplitude_m, n) in zigzags.into_iter().chain(rounder) {
                    if amplitude_m <= most_m
                        && let Some(curve) = legs(amplitude_m, n)?
                    {
                        return Ok(Some(curve));
                    }
                }
            }
            amplitude_m *= AMPLITUDE_STEP;
        }
        Err(PlanError::Impossible(if best.is_finite() {
            format!(
                "ghosts of {wanted} cannot be reached by curved lines: waves of up to {most_m:.2} m (speed, \
                 line spacing and height allow no more) leave {best:.2} at best; ask for less in \
                 want.ghost, or fly several headings"
            )
        } else {
            format!(
                "lines cannot be curved to weaken ghosts: at {speed_m_s:.2} m/s the drone follows \
                 waves of {most_m:.3} m at most over {period_m:.1} m"
            )
        }))
    }
}

/// The largest ghost of targets at a distance from the line, abeam a crest and a zero crossing.
fn worst_ghost(
    file: &PlanFile,
    view: &View,
    swath: &Swath,
    wave: Wave,
    offset_m: f64,
) -> Result<f64, PlanError> {
    let half_m = swath.height_m.hypot(offset_m) * view.half_rad.tan();
    let step_m = (0.5 * view.longest_step_m).max(2.0 * half_m / MOST_PULSES);
    let count = (2.0 * half_m / step_m).ceil();
    let [low_hz, high_hz] = file.radar.band_hz();
    let frequency_hz: Vec<f64> = (0..171)
        .map(|n| low_hz + (high_hz - low_hz) * f64::from(n) / 170.0)
        .collect();
    let failed = |e: acerra_imaging::ImagingError| PlanError::Impossible(e.to_string());
    let mut worst = 0.0f64;
    for shift_m in [0.0, 0.25 * wave.period_m] {
        let track: Vec<[f64; 3]> = (0..=count as usize)
            .map(|i| {
                let x = -half_m + 2.0 * half_m * i as f64 / count;
                [x, wave.left_m(x + shift_m), swath.height_m]
            })
            .collect();
        let spread =
            PointSpread::new(track, None, frequency_hz.clone(), LIGHT_SPEED_M_S).map_err(failed)?;
        for side in [1.0, -1.0] {
            let found = Analysis::of(&spread, [0.0, side * offset_m, 0.0], 0.0).map_err(failed)?;
            // A ghost that coincides with the target cannot be distinguished from the target.
            worst = worst.max(found.ghost.map_or(1.0, |g| g.level));
        }
    }
    Ok(worst)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::swath::FarLimit;

    fn file(ghost: f64) -> PlanFile {
        let text = format!(
            "[area]\ncorners_deg = [[40.9, 14.2], [40.9, 14.2003], [40.9002, 14.2003]]\n\
             [want]\nalong_m = 0.06\nacross_m = 0.5\nghost = {ghost}\n"
        );
        PlanFile::parse(&text).expect("possible")
    }

    const SWATH: Swath = Swath {
        height_m: 5.0,
        near_m: 1.2,
        far_m: 4.0,
        far_limit: FarLimit::Beam,
    };

    #[test]
    fn a_straight_line_has_a_ghost_of_one_and_a_curved_one_less() {
        let file = file(0.5);
        let view = View::of(&file).expect("a view");
        let smooth = |amplitude_m, period_m| Wave {
            amplitude_m,
            period_m,
            waypoints: None,
        };
        let straight = worst_ghost(&file, &view, &SWATH, smooth(0.0, 5.0), 2.0).expect("computed");
        assert!((straight - 1.0).abs() < 1e-6, "{straight}");
        let curve = Curve::choose(&file, &view, &SWATH, None, 0.4).expect("possible");
        let curve = curve.expect("curved");
        assert!(curve.ghost.iter().all(|[_, g]| *g <= 0.5), "{curve:?}");
        // The next smaller amplitude does not do with as few waypoints.
        let less = Wave {
            amplitude_m: curve.amplitude_m / AMPLITUDE_STEP,
            period_m: curve.period_m,
            waypoints: Some(curve.waypoints_per_period),
        };
        let worst = curve
            .ghost
            .iter()
            .map(|[d, _]| worst_ghost(&file, &view, &SWATH, less, *d))
            .try_fold(0.0f64, |w, g| g.map(|g| w.max(g)))
            .expect("computed");
        assert!(worst > 0.5, "{worst}");
        assert!(
            curve.ghost_at(0.0) == curve.ghost[0][1] && curve.ghost_at(9.0) == curve.ghost[2][1]
        );
    }

    #[test]
    fn legs_keep_to_the_wave_within_the_tolerance_stated() {
        for (n, share) in [(2, 0.2105), (12, 0.0330)] {
            let wave = Wave {
                amplitude_m: 0.5,
                period_m: 6.0,
                waypoints: Some(n),
            };
            // Crests are waypoints.
            assert!((wave.left_m(12.0) - 0.5).abs() < 1e-12);
            // The zigzag: max of cos t − (1 − 2t/π). Twelve: cos 15° − (1 + cos 30°)/2.
            assert!((wave.tolerance_m() - 0.5 * share).abs() < 1e-3, "{n}");
        }
        let curve = Curve {
            amplitude_m: 0.5,
            period_m: 6.0,
            waypoints_per_period: 2,
            waypoint_tolerance_m: 0.105,
            ghost: Vec::new(),
        };
        let along = curve.waypoints_along_m(10.0, -4.0);
        assert_eq!(along, [10.0, 9.0, 6.0, 3.0, 0.0, -3.0, -4.0]);
        // A waypoint a hand's breadth from an end would only be hovered over.
        assert_eq!(curve.waypoints_along_m(-0.1, 3.2), [-0.1, 3.2]);
    }

    #[test]
    fn what_the_drone_cannot_follow_is_refused() {
        let mut file = file(0.1);
        file.drone.lateral_acceleration_m_s2 = 0.01;
        let view = View::of(&file).expect("a view");
        let error = Curve::choose(&file, &view, &SWATH, None, 1.5).expect_err("too stiff");
        assert!(
            error.to_string().contains("the drone follows waves of"),
            "{error}"
        );
        assert_eq!(
            Curve::choose(
                &PlanFile {
                    want: crate::Want {
                        ghost: None,
                        ..file.want.clone()
                    },
                    ..file.clone()
                },
                &view,
                &SWATH,
                None,
                1.5
            ),
            Ok(None)
        );
    }
}
