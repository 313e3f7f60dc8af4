//! The flight as flown: position and attitude over time.

use acerra_geo::trajectory::Attitude;
use acerra_settings::ValueError;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::model::FlightModel;
use super::wander::Wander;

/// Spacing of the stored poses (s).
pub(super) const STEP_S: f64 = 0.01;

/// Position of the positioned point and attitude of the body at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Seconds from the start of the flight.
    pub time_s: f64,
    /// East, north, up (m).
    pub position_m: [f64; 3],
    /// From forward, left, up to east, north, up.
    pub attitude: Attitude,
}

impl Pose {
    /// The place of a point of the body, given forward, left and up of the positioned point (m).
    #[must_use]
    pub fn point_m(&self, lever_arm_m: [f64; 3]) -> [f64; 3] {
        let arm = self.attitude.rotate(lever_arm_m);
        [0, 1, 2].map(|i| self.position_m[i] + arm[i])
    }
}

/// A whole flight.
#[derive(Clone, Debug)]
pub struct Flight {
    poses: Vec<Pose>,
    /// When the craft passes the two ends of the track (s).
    pub on_track_s: [f64; 2],
}

impl Flight {
    /// Flies the model; the same seed gives the same flight.
    ///
    /// # Errors
    /// A model that no craft can fly.
    ///
    /// ```
    /// use acerra_simulate::flight::{Flight, FlightModel};
    /// let model: FlightModel = toml::from_str(
    ///     "track_start_m = [0, 0]\ntrack_end_m = [31.4, 0]\nheight_m = 4\ntrack_duration_s = 17.5",
    /// )?;
    /// let flight = Flight::fly(&model, 1)?;
    /// let [start, end] = flight.on_track_s;
    /// assert!((end - start - 17.5).abs() < 1e-9);
    /// let travelled = flight.pose_at(end).position_m[0] - flight.pose_at(start).position_m[0];
    /// assert!((travelled - 31.4).abs() < 1.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn fly(model: &FlightModel, seed: u64) -> Result<Self, ValueError> {
        model.check()?;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let plan = Timetable::of(model);
        let wander_steps =
            |sigma: f64, rng: &mut ChaCha8Rng| Wander::new(sigma, model.wander_time_s, STEP_S, rng);
        let mut wander = model.wander_m.map(|sigma| wander_steps(sigma, &mut rng));
        let mut tilt = model
            .tilt_deg
            .map(|sigma| wander_steps(sigma.to_radians(), &mut rng));

        let length = model.track_length_m();
        let along = [0, 1].map(|i| (model.track_end_m[i] - model.track_start_m[i]) / length);
        let across = [-along[1], along[0]];
        let heading_rad = along[0].atan2(along[1]);

        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "checked to be a moderate positive number"
        )]
        let count = (plan.end_s / STEP_S).ceil() as usize + 2;
        let mut poses = Vec::with_capacity(count);
        for k in 0..count {
            #[expect(clippy::cast_precision_loss, reason = "a count of steps")]
            let time_s = k as f64 * STEP_S;
            // On the ground the wander is zero; in the air it has its full size.
            let airborne = plan.airborne(time_s);
            let [da, dc, du] = [0, 1, 2].map(|i| airborne * wander[i].step(&mut rng));
            let [roll, pitch, yaw] = [0, 1, 2].map(|i| airborne * tilt[i].step(&mut rng));
            let s = plan.progress_m(time_s) + da;
            let [e, n] = [0, 1].map(|i| model.track_start_m[i] + along[i] * s + across[i] * dc);
            poses.push(Pose {
                time_s,
                position_m: [e, n, plan.height_m(time_s) + du],
                attitude: attitude(heading_rad + yaw, pitch, roll),
            });
        }
        Ok(Self {
            poses,
            on_track_s: plan.on_track_s,
        })
    }

    /// A flight through `poses`, [`STEP_S`] apart and never empty.
    pub(super) fn of(poses: Vec<Pose>, on_track_s: [f64; 2]) -> Self {
        Self { poses, on_track_s }
    }

    /// Duration (s).
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.poses.last().map_or(0.0, |pose| pose.time_s)
    }

    /// The pose at any time; before the start and after the end, the first and last one.
    #[must_use]
    pub fn pose_at(&self, time_s: f64) -> Pose {
        let last = self.poses.len() - 1;
        #[expect(clippy::cast_precision_loss, reason = "a count of steps")]
        let at = (time_s / STEP_S).clamp(0.0, last as f64);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped to the stored poses"
        )]
        let k = (at as usize).min(last.saturating_sub(1));
        #[expect(clippy::cast_precision_loss, reason = "a count of steps")]
        let u = at - k as f64;
        let near = |i: isize| &self.poses[k.saturating_add_signed(i).min(last)];
        let (before, a, b, after) = (near(-1), near(0), near(1), near(2));
        // Cubic through the two poses, with slopes from their neighbours (Catmull and Rom).
        let position_m = [0, 1, 2].map(|i| {
            let p = [before, a, b, after].map(|pose| pose.position_m[i]);
            let (m0, m1) = (0.5 * (p[2] - p[0]), 0.5 * (p[3] - p[1]));
            let d = p[2] - p[1];
            p[1] + u * (m0 + u * (3.0 * d - 2.0 * m0 - m1 + u * (m0 + m1 - 2.0 * d)))
        });
        Pose {
            time_s,
            position_m,
            attitude: a.attitude.towards(&b.attitude, u),
        }
    }
}

