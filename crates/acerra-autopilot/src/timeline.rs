//! Samples of a source on one scale of time, in order.

use acerra_geo::time::GpsTime;
use acerra_geo::trajectory::{Attitude, SolutionStatus};

use crate::clock::ClockFit;
use crate::sample::{AttitudeSample, PositionSample, PositionSource, Recording, SourceKind, Stamp};

/// Attitudes further apart than this (s) are not interpolated.
const LONGEST_ATTITUDE_GAP_S: f64 = 0.5;

/// GPS time of a stamp; none for a stamp by the autopilot's clock where its relation to GPS time is unknown.
pub fn gps_time(stamp: Stamp, clock: Option<&ClockFit>) -> Option<GpsTime> {
    match stamp {
        Stamp::Gps(time) => Some(time),
        Stamp::Boot(boot_s) => clock.map(|clock| clock.gps_at(boot_s)),
    }
}

/// Attitudes on GPS time.
#[derive(Debug, Clone, Default)]
pub struct AttitudeTrack {
    samples: Vec<(GpsTime, Attitude)>,
}

impl AttitudeTrack {
    /// The samples in order of time; those without a time on the scale are left out.
    pub fn new(samples: &[AttitudeSample], clock: Option<&ClockFit>) -> Self {
        let timed = |s: &AttitudeSample| Some((gps_time(s.stamp, clock)?, s.attitude));
        let mut samples: Vec<(GpsTime, Attitude)> = samples.iter().filter_map(timed).collect();
        samples.sort_by_key(|(time, _)| *time);
        Self { samples }
    }

    /// The attitude at `time`, between the neighbours; none in a gap.
    pub fn at(&self, time: GpsTime) -> Option<Attitude> {
        let after = self.samples.partition_point(|(t, _)| *t <= time);
        let before = after.checked_sub(1).and_then(|k| self.samples.get(k));
        match (before, self.samples.get(after)) {
            (Some((t0, a0)), Some((t1, a1))) if *t1 - *t0 <= LONGEST_ATTITUDE_GAP_S => {
                Some(a0.towards(a1, (time - *t0) / (*t1 - *t0)))
            }
            (Some((t, a)), _) if time - *t <= 0.5 * LONGEST_ATTITUDE_GAP_S => Some(*a),
            (_, Some((t, a))) if *t - time <= 0.5 * LONGEST_ATTITUDE_GAP_S => Some(*a),
            _ => None,
        }
    }
}

/// Kinds of solution over time.
#[derive(Debug, Clone, Default)]
pub struct StatusTrack {
    is_filter: bool,
    receiver: Vec<(GpsTime, SolutionStatus)>,
}

impl StatusTrack {
    /// The statuses for the positions of `source`: its own, or for a filter those of the log's first
    /// receiver.
    pub fn of(recording: &Recording, source: &PositionSource, clock: Option<&ClockFit>) -> Self {
        let is_filter = source.kind == SourceKind::Filter;
        let receiver = recording
            .positions
            .iter()
            .find(|s| is_filter && s.kind == SourceKind::Gnss && !s.samples.is_empty());
        let timed = |s: &PositionSample| Some((gps_time(s.stamp, clock)?, s.status?));
        let samples = receiver.into_iter().flat_map(|s| &s.samples);
        let mut receiver: Vec<(GpsTime, SolutionStatus)> = samples.filter_map(timed).collect();
        receiver.sort_by_key(|(time, _)| *time);
        Self {
            is_filter,
            receiver,
        }
    }

    /// The status of a position. The status of a filter is never better than float: no test shows that its
    /// combination of fixed positions with barometer and accelerometers is accurate to centimetres.
    pub fn at(&self, time: GpsTime, sample: &PositionSample) -> SolutionStatus {
        if !self.is_filter {
            return sample.status.unwrap_or(SolutionStatus::Unknown);
        }
        let after = self.receiver.partition_point(|(t, _)| *t <= time);
        let near = after.checked_sub(1).or(Some(0));
        let status = near.and_then(|k| self.receiver.get(k)).map(|(_, s)| *s);
        status.map_or(SolutionStatus::Unknown, |s| s.worse(SolutionStatus::Float))
    }
}

/// Members of the longest strictly rising subsequence of `times`, in order.
///
/// One wild time costs itself and not all that follow it.
pub fn longest_rising(times: &[GpsTime]) -> Vec<usize> {
    // tails[k]: the time that ends a rising choice of k + 1 times as early as can be.
    let mut tails: Vec<usize> = Vec::new();
    let mut before: Vec<Option<usize>> = vec![None; times.len()];
    for (i, time) in times.iter().enumerate() {
        let k = tails.partition_point(|&t| times[t] < *time);
        before[i] = k.checked_sub(1).map(|k| tails[k]);
        if k == tails.len() {
            tails.push(i);
        } else if times[tails[k]] > *time {
            tails[k] = i;
        }
    }
    let mut kept = Vec::with_capacity(tails.len());
    let mut at = tails.last().copied();
    while let Some(i) = at {
        kept.push(i);
        at = before[i];
    }
    kept.reverse();
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_wild_time_costs_itself_and_of_equal_ones_the_first_stays() {
        let times = [0.0, 1.0, 900.0, 2.0, 2.0, 3.0].map(|s| GpsTime::from_week_tow(2300, s));
        assert_eq!(longest_rising(&times), [0, 1, 3, 5]);
        assert!(longest_rising(&[]).is_empty());
    }

    #[test]
    fn attitudes_are_interpolated_and_not_across_gaps() {
        let at = |s: f64| GpsTime::from_week_tow(2300, s);
        let sample = |s: f64, heading: f64| AttitudeSample {
            stamp: Stamp::Gps(at(s)),
            attitude: Attitude::from_heading(heading),
        };
        let track = AttitudeTrack::new(
            &[sample(0.1, 0.2), sample(0.0, 0.0), sample(5.0, 1.0)],
            None,
        );
        let found = track.at(at(0.05)).unwrap();
        assert!(found.angle_to(&Attitude::from_heading(0.1)) < 1e-7);
        assert!(track.at(at(2.0)).is_none());
        assert!(track.at(at(5.2)).is_some() && track.at(at(5.3)).is_none());
    }
}
