//! The rover's position at time-tagged events.

use super::epoch::{EventPosition, Solution};
use crate::observations::observation::EventRecord;
use acerra_geo::time::GpsTime;

/// Solutions further apart than this many typical intervals have a gap between them.
const LARGEST_INTERVALS: f64 = 1.5;

/// Positions at `events`, interpolated in `solutions` (ascending in time).
///
/// Between four evenly spaced neighbours the cubic through them, else the straight line; no position outside
/// the solution and across gaps. Event times are GPS time as recorded: receivers mark events on the time
/// scale that they steer to, not on the tags of their observations.
pub(crate) fn interpolate_events(
    events: &[EventRecord],
    solutions: &[Solution],
) -> Vec<EventPosition> {
    let interval_s = typical_interval_s(solutions);
    events
        .iter()
        .map(|event| at_time(event, event.time, solutions, interval_s * LARGEST_INTERVALS))
        .collect()
}

fn typical_interval_s(solutions: &[Solution]) -> f64 {
    let mut intervals: Vec<f64> = solutions
        .windows(2)
        .map(|w| w[1].time.seconds_since(w[0].time))
        .collect();
    intervals.sort_by(f64::total_cmp);
    intervals.get(intervals.len() / 2).copied().unwrap_or(0.0)
}

fn at_time(
    event: &EventRecord,
    time: GpsTime,
    solutions: &[Solution],
    largest_gap_s: f64,
) -> EventPosition {
    let mut result = EventPosition {
        event: event.clone(),
        time,
        position_ecef_m: None,
        covariance_ecef_m2: [[0.0; 3]; 3],
        quality: None,
    };
    let after = solutions.partition_point(|s| s.time <= time);
    let (Some(before), Some(next)) = (after.checked_sub(1), solutions.get(after)) else {
        return result;
    };
    let previous = &solutions[before];
    let gap_s = next.time.seconds_since(previous.time);
    if gap_s > largest_gap_s || gap_s <= 0.0 {
        return result;
    }
    let neighbours = match (before.checked_sub(1), solutions.get(after + 1)) {
        (Some(first), Some(last))
            if previous.time.seconds_since(solutions[first].time) <= largest_gap_s
                && last.time.seconds_since(next.time) <= largest_gap_s =>
        {
            &solutions[first..=after + 1]
        }
        _ => &solutions[before..=after],
    };
    let mut position = [0.0; 3];
    for (i, s) in neighbours.iter().enumerate() {
        let mut weight = 1.0;
        for (j, other) in neighbours.iter().enumerate() {
            if i != j {
                weight *= time.seconds_since(other.time) / s.time.seconds_since(other.time);
            }
        }
        for (sum, x) in position.iter_mut().zip(s.position_ecef_m) {
            *sum += weight * x;
        }
    }
    let worse = if next.quality > previous.quality {
        next
    } else {
        previous
    };
    result.position_ecef_m = Some(position);
    result.covariance_ecef_m2 = worse.covariance_ecef_m2;
    result.quality = Some(worse.quality);
    result
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observations::observation::EventKind;
    use crate::solution::quality::Quality;

    fn solution(time_s: f64, x: f64) -> Solution {
        Solution {
            time: GpsTime::from_week_tow(2_000, time_s),
            position_ecef_m: [x, 0.0, 0.0],
            covariance_ecef_m2: [[0.0; 3]; 3],
            baseline: None,
            velocity_ecef_m_s: None,
            quality: Quality::Fixed,
            satellites: 8,
            age_s: 0.0,
            ratio: 10.0,
            not_fixed: None,
            residuals: vec![],
        }
    }

    fn event(time_s: f64, kind: EventKind) -> EventRecord {
        EventRecord {
            time: GpsTime::from_week_tow(2_000, time_s),
            kind,
            count: None,
            accuracy_s: None,
        }
    }

    #[test]
    fn every_event_gets_its_own_place_on_a_curve() {
        // x = t³ is met exactly by the cubic; near the ends the straight line takes over.
        let path: Vec<Solution> = (0..6)
            .map(|t| solution(f64::from(t), f64::from(t).powi(3)))
            .collect();
        let events: Vec<EventRecord> = [0.5, 2.25, 2.75, 7.0, -1.0]
            .iter()
            .map(|&t| event(t, EventKind::FallingEdge))
            .collect();
        let found = interpolate_events(&events, &path);
        let x = |k: usize| found[k].position_ecef_m.map(|p| p[0]);
        assert!((x(0).unwrap() - 0.5).abs() < 1e-9);
        assert!((x(1).unwrap() - 2.25f64.powi(3)).abs() < 1e-9);
        assert!((x(2).unwrap() - 2.75f64.powi(3)).abs() < 1e-9);
        assert_eq!((x(3), x(4)), (None, None));
    }

    #[test]
    fn gaps_are_not_bridged_and_event_times_stand_as_they_are() {
        let path: Vec<Solution> = [0.0, 1.0, 2.0, 5.0, 6.0, 7.0]
            .iter()
            .map(|&t| solution(t, t))
            .collect();
        let events = [
            event(3.0, EventKind::External),
            event(1.5, EventKind::External),
        ];
        let found = interpolate_events(&events, &path);
        assert_eq!(found[0].position_ecef_m, None);
        assert!((found[1].position_ecef_m.unwrap()[0] - 1.5).abs() < 1e-9);
    }
}
