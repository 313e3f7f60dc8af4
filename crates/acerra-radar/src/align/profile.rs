//! Height and speed over the trajectory's time, evenly sampled.

use super::AlignError;
use crate::constants::two_way_delay_s;

/// Largest number of samples of a profile.
const LONGEST: f64 = 4e6;
/// Ratio of the largest followed rate of an echo to its rate.
pub(super) const REACH: f64 = 2.0;
/// Share of the platform's fast speed below which it is at rest.
pub(super) const AT_REST: f64 = 0.1;
/// Least duration of a start or halt, s.
const LASTING_S: f64 = 0.5;

/// Height and speed of the trajectory at one instant.
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
    lasting_error_m: f64,
    stated_error_m: f64,
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
            lasting_error_m: 0.0,
            stated_error_m: 0.0,
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

    /// This profile with height errors of a standard deviation (m) that last as long as changes of the
    /// height, for positions without fixed ambiguities: such errors do not appear in the scatter about the
    /// echoes.
    #[must_use]
    pub fn with_lasting_error_m(mut self, lasting_error_m: f64) -> Self {
        self.lasting_error_m = lasting_error_m.max(0.0);
        self
    }

    /// This profile with stated height errors of a standard deviation (m), which may last as long as a climb.
    /// The error is reported with the offset
    /// ([`HeightCue::stated_sigma_s`](super::HeightCue::stated_sigma_s)) without an effect on its likelihood.
    #[must_use]
    pub fn with_stated_error_m(mut self, stated_error_m: f64) -> Self {
        self.stated_error_m = stated_error_m.max(0.0);
        self
    }

    /// Stated error of the heights, as a delay, s.
    pub(super) fn stated_error_s(&self) -> f64 {
        two_way_delay_s(self.stated_error_m)
    }

    /// Error of the heights that lasts as long as their changes, as a delay, s.
    pub(super) fn lasting_error_s(&self) -> f64 {
        two_way_delay_s(self.lasting_error_m)
    }

    /// This profile with heights smoothed by local parabolas over `half_window_s` to each side (less next to
    /// gaps and at the ends). Noise of the positions that changes from fix to fix is reduced; motion whose
    /// acceleration changes evenly over the window is unchanged, without a shift in time.
    ///
    /// Smoothing matters because noise of the heights fits noise of the echoes best at some offset by chance:
    /// the resulting error of the offset is the ratio of the noise's rate to the flight's rate.
    ///
    /// ```
    /// use acerra_radar::align::{FlightProfile, FlightState};
    /// use acerra_radar::two_way_delay_s;
    ///
    /// let climb = |t: f64| 5.0 + 0.3 * t + 0.1 * t * t;
    /// let state = |t| Some(FlightState { height_m: climb(t), speed_m_s: 1.0 });
    /// let profile = FlightProfile::sample([0.0, 10.0], state)?.smoothed(0.7);
    /// assert!((profile.echo_delay_s(4.0) - two_way_delay_s(climb(4.0))).abs() < 1e-14);
    /// # Ok::<(), acerra_radar::align::AlignError>(())
    /// ```
    #[must_use]
    pub fn smoothed(mut self, half_window_s: f64) -> Self {
        let widest = (half_window_s.clamp(0.0, LONGEST_WINDOW_S) / self.step_s).round() as usize;
        let weights: Vec<Vec<f64>> = (0..=widest).map(parabola_weights).collect();
        let known = |d: &f64| d.is_finite();
        let last = self.echo_delay_s.len() - 1;
        let smooth = |i: usize| {
            let most = widest.min(i).min(last - i);
            let near = (1..=most).take_while(|k| {
                let ends = [i - k, i + k].map(|j| self.echo_delay_s[j]);
                ends.iter().all(known)
            });
            let half = near.count();
            let window = &self.echo_delay_s[i - half..=i + half];
            let terms = window.iter().zip(&weights[half]);
            terms.map(|(d, w)| d * w).sum::<f64>()
        };
        self.echo_delay_s = (0..=last).map(smooth).collect();
        self
    }

    /// Number of starts and halts of the platform between the first and the last of some times (s, rising),
    /// for half a second or more. Times without a position are skipped.
    #[must_use]
    pub fn starts_and_halts(&self, time_s: impl IntoIterator<Item = f64>) -> usize {
        let Some(fast_m_s) = self.fast_speed_m_s() else {
            return 0;
        };
        let (mut count, mut state, mut since_s) = (0, None, 0.0);
        for t in time_s {
            let speed_m_s = self.speed_at(t);
            if !speed_m_s.is_finite() {
                continue;
            }
            let moving = speed_m_s > AT_REST * fast_m_s;
            match state {
                Some(before) if before == moving => since_s = t,
                Some(_) if t - since_s < LASTING_S => {}
                before => {
                    count += usize::from(before.is_some());
                    state = Some(moving);
                    since_s = t;
                }
            }
        }
        count
    }

    /// The speed that is exceeded in one twentieth of the time, m/s; `None` where no speed is known.
    pub(super) fn fast_speed_m_s(&self) -> Option<f64> {
        let mut known: Vec<f64> = self.speed_m_s.clone();
        known.retain(|v| v.is_finite());
        known.sort_by(f64::total_cmp);
        known.get(known.len() * 19 / 20).copied()
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

    /// Rate of change of 2h/c at which echoes are followed, s/s: the rate exceeded in one twentieth of the
    /// time. For a platform at rest most of the time, whose climbs are [beyond reach](REACH) of this rate,
    /// the rate exceeded in one twentieth of the height flown up and down.
    pub(super) fn fast_echo_rate(&self) -> f64 {
        let mut rates: Vec<f64> = self
            .echo_delay_s
            .windows(2)
            .map(|w| (w[1] - w[0]).abs() / self.step_s)
            .filter(|r| r.is_finite())
            .collect();
        rates.sort_by(f64::total_cmp);
        let usual = rates.get(rates.len() * 19 / 20).copied().unwrap_or(0.0);
        let most = 0.95 * rates.iter().sum::<f64>();
        let mut slower = 0.0;
        let climbing = rates.iter().find(|rate| {
            slower += **rate;
            slower >= most
        });
        let climbing = climbing.copied().unwrap_or(0.0);
        if climbing > REACH * usual {
            climbing
        } else {
            usual
        }
    }
}

