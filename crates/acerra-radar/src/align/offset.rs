//! Correlation of two curves over the offset of their clocks.

use super::AlignError;

/// Offsets tried by [`coarse_offset`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct OffsetSearch {
    /// Smallest and largest offset, s; `None` tries all at which the two overlap enough.
    pub range_s: Option<[f64; 2]>,
    /// Step, s.
    pub step_s: f64,
    /// Share of the traces that must fall within the speed's time span.
    pub overlap: f64,
}

impl Default for OffsetSearch {
    fn default() -> Self {
        Self {
            range_s: None,
            step_s: 0.01,
            overlap: 0.5,
        }
    }
}

impl OffsetSearch {
    /// These parameters within a range of offsets, s.
    #[must_use]
    pub const fn within(mut self, range_s: [f64; 2]) -> Self {
        self.range_s = Some(range_s);
        self
    }

    /// These parameters with another step, s.
    #[must_use]
    pub const fn with_step_s(mut self, step_s: f64) -> Self {
        self.step_s = step_s;
        self
    }
}

/// The best offset with its evidence.
#[derive(Debug, Clone, PartialEq)]
pub struct CoarseOffset {
    /// Trajectory time − radar time, s, at the highest correlation (between steps, by a parabola).
    pub offset_s: f64,
    /// Correlation coefficient at this offset.
    pub correlation: f64,
    /// Largest correlation of another peak: one outside the main peak's own flanks. −1 if none.
    pub runner_up: f64,
    /// Confidence in the offset, 0 to 1: correlation above the runner-up, as a share of the possible margin.
    pub confidence: f64,
    /// Offsets about the best one within which the correlation stays within 1 % of its maximum, s.
    pub interval_s: [f64; 2],
    /// Every offset tried and its correlation.
    pub curve: Vec<(f64, f64)>,
}

/// Correlates `activity` over `radar_time_s` (see [`activity`](super::activity)) with the
/// platform's speed over `trajectory_time_s`, for every offset.
///
/// The offset is trajectory time − radar time, the campaign file's `time_offset_s`. Speeds that
/// are NaN are left out.
///
/// # Errors
/// If a curve is too short, constant or not in order of time, or the two never overlap.
///
/// ```
/// use acerra_radar::align::{OffsetSearch, coarse_offset};
/// let step = |t: f64| if (3.0..8.0).contains(&t) { 1.0 } else { 0.0 };
/// let radar_s: Vec<f64> = (0..400).map(|i| f64::from(i) * 0.03).collect();
/// let activity: Vec<f64> = radar_s.iter().map(|&t| step(t)).collect();
/// let trajectory_s: Vec<f64> = (0..900).map(|i| 90.0 + f64::from(i) * 0.05).collect();
/// let speed: Vec<f64> = trajectory_s.iter().map(|&t| step(t - 103.2)).collect();
/// let found = coarse_offset(&radar_s, &activity, &trajectory_s, &speed, &OffsetSearch::default())?;
/// assert!((found.offset_s - 103.2).abs() < 0.05);
/// # Ok::<(), acerra_radar::align::AlignError>(())
/// ```
pub fn coarse_offset(
    radar_time_s: &[f64],
    activity: &[f64],
    trajectory_time_s: &[f64],
    speed_m_s: &[f64],
    search: &OffsetSearch,
) -> Result<CoarseOffset, AlignError> {
    check("radar activity", radar_time_s, activity)?;
    check("speed", trajectory_time_s, speed_m_s)?;
    let (radar_first, radar_last) = ends(radar_time_s);
    let (track_first, track_last) = ends(trajectory_time_s);
    let [from_s, to_s] = search
        .range_s
        .unwrap_or([track_first - radar_last, track_last - radar_first]);
    let steps = (to_s - from_s) / search.step_s;
    if !(search.step_s > 0.0 && (0.0..=1e7).contains(&steps)) {
        return Err(AlignError::Step {
            step_s: search.step_s,
            range_s: to_s - from_s,
        });
    }
    let needed = ((search.overlap * radar_time_s.len() as f64).ceil() as usize).max(3);
    let curve: Vec<(f64, f64)> = (0..=steps.round() as usize)
        .map(|k| from_s + k as f64 * search.step_s)
        .filter_map(|offset| {
            let pairs = pairs_at(radar_time_s, activity, trajectory_time_s, speed_m_s, offset);
            let r = (pairs.len() >= needed).then(|| correlation(&pairs))?;
            Some((offset, r))
        })
        .collect();
    if curve.is_empty() {
        return Err(AlignError::NoOverlap {
            from_s,
            to_s,
            percent: 100.0 * search.overlap,
        });
    }
    Ok(best(curve, search.step_s))
}

