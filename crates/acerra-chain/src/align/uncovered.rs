//! Times at which radar log and positions cannot be compared: a possible cause of a failed search.

use crate::align::interpolator;
use crate::align::recording::Recording;
use crate::journal::warnings::Warnings;
use crate::position::Positions;

/// Least share of the radar log's time that positions must cover, as for the finding `trajectory_coverage`.
const LEAST_SHARE: f64 = 0.8;

/// Reports gaps of a recording's positions, and positions that cover much less time than the radar log.
pub(crate) fn warn_of_uncovered(recording: &Recording, warnings: &mut Warnings) {
    let Positions::Trajectory(trajectory) = &recording.positions else {
        return;
    };
    let radar_s = recording.radar.content.time_s();
    let log_s = match radar_s {
        [first, .., last] => last - first,
        _ => 0.0,
    };
    let positions_s = trajectory.end_s() - trajectory.start_s();
    if positions_s < LEAST_SHARE * log_s {
        warnings.add(format!(
            "{}: the positions last {positions_s:.1} s, the radar log {log_s:.1} s; do they belong together, \
             and do the logs of the positions begin and end about the flight?",
            recording.name
        ));
    }
    let longest_s = interpolator(recording.options.align.max_gap_s, trajectory).max_gap_s();
    let steps = trajectory.fixes().windows(2);
    let gaps: Vec<(f64, f64)> = steps
        .map(|pair| (pair[0].time_s, pair[1].time_s - pair[0].time_s))
        .filter(|(_, gap_s)| *gap_s > longest_s)
        .collect();
    let widest = gaps.iter().max_by(|a, b| a.1.total_cmp(&b.1));
    if let Some((from_s, gap_s)) = widest {
        warnings.add(format!(
            "{}: the positions have gaps longer than {longest_s:.2} s: {}, the longest of {gap_s:.1} s from \
             {from_s:.1} s on; nothing is compared within them ([trajectory] max_gap_s)",
            recording.name,
            gaps.len()
        ));
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test that cannot go on has failed
mod tests {
    use acerra_geo::trajectory::{Fix, Frame, TimeOrigin, Trajectory};
    use acerra_radar::{Radargram, Samples};

    use super::*;

    fn warnings_of(times_s: impl Iterator<Item = f64>) -> Vec<String> {
        let time_s = vec![0.0, 5.0, 10.0];
        let radargram = Radargram::new(time_s, 0.0, 1e-9, Samples::Real(vec![0.0; 12])).unwrap();
        let fixes = times_s.map(|t| Fix::new(t, [t, 0.0, 5.0])).collect();
        let trajectory = Trajectory::new(Frame::Local, TimeOrigin::Relative, fixes).unwrap();
        let recording = Recording::new("north", radargram, trajectory);
        let mut warnings = Warnings::default();
        warn_of_uncovered(&recording, &mut warnings);
        warnings.said().to_vec()
    }

    #[test]
    fn gaps_and_short_positions_are_told() {
        let even = |count: u32| (0..count).map(|k| 0.2 * f64::from(k));
        assert!(warnings_of(even(60)).is_empty());
        assert!(warnings_of(even(42)).is_empty());
        let short = warnings_of(even(40));
        assert!(short[0].contains("the positions last 7.8 s, the radar log 10.0 s"));
        let torn = warnings_of(even(60).filter(|t| !(3.1..7.1).contains(t)));
        assert_eq!(torn.len(), 1);
        let said = "gaps longer than 0.50 s: 1, the longest of 4.2 s from 3.0 s on";
        assert!(torn[0].contains(said), "{torn:?}");
    }
}
