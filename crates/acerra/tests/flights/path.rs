//! Paths of random flights: where the positioned point is and how the craft is turned, at any time.

use acerra_geo::trajectory::Attitude;

use crate::random::{Random, Sway};

/// What is flown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    Straight,
    Arc,
    Circle,
    Slanted,
    Grid,
    HoverAndYaw,
}

pub const SHAPES: [Shape; 6] = [
    Shape::Straight,
    Shape::Arc,
    Shape::Circle,
    Shape::Slanted,
    Shape::Grid,
    Shape::HoverAndYaw,
];

impl Shape {
    pub fn name(self) -> &'static str {
        match self {
            Self::Straight => "straight",
            Self::Arc => "arc",
            Self::Circle => "circle",
            Self::Slanted => "slanted",
            Self::Grid => "grid",
            Self::HoverAndYaw => "hover and yaw",
        }
    }
}

/// Position (m) and attitude at a time.
#[derive(Clone, Copy, Debug)]
pub struct Pose {
    pub position_m: [f64; 3],
    pub attitude: Attitude,
}

/// Height of the positioned point while the craft stands (m).
const GROUND_M: f64 = 0.4;
/// Acceleration on the track (m/s²).
const ACCELERATION_M_S2: f64 = 1.0;
/// Hover before and after the track, and where the craft turns on the spot (s).
const HOVER_S: f64 = 4.0;
const YAW_S: f64 = 6.0;

/// A flight from the ground to the ground.
pub struct Path {
    shape: Shape,
    pub height_m: f64,
    pub length_m: f64,
    speed_m_s: f64,
    /// Turn of the nose on the spot (rad).
    yaw_rad: f64,
    /// Time on the ground before and after (s).
    pub ground_s: f64,
    climb_s: f64,
    /// Corners of the track, or of the polygon that stands for a curve.
    corners_m: Vec<[f64; 3]>,
    /// Wander along east, north, up (m); roll, pitch, yaw (rad).
    wander: [Sway; 3],
    tilt: [Sway; 3],
    /// Lean into the wind (rad), and where from the wind blows (rad clockwise from north).
    lean_rad: f64,
    wind_rad: f64,
    crab_rad: f64,
}

impl Path {
    /// A path of a shape at a height, in a wind.
    pub fn of(shape: Shape, height_m: f64, wind_m_s: f64, random: &mut Random) -> Self {
        let length_m = (1.2 * height_m).clamp(9.0, 22.0);
        let corners_m = corners(shape, height_m, length_m, random);
        let length_m = length_of(&corners_m);
        let wind_rad = random.between(0.0, std::f64::consts::TAU);
        let level_m = 0.02 + 0.015 * wind_m_s;
        let tilt_rad = (0.5 + 0.25 * wind_m_s).to_radians();
        let mut sway = |sigma: f64, period_s| Sway::of(sigma, period_s, random);
        let wander = [level_m, level_m, 0.6 * level_m].map(|s| sway(s, [3.0, 20.0]));
        let tilt = [tilt_rad, tilt_rad, 1.5 * tilt_rad].map(|s| sway(s, [1.5, 10.0]));
        Self {
            shape,
            height_m,
            length_m,
            speed_m_s: random.between(1.0, 2.0),
            yaw_rad: random.between(0.5, 1.0) * std::f64::consts::TAU,
            ground_s: random.between(8.0, 25.0),
            climb_s: 1.5 * height_m / random.between(1.0, 3.0),
            corners_m,
            wander,
            tilt,
            lean_rad: (0.8 * wind_m_s).to_radians(),
            wind_rad,
            crab_rad: random.normal((0.5 * wind_m_s).to_radians()),
        }
    }

    /// Start and end of a log that is switched on and off by hand, about the track (s).
    pub fn recorded_s(&self) -> [f64; 2] {
        let [start_s, end_s] = self.on_track_s();
        [start_s - 0.7 * HOVER_S, end_s + 0.7 * HOVER_S]
    }