/// Spacing of samples, s: an acceleration of 5 m/s² bends a path by 0.25 mm within a spacing.
pub(super) const STEP_S: f64 = 0.02;

/// Longest half window for smoothing heights, s.
const LONGEST_WINDOW_S: f64 = 5.0;

/// Weights of 2m + 1 even samples that give the value in the middle of their least-squares parabola (Savitzky
/// and Golay 1964); for three samples and for one, only the middle one has weight.
fn parabola_weights(m: usize) -> Vec<f64> {
    let half = m as f64;
    let over = (2.0 * half - 1.0) * (2.0 * half + 1.0) * (2.0 * half + 3.0);
    let weight = |k: usize| {
        let x = k as f64 - half;
        (3.0 * (3.0 * half * half + 3.0 * half - 1.0) - 15.0 * x * x) / over
    };
    (0..=2 * m).map(weight).collect()
}

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

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test that cannot go on has failed
mod tests {
    use super::*;

    fn profile(height_m: impl Fn(f64) -> Option<f64>) -> FlightProfile {
        let state = |height_m| FlightState {
            height_m,
            speed_m_s: 1.0,
        };
        FlightProfile::sample([0.0, 20.0], |t| height_m(t).map(state)).unwrap()
    }

    #[test]
    fn smoothing_keeps_cubic_climbs_and_takes_noise_away() {
        let climb = |t: f64| 5.0 + 0.4 * t + 0.05 * t * t - 0.004 * t * t * t;
        let smooth = profile(|t| Some(climb(t))).smoothed(0.7);
        for t in [0.0, 0.02, 0.5, 7.0, 19.98] {
            let off_s = smooth.echo_delay_s(t) - two_way_delay_s(climb(t));
            assert!(off_s.abs() < 1e-13, "{t}: {off_s}");
        }
        // Each sample has an independent error of a metre's delay.
        let noise = |t: f64| 5.0 + f64::from((t * 50.0).round() as i32 % 2);
        let smooth = profile(|t| Some(noise(t))).smoothed(0.7);
        let off_s = smooth.echo_delay_s(10.0) - two_way_delay_s(5.5);
        assert!(off_s.abs() < 0.05 * two_way_delay_s(1.0), "{off_s}");
    }

    #[test]
    fn the_rate_is_that_of_the_climb_however_long_the_platform_stands() {
        // Half a second at 1 m/s in twenty.
        let climb = |seconds: f64| move |t: f64| Some(0.2 + (t - 9.0).clamp(0.0, seconds));
        for seconds in [0.5, 5.0] {
            let rate = profile(climb(seconds)).fast_echo_rate();
            assert!((rate / two_way_delay_s(1.0) - 1.0).abs() < 0.01, "{rate}");
        }
        // A wander whose fastest tenth is within reach of the rest.
        let wander = |t: f64| Some(4.0 + if t < 19.5 { 0.6 * t } else { 11.7 + (t - 19.5) });
        let rate = profile(wander).fast_echo_rate();
        assert!((rate / two_way_delay_s(0.6) - 1.0).abs() < 0.01, "{rate}");
        assert!(profile(|_| Some(4.0)).fast_echo_rate().abs() < 1e-20);
    }

    #[test]
    fn gaps_stay_gaps_and_bend_nothing_beside_them() {
        let climb = |t: f64| (!(8.0..9.0).contains(&t)).then_some(4.0 + 0.2 * t * t);
        let smooth = profile(climb).smoothed(0.7);
        assert!(smooth.echo_delay_s(8.5).is_nan());
        let off_s = smooth.echo_delay_s(7.9) - two_way_delay_s(4.0 + 0.2 * 7.9 * 7.9);
        assert!(off_s.abs() < 1e-13, "{off_s}");
    }

    #[test]
    fn starts_and_halts_are_counted_where_they_last() {
        let speed = |t: f64| match t {
            t if (3.0..8.0).contains(&t) || (12.0..19.0).contains(&t) => 1.5,
            // A stumble.
            t if (10.0..10.2).contains(&t) => 1.5,
            _ => 0.0,
        };
        let state = |t: f64| FlightState {
            height_m: 5.0,
            speed_m_s: speed(t),
        };
        let profile = FlightProfile::sample([0.0, 20.0], |t| Some(state(t))).unwrap();
        let times = |from: i32, to: i32| (from..to).map(|k| 0.1 * f64::from(k));
        assert_eq!(profile.starts_and_halts(times(0, 200)), 4);
        assert_eq!(profile.starts_and_halts(times(40, 110)), 1);
        assert_eq!(profile.starts_and_halts(times(130, 180)), 0);
    }
}
