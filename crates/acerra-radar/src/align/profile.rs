//! Height and speed over the trajectory's time, evenly sampled.

use super::AlignError;
use crate::constants::two_way_delay_s;

/// Most samples of a profile.
const LONGEST: f64 = 4e6;

/// What the trajectory says of one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlightState {
    /// Height of the radar's phase centre above the surface, m.
    pub height_m: f64,
    /// Speed over all three axes, m/s.
    pub speed_m_s: f64,
}

/// Height and speed over the trajectory, evenly sampled; NaN where the trajectory has a gap.
#[derive(Debug, Clone, PartialEq)]
pub struct FlightProfile {
    start_s: f64,
    step_s: f64,
    echo_delay_s: Vec<f64>,
    speed_m_s: Vec<f64>,
}

impl FlightProfile {
    /// Samples a trajectory from `from_s` to `to_s` every 20 ms (less often over more than a day);
    /// `at` answers `None` where there is no position.
    ///
    /// # Errors
    /// If the span is empty or not finite.
    pub fn sample(
        [from_s, to_s]: [f64; 2],
        at: impl Fn(f64) -> Option<FlightState>,
    ) -> Result<Self, AlignError> {
        let range_s = to_s - from_s;
        if !(range_s > 0.0 && range_s.is_finite()) {
            return Err(AlignError::Step {
                step_s: STEP_S,
                range_s,
            });
        }
        let step_s = STEP_S.max(range_s / LONGEST);
        let count = (range_s / step_s) as usize + 1;
        let (echo_delay_s, speed_m_s) = (0..count)
            .map(|k| match at(from_s + k as f64 * step_s) {
                Some(state) => (two_way_delay_s(state.height_m), state.speed_m_s),
                None => (f64::NAN, f64::NAN),
            })
            .unzip();
        Ok(Self {
            start_s: from_s,
            step_s,
            echo_delay_s,
            speed_m_s,
        })
    }

    /// Time of the first sample, s.
    #[must_use]
    pub fn start_s(&self) -> f64 {
        self.start_s
    }

    /// Time of the last sample, s.
    #[must_use]
    pub fn end_s(&self) -> f64 {
        self.start_s + (self.speed_m_s.len() - 1) as f64 * self.step_s
    }

    /// Times of all samples, s.
    #[must_use]
    pub fn times_s(&self) -> Vec<f64> {
        (0..self.speed_m_s.len())
            .map(|k| self.start_s + k as f64 * self.step_s)
            .collect()
    }

    /// Speeds, m/s; NaN where unknown.
    #[must_use]
    pub fn speed_m_s(&self) -> &[f64] {
        &self.speed_m_s
    }

    /// Two-way delay of the surface echo, 2h/c, at a time, s; NaN where unknown.
    #[must_use]
    pub fn echo_delay_s(&self, time_s: f64) -> f64 {
        interpolate(&self.echo_delay_s, (time_s - self.start_s) / self.step_s)
    }

    /// Speed at a time, m/s; NaN where unknown.
    #[must_use]
    pub fn speed_at(&self, time_s: f64) -> f64 {
        interpolate(&self.speed_m_s, (time_s - self.start_s) / self.step_s)
    }

    /// Smallest and largest 2h/c, s; `None` if no height is known.
    pub(super) fn echo_delay_range_s(&self) -> Option<[f64; 2]> {
        let known = || self.echo_delay_s.iter().copied().filter(|d| d.is_finite());
        let low = known().fold(f64::INFINITY, f64::min);
        let high = known().fold(f64::NEG_INFINITY, f64::max);
        (low <= high).then_some([low, high])
    }

    /// Rate of change of 2h/c that is exceeded in one twentieth of the time, s/s.
    pub(super) fn fast_echo_rate(&self) -> f64 {
        let mut rates: Vec<f64> = self
            .echo_delay_s
            .windows(2)
            .map(|w| (w[1] - w[0]).abs() / self.step_s)
            .filter(|r| r.is_finite())
            .collect();
        rates.sort_by(f64::total_cmp);
        rates.get(rates.len() * 19 / 20).copied().unwrap_or(0.0)
    }
}

/// Spacing of samples, s: an acceleration of 5 m/s² bends a path by 0.25 mm over it.
pub(super) const STEP_S: f64 = 0.02;

fn interpolate(values: &[f64], x: f64) -> f64 {
    let last = values.len() - 1;
    if !(x >= 0.0 && x <= last as f64) {
        return f64::NAN;
    }
    let i = x as usize;
    if i == last {
        return values[last];
    }
    values[i] + (x - i as f64) * (values[i + 1] - values[i])
}
