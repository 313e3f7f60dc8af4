//! Choice of the radar's motion among several: the motion with which the radar's echoes change.

use acerra_geo::trajectory::Trajectory;
use acerra_radar::Radargram;
use acerra_radar::align::{OffsetSearch, activity, coarse_offset};

use crate::align::interpolator;

/// Spacing at which the speed is sampled (s), and half the interval over which it is averaged.
const STEP_S: f64 = 0.05;
const HALF_S: f64 = 0.1;
/// Longest trajectory that is sampled (s).
const LONGEST_S: f64 = 1e5;

/// Correlation of a motion with the change of the echoes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionMatch {
    /// Trajectory time minus radar time (s).
    pub offset_s: f64,
    /// Correlation of the change of the echoes with the speed there.
    pub correlation: f64,
}

/// Correlates the change of the echoes from trace to trace with the speed of the trajectory at every offset; none
/// where either never changes, or the two never overlap.
///
/// ```
/// use acerra_chain::look::match_motion;
/// use acerra_geo::trajectory::{Fix, Frame, TimeOrigin, Trajectory};
/// use acerra_radar::{Radargram, Samples};
///
/// // At rest until 4 s and from 8 s on: the traces differ in between.
/// let way = |t: f64| (t - 4.0).clamp(0.0, 4.0);
/// let traces: Vec<f32> = (0..120)
///     .flat_map(|k| (0..20).map(move |j| (40.0 * way(0.1 * f64::from(k)) + f64::from(j)).sin() as f32))
///     .collect();
/// let time_s = (0..120).map(|k| 0.1 * f64::from(k)).collect();
/// let radargram = Radargram::new(time_s, 0.0, 1e-10, Samples::Real(traces))?;
/// let fix = |k: u32| Fix::new(50.0 + 0.1 * f64::from(k), [way(0.1 * f64::from(k)), 0.0, 1.0]);
/// let trajectory = Trajectory::new(Frame::Local, TimeOrigin::Relative, (0..120).map(fix).collect())?;
/// let found = match_motion(&radargram, &trajectory).expect("both change");
/// assert!((found.offset_s - 50.0).abs() < 0.2 && found.correlation > 0.8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn match_motion(radargram: &Radargram, trajectory: &Trajectory) -> Option<MotionMatch> {
    let (start_s, end_s) = (trajectory.start_s(), trajectory.end_s());
    if end_s - start_s >= LONGEST_S || !(end_s - start_s).is_finite() {
        return None;
    }
    let at = interpolator(None, trajectory);
    let count = ((end_s - start_s) / STEP_S).ceil() as usize;
    let time_s: Vec<f64> = (0..=count).map(|k| start_s + k as f64 * STEP_S).collect();
    let speed_m_s: Vec<f64> = time_s
        .iter()
        .map(|t| {
            let [before, after] = [t - HALF_S, t + HALF_S].map(|t| at.at(t));
            if !(before.flag.is_covered() && after.flag.is_covered()) {
                return f64::NAN;
            }
            let square: f64 = (0..3)
                .map(|i| (after.position_m[i] - before.position_m[i]).powi(2))
                .sum();
            square.sqrt() / (2.0 * HALF_S)
        })
        .collect();
    // The change saturates with the speed: its root is closer to a measure of motion.
    let change: Vec<f64> = activity(radargram).iter().map(|a| a.sqrt()).collect();
    let found = coarse_offset(
        &radargram.time_s,
        &change,
        &time_s,
        &speed_m_s,
        &OffsetSearch::default(),
    )
    .ok()?;
    Some(MotionMatch {
        offset_s: found.offset_s,
        correlation: found.correlation,
    })
}
