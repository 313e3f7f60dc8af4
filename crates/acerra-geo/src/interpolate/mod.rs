//! Positions at any time, interpolated between fixes; gaps are flagged.
//!
//! # Which curve
//! A multicopter is a heavy thing pushed by bounded forces: its acceleration is bounded and mostly
//! continuous, so its path between two fixes is close to a cubic. [`Method::Smooth`], the default,
//! is the cubic spline through the fixes (continuous acceleration, not-a-knot ends), whose error
//! falls with the fourth power of the interval. For a sway of ±40 cm with a period of 4 s, straight
//! lines are off by up to 28 mm at 2 Hz and 4.9 mm at 5 Hz, the spline by 3.1 mm and 0.04 mm; 1 Hz is
//! too slow for either. At the 360 Hz of motion capture all curves agree within the noise.
//! [`Method::Linear`] follows each pair of fixes alone and is the choice for positions that jump.
//!
//! # Where the curve stops
//! A spline carries a jump at one fix into its neighbours. It therefore runs over one *stretch* at a time:
//! fixes without a gap between them, all of imaging grade or all not. A metre's jump at a float epoch leaves
//! the neighbouring fixed epochs untouched. Between stretches interpolation is linear and flagged. It is
//! linear too, though not flagged, across a few frames that motion capture lost: slopes between noisy frames
//! 3 ms apart do not predict the next 20 ms.

mod path;
mod spline;

pub use path::path_length_per_trace_m;

use crate::matrix::{Matrix3, Vector3, scale, subtract};
use crate::trajectory::{Attitude, Fix, SolutionStatus, Trajectory};
use spline::Spline;

/// Largest number of sample intervals that a curve spans between two fixes: one lost epoch, not two.
const INTERVALS_BRIDGED: f64 = 2.5;

/// Method by which positions between fixes are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// Cubic spline over each stretch.
    #[default]
    Smooth,
    /// Straight lines between fixes.
    Linear,
}

impl Method {
    /// Its name: `smooth` or `linear`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Smooth => "smooth",
            Self::Linear => "linear",
        }
    }
}

impl std::fmt::Display for Method {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

/// A text that names no [`Method`].
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("expected an interpolation of \"smooth\" or \"linear\", found {found:?}")]
pub struct UnknownMethod {
    /// The text.
    pub found: String,
}

impl std::str::FromStr for Method {
    type Err = UnknownMethod;

    fn from_str(text: &str) -> Result<Self, UnknownMethod> {
        [Self::Smooth, Self::Linear]
            .into_iter()
            .find(|method| method.name() == text)
            .ok_or_else(|| UnknownMethod {
                found: text.to_owned(),
            })
    }
}

/// Options of the interpolation.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct InterpolationOptions {
    /// The curve.
    pub method: Method,
    /// Longest time between fixes that is not a gap (s); none: [`default_max_gap_s`].
    pub max_gap_s: Option<f64>,
}

impl InterpolationOptions {
    /// This interpolator with another curve.
    #[must_use]
    pub const fn with_method(mut self, method: Method) -> Self {
        self.method = method;
        self
    }

    /// This interpolator with another longest time between fixes that is not a gap (s).
    #[must_use]
    pub const fn with_max_gap_s(mut self, max_gap_s: f64) -> Self {
        self.max_gap_s = Some(max_gap_s);
        self
    }
}

/// Source of an interpolated position.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Flag {
    /// Between two fixes of imaging grade with no gap between them.
    Ok,
    /// Between fixes of which one or both are below imaging grade.
    Unfixed,
    /// Inside a gap: a straight line between its ends.
    InGap,
    /// Before the first fix (or not a number): the first position.
    BeforeStart,
    /// After the last fix: the last position.
    AfterEnd,
}

impl Flag {
    /// One word, as written in `trajectory.csv`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Unfixed => "unfixed",
            Self::InGap => "in-gap",
            Self::BeforeStart => "before-start",
            Self::AfterEnd => "after-end",
        }
    }

    /// Whether the time lies between fixes without a gap ([`Self::Ok`] or [`Self::Unfixed`]).
    #[must_use]
    pub const fn is_covered(self) -> bool {
        matches!(self, Self::Ok | Self::Unfixed)
    }
}

