//! The platform's motion at its latest positions: where it is a little later.

use acerra_geo::matrix::{add, scale, subtract};
use acerra_geo::trajectory::Fix;

/// Longest time beyond the latest position, in intervals of positions.
const MOST_INTERVALS: f64 = 2.0;
/// Longest time beyond the latest position (s).
const LONGEST_S: f64 = 1.0;

/// A position's time (s) and, where the receiver states it, the velocity there (m/s).
#[derive(Clone, Copy, Debug)]
struct Moment {
    time_s: f64,
    velocity_m_s: Option<[f64; 3]>,
}

/// The velocities at the latest two positions.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Motion {
    before: Option<Moment>,
    latest: Option<Moment>,
}

impl Motion {
    /// Takes the velocity that the receiver states with a position.
    pub fn take(&mut self, time_s: f64, velocity_m_s: Option<[f64; 3]>) {
        self.before = self.latest.replace(Moment {
            time_s,
            velocity_m_s,
        });
    }

    /// The displacement since the latest of two fixes until a later time (m); none where that is too far off.
    ///
    /// The receiver's velocities at both fixes give velocity and acceleration. Without them the velocity is
    /// that between the fixes: an acceleration by three positions would be three times as noisy.
    pub fn displacement_m(&self, [before, latest]: [&Fix; 2], time_s: f64) -> Option<[f64; 3]> {
        let interval_s = latest.time_s - before.time_s;
        let after_s = time_s - latest.time_s;
        let longest_s = (MOST_INTERVALS * interval_s).min(LONGEST_S);
        if !(after_s >= 0.0 && after_s <= longest_s && interval_s <= LONGEST_S) {
            return None;
        }
        let velocity_at = |moment: Option<Moment>, fix: &Fix| {
            let moment = moment.filter(|moment| moment.time_s == fix.time_s)?;
            moment.velocity_m_s
        };
        let Some(velocity_m_s) = velocity_at(self.latest, latest) else {
            let step_m = subtract(latest.position_m, before.position_m);
            return Some(scale(after_s / interval_s, step_m));
        };
        let linear_m = scale(after_s, velocity_m_s);
        let Some(before_m_s) = velocity_at(self.before, before) else {
            return Some(linear_m);
        };
        let change_m_s = subtract(velocity_m_s, before_m_s);
        let bend_m = scale(0.5 * after_s * after_s / interval_s, change_m_s);
        Some(add(linear_m, bend_m))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fix(time_s: f64) -> Fix {
        // 2 m/s to the east, 0.5 m/s² to the north.
        Fix::new(time_s, [2.0 * time_s, 0.25 * time_s * time_s, 10.0])
    }

    fn velocity(time_s: f64) -> Option<[f64; 3]> {
        Some([2.0, 0.5 * time_s, 0.0])
    }

    fn off_m(motion: &Motion, after_s: f64) -> f64 {
        let (before, latest) = (fix(4.0), fix(4.1));
        let moved_m = motion.displacement_m([&before, &latest], 4.1 + after_s);
        let truth = fix(4.1 + after_s).position_m;
        let found = add(latest.position_m, moved_m.unwrap());
        (0..3).fold(0.0, |off: f64, k| off.max((found[k] - truth[k]).abs()))
    }

    #[test]
    fn the_receivers_velocities_tell_velocity_and_acceleration() {
        let mut motion = Motion::default();
        motion.take(4.0, velocity(4.0));
        motion.take(4.1, velocity(4.1));
        assert!(off_m(&motion, 0.15) < 1e-9);
    }

    #[test]
    fn without_them_the_line_through_two_positions_goes_on() {
        let mut motion = Motion::default();
        // Half the acceleration times time since and time between.
        let expected_m = 0.5 * 0.5 * 0.15 * (0.15 + 0.1);
        assert!((off_m(&motion, 0.15) - expected_m).abs() < 1e-9);
        motion.take(4.0, None);
        motion.take(4.1, None);
        assert!((off_m(&motion, 0.15) - expected_m).abs() < 1e-9);
        // A velocity of another position is none of this one.
        motion.take(4.2, velocity(4.2));
        assert!((off_m(&motion, 0.15) - expected_m).abs() < 1e-9);
    }

    #[test]
    fn nothing_is_said_of_times_too_far_off() {
        let motion = Motion::default();
        let at = |between_s: f64, after_s: f64| {
            motion
                .displacement_m([&fix(0.0), &fix(between_s)], between_s + after_s)
                .is_some()
        };
        assert!(at(0.1, 0.19) && !at(0.1, 0.21));
        assert!(at(1.0, 0.99) && !at(1.0, 1.01));
        assert!(!at(3.0, 0.1) && !at(0.1, -0.1) && !at(0.1, f64::NAN));
    }
}
