//! Selection of the traces that enter the image.

use acerra_radar::{MovingOptions, moving_traces};

use crate::choices::Select;

/// Share of the traces at rest from which a platform counts as at rest for a tenth of the time or more: traces recorded at one
/// place add up to an arc with this share of the amplitude of a point, here −20 dB.
const STANDING_SHARE: f64 = 0.1;
/// Share of the moving traces that the longest moving interval must hold to represent all of them.
const MOVING_SHARE: f64 = 0.9;

/// Reason for which a selection is invalid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SelectError {
    /// A selection beyond the end of the log.
    #[error(
        "[radar] select: expected trace numbers below {traces}, the traces of the log, found {last}"
    )]
    Beyond {
        /// Traces in the log.
        traces: usize,
        /// Largest number found.
        last: usize,
    },
    /// Moving traces are selected, and the platform never moves.
    #[error("[radar] select = \"moving\": the platform never moves over ground")]
    NeverMoves,
}

/// The traces selected, and the kind of motion of the platform.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// Whether each trace of the log is selected.
    pub selected: Vec<bool>,
    /// Whether the platform is at rest for a tenth of the time or more, and the campaign left the choice to the data.
    pub is_often_at_rest: bool,
}

impl Selection {
    /// The traces that `choice` selects, given the horizontal speed (m/s) of each trace where known.
    ///
    /// # Errors
    /// Trace numbers beyond the log, a platform that never moves.
    pub fn of(choice: Select, speed_m_s: &[Option<f64>]) -> Result<Self, SelectError> {
        let mut selected = vec![false; speed_m_s.len()];
        let mut is_often_at_rest = false;
        match choice {
            Select::All => selected.fill(true),
            Select::Range([first, last]) => {
                let traces = speed_m_s.len();
                if last >= traces {
                    return Err(SelectError::Beyond { traces, last });
                }
                selected[first..=last].fill(true);
            }
            Select::Moving => {
                let moving = moving_traces(&known(speed_m_s), &MovingOptions::default());
                if moving.is_empty() {
                    return Err(SelectError::NeverMoves);
                }
                selected[moving].fill(true);
            }
            Select::Auto => {
                is_often_at_rest = rests_often(speed_m_s);
                let moving = moving_traces(&known(speed_m_s), &MovingOptions::default());
                let unbridged = MovingOptions::default().with_bridge(usize::MAX);
                let whole = moving_traces(&known(speed_m_s), &unbridged);
                // Passes with a long halt between them are all kept.
                let is_most = moving.len() as f64 >= MOVING_SHARE * whole.len() as f64;
                match is_often_at_rest {
                    true if is_most => selected[moving].fill(true),
                    true => selected[whole].fill(true),
                    false => selected.fill(true),
                }
            }
        }
        Ok(Self {
            selected,
            is_often_at_rest,
        })
    }
}

fn known(speed_m_s: &[Option<f64>]) -> Vec<f64> {
    speed_m_s.iter().map(|v| v.unwrap_or(f64::NAN)).collect()
}

/// Whether a platform that moves at times is at rest during much of the remaining time.
fn rests_often(speed_m_s: &[Option<f64>]) -> bool {
    let mut speed: Vec<f64> = speed_m_s.iter().copied().flatten().collect();
    speed.sort_by(f64::total_cmp);
    let Some(fast_m_s) = speed.get(speed.len() * 19 / 20) else {
        return false;
    };
    let slow = speed.partition_point(|v| *v <= 0.25 * fast_m_s);
    // A platform that only sways about its place has no moving part.
    *fast_m_s > LEAST_SPEED_M_S && slow as f64 > STANDING_SHARE * speed.len() as f64
}

/// Speed that the wander of positions does not reach, averaged over half a second (m/s).
const LEAST_SPEED_M_S: f64 = 0.1;

#[cfg(test)]
mod tests {
    use super::*;

    fn flight(parts: &[(usize, f64)]) -> Vec<Option<f64>> {
        parts
            .iter()
            .flat_map(|(count, v)| vec![Some(*v); *count])
            .collect()
    }

    fn of(parts: &[(usize, f64)]) -> (usize, bool) {
        let selection = Selection::of(Select::Auto, &flight(parts)).unwrap();
        let count = selection.selected.iter().filter(|s| **s).count();
        (count, selection.is_often_at_rest)
    }

    #[test]
    fn a_platform_that_stands_is_imaged_moving() {
        assert_eq!(of(&[(100, 0.01), (150, 1.0), (100, 0.02)]), (150, true));
        assert_eq!(of(&[(10, 0.01), (300, 1.0), (10, 0.02)]), (320, false));
        // Swaying in place does not count as motion.
        assert_eq!(of(&[(50, 0.01), (50, 0.05)]), (100, false));
    }

    #[test]
    fn passes_with_a_halt_between_are_all_kept() {
        assert_eq!(
            of(&[(90, 0.0), (100, 1.0), (90, 0.0), (100, 1.0), (60, 0.0)]),
            (290, true)
        );
    }

    #[test]
    fn impossible_selections_are_refused() {
        let speed = flight(&[(10, 0.0)]);
        assert_eq!(
            Selection::of(Select::Range([0, 10]), &speed),
            Err(SelectError::Beyond {
                traces: 10,
                last: 10
            })
        );
        assert_eq!(
            Selection::of(Select::Moving, &speed),
            Err(SelectError::NeverMoves)
        );
    }
}
