//! Motions of side-looking captures: where the positioned point is and how the body is turned, at any time.

use acerra_geo::trajectory::Attitude;

use crate::random::{Random, Sway};

/// What carries the radar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Carrier {
    /// A slide on a straight rail.
    Rail,
    /// The hand of somebody who walks.
    Hand,
    /// A multicopter in a motion-capture hall.
    Hall,
}

pub const CARRIERS: [Carrier; 3] = [Carrier::Rail, Carrier::Hand, Carrier::Hall];

impl Carrier {
    pub fn name(self) -> &'static str {
        match self {
            Self::Rail => "rail",
            Self::Hand => "hand",
            Self::Hall => "hall",
        }
    }
}

/// A straight way to the east, or there and back, from halt to halt.
pub struct Motion {
    pub carrier: Carrier,
    /// Length of the way (m), and the speed on it (m/s).
    pub length_m: f64,
    pub speed_m_s: f64,
    pub height_m: f64,
    pub returns: bool,
    /// Halt before and after (s).
    halt_s: f64,
    /// Time of acceleration and of braking (s).
    ramp_s: f64,
    /// Steps of a walk: height (m), rate (rad/s) and phase (rad) of the bobbing.
    bob: [f64; 3],
    /// Wander to the east, north, up (m), and of roll, pitch and yaw (rad).
    wander: [Sway; 3],
    tilt: [Sway; 3],
}

impl Motion {
    pub fn of(carrier: Carrier, random: &mut Random) -> Self {
        let (length_m, speed_m_s, height_m) = match carrier {
            Carrier::Rail => {
                let length_m = random.between(1.0, 5.0);
                (length_m, length_m / random.between(10.0, 30.0), [0.5, 2.0])
            }
            Carrier::Hand => (
                random.between(3.0, 8.0),
                random.between(0.5, 1.2),
                [0.9, 1.6],
            ),
            Carrier::Hall => (
                random.between(3.0, 7.0),
                random.between(0.3, 1.0),
                [1.5, 3.0],
            ),
        };
        let (wander_m, tilt_deg, period_s) = match carrier {
            Carrier::Rail => ([0.0, 0.0005, 0.0005], [0.05; 3], [1.0, 5.0]),
            Carrier::Hand => (
                [0.01, 0.03, 0.01],
                [random.between(2.0, 6.0); 3],
                [0.8, 4.0],
            ),
            Carrier::Hall => (
                [0.03, 0.05, 0.03],
                [random.between(1.0, 3.0); 3],
                [1.5, 8.0],
            ),
        };
        let is_walk = carrier == Carrier::Hand;
        let bob_m = if is_walk {
            random.between(0.02, 0.05)
        } else {
            0.0
        };
        let bob_hz = random.between(1.5, 2.0);
        Self {
            carrier,
            length_m,
            speed_m_s,
            height_m: random.between(height_m[0], height_m[1]),
            returns: random.happens(0.3),
            halt_s: random.between(3.0, 6.0),
            ramp_s: if carrier == Carrier::Rail { 0.3 } else { 0.8 },
            bob: [
                0.5 * bob_m,
                std::f64::consts::TAU * bob_hz,
                random.between(0.0, std::f64::consts::TAU),
            ],
            wander: wander_m.map(|sigma| Sway::of(sigma, period_s, random)),
            tilt: tilt_deg.map(|deg: f64| Sway::of(deg.to_radians(), period_s, random)),
        }
    }

    /// Time from halt to halt over the way (s).
    fn leg_s(&self) -> f64 {
        self.length_m / self.speed_m_s + self.ramp_s
    }

    /// When the radar is switched off (s).
    pub fn duration_s(&self) -> f64 {
        let legs = if self.returns { 2.0 } else { 1.0 };
        (legs + 1.0) * self.halt_s + legs * self.leg_s()
    }

    /// Way after the start of a leg (m), and the share of the full speed.
    fn on_leg(&self, time_s: f64) -> (f64, f64) {
        let (v, ramp_s) = (self.speed_m_s, self.ramp_s);
        let t = time_s.clamp(0.0, self.leg_s());
        let left_s = self.leg_s() - t;
        if t < ramp_s {
            (0.5 * v / ramp_s * t * t, t / ramp_s)
        } else if left_s < ramp_s {
            let left_m = 0.5 * v / ramp_s * left_s * left_s;
            (self.length_m - left_m, left_s / ramp_s)
        } else {
            (v * (t - 0.5 * ramp_s), 1.0)
        }
    }

    /// Position (m), and roll, pitch and heading of the level body (rad), at a time.
    pub fn at(&self, time_s: f64) -> ([f64; 3], [f64; 3]) {
        let (there_m, there) = self.on_leg(time_s - self.halt_s);
        let back_s = time_s - 2.0 * self.halt_s - self.leg_s();
        let (back_m, back) = if self.returns {
            self.on_leg(back_s)
        } else {
            (0.0, 0.0)
        };
        let moving = there.max(back);
        // A platform that stands still moves less; a multicopter hovers.
        let share = match self.carrier {
            Carrier::Rail => moving,
            Carrier::Hand => 0.1 + 0.9 * moving,
            Carrier::Hall => 1.0,
        };
        let [bob_m, rate, phase] = self.bob;
        let sway = |k: usize| share * self.wander[k].at(time_s);
        let position_m = [
            there_m - back_m - 0.5 * self.length_m + sway(0),
            sway(1),
            self.height_m + sway(2) + moving * bob_m * (rate * time_s + phase).sin(),
        ];
        let turn = |k: usize| share * self.tilt[k].at(time_s);
        let heading_rad = std::f64::consts::FRAC_PI_2 + turn(2);
        (position_m, [turn(0), turn(1), heading_rad])
    }
}

/// The attitude of a body; `side_looking` turns what looks down on the body to its left.
pub fn attitude([roll_rad, pitch_rad, heading_rad]: [f64; 3], side_looking: bool) -> [f64; 4] {
    let quarter_rad = if side_looking {
        std::f64::consts::FRAC_PI_2
    } else {
        0.0
    };
    Attitude::from_euler([roll_rad + quarter_rad, pitch_rad, heading_rad])
        .unwrap_or(Attitude::IDENTITY)
        .quaternion()
}

/// A lever arm of the level body in the axes of the body that [`attitude`] turns to the side.
pub fn side_looking_arm([forward_m, left_m, up_m]: [f64; 3]) -> [f64; 3] {
    [forward_m, up_m, -left_m]
}