    /// Start and end of the track (s).
    fn on_track_s(&self) -> [f64; 2] {
        let start_s = self.ground_s + self.climb_s + HOVER_S;
        [start_s, start_s + self.track_s()]
    }

    /// When it has landed and stood (s).
    pub fn duration_s(&self) -> f64 {
        self.on_track_s()[1] + HOVER_S + self.climb_s + self.ground_s
    }

    fn track_s(&self) -> f64 {
        let halts = if self.shape == Shape::HoverAndYaw {
            2.0
        } else {
            1.0
        };
        let spot_s = if self.shape == Shape::HoverAndYaw {
            YAW_S
        } else {
            0.0
        };
        halts * self.leg_s(self.length_m / halts) + spot_s
    }

    /// Time over a leg from halt to halt (s).
    fn leg_s(&self, length_m: f64) -> f64 {
        length_m / self.speed_m_s + self.speed_m_s / ACCELERATION_M_S2
    }

    /// Way on a leg after a time (m).
    fn leg_m(&self, length_m: f64, time_s: f64) -> f64 {
        let (v, a) = (self.speed_m_s, ACCELERATION_M_S2);
        let t = time_s.clamp(0.0, self.leg_s(length_m));
        let left = self.leg_s(length_m) - t;
        let ramp_s = v / a;
        if t < ramp_s {
            0.5 * a * t * t
        } else if left < ramp_s {
            length_m - 0.5 * a * left * left
        } else {
            v * (t - 0.5 * ramp_s)
        }
    }

    /// Way along the track (m) and turn on the spot (rad) at a time of the track.
    fn progress(&self, time_s: f64) -> (f64, f64) {
        if self.shape != Shape::HoverAndYaw {
            return (self.leg_m(self.length_m, time_s), 0.0);
        }
        let half_m = 0.5 * self.length_m;
        let leg_s = self.leg_s(half_m);
        let turned = eased((time_s - leg_s) / YAW_S);
        let second_m = self.leg_m(half_m, time_s - leg_s - YAW_S);
        (self.leg_m(half_m, time_s) + second_m, self.yaw_rad * turned)
    }

    /// Position and attitude at a time.
    pub fn at(&self, time_s: f64) -> Pose {
        let [start_s, end_s] = self.on_track_s();
        let up = eased((time_s - self.ground_s) / self.climb_s);
        let down = eased((time_s - end_s - HOVER_S) / self.climb_s);
        let airborne = up - down;
        let (way_m, turned_rad) = self.progress(time_s - start_s);
        let (place_m, course_rad) = self.on_corners(way_m);
        let sway = |k: usize| airborne * self.wander[k].at(time_s);
        let z_m = GROUND_M + (place_m[2] - GROUND_M) * airborne + sway(2);
        let heading_rad =
            course_rad + turned_rad + airborne * (self.crab_rad + self.tilt[2].at(time_s));
        let (right, ahead) = (self.wind_rad - heading_rad).sin_cos();
        let roll_rad = airborne * (self.lean_rad * right + self.tilt[0].at(time_s));
        let pitch_rad = airborne * (self.tilt[1].at(time_s) - self.lean_rad * ahead);
        Pose {
            position_m: [place_m[0] + sway(0), place_m[1] + sway(1), z_m],
            attitude: turned(heading_rad, pitch_rad, roll_rad),
        }
    }

    /// Place and course (clockwise from north) after a way along the corners.
    pub fn on_corners(&self, way_m: f64) -> ([f64; 3], f64) {
        let mut left_m = way_m;
        let legs = self.corners_m.len() - 1;
        for (k, pair) in self.corners_m.windows(2).enumerate() {
            let d: [f64; 3] = std::array::from_fn(|i| pair[1][i] - pair[0][i]);
            let leg_m = d.iter().map(|v| v * v).sum::<f64>().sqrt();
            if left_m <= leg_m || k + 1 == legs {
                let share = (left_m / leg_m).min(1.0);
                return (
                    std::array::from_fn(|i| pair[0][i] + share * d[i]),
                    d[0].atan2(d[1]),
                );
            }
            left_m -= leg_m;
        }
        (self.corners_m[legs], 0.0)
    }
}

