//! Path covered and speed.

use super::{InterpolationOptions, Interpolator, Method};
use crate::matrix::{Vector3, distance};
use crate::trajectory::Trajectory;

/// The length of path (m) that each of a series of positions stands for: half the way from the
/// one before and half the way to the next.
///
/// This is the trapezoidal weight that turns a sum over unevenly spaced traces into an integral
/// along the track. The weights add up to the whole path.
///
/// ```
/// use acerra_geo::interpolate::path_length_per_trace_m;
/// let track = [0.0, 1.0, 1.0, 3.0].map(|x| [x, 0.0, 5.0]);
/// assert_eq!(path_length_per_trace_m(&track), [0.5, 0.5, 1.0, 1.0]);
/// ```
#[must_use]
pub fn path_length_per_trace_m(positions_m: &[Vector3]) -> Vec<f64> {
    let mut covered = vec![0.0; positions_m.len()];
    for (i, pair) in positions_m.windows(2).enumerate() {
        let half = 0.5 * distance(pair[0], pair[1]);
        covered[i] += half;
        covered[i + 1] += half;
    }
    covered
}

/// Speed over time, evenly sampled.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeedProfile {
    /// Time of the first value (s after the trajectory's origin).
    pub start_s: f64,
    /// Time between values (s).
    pub step_s: f64,
    /// Speeds (m/s).
    pub speed_m_s: Vec<f64>,
}

impl SpeedProfile {
    /// Time of value `i` (s).
    #[must_use]
    pub fn time_s(&self, i: usize) -> f64 {
        self.start_s + self.step_s * i as f64
    }

    /// Speed at a time, linear between values; none outside.
    #[must_use]
    pub fn at(&self, time_s: f64) -> Option<f64> {
        let x = (time_s - self.start_s) / self.step_s;
        let last = self.speed_m_s.len().checked_sub(1)?;
        if !(x >= 0.0 && x <= last as f64) {
            return None;
        }
        let i = (x as usize).min(last.saturating_sub(1));
        let next = self
            .speed_m_s
            .get(i + 1)
            .copied()
            .unwrap_or(self.speed_m_s[i]);
        let share = x - i as f64;
        Some((1.0 - share) * self.speed_m_s[i] + share * next)
    }
}

/// Speed from start to end of a trajectory, every `step_s`, each the distance between the places
/// half a `window_s` before and after, over that time: vibration and position noise average out,
/// and motion that starts and stops keeps its time.
///
/// At the ends the window is what there is of it. Gaps are crossed on a straight line: this is for
/// finding when the platform moved, not for imaging.
///
/// Empty when `step_s` or `window_s` is not positive, or the profile would have more than ten
/// million values.
#[must_use]
pub fn speed_profile(trajectory: &Trajectory, window_s: f64, step_s: f64) -> SpeedProfile {
    let (start_s, end_s) = (trajectory.start_s(), trajectory.end_s());
    let count = (end_s - start_s) / step_s;
    let mut profile = SpeedProfile {
        start_s,
        step_s,
        speed_m_s: Vec::new(),
    };
    if !(step_s > 0.0 && window_s > 0.0 && count < 1e7) {
        return profile;
    }
    let options = InterpolationOptions {
        method: Method::Linear,
        max_gap_s: None,
    };
    let place = Interpolator::new(trajectory, &options);
    profile.speed_m_s = (0..=count as usize)
        .map(|i| {
            let t = start_s + step_s * i as f64;
            let before = (t - 0.5 * window_s).max(start_s);
            let after = (t + 0.5 * window_s).min(end_s);
            let time = after - before;
            if time > 0.0 {
                distance(place.at(before).position_m, place.at(after).position_m) / time
            } else {
                0.0
            }
        })
        .collect();
    profile
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trajectory::{Fix, Frame, TimeOrigin};

    #[test]
    fn weights_add_up_to_the_path() {
        let track: Vec<Vector3> = (0..50)
            .map(|i| [f64::from(i * i) * 0.01, f64::from(i).sin(), 3.0])
            .collect();
        let path: f64 = track.windows(2).map(|w| distance(w[0], w[1])).sum();
        let weights = path_length_per_trace_m(&track);
        assert!((weights.iter().sum::<f64>() - path).abs() < 1e-12);
        assert_eq!(path_length_per_trace_m(&[]), [0.0; 0]);
        assert_eq!(path_length_per_trace_m(&[[1.0; 3]]), [0.0]);
    }

    /// Still, then 2 m/s from 5 s to 9 s, then still, under 5 mm of shaking.
    #[test]
    fn onset_and_stop_stand_where_they_are() {
        let fixes = (0..1_401).map(|i| {
            let t = 0.01 * f64::from(i);
            let shake = 0.005 * (if i % 2 == 0 { 1.0 } else { -1.0 });
            Fix::new(t, [2.0 * (t - 5.0).clamp(0.0, 4.0), shake, 4.0])
        });
        let track = Trajectory::new(Frame::Local, TimeOrigin::Relative, fixes.collect());
        let profile = speed_profile(&track.expect("a trajectory"), 0.5, 0.05);
        assert!(profile.at(2.0).expect("inside") < 0.05);
        assert!((profile.at(7.0).expect("inside") - 2.0).abs() < 0.01);
        for t in [5.0, 9.0] {
            assert!(
                (profile.at(t).expect("inside") - 1.0).abs() < 0.05,
                "half speed at {t}"
            );
        }
        assert_eq!((profile.at(-0.1), profile.at(14.1)), (None, None));
        assert_eq!(profile.time_s(20), 1.0);
    }
}
