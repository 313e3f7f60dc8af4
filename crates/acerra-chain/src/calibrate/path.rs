//! The flown path in the form that the calibration needs: the positioned point, and the displacement of the
//! phase centre for each unit of lever arm.
//!
//! The lever arm enters the chain linearly (see [`apply_lever_arm`]), and so does interpolation: the path
//! moved by a unit arm, less the path itself, is exactly the chain's displacement by that arm.

use acerra_geo::interpolate::{Flag, Interpolator};
use acerra_geo::lever_arm::{HeadingOptions, apply_lever_arm};
use acerra_geo::trajectory::Trajectory;

use crate::align::interpolator;
use crate::position::Positions;

/// Position of the positioned point and attitude of the body at one time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pose {
    /// The positioned point, east, north, up (m).
    pub position_m: [f64; 3],
    /// Velocity, averaged over [`RATE_WINDOW_S`] (m/s).
    pub velocity_m_s: [f64; 3],
    /// Forward, left and up axis, in east, north, up; zero where the heading is unknown.
    pub axis: [[f64; 3]; 3],
    /// Rates, averaged in the same way (1/s).
    pub axis_rate: [[f64; 3]; 3],
    /// Standard deviations of the position (m), where the trajectory states them.
    pub sigma_m: Option<[f64; 3]>,
}

impl Pose {
    /// The phase centre at the end of a lever arm (m).
    pub fn phase_centre_m(&self, lever_arm_m: [f64; 3]) -> [f64; 3] {
        moved(self.position_m, &self.axis, lever_arm_m)
    }

    /// Velocity of the positioned point (m/s).
    pub fn phase_centre_velocity_m_s(&self, lever_arm_m: [f64; 3]) -> [f64; 3] {
        moved(self.velocity_m_s, &self.axis_rate, lever_arm_m)
    }
}

fn moved(start: [f64; 3], axis: &[[f64; 3]; 3], arm: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| {
        start[i]
            + axis
                .iter()
                .zip(arm)
                .map(|(axis, arm)| arm * axis[i])
                .sum::<f64>()
    })
}

/// A track's path, with the paths of the ends of unit lever arms.
#[derive(Clone, Debug)]
pub(super) enum Path {
    /// On a clock of its own.
    Flown {
        point: Box<Trajectory>,
        /// Moved by 1 m forward, left, up; absent without a heading.
        arm_end: Box<[Option<Trajectory>; 3]>,
        max_gap_s: Option<f64>,
    },
    /// One place of the phase centre for each trace: neither offset nor lever arm.
    PerTrace {
        time_s: Vec<f64>,
        position_m: Vec<[f64; 3]>,
    },
}

impl Path {
    /// The path of positions that do not yet contain a lever arm.
    pub fn new(positions: &Positions, time_s: &[f64], max_gap_s: Option<f64>) -> Self {
        match positions {
            Positions::PerTrace(places) => Self::PerTrace {
                time_s: time_s.to_vec(),
                position_m: places.position_m.clone(),
            },
            Positions::Trajectory(point) => {
                let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
                let end = |arm| {
                    let moved = apply_lever_arm(point, arm, &HeadingOptions::default());
                    moved.ok().map(|(trajectory, _)| trajectory)
                };
                Self::Flown {
                    arm_end: Box::new(unit.map(end)),
                    point: point.clone(),
                    max_gap_s,
                }
            }
        }
    }

    /// A reader of the path at any time.
    pub fn sampler(&self) -> Sampler<'_> {
        match self {
            Self::Flown {
                point,
                arm_end,
                max_gap_s,
            } => {
                let along = |trajectory| interpolator(*max_gap_s, trajectory);
                Sampler::Flown {
                    point: Box::new(along(point)),
                    arm_end: Box::new([0, 1, 2].map(|i| arm_end[i].as_ref().map(along))),
                }
            }
            Self::PerTrace { time_s, position_m } => Sampler::PerTrace { time_s, position_m },
        }
    }
}

/// Reads a [`Path`] at any time.
#[derive(Debug)]
pub(super) enum Sampler<'a> {
    Flown {
        point: Box<Interpolator<'a>>,
        arm_end: Box<[Option<Interpolator<'a>>; 3]>,
    },
    PerTrace {
        time_s: &'a [f64],
        position_m: &'a [[f64; 3]],
    },
}

impl Sampler<'_> {
    /// The pose at radar time `time_s` and clock offset `offset_s`; none beyond the path's ends and within
    /// gaps of the path.
    pub fn at(&self, time_s: f64, offset_s: f64) -> Option<Pose> {
        match self {
            Self::Flown { point, arm_end } => flown(point, arm_end, time_s + offset_s),
            Self::PerTrace {
                time_s: times_s,
                position_m,
            } => {
                let k = times_s.partition_point(|t| *t < time_s);
                Some(Pose {
                    position_m: *position_m.get(k)?,
                    velocity_m_s: [0.0; 3],
                    axis: [[0.0; 3]; 3],
                    axis_rate: [[0.0; 3]; 3],
                    sigma_m: None,
                })
            }
        }
    }
}

/// Time over which velocities are averaged (s). Noise of the positions must not pass for motion: it
/// would seem to separate the clock offset from a lever arm ahead.
const RATE_WINDOW_S: f64 = 1.0;

fn flown(
    point: &Interpolator<'_>,
    arm_end: &[Option<Interpolator<'_>>; 3],
    time_s: f64,
) -> Option<Pose> {
    let at = point.at(time_s);
    if matches!(at.flag, Flag::BeforeStart | Flag::AfterEnd | Flag::InGap) {
        return None;
    }
    let mut pose = Pose {
        position_m: at.position_m,
        velocity_m_s: [0.0; 3],
        axis: [[0.0; 3]; 3],
        axis_rate: [[0.0; 3]; 3],
        sigma_m: at
            .covariance_m2
            .map(|c| [0, 1, 2].map(|i| c[i][i].max(0.0).sqrt())),
    };
    // Beyond the ends of the path and in gaps the window is cut to the side that is covered.
    let [before_s, after_s] = [-0.5, 0.5].map(|part| {
        let other_s = time_s + part * RATE_WINDOW_S;
        if point.at(other_s).flag.is_covered() {
            other_s
        } else {
            time_s
        }
    });
    let span_s = (after_s - before_s).max(1e-9);
    let rate = |of: &Interpolator<'_>| {
        subtract(of.at(after_s).position_m, of.at(before_s).position_m).map(|d| d / span_s)
    };
    pose.velocity_m_s = rate(point);
    for (i, end) in arm_end.iter().enumerate() {
        if let Some(end) = end {
            pose.axis[i] = subtract(end.at(time_s).position_m, at.position_m);
            pose.axis_rate[i] = subtract(rate(end), pose.velocity_m_s);
        }
    }
    Some(pose)
}

fn subtract(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i] - b[i])
}
