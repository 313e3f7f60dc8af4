//! Check before any search whether radar log and positions can belong together: times must overlap, and
//! positions must be frequent enough.

use crate::align::recording::Recording;
use crate::align::{AlignError, no_overlap};
use crate::choices::TimeOffset;
use crate::position::Positions;

/// Positions whose interval contains the whole radar log are rejected where all positions last this many
/// times longer than the radar log; two positions alone are accepted as the ends of a rail.
const MUCH_LONGER: f64 = 10.0;

/// Reason for which the clocks of a radar log and of positions cannot belong together.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ClocksError {
    /// At the offset in force the traces lie before or after the positions.
    #[error(transparent)]
    Apart(#[from] AlignError),
    /// The radar log is shorter than the time between two positions.
    #[error(
        "[trajectory]: expected several positions within the {radar_s:.1} s of the radar log, found one every \
         {interval_s:.3} s over {positions_s:.1} s (are their times in seconds?)"
    )]
    Rare {
        /// Time from the first trace to the last (s).
        radar_s: f64,
        /// Typical time between two positions (s).
        interval_s: f64,
        /// Time from the first position to the last (s).
        positions_s: f64,
    },
}

/// Compares the times of a recording's traces with the times of its positions.
///
/// # Errors
/// A stated offset at which they do not overlap, positions too rare to follow the traces.
pub(crate) fn check_clocks(recording: &Recording) -> Result<(), ClocksError> {
    let (Positions::Trajectory(trajectory), [first_s, .., last_s]) =
        (&recording.positions, recording.radar.content.time_s())
    else {
        return Ok(());
    };
    if let TimeOffset::Seconds(offset_s) = recording.options.align.time_offset.unwrap_or_default() {
        let traces_s = [first_s + offset_s, last_s + offset_s];
        if traces_s[0] > trajectory.end_s() || traces_s[1] < trajectory.start_s() {
            return Err(no_overlap(offset_s, traces_s, trajectory).into());
        }
    }
    let radar_s = last_s - first_s;
    let positions_s = trajectory.end_s() - trajectory.start_s();
    match trajectory.sample_interval_s() {
        Some(interval_s) if radar_s < interval_s && positions_s > MUCH_LONGER * radar_s => {
            Err(ClocksError::Rare {
                radar_s,
                interval_s,
                positions_s,
            })
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test that cannot go on has failed
mod tests {
    use acerra_geo::trajectory::{Fix, Frame, TimeOrigin, Trajectory};
    use acerra_radar::{Radargram, Samples};

    use super::*;

    /// A radar log of 20 s, and positions at some times.
    fn recording(times_s: impl Iterator<Item = f64>, offset: TimeOffset) -> Recording {
        let time_s = (0..200).map(|k| 0.1 * f64::from(k)).collect();
        let samples = Samples::Real(vec![0.0; 200 * 4]);
        let radargram = Radargram::new(time_s, 0.0, 1e-9, samples).unwrap();
        let fixes = times_s.map(|t| Fix::new(t, [t, 0.0, 5.0])).collect();
        let trajectory = Trajectory::new(Frame::Local, TimeOrigin::Relative, fixes).unwrap();
        let mut recording = Recording::new("north", radargram, trajectory);
        recording.options.align.time_offset = Some(offset);
        recording
    }

    fn every(step_s: f64) -> impl Iterator<Item = f64> {
        (0..300).map(move |k| 1000.0 + step_s * f64::from(k))
    }

    #[test]
    fn stated_offsets_must_bring_the_traces_onto_the_positions() {
        let at = |offset_s| check_clocks(&recording(every(0.1), TimeOffset::Seconds(offset_s)));
        // Traces of 0 to 19.9 s, positions of 1000 to 1029.9 s.
        for offset_s in [981.0, 1000.0, 1029.0] {
            assert_eq!(at(offset_s), Ok(()), "{offset_s}");
        }
        for offset_s in [0.0, 980.0, 1030.0, -1e9] {
            let said = at(offset_s).unwrap_err().to_string();
            assert!(said.contains("1000.000 to 1029.900 s"), "{said}");
            assert!(said.contains(&format!("{offset_s:.3} to")), "{said}");
        }
        let auto = recording(every(0.1), TimeOffset::Auto);
        assert_eq!(check_clocks(&auto), Ok(()));
    }

    #[test]
    fn milliseconds_taken_for_seconds_are_refused_and_a_rail_by_its_ends_is_not() {
        for offset in [TimeOffset::Auto, TimeOffset::Seconds(1000.0)] {
            let refused = check_clocks(&recording(every(100.0), offset));
            assert!(
                matches!(refused, Err(ClocksError::Rare { .. })),
                "{refused:?}"
            );
            let slow = recording(every(1.0), offset);
            assert_eq!(check_clocks(&slow), Ok(()));
            let rail = recording([995.0, 1025.0].into_iter(), offset);
            assert_eq!(check_clocks(&rail), Ok(()));
        }
    }
}
