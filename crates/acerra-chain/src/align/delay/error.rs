//! Reasons for which a delay cannot be found.

use acerra_imaging::ImagingError;

use crate::clean::CleanError;
use crate::control::Cancelled;

/// Half of the distance that light travels in a nanosecond (m).
const HALF_LIGHT_M_NS: f64 = 0.149_896_229;
/// The measurement that settles a delay which the data leave open.
const SETTLING: &str = "one reflector at a known place settles the delay (acerra calibrate --reflector X,Y,Z), or \
                        one at a taped range from the radar at rest (--range-m; guide, \"Calibration\"), or state it";

/// Reason for which the fast time of zero range cannot be found.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DelayError {
    /// The delay is to be found from spectra.
    #[error("[radar] delay_ns = \"auto\": expected a radargram, found spectra")]
    Spectra,
    /// Two delays agree with the data.
    #[error(
        "[radar] delay_ns = \"auto\": {first_ns:.2} ns and {second_ns:.2} ns agree with the data \
         almost equally (log-likelihoods {margin:.1} apart, {needed:.0} needed), ranges {:.2} m apart; {SETTLING}",
        (second_ns - first_ns).abs() * HALF_LIGHT_M_NS
    )]
    Ambiguous {
        /// The most likely delay (ns).
        first_ns: f64,
        /// The second most likely delay (ns).
        second_ns: f64,
        /// Log-likelihood of the most likely delay less that of the second.
        margin: f64,
        /// Required difference.
        needed: f64,
    },
    /// The data hardly depend on the delay.
    #[error(
        "[radar] delay_ns = \"auto\": every delay from {from_ns:.2} to {to_ns:.2} ns agrees with the data \
         (the aperture is too short, or no echo is strong enough); {SETTLING}"
    )]
    Vague {
        /// Smallest delay that agrees (ns).
        from_ns: f64,
        /// Largest (ns).
        to_ns: f64,
    },
    /// Errors of the positions bend the echoes like a wrong delay does.
    #[error(
        "[radar] delay_ns = \"auto\": the positions' stated errors leave the delay uncertain by {sigma_ns:.2} ns (one \
         standard deviation), at most {most_ns:.2} ns are accepted; {SETTLING}"
    )]
    Uncertain {
        /// Standard deviation of the delay (ns).
        sigma_ns: f64,
        /// Largest accepted standard deviation (ns).
        most_ns: f64,
    },
    /// The strongest echo gets stronger up to the end of the delays tried.
    #[error(
        "[radar] delay_ns = \"auto\": the strongest echo is strongest at {at_ns:.2} ns, the end of the delays \
         tried ({from_ns} to {to_ns} ns); {SETTLING}"
    )]
    AtEnd {
        /// End of the delays tried (ns).
        at_ns: f64,
        /// Smallest delay tried (ns).
        from_ns: f64,
        /// Largest (ns).
        to_ns: f64,
    },
    /// The traces cannot be cleaned.
    #[error(transparent)]
    Clean(#[from] CleanError),
    /// The images of the search cannot be made.
    #[error(transparent)]
    Imaging(#[from] ImagingError),
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