fn check(what: &'static str, times: &[f64], values: &[f64]) -> Result<(), AlignError> {
    if times.len() != values.len() || times.len() < 3 {
        return Err(AlignError::Length {
            what,
            times: times.len(),
            values: values.len(),
        });
    }
    if let Some(i) = times
        .windows(2)
        .position(|w| w[1] <= w[0] || w[1].is_nan() || w[0].is_nan())
    {
        return Err(AlignError::Order { what, index: i + 1 });
    }
    let mut known = values.iter().copied().filter(|v| v.is_finite());
    let first = known.next();
    if known.all(|v| Some(v) == first) {
        return Err(AlignError::Constant { what });
    }
    Ok(())
}

fn ends(times: &[f64]) -> (f64, f64) {
    (times[0], times[times.len() - 1])
}

/// (activity, speed) of every trace whose time falls within the trajectory.
fn pairs_at(
    radar_time_s: &[f64],
    activity: &[f64],
    trajectory_time_s: &[f64],
    speed_m_s: &[f64],
    offset_s: f64,
) -> Vec<(f64, f64)> {
    let mut pairs = Vec::with_capacity(radar_time_s.len());
    let mut k = 0;
    for (&t, &a) in radar_time_s.iter().zip(activity) {
        let t = t + offset_s;
        while k + 2 < trajectory_time_s.len() && trajectory_time_s[k + 1] < t {
            k += 1;
        }
        let (t0, t1) = (trajectory_time_s[k], trajectory_time_s[k + 1]);
        if !(t0..=t1).contains(&t) {
            continue;
        }
        let v = speed_m_s[k] + (t - t0) / (t1 - t0) * (speed_m_s[k + 1] - speed_m_s[k]);
        if v.is_finite() && a.is_finite() {
            pairs.push((a, v));
        }
    }
    pairs
}

/// Pearson's correlation coefficient; 0 where one side is constant.
fn correlation(pairs: &[(f64, f64)]) -> f64 {
    let n = pairs.len() as f64;
    let (sa, sv) = pairs
        .iter()
        .fold((0.0, 0.0), |(a, v), p| (a + p.0, v + p.1));
    let (ma, mv) = (sa / n, sv / n);
    let (mut aa, mut vv, mut av) = (0.0, 0.0, 0.0);
    for &(a, v) in pairs {
        aa += (a - ma).powi(2);
        vv += (v - mv).powi(2);
        av += (a - ma) * (v - mv);
    }
    // At this offset only an interval without motion may overlap.
    if aa <= 0.0 || vv <= 0.0 {
        0.0
    } else {
        av / (aa * vv).sqrt()
    }
}

fn best(curve: Vec<(f64, f64)>, step_s: f64) -> CoarseOffset {
    let peak = (0..curve.len())
        .max_by(|&a, &b| curve[a].1.total_cmp(&curve[b].1))
        .unwrap_or(0);
    let correlation = curve[peak].1;
    let mut offset_s = curve[peak].0;
    if peak > 0 && peak + 1 < curve.len() {
        let (before, after) = (curve[peak - 1].1, curve[peak + 1].1);
        let curvature = before - 2.0 * correlation + after;
        if curvature < 0.0 {
            offset_s += step_s * (0.5 * (before - after) / curvature).clamp(-0.5, 0.5);
        }
    }
    // The main peak's flanks reach down to the first minimum on each side below half its height.
    let flank = |indices: &mut dyn Iterator<Item = usize>| {
        let mut low = correlation;
        for i in indices {
            let r = curve[i].1;
            if low < 0.5 * correlation && r > low + 0.05 {
                return Some(i);
            }
            low = low.min(r);
        }
        None
    };
    let left = flank(&mut (0..peak).rev());
    let right = flank(&mut (peak + 1..curve.len()));
    let outside = curve[..left.map_or(0, |i| i + 1)]
        .iter()
        .chain(&curve[right.unwrap_or(curve.len())..]);
    let runner_up = outside.map(|c| c.1).fold(-1.0, f64::max);
    let near = |r: f64| r >= correlation - 0.01 * correlation.abs();
    let first = (0..=peak)
        .rev()
        .take_while(|&i| near(curve[i].1))
        .last()
        .unwrap_or(peak);
    let last = (peak..curve.len())
        .take_while(|&i| near(curve[i].1))
        .last()
        .unwrap_or(peak);
    let floor = runner_up.max(0.0);
    let confidence = if correlation > floor {
        (correlation - floor) / (1.0 - floor)
    } else {
        0.0
    };
    CoarseOffset {
        offset_s,
        correlation,
        runner_up,
        confidence,
        interval_s: [curve[first].0, curve[last].0],
        curve,
    }
}