/// When the craft does what.
struct Timetable {
    takeoff_s: f64,
    /// Start of the run-in, ends of the track, end of the run-out.
    run_in_s: f64,
    on_track_s: [f64; 2],
    run_out_end_s: f64,
    landed_s: f64,
    end_s: f64,
    run_in_m: f64,
    track_m: f64,
    ground_height_m: f64,
    height_m: f64,
}

impl Timetable {
    fn of(model: &FlightModel) -> Self {
        let track_m = model.track_length_m();
        let speed = track_m / model.track_duration_s;
        // Half the mean speed from standstill to track speed: run-in takes twice its time.
        let run_s = (2.0 * model.run_in_m / speed).max(2.0 * STEP_S);
        let climb_s = 1.5 * (model.height_m - model.ground_height_m) / model.climb_m_s;
        let takeoff_s = model.ground_time_s;
        let run_in_s = takeoff_s + climb_s;
        let on_track_s = [run_in_s + run_s, run_in_s + run_s + model.track_duration_s];
        let run_out_end_s = on_track_s[1] + run_s;
        let landed_s = run_out_end_s + climb_s;
        Self {
            takeoff_s,
            run_in_s,
            on_track_s,
            run_out_end_s,
            landed_s,
            end_s: landed_s + model.ground_time_s,
            run_in_m: model.run_in_m,
            track_m,
            ground_height_m: model.ground_height_m,
            height_m: model.height_m,
        }
    }

    /// 0 on the ground, 1 in the air, smooth between.
    fn airborne(&self, time_s: f64) -> f64 {
        ramp(time_s, self.takeoff_s, self.run_in_s)
            * (1.0 - ramp(time_s, self.run_out_end_s, self.landed_s))
    }

    fn height_m(&self, time_s: f64) -> f64 {
        self.ground_height_m + (self.height_m - self.ground_height_m) * self.airborne(time_s)
    }

    /// Distance along the track's line, 0 at its start: uniformly accelerated, even, slowed.
    fn progress_m(&self, time_s: f64) -> f64 {
        let [start, end] = self.on_track_s;
        if time_s < start {
            let u = ((time_s - self.run_in_s) / (start - self.run_in_s)).max(0.0);
            -self.run_in_m * (1.0 - u * u)
        } else if time_s <= end {
            self.track_m * (time_s - start) / (end - start)
        } else {
            let u = ((self.run_out_end_s - time_s) / (self.run_out_end_s - end)).max(0.0);
            self.track_m + self.run_in_m * (1.0 - u * u)
        }
    }
}

/// Smooth step from 0 at `from` to 1 at `to`.
fn ramp(time_s: f64, from: f64, to: f64) -> f64 {
    let u = ((time_s - from) / (to - from).max(STEP_S)).clamp(0.0, 1.0);
    u * u * (3.0 - 2.0 * u)
}