impl std::fmt::Display for Flag {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

/// A position at a requested time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interpolated {
    /// The time (s after the trajectory's origin).
    pub time_s: f64,
    /// East, north, up (m). Only as good as [`flag`](Self::flag) says.
    pub position_m: Vector3,
    /// Velocity (m/s): the slope of the curve; zero outside the trajectory.
    pub velocity_m_s: Vector3,
    /// Covariance (m²), blended linearly from the fixes on both sides: the covariance of errors that change
    /// slowly from fix to fix, as those of carrier-phase positions do.
    pub covariance_m2: Option<Matrix3>,
    /// Attitude between the attitudes of the fixes on both sides.
    pub attitude: Option<Attitude>,
    /// Attitude of the gimbal that carries the antenna, likewise.
    pub gimbal: Option<Attitude>,
    /// The worse status of the fixes on both sides.
    pub status: SolutionStatus,
    /// Relation of the output to the fixes about it.
    pub flag: Flag,
}

/// Neighbouring outputs with the same flag.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// Flag.
    pub flag: Flag,
    /// Index of the first.
    pub first: usize,
    /// Index of the last.
    pub last: usize,
    /// Time of the first (s).
    pub start_s: f64,
    /// Time of the last (s).
    pub end_s: f64,
}

/// How a whole series of outputs is covered.
#[derive(Debug, Clone, PartialEq)]
pub struct Coverage {
    /// All outputs, split into runs of one flag.
    pub spans: Vec<Span>,
    /// Longest time between fixes that was not taken as a gap (s).
    pub max_gap_s: f64,
}

impl Coverage {
    /// Outputs with a flag.
    #[must_use]
    pub fn count(&self, flag: Flag) -> usize {
        self.spans
            .iter()
            .filter(|s| s.flag == flag)
            .map(|s| s.last - s.first + 1)
            .sum()
    }

    /// Runs of outputs that are not [`Flag::Ok`].
    pub fn troubles(&self) -> impl Iterator<Item = &Span> {
        self.spans.iter().filter(|s| s.flag != Flag::Ok)
    }
}

/// `308 ok; 3 in-gap 12.10–12.16 s`.
impl std::fmt::Display for Coverage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ok", self.count(Flag::Ok))?;
        for s in self.troubles() {
            let n = s.last - s.first + 1;
            write!(f, "; {n} {} {:.2}–{:.2} s", s.flag, s.start_s, s.end_s)?;
        }
        Ok(())
    }
}

/// The default longest time between fixes (s) that is not a gap: two and a half sample intervals, so that one
/// lost epoch is bridged and two are not; and at least 50 ms, over which a drone's 5 m/s² moves it only 1.6
/// mm off a straight line.
#[must_use]
pub fn default_max_gap_s(trajectory: &Trajectory) -> f64 {
    trajectory
        .sample_interval_s()
        .map_or(0.05, |interval| (2.5 * interval).max(0.05))
}

/// Positions of a trajectory at any time.
///
/// ```
/// use acerra_geo::interpolate::{Flag, InterpolationOptions, Interpolator};
/// use acerra_geo::trajectory::{Fix, Frame, TimeOrigin, Trajectory};
///
/// let times = [0.0, 1.0, 2.0, 3.0, 9.0, 10.0];
/// let fixes = times.map(|t| Fix::new(t, [2.0 * t, 0.0, 10.0])).to_vec();
/// let flight = Trajectory::new(Frame::Local, TimeOrigin::Relative, fixes)?;
/// let at = Interpolator::new(&flight, &InterpolationOptions::default());
///
/// let p = at.at(1.25);
/// assert_eq!((p.flag, p.position_m[0]), (Flag::Ok, 2.5));
/// assert_eq!(at.at(5.0).flag, Flag::InGap);
/// assert_eq!(at.at(10.5).flag, Flag::AfterEnd);
/// # Ok::<(), acerra_geo::trajectory::TrajectoryError>(())
/// ```
#[derive(Debug)]
pub struct Interpolator<'a> {
    fixes: &'a [Fix],
    max_gap_s: f64,
    /// The spline of each stretch of three fixes or more, with the index of its first.
    splines: Vec<(usize, Spline)>,
}