/// Smooth between 0 and 1.
fn eased(share: f64) -> f64 {
    let x = share.clamp(0.0, 1.0);
    x * x * x * (10.0 + x * (6.0 * x - 15.0))
}

fn corners(shape: Shape, height_m: f64, length_m: f64, random: &mut Random) -> Vec<[f64; 3]> {
    let half_m = 0.5 * length_m;
    let around = |radius_m: f64, angle_rad: f64, centre_m: [f64; 2]| {
        let steps = 90;
        (0..=steps)
            .map(|k| angle_rad * (f64::from(k) / f64::from(steps) - 0.5))
            .map(|a| {
                [
                    centre_m[0] + radius_m * a.sin(),
                    centre_m[1] - radius_m * a.cos(),
                    height_m,
                ]
            })
            .collect()
    };
    match shape {
        Shape::Straight | Shape::HoverAndYaw => {
            vec![[-half_m, 0.0, height_m], [half_m, 0.0, height_m]]
        }
        Shape::Slanted => {
            let rise_m = random.between(0.1, 0.2) * height_m;
            vec![
                [-half_m, 0.0, height_m - rise_m],
                [half_m, 0.0, height_m + rise_m],
            ]
        }
        Shape::Arc => {
            let angle_rad = random.between(40.0, 110.0).to_radians();
            let radius_m = length_m / angle_rad;
            // Its middle is the origin, and its centre lies to the north.
            around(radius_m, angle_rad, [0.0, radius_m])
        }
        Shape::Circle => {
            let radius_m = random.between(0.4, 0.7) * height_m.max(4.0);
            around(radius_m, std::f64::consts::TAU, [0.0, radius_m])
        }
        Shape::Grid => {
            let between_m = random.between(1.5, 2.2);
            let line = |k: i32| {
                let y_m = -between_m * f64::from(k);
                let end = if k % 2 == 0 { half_m } else { -half_m };
                let turn = (0..=12).map(move |step| {
                    let angle = std::f64::consts::PI * f64::from(step) / 12.0;
                    let radius_m = 0.5 * between_m;
                    let x_m = end + end.signum() * radius_m * angle.sin();
                    [x_m, y_m - radius_m * (1.0 - angle.cos()), height_m]
                });
                std::iter::once([-end, y_m, height_m]).chain(turn.take(if k < 2 { 12 } else { 1 }))
            };
            (0..3).flat_map(line).collect()
        }
    }
}

fn length_of(corners_m: &[[f64; 3]]) -> f64 {
    let leg = |p: &[[f64; 3]]| {
        (0..3)
            .map(|i| (p[1][i] - p[0][i]).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    corners_m.windows(2).map(leg).sum()
}

/// Heading clockwise from north, then nose up, then right wing down.
fn turned(heading_rad: f64, pitch_rad: f64, roll_rad: f64) -> Attitude {
    let times = |[a, b, c, d]: [f64; 4], [e, f, g, h]: [f64; 4]| {
        [
            a * e - b * f - c * g - d * h,
            a * f + b * e + c * h - d * g,
            a * g - b * h + c * e + d * f,
            a * h + b * g - c * f + d * e,
        ]
    };
    let [(sp, cp), (sr, cr)] = [-0.5 * pitch_rad, 0.5 * roll_rad].map(f64::sin_cos);
    let level = Attitude::from_heading(heading_rad);
    let nose_up = times(level.quaternion(), [cp, 0.0, sp, 0.0]);
    let [w, x, y, z] = times(nose_up, [cr, sr, 0.0, 0.0]);
    Attitude::from_quaternion(w, x, y, z).unwrap_or(level)
}
