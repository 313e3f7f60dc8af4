//! Reasons why no clock offset can be estimated.

use thiserror::Error;

use acerra_control::Cancelled;

/// Why no offset was found.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum AlignError {
    /// A curve without values, or of unequal lengths.
    #[error("{what}: {times} times for {values} values, at least 3 of each are needed")]
    Length {
        /// Which curve.
        what: &'static str,
        /// Times given.
        times: usize,
        /// Values given.
        values: usize,
    },
    /// Times that do not rise.
    #[error("{what}: time {index} is not after the one before")]
    Order {
        /// Which curve.
        what: &'static str,
        /// Index of the offender.
        index: usize,
    },
    /// A curve that is constant: nothing moves.
    #[error("{what} does not change: there is no motion to align by")]
    Constant {
        /// Which curve.
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
        "nothing in the radargram follows the flight: no echo moves with the height and the change from \
         trace to trace does not follow the speed (do the logs belong together?); state the offset"
    )]
    NoCue,
    /// The likelihood is so wide that any offset within it would be a guess.
    #[error(
        "height and speed change too little to determine the offset: anything within {from_s:.2} to \
         {to_s:.2} s agrees with the data (best {best_s:.3} s); state the offset"
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
         differ by {margin:.1}, at least {needed:.1} are needed); state the offset"
    )]
    Ambiguous {
        /// Most likely offset, s.
        best_s: f64,
        /// The other one, s.
        second_s: f64,
        /// Log-likelihood of the best less that of the other.
        margin: f64,
        /// Difference needed.
        needed: f64,
    },
    /// Two cues, each certain, contradict each other.
    #[error(
        "the cues contradict each other: height gives {height_s:.3} ± {height_sigma_s:.3} s, sharpness \
         {sharpness_s:.3} ± {sharpness_sigma_s:.3} s; state the offset"
    )]
    Contradiction {
        /// Offset by height (and motion), s.
        height_s: f64,
        /// Its standard deviation, s.
        height_sigma_s: f64,
        /// Offset by sharpness, s.
        sharpness_s: f64,
        /// Its standard deviation, s.
        sharpness_sigma_s: f64,
    },
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