impl<'a> Interpolator<'a> {
    /// Prepares the curves.
    #[must_use]
    pub fn new(trajectory: &'a Trajectory, options: &InterpolationOptions) -> Self {
        let fixes = trajectory.fixes();
        let max_gap_s = options
            .max_gap_s
            .filter(|gap| *gap >= 0.0)
            .unwrap_or_else(|| default_max_gap_s(trajectory));
        let mut splines = Vec::new();
        if options.method == Method::Smooth {
            let longest_s = trajectory
                .sample_interval_s()
                .map_or(max_gap_s, |interval| {
                    max_gap_s.min(INTERVALS_BRIDGED * interval)
                });
            let joined = |a: &Fix, b: &Fix| {
                b.time_s - a.time_s <= longest_s && a.status.is_fixed() == b.status.is_fixed()
            };
            let mut start = 0;
            for stretch in fixes.chunk_by(joined) {
                if stretch.len() >= 3 {
                    splines.push((start, Spline::through(stretch)));
                }
                start += stretch.len();
            }
        }
        Self {
            fixes,
            max_gap_s,
            splines,
        }
    }

    /// Longest time between fixes that is not taken as a gap (s).
    #[must_use]
    pub const fn max_gap_s(&self) -> f64 {
        self.max_gap_s
    }

    /// The position at a time (s after the trajectory's origin).
    #[must_use]
    pub fn at(&self, time_s: f64) -> Interpolated {
        let end = self.fixes.len() - 1;
        let after = self.fixes.partition_point(|fix| fix.time_s <= time_s);
        let held = |fix: &Fix, flag| Interpolated {
            time_s,
            position_m: fix.position_m,
            velocity_m_s: [0.0; 3],
            covariance_m2: fix.covariance_m2,
            attitude: fix.attitude,
            gimbal: fix.gimbal,
            status: fix.status,
            flag,
        };
        let Some(i) = after.checked_sub(1) else {
            return held(&self.fixes[0], Flag::BeforeStart);
        };
        let a = &self.fixes[i];
        if time_s > a.time_s && i == end {
            return held(a, Flag::AfterEnd);
        }
        if time_s == a.time_s {
            // On a fix: the fix's own quality, whatever its neighbours are.
            let flag = if a.status.is_fixed() {
                Flag::Ok
            } else {
                Flag::Unfixed
            };
            let velocity_m_s = if end == 0 {
                [0.0; 3]
            } else if i == end {
                self.curve(i - 1, time_s).1
            } else {
                self.curve(i, time_s).1
            };
            return Interpolated {
                velocity_m_s,
                ..held(a, flag)
            };
        }
        let b = &self.fixes[i + 1];
        let (position_m, velocity_m_s) = self.curve(i, time_s);
        let share = (time_s - a.time_s) / (b.time_s - a.time_s);
        let flag = if b.time_s - a.time_s > self.max_gap_s {
            Flag::InGap
        } else if a.status.is_fixed() && b.status.is_fixed() {
            Flag::Ok
        } else {
            Flag::Unfixed
        };
        Interpolated {
            time_s,
            position_m,
            velocity_m_s,
            covariance_m2: blend(a.covariance_m2, b.covariance_m2, share),
            attitude: between(a.attitude, b.attitude, share),
            gimbal: between(a.gimbal, b.gimbal, share),
            status: a.status.worse(b.status),
            flag,
        }
    }

    /// Positions at many times, and how they are covered.
    #[must_use]
    pub fn at_all(&self, times_s: &[f64]) -> (Vec<Interpolated>, Coverage) {
        let positions: Vec<Interpolated> = times_s.iter().map(|&t| self.at(t)).collect();
        let mut spans: Vec<Span> = Vec::new();
        for (i, p) in positions.iter().enumerate() {
            match spans.last_mut() {
                Some(span) if span.flag == p.flag => {
                    span.last = i;
                    span.end_s = p.time_s;
                }
                _ => spans.push(Span {
                    flag: p.flag,
                    first: i,
                    last: i,
                    start_s: p.time_s,
                    end_s: p.time_s,
                }),
            }
        }
        (
            positions,
            Coverage {
                spans,
                max_gap_s: self.max_gap_s,
            },
        )
    }

