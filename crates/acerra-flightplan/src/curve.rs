//! How much a line must bend until the ghost on its other side fades.
//!
//! A straight line sees its left and its right alike. A sideways wave of the line changes the
//! range to a target and to its mirror image by opposite amounts, by 2dA/R for an amplitude A; once
//! that is some way beyond the wavelength the mirror image no longer adds up. How far is
//! found by the exact point spread function, not by a rule of thumb.

use std::f64::consts::{PI, TAU};

use acerra_imaging::psf::{Analysis, PointSpread};

use super::swath::View;
use super::{LIGHT_SPEED_M_S, PlanError, PlanFile, Swath};

/// A sideways wave of all lines: left = A cos(2π along / P).
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Curve {
    /// A (m).
    pub amplitude_m: f64,
    /// P (m): the length under which the nearest targets are seen.
    pub period_m: f64,
    /// Distance from the line (m) and largest ghost there, relative to its target.
    pub ghost: Vec<[f64; 2]>,
}

/// Most pulses of a point spread function computed here.
const MOST_PULSES: f64 = 1_200.0;

impl Curve {
    /// How far to the left of the straight line it runs (m).
    #[must_use]
    pub fn left_m(&self, along_m: f64) -> f64 {
        self.amplitude_m * (TAU * along_m / self.period_m).cos()
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

    /// The least amplitude whose ghosts are all as weak as wanted; none when straight lines will
    /// do.
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

        let mut best: Option<Self> = None;
        let mut amplitude_m = 0.02;
        while amplitude_m <= most_m {
            let mut ghost = Vec::with_capacity(offsets.len());
            for offset_m in offsets {
                ghost.push([
                    offset_m,
                    worst_ghost(file, view, swath, amplitude_m, period_m, offset_m)?,
                ]);
            }
            let curve = Self {
                amplitude_m,
                period_m,
                ghost,
            };
            if curve.largest() <= wanted {
                return Ok(Some(curve));
            }
            if best.as_ref().is_none_or(|b| curve.largest() < b.largest()) {
                best = Some(curve);
            }
            amplitude_m *= 1.3;
        }
        Err(PlanError::Impossible(match best {
            Some(best) => format!(
                "ghosts of {wanted} cannot be had by curved lines: waves of up to {most_m:.2} m \
                 (speed, line spacing and height allow no more) leave {:.2} at best; ask for less \
                 in want.ghost, or fly several headings",
                best.largest()
            ),
            None => format!(
                "lines cannot be curved to weaken ghosts: at {speed_m_s:.2} m/s the drone follows \
                 waves of {most_m:.3} m at most over {period_m:.1} m"
            ),
        }))
    }

    fn largest(&self) -> f64 {
        self.ghost.iter().fold(0.0, |worst, [_, g]| worst.max(*g))
    }
}

/// The largest ghost of targets at a distance from the line, abeam a crest and a zero crossing.
fn worst_ghost(
    file: &PlanFile,
    view: &View,
    swath: &Swath,
    amplitude_m: f64,
    period_m: f64,
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
    for phase in [0.0, 0.5 * PI] {
        let track: Vec<[f64; 3]> = (0..=count as usize)
            .map(|i| {
                let x = -half_m + 2.0 * half_m * i as f64 / count;
                let y = amplitude_m * (TAU * x / period_m + phase).cos();
                [x, y, swath.height_m]
            })
            .collect();
        let spread =
            PointSpread::new(track, None, frequency_hz.clone(), LIGHT_SPEED_M_S).map_err(failed)?;
        for side in [1.0, -1.0] {
            let found = Analysis::of(&spread, [0.0, side * offset_m, 0.0], 0.0).map_err(failed)?;
            // Where the ghost is one with the target, it cannot be told from it.
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
        let straight = worst_ghost(&file, &view, &SWATH, 0.0, 5.0, 2.0).expect("computed");
        assert!((straight - 1.0).abs() < 1e-6, "{straight}");
        let curve = Curve::choose(&file, &view, &SWATH, None, 0.4).expect("possible");
        let curve = curve.expect("curved");
        assert!(curve.largest() <= 0.5, "{curve:?}");
        // The next smaller amplitude that was tried does not do.
        let less = curve.amplitude_m / 1.3;
        let worst = curve
            .ghost
            .iter()
            .map(|[d, _]| worst_ghost(&file, &view, &SWATH, less, curve.period_m, *d))
            .try_fold(0.0f64, |w, g| g.map(|g| w.max(g)))
            .expect("computed");
        assert!(worst > 0.5, "{worst}");
        assert!(
            curve.ghost_at(0.0) == curve.ghost[0][1] && curve.ghost_at(9.0) == curve.ghost[2][1]
        );
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
