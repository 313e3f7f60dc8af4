//! From the point that was positioned to the radar's phase centre.

use crate::interpolate::{InterpolationOptions, Interpolator};
use crate::matrix::{Vector3, add, is_finite, subtract};
use crate::trajectory::{Attitude, Fix, Trajectory};

/// How the body's axes are found where no attitude was recorded.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct HeadingOptions {
    /// Horizontal speed (m/s) below which the track does not show the heading.
    pub min_speed_m_s: f64,
    /// Time over which the velocity is taken (s).
    pub window_s: f64,
}

impl Default for HeadingOptions {
    fn default() -> Self {
        Self {
            min_speed_m_s: 0.3,
            window_s: 1.0,
        }
    }
}

/// Where the axes came from, fix by fix.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LeverArmReport {
    /// Fixes with a recorded attitude.
    pub from_attitude: usize,
    /// Fixes whose axes are the track's heading, level.
    pub from_track: usize,
    /// Fixes that hover or lack an attitude: axes held from the nearest earlier one (before the
    /// first: the first).
    pub held: usize,
    /// Of those held: attitudes that turn over for one fix and back, faster than a body can, as motion
    /// capture does when it mistakes one marker for another.
    pub flipped: usize,
    /// Fixes moved straight up or down, which needs no heading.
    pub vertical: usize,
}

/// Reason why a lever arm cannot be applied.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LeverArmError {
    /// A component is NaN or infinite.
    #[error("lever arm {0:?} m is not made of finite numbers")]
    NotFinite(Vector3),
    /// Neither attitude nor motion shows where forward is.
    #[error(
        "the lever arm needs a heading, but there is no attitude and the platform never moves \
         faster than {min_speed_m_s} m/s"
    )]
    NoHeading {
        /// The requested speed (m/s).
        min_speed_m_s: f64,
    },
}

/// The trajectory of a point that sits `forward_left_up_m` from the one positioned.
///
/// The body's axes are the recorded attitude where there is one. Otherwise the body is assumed level with its
/// nose along the track, which is valid for a drone that flies forward and not for one that drifts sideways;
/// hovering keeps the last heading. The report counts the fixes of each kind.
///
/// # Errors
/// [`LeverArmError`] for a lever arm that is not finite, or one with a horizontal part when no
/// fix has an attitude or a heading.
///
/// ```
/// use acerra_geo::lever_arm::{HeadingOptions, apply_lever_arm};
/// use acerra_geo::trajectory::{Fix, Frame, TimeOrigin, Trajectory};
///
/// // Flying north; the radar hangs 10 cm ahead and 20 cm below the GNSS antenna.
/// let fixes = (0..9).map(|i| Fix::new(f64::from(i), [0.0, 2.0 * f64::from(i), 10.0])).collect();
/// let antenna = Trajectory::new(Frame::Local, TimeOrigin::Relative, fixes)?;
/// let (radar, report) =
///     apply_lever_arm(&antenna, [0.1, 0.0, -0.2], &HeadingOptions::default()).unwrap();
/// let [e, n, u] = radar.fixes()[4].position_m;
/// assert!(e.abs() < 1e-12 && (n - 8.1).abs() < 1e-12 && (u - 9.8).abs() < 1e-12);
/// assert_eq!(report.from_track, 9);
/// # Ok::<(), acerra_geo::trajectory::TrajectoryError>(())
/// ```
pub fn apply_lever_arm(
    trajectory: &Trajectory,
    forward_left_up_m: Vector3,
    options: &HeadingOptions,
) -> Result<(Trajectory, LeverArmReport), LeverArmError> {
    if !is_finite(forward_left_up_m) {
        return Err(LeverArmError::NotFinite(forward_left_up_m));
    }
    let fixes = trajectory.fixes();
    let mut report = LeverArmReport::default();
    let recorded = fixes.iter().any(|fix| fix.attitude.is_some());
    let level = forward_left_up_m[0] == 0.0 && forward_left_up_m[1] == 0.0;
    let own: Vec<Option<Attitude>> = if recorded {
        without_flips(fixes, &mut report.flipped)
    } else if level {
        vec![Some(Attitude::IDENTITY); fixes.len()]
    } else {
        headings(trajectory, options)
    };
    let first = own.iter().flatten().next().copied();
    let mut held = first.ok_or(LeverArmError::NoHeading {
        min_speed_m_s: options.min_speed_m_s,
    })?;
    let moved = fixes
        .iter()
        .zip(own)
        .map(|(fix, own)| {
            match own {
                Some(attitude) => {
                    held = attitude;
                    *(if recorded {
                        &mut report.from_attitude
                    } else if level {
                        &mut report.vertical
                    } else {
                        &mut report.from_track
                    }) += 1;
                }
                None => report.held += 1,
            }
            Fix {
                position_m: add(fix.position_m, held.rotate(forward_left_up_m)),
                // Without those that turn over for one fix.
                attitude: fix.attitude.map(|_| held),
                ..*fix
            }
        })
        .collect();
    let moved = Trajectory::new(*trajectory.frame(), trajectory.time_origin(), moved)
        .map_err(|_| LeverArmError::NotFinite(forward_left_up_m))?;
    Ok((moved, report))
}