/// Heading clockwise from north, then nose up, then right wing down.
fn attitude(heading_rad: f64, pitch_rad: f64, roll_rad: f64) -> Attitude {
    let level = Attitude::from_heading(heading_rad);
    let [w, x, y, z] = level.quaternion();
    let (sp, cp) = (-0.5 * pitch_rad).sin_cos();
    let (sr, cr) = (0.5 * roll_rad).sin_cos();
    // level ⊗ (turn about left by −pitch) ⊗ (turn about forward by roll)
    let a = [
        w * cp - y * sp,
        x * cp - z * sp,
        w * sp + y * cp,
        x * sp + z * cp,
    ];
    let q = [
        a[0] * cr - a[1] * sr,
        a[0] * sr + a[1] * cr,
        a[2] * cr + a[3] * sr,
        a[3] * cr - a[2] * sr,
    ];
    Attitude::from_quaternion(q[0], q[1], q[2], q[3]).unwrap_or(level)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model() -> FlightModel {
        toml::from_str(
            "track_start_m = [3, 1]\ntrack_end_m = [3, 34]\nheight_m = 10\ntrack_duration_s = 21.7",
        )
        .unwrap()
    }

    #[test]
    fn the_track_is_flown_as_stated() {
        let flight = Flight::fly(&model(), 7).unwrap();
        let [start, end] = flight.on_track_s;
        let heights: Vec<f64> = (0..=100)
            .map(|k| flight.pose_at(start + (end - start) * f64::from(k) / 100.0))
            .map(|pose| pose.position_m[2])
            .collect();
        let mean = heights.iter().sum::<f64>() / 101.0;
        assert!((mean - 10.0).abs() < 0.1, "{mean}");
        let ends = [start, end].map(|t| flight.pose_at(t).position_m);
        assert!(
            (ends[0][1] - 1.0).abs() < 0.5 && (ends[1][1] - 34.0).abs() < 0.5,
            "{ends:?}"
        );
        assert!((flight.pose_at(0.0).position_m[2] - 0.4).abs() < 1e-12);
        assert!((flight.pose_at(1e9).position_m[2] - 0.4).abs() < 1e-12);
    }

    #[test]
    fn motion_is_smooth_and_repeatable() {
        let flight = Flight::fly(&model(), 7).unwrap();
        let again = Flight::fly(&model(), 7).unwrap();
        let other = Flight::fly(&model(), 8).unwrap();
        let mid = 0.5 * (flight.on_track_s[0] + flight.on_track_s[1]);
        assert_eq!(flight.pose_at(mid), again.pose_at(mid));
        assert_ne!(flight.pose_at(mid), other.pose_at(mid));
        let step = |t: f64| {
            let [a, b, c] = [t - 0.01, t, t + 0.01].map(|t| flight.pose_at(t).position_m);
            [0, 1, 2].map(|i| (a[i] - 2.0 * b[i] + c[i]) / 1e-4)
        };
        let mut t = 0.02;
        while t < flight.duration_s() - 0.02 {
            let acceleration = step(t).iter().map(|a| a * a).sum::<f64>().sqrt();
            assert!(acceleration < 8.0, "{acceleration} m/s² at {t} s");
            t += 0.01;
        }
    }

    #[test]
    fn attitudes_follow_their_names() {
        let north = attitude(0.0, 0.1, 0.0).rotate([1.0, 0.0, 0.0]);
        assert!(
            (north[1] - 0.1_f64.cos()).abs() < 1e-12 && (north[2] - 0.1_f64.sin()).abs() < 1e-12
        );
        // Right wing down: left goes up.
        let left = attitude(0.0, 0.0, 0.1).rotate([0.0, 1.0, 0.0]);
        assert!((left[2] - 0.1_f64.sin()).abs() < 1e-12, "{left:?}");
        let both = attitude(1.0, 0.2, -0.3).rotate([0.0, 0.0, 1.0]);
        assert!((both.iter().map(|v| v * v).sum::<f64>() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn impossible_flights_are_refused() {
        for (key, change) in [
            (
                "height_m",
                FlightModel {
                    height_m: -4.0,
                    ..model()
                },
            ),
            (
                "track_end_m",
                FlightModel {
                    track_end_m: [3.0, 1.0],
                    ..model()
                },
            ),
            (
                "track_duration_s",
                FlightModel {
                    track_duration_s: 0.0,
                    ..model()
                },
            ),
            (
                "track_duration_s",
                FlightModel {
                    track_duration_s: f64::NAN,
                    ..model()
                },
            ),
            (
                "tilt_deg",
                FlightModel {
                    tilt_deg: [90.0, 0.0, 0.0],
                    ..model()
                },
            ),
        ] {
            assert_eq!(Flight::fly(&change, 1).unwrap_err().key, key);
        }
    }
}
