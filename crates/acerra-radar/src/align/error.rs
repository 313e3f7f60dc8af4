//! Reasons why no clock offset can be estimated.

use thiserror::Error;

use acerra_control::Cancelled;

/// Reason for which no offset was found.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum AlignError {
    /// A curve without values, or of unequal lengths.
    #[error("{what}: {times} times for {values} values, at least 3 of each are needed")]
    Length {
        /// Name of the curve.
        what: &'static str,
        /// Times given.
        times: usize,
        /// Values given.
        values: usize,
    },
    /// Times that do not rise.
    #[error("{what}: time {index} is not after the one before")]
    Order {
        /// Name of the curve.
        what: &'static str,
        /// Index of the first time that does not rise.
        index: usize,
    },
    /// A curve that is constant: nothing moves.
    #[error("{what} does not change: there is no motion to align by")]
    Constant {
        /// Name of the curve.
        what: &'static str,
    },
    /// The curves overlap too little at every offset.
    #[error(
        "at no offset within {from_s} to {to_s} s do {percent:.0} % of the radar traces fall within the \
         trajectory"
    )]
    NoOverlap {
        /// Smallest offset tried, s.
        from_s: f64,
        /// Largest offset tried, s.
        to_s: f64,
        /// Share needed, percent.
        percent: f64,
    },
    /// A step that is not a positive number, or tries more than ten million offsets.
    #[error("offset step of {step_s} s over {range_s} s")]
    Step {
        /// The step, s.
        step_s: f64,
        /// The range, s.
        range_s: f64,
    },
    /// A range of delays that is not an interval.
    #[error("delays from {from_s:e} to {to_s:e} s are not an interval")]
    DelayRange {
        /// Smallest delay, s.
        from_s: f64,
        /// Largest delay, s.
        to_s: f64,
    },
    /// No cue depends on the offset.
    #[error(
        "nothing in the radargram follows the flight: no echo moves with the height and the \
         change from trace to trace does not follow the speed (do the logs belong together?)"
    )]
    NoCue,
    /// The likelihood is too wide to determine an offset.
    #[error(
        "height and speed change too little to determine the offset: anything within {from_s:.2} to \
         {to_s:.2} s agrees with the data (best {best_s:.3} s)"
    )]
    Vague {
        /// Most likely offset, s.
        best_s: f64,
        /// Smallest offset that agrees, s.
        from_s: f64,
        /// Largest offset that agrees, s.
        to_s: f64,
    },
    /// Two offsets agree with the data.
    #[error(
        "two offsets agree with the data: {best_s:.3} s and {second_s:.3} s (log-likelihoods \
         differ by {margin:.1}, at least {needed:.1} are needed)"
    )]
    Ambiguous {
        /// Most likely offset, s.
        best_s: f64,
        /// The other offset, s.
        second_s: f64,
        /// Log-likelihood of the best offset less that of the other.
        margin: f64,
        /// Difference needed.
        needed: f64,
    },
    /// Two cues, each certain, contradict each other.
    #[error(
        "the cues contradict each other: height gives {height_s:.3} ± {height_sigma_s:.3} s, \
         sharpness {sharpness_s:.3} ± {sharpness_sigma_s:.3} s"
    )]
    Contradiction {
        /// Offset by height (and motion), s.
        height_s: f64,
        /// Standard deviation of the offset by height, s.
        height_sigma_s: f64,
        /// Offset by sharpness, s.
        sharpness_s: f64,
        /// Standard deviation of the offset by sharpness, s.
        sharpness_sigma_s: f64,
    },
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Offsets that remain possible after a refusal.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenOffsets {
    /// The most likely offset, s.
    pub best_s: f64,
    /// Stretches of offsets `[from, to]` that agree with the data, s, rising.
    pub stretches_s: Vec<[f64; 2]>,
}

/// Reach to each side of an offset that is stated without a deviation, s.
const REACH_S: f64 = 1.0;
/// Reach of a stretch to each side of an offset, in standard deviations.
const REACH_SIGMAS: f64 = 5.0;

impl AlignError {
    /// The offsets that agree with the data, where the data agree with some but do not decide between them.
    #[must_use]
    pub fn open_offsets(&self) -> Option<OpenOffsets> {
        let about = |offset_s: f64, reach_s: f64| [offset_s - reach_s, offset_s + reach_s];
        let (best_s, mut stretches_s) = match *self {
            Self::Vague {
                best_s,
                from_s,
                to_s,
            } => (best_s, vec![[from_s - REACH_S, to_s + REACH_S]]),
            Self::Ambiguous {
                best_s, second_s, ..
            } => (
                best_s,
                vec![about(best_s, REACH_S), about(second_s, REACH_S)],
            ),
            Self::Contradiction {
                height_s,
                height_sigma_s,
                sharpness_s,
                sharpness_sigma_s,
            } => {
                let reach_s = |sigma_s: f64| REACH_S.max(REACH_SIGMAS * sigma_s);
                let stretches_s = vec![
                    about(height_s, reach_s(height_sigma_s)),
                    about(sharpness_s, reach_s(sharpness_sigma_s)),
                ];
                (height_s, stretches_s)
            }
            _ => return None,
        };
        stretches_s.sort_by(|a, b| a[0].total_cmp(&b[0]));
        Some(OpenOffsets {
            best_s,
            stretches_s: merged(stretches_s),
        })
    }
}

/// Rising stretches, with overlapping ones merged.
fn merged(stretches_s: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let mut all: Vec<[f64; 2]> = Vec::with_capacity(stretches_s.len());
    for next in stretches_s {
        match all.last_mut() {
            Some(last) if next[0] <= last[1] => last[1] = last[1].max(next[1]),
            _ => all.push(next),
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_names_the_offsets_that_it_leaves_open() {
        let two = AlignError::Ambiguous {
            best_s: 20.0,
            second_s: 10.0,
            margin: 2.0,
            needed: 6.0,
        };
        let open = two.open_offsets().unwrap();
        assert_eq!(open.best_s, 20.0);
        assert_eq!(open.stretches_s, [[9.0, 11.0], [19.0, 21.0]]);
        let near = AlignError::Contradiction {
            height_s: 5.0,
            height_sigma_s: 0.4,
            sharpness_s: 6.0,
            sharpness_sigma_s: 0.01,
        };
        assert_eq!(near.open_offsets().unwrap().stretches_s, [[3.0, 7.0]]);
        assert_eq!(AlignError::NoCue.open_offsets(), None);
    }
}
