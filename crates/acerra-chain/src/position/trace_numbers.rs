//! Positions by trace number, at the times of the traces.

use acerra_geo::trajectory::{TimeOrigin, Trajectory, TrajectoryError};

/// Reason for which positions by trace number cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TraceNumberError {
    /// A number that no trace has.
    #[error("trace {number}: expected {first} to {last}, the traces of the radar log")]
    Beyond {
        /// The number.
        number: f64,
        /// Number of the first trace.
        first: usize,
        /// Number of the last one.
        last: usize,
    },
    /// Times of the traces that make no trajectory.
    #[error(transparent)]
    Times(#[from] TrajectoryError),
}

/// The positions at the times of the traces with these numbers, on the radar's clock, and the number of the
/// first trace: 0 where a row has the number 0, otherwise 1.
///
/// # Errors
/// A number that no trace has.
pub fn at_traces(
    numbered: Trajectory,
    trace_time_s: &[f64],
) -> Result<(Trajectory, usize), TraceNumberError> {
    let first = usize::from(numbered.start_s() > 0.0);
    let frame = *numbered.frame();
    let mut fixes = numbered.into_fixes();
    for fix in &mut fixes {
        let number = fix.time_s;
        let time_s = trace_time_s.get((number as usize).wrapping_sub(first));
        fix.time_s = *time_s.ok_or(TraceNumberError::Beyond {
            number,
            first,
            last: (first + trace_time_s.len()).saturating_sub(1),
        })?;
    }
    Ok((
        Trajectory::new(frame, TimeOrigin::TraceNumbers, fixes)?,
        first,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use acerra_geo::trajectory::{Fix, Frame};

    fn numbered(numbers: &[f64]) -> Trajectory {
        let fix = |n: &f64| Fix::new(*n, [0.1 * n, 0.0, 2.0]);
        let fixes = numbers.iter().map(fix).collect();
        Trajectory::new(Frame::Local, TimeOrigin::TraceNumbers, fixes).unwrap()
    }

    #[test]
    fn positions_take_the_times_of_their_traces() {
        let times_s = [5.0, 5.5, 6.5, 7.0];
        let (track, first) = at_traces(numbered(&[1.0, 3.0, 4.0]), &times_s).unwrap();
        let found: Vec<f64> = track.fixes().iter().map(|fix| fix.time_s).collect();
        assert_eq!((first, found), (1, vec![5.0, 6.5, 7.0]));
        let (track, first) = at_traces(numbered(&[0.0, 3.0]), &times_s).unwrap();
        assert_eq!((first, track.end_s()), (0, 7.0));
        let found = at_traces(numbered(&[1.0, 5.0]), &times_s).unwrap_err();
        assert_eq!(
            found.to_string(),
            "trace 5: expected 1 to 4, the traces of the radar log"
        );
        assert!(at_traces(numbered(&[0.0, 4.0]), &times_s).is_err());
    }
}