/// Recorded attitudes, without those that differ by more than 30° from both neighbours less than
/// 0.1 s away while the neighbours agree within 10°.
fn without_flips(fixes: &[Fix], flipped: &mut usize) -> Vec<Option<Attitude>> {
    const TURNED_RAD: f64 = 0.52;
    const AGREE_RAD: f64 = 0.17;
    let mut attitudes: Vec<Option<Attitude>> = fixes.iter().map(|fix| fix.attitude).collect();
    for (i, three) in fixes.windows(3).enumerate() {
        if let [Some(before), Some(this), Some(after)] = [0, 1, 2].map(|k| three[k].attitude)
            && three[2].time_s - three[0].time_s < 0.1
            && before.angle_to(&this) > TURNED_RAD
            && after.angle_to(&this) > TURNED_RAD
            && before.angle_to(&after) < AGREE_RAD
        {
            attitudes[i + 1] = None;
            *flipped += 1;
        }
    }
    attitudes
}

/// Level attitudes along the track; none where it is too slow.
fn headings(trajectory: &Trajectory, options: &HeadingOptions) -> Vec<Option<Attitude>> {
    let place = Interpolator::new(trajectory, &InterpolationOptions::default());
    let (start, end) = (trajectory.start_s(), trajectory.end_s());
    // At 1 Hz a window of one second must still reach the neighbouring fixes.
    let interval = trajectory.sample_interval_s().unwrap_or(0.0);
    let half = (0.5 * options.window_s).max(interval);
    trajectory
        .fixes()
        .iter()
        .map(|fix| {
            let before = (fix.time_s - half).max(start);
            let after = (fix.time_s + half).min(end);
            if after <= before {
                return None;
            }
            let [e, n, _] = subtract(place.at(after).position_m, place.at(before).position_m);
            let speed = e.hypot(n) / (after - before);
            (speed >= options.min_speed_m_s).then(|| Attitude::from_heading(e.atan2(n)))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matrix::distance;
    use crate::trajectory::{Frame, TimeOrigin};
    use std::f64::consts::TAU;

    fn track(fixes: Vec<Fix>) -> Trajectory {
        Trajectory::new(Frame::Local, TimeOrigin::Relative, fixes).expect("a trajectory")
    }

    #[test]
    fn on_a_circle_a_point_to_the_left_runs_inside() {
        // Counter-clockwise, radius 20 m, 2 m/s, 5 Hz.
        let fixes = (0..=300).map(|i| {
            let t = 0.2 * f64::from(i);
            let a = 0.1 * t;
            Fix::new(t, [20.0 * a.cos(), 20.0 * a.sin(), 5.0])
        });
        let (moved, report) = apply_lever_arm(
            &track(fixes.collect()),
            [0.0, 0.5, 0.1],
            &HeadingOptions::default(),
        )
        .expect("moves");
        assert_eq!(report.from_track, 301);
        for fix in &moved.fixes()[5..295] {
            let [x, y, z] = fix.position_m;
            assert!((x.hypot(y) - 19.5).abs() < 1e-4, "{}", x.hypot(y));
            assert!((z - 5.1).abs() < 1e-12);
        }
    }

    #[test]
    fn hovering_keeps_the_last_heading_and_says_so() {
        // East, then hover.
        let fixes = (0..=40).map(|i| {
            let t = 0.5 * f64::from(i);
            Fix::new(t, [2.0 * t.min(10.0), 0.0, 5.0])
        });
        let (moved, report) = apply_lever_arm(
            &track(fixes.collect()),
            [0.3, 0.0, 0.0],
            &HeadingOptions::default(),
        )
        .expect("moves");
        assert!((moved.fixes()[40].position_m[0] - 20.3).abs() < 1e-12);
        assert!((19..=21).contains(&report.held), "{report:?}");
        let still = track(
            (0..5)
                .map(|i| Fix::new(f64::from(i), [1.0, 1.0, 1.0]))
                .collect(),
        );
        let options = HeadingOptions::default();
        assert!(matches!(
            apply_lever_arm(&still, [0.3, 0.0, 0.0], &options),
            Err(LeverArmError::NoHeading { .. })
        ));
        let (up, report) = apply_lever_arm(&still, [0.0, 0.0, -0.2], &options).expect("vertical");
        assert_eq!(
            (up.fixes()[0].position_m, report.vertical),
            ([1.0, 1.0, 0.8], 5)
        );
        assert!(apply_lever_arm(&still, [f64::NAN, 0.0, 0.0], &options).is_err());
    }

    #[test]
    fn attitude_wins_over_the_track() {
        let mut fixes: Vec<Fix> = (0..4)
            .map(|i| Fix::new(f64::from(i), [2.0 * f64::from(i), 0.0, 5.0]))
            .collect();
        // Flying east with the nose north, rolled a quarter turn to the right.
        let north = Attitude::from_heading(0.0);
        let [w, _, _, z] = north.quaternion();
        assert!((w * w + z * z - 1.0).abs() < 1e-12);
        fixes[1].attitude = Some(north);
        fixes[2].attitude =
            Attitude::from_quaternion((TAU / 8.0).cos(), (TAU / 8.0).sin(), 0.0, 0.0);
        let (moved, report) =
            apply_lever_arm(&track(fixes), [1.0, 0.0, 0.5], &HeadingOptions::default())
                .expect("moves");
        assert_eq!((report.from_attitude, report.held), (2, 2));
        // The first has none and takes the first there is.
        assert!(distance(moved.fixes()[0].position_m, [0.0, 1.0, 5.5]) < 1e-12);
        assert!(distance(moved.fixes()[1].position_m, [2.0, 1.0, 5.5]) < 1e-12);
        // About forward = east by +90°: up turns to −y (south).
        assert!(distance(moved.fixes()[2].position_m, [5.0, -0.5, 5.0]) < 1e-12);
        assert!(distance(moved.fixes()[3].position_m, [7.0, -0.5, 5.0]) < 1e-12);
    }
}