    /// Position and velocity in the interval after fix `i`.
    fn curve(&self, i: usize, time_s: f64) -> (Vector3, Vector3) {
        let before = self.splines.partition_point(|(start, _)| *start <= i);
        if let Some((start, spline)) = before.checked_sub(1).map(|s| &self.splines[s])
            && i - start + 1 < spline.len()
        {
            return spline.at(i - start, &self.fixes[i], &self.fixes[i + 1], time_s);
        }
        let (a, b) = (&self.fixes[i], &self.fixes[i + 1]);
        let step_s = b.time_s - a.time_s;
        let velocity = scale(1.0 / step_s, subtract(b.position_m, a.position_m));
        let share = (time_s - a.time_s) / step_s;
        let position =
            [0, 1, 2].map(|k| a.position_m[k] + share * (b.position_m[k] - a.position_m[k]));
        (position, velocity)
    }
}

fn between(a: Option<Attitude>, b: Option<Attitude>, share: f64) -> Option<Attitude> {
    Some(a?.towards(&b?, share))
}

fn blend(a: Option<Matrix3>, b: Option<Matrix3>, share: f64) -> Option<Matrix3> {
    let (a, b) = (a?, b?);
    Some([0, 1, 2].map(|i| [0, 1, 2].map(|j| (1.0 - share) * a[i][j] + share * b[i][j])))
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

    fn sway(t: f64) -> Vector3 {
        [
            1.5 * t,
            0.4 * (TAU * t / 4.0).sin(),
            10.0 + 0.1 * (TAU * t / 6.0).cos(),
        ]
    }

    fn worst(rate_hz: f64, method: Method) -> f64 {
        let fixes = (0..=(30.0 * rate_hz) as usize).map(|i| {
            let t = i as f64 / rate_hz;
            Fix::new(t, sway(t))
        });
        let track = track(fixes.collect());
        let options = InterpolationOptions {
            method,
            max_gap_s: None,
        };
        let at = Interpolator::new(&track, &options);
        (0..=2_991)
            .map(|i| 0.01 * f64::from(i))
            .fold(0.0, |worst: f64, t| {
                let p = at.at(t);
                assert_eq!(p.flag, Flag::Ok);
                worst.max(distance(p.position_m, sway(t)))
            })
    }

    #[test]
    fn the_spline_is_as_good_as_the_module_says() {
        for (rate_hz, linear_m, smooth_m) in [(2.0, 28.4e-3, 3.11e-3), (5.0, 4.9e-3, 0.036e-3)] {
            let (linear, smooth) = (
                worst(rate_hz, Method::Linear),
                worst(rate_hz, Method::Smooth),
            );
            assert!((linear / linear_m - 1.0).abs() < 0.02, "{linear}");
            assert!((smooth / smooth_m - 1.0).abs() < 0.05, "{smooth}");
        }
        // Fourth order: half the interval, a sixteenth of the error.
        let order = (worst(5.0, Method::Smooth) / worst(10.0, Method::Smooth)).log2();
        assert!((3.7..5.1).contains(&order), "{order}");
    }

    #[test]
    fn velocity_is_the_slope() {
        let fixes = (0..=100).map(|i| Fix::new(0.1 * f64::from(i), sway(0.1 * f64::from(i))));
        let track = track(fixes.collect());
        for method in [Method::Smooth, Method::Linear] {
            let at = Interpolator::new(
                &track,
                &InterpolationOptions {
                    method,
                    max_gap_s: None,
                },
            );
            for t in [0.05, 1.237, 5.0 + 1e-3, 9.97] {
                let slope = scale(
                    1.0 / 2e-6,
                    subtract(at.at(t + 1e-6).position_m, at.at(t - 1e-6).position_m),
                );
                assert!(distance(at.at(t).velocity_m_s, slope) < 1e-6);
            }
        }
        let at = Interpolator::new(&track, &InterpolationOptions::default());
        // On a fix, and at the very last, there is a slope too.
        assert!((at.at(5.0).velocity_m_s[0] - 1.5).abs() < 1e-9);
        assert!((at.at(10.0).velocity_m_s[0] - 1.5).abs() < 1e-9);
    }

    #[test]
    fn a_jump_at_float_epochs_stays_there() {
        let make = |jump: f64| {
            let fixes = (0..60).map(|i| {
                let t = 0.2 * f64::from(i);
                let mut fix = Fix::new(t, sway(t));
                fix.status = SolutionStatus::Fixed;
                if (30..35).contains(&i) {
                    fix.status = SolutionStatus::Float;
                    fix.position_m[1] += jump;
                }
                fix
            });
            track(fixes.collect())
        };
        let (clean, jumped) = (make(0.0), make(1.0));
        let options = InterpolationOptions::default();
        let a = Interpolator::new(&clean, &options);
        let b = Interpolator::new(&jumped, &options);
        for i in 0..1_180 {
            let t = 0.01 * f64::from(i);
            let unfixed = t > 5.8 + 1e-9 && t < 7.0 - 1e-9;
            let (a, b) = (a.at(t), b.at(t));
            assert_eq!(b.flag == Flag::Unfixed, unfixed, "{t}");
            if !unfixed {
                assert_eq!(a.position_m, b.position_m, "{t}");
            }
            assert_eq!(b.status == SolutionStatus::Float, unfixed);
        }
    }

    #[test]
    fn gaps_and_ends_are_flagged_and_reported() {
        let times = [0.0, 0.1, 0.2, 0.3, 0.5, 0.6, 1.0, 1.1, 1.2];
        let track = track(times.iter().map(|&t| Fix::new(t, [t, 0.0, 0.0])).collect());
        let at = Interpolator::new(&track, &InterpolationOptions::default());
        assert!((at.max_gap_s() - 0.25).abs() < 1e-12);
        let asked: Vec<f64> = (-1..=14).map(|i| 0.1 * f64::from(i) + 0.05).collect();
        let (positions, coverage) = at.at_all(&asked);
        let flags: Vec<Flag> = coverage.spans.iter().map(|s| s.flag).collect();
        assert_eq!(
            flags,
            [
                Flag::BeforeStart,
                Flag::Ok,
                Flag::InGap,
                Flag::Ok,
                Flag::AfterEnd
            ]
        );
        assert_eq!(
            (coverage.count(Flag::InGap), coverage.count(Flag::AfterEnd)),
            (4, 3)
        );
        assert_eq!(
            coverage
                .spans
                .iter()
                .map(|s| s.last - s.first + 1)
                .sum::<usize>(),
            asked.len()
        );
        assert!((positions[8].position_m[0] - 0.75).abs() < 1e-12);
        assert_eq!(at.at(f64::NAN).flag, Flag::BeforeStart);
        assert!(
            coverage.to_string().starts_with("8 ok; 1 before-start"),
            "{coverage}"
        );
        let strict = InterpolationOptions {
            max_gap_s: Some(0.15),
            ..Default::default()
        };
        assert_eq!(Interpolator::new(&track, &strict).at(0.4).flag, Flag::InGap);
    }

    #[test]
    fn a_single_fix_is_known_at_its_own_time_only() {
        let track = track(vec![Fix::new(5.0, [1.0, 2.0, 3.0])]);
        let at = Interpolator::new(&track, &InterpolationOptions::default());
        assert_eq!(at.at(5.0).flag, Flag::Ok);
        assert_eq!(
            (at.at(4.9).flag, at.at(5.1).flag),
            (Flag::BeforeStart, Flag::AfterEnd)
        );
        assert_eq!(at.at(5.0).velocity_m_s, [0.0; 3]);
    }

    #[test]
    fn covariance_and_attitude_lie_between() {
        let mut fixes = vec![Fix::new(0.0, [0.0; 3]), Fix::new(1.0, [1.0, 0.0, 0.0])];
        fixes[0].covariance_m2 = Some([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        fixes[1].covariance_m2 = Some([[3.0, 1.0, 0.0], [1.0, 3.0, 0.0], [0.0, 0.0, 3.0]]);
        fixes[0].attitude = Some(Attitude::from_heading(0.0));
        fixes[1].attitude = Some(Attitude::from_heading(1.0));
        let track = track(fixes);
        let p = Interpolator::new(&track, &InterpolationOptions::default()).at(0.5);
        assert_eq!(p.covariance_m2.expect("known")[0], [2.0, 0.5, 0.0]);
        let forward = p.attitude.expect("known").rotate([1.0, 0.0, 0.0]);
        assert!(distance(forward, [0.5f64.sin(), 0.5f64.cos(), 0.0]) < 1e-12);
    }
}
