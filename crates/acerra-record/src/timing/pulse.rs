//! A pulse per second, and why pulses are not used.

use thiserror::Error;

use super::fit::LEAST_PAIRS;

/// Share of the pulses that must lie on the line.
pub(super) const LEAST_SHARE: f64 = 0.75;
/// Largest scatter of pulses (s): USB looks at a wire each millisecond at worst, interrupts at once.
pub(super) const MOST_SCATTER_S: f64 = 1e-3;
/// Largest deviation of the host's clock from a line (s): an oscillator whose rate changes by 5 ppm over ten
/// minutes reaches half of this.
pub(super) const MOST_WANDER_S: f64 = 0.25e-3;

/// A pulse as it was recorded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    /// Number by the kernel.
    pub sequence: u32,
    /// Host clock at its edge (s).
    pub host_s: f64,
    /// Whether the receiver had a fix: without a fix, pulses follow the receiver's own clock.
    pub has_fix: bool,
}

/// Reason why pulses are not used.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PulseError {
    /// Too few pulses.
    #[error(
        "expected {LEAST_PAIRS} pulses at least while the receiver has a fix, found {found} ({without_fix} without a \
         fix, {doubled} with doubled edges)"
    )]
    TooFew {
        /// Pulses with a fix and single edges.
        found: usize,
        /// Pulses without a fix.
        without_fix: usize,
        /// Pulses before which the kernel counted more edges than seconds.
        doubled: usize,
    },
    /// The arrival clock does not identify the second of a pulse.
    #[error(
        "the second of a pulse cannot be identified by times of arrival, which are sure to {:.0} ms; expected less than \
         {:.0} ms",
        1e3 * sigma_s, 1e3 * limit_s
    )]
    Ambiguous {
        /// Standard deviation of the arrival clock (s).
        sigma_s: f64,
        /// What it must be less than (s).
        limit_s: f64,
    },
    /// The pulses are not one a second.
    #[error(
        "{together} of {pulses} pulses are a whole number of seconds apart; expected {:.0} % at least",
        100.0 * LEAST_SHARE
    )]
    NotSeconds {
        /// Pulses that lie on one line.
        together: usize,
        /// Pulses with a fix.
        pulses: usize,
    },
    /// The pulses scatter more than pulses do.
    #[error(
        "the pulses scatter by {:.2} ms; expected less than {:.0} ms",
        1e3 * scatter_s, 1e3 * MOST_SCATTER_S
    )]
    Unsteady {
        /// Scatter (s).
        scatter_s: f64,
    },
    /// The pulses are on no line.
    #[error(
        "the pulses wander from a line by {:.2} ms; expected less than {:.2} ms: is the computer's clock being set?",
        1e3 * wander_s, 1e3 * MOST_WANDER_S
    )]
    Wandering {
        /// Deviation of their means over some seconds (s).
        wander_s: f64,
    },
    /// Epochs would be sent before they are measured.
    #[error(
        "the receiver's first byte would come {:.1} ms before the pulse of its second, which is impossible: \
         the kernel stamps the pulse's other edge (an inverted wire is late by the pulse's width), or the \
         pulses are not those of GPS time",
        -1e3 * latency_s
    )]
    Early {
        /// Latency of the receiver by the pulses (s).
        latency_s: f64,
    },
    /// The receiver would need longer than receivers do.
    #[error(
        "the receiver's first byte would come {:.1} ms behind the pulse of its second; expected less than {:.0} ms, \
         its interval between measurements: the kernel stamps another edge, or the pulses do not follow GPS time",
        1e3 * latency_s, 1e3 * limit_s
    )]
    Late {
        /// Latency of the receiver by the pulses (s).
        latency_s: f64,
        /// The longest accepted latency (s).
        limit_s: f64,
    },
    /// The pulses cover too little of the recording: clocks wander.
    #[error(
        "the pulses with a fix span {found_s:.0} s of {recorded_s:.0} s; expected half of it at least"
    )]
    Span {
        /// From the first to the last (s).
        found_s: f64,
        /// From the receiver's first epoch to its last (s).
        recorded_s: f64,
    },
    /// The pulses run at another rate than the receiver's epochs.
    #[error(
        "pulses and epochs run apart by {found_ppm:.1} parts in a million; expected less than {limit_ppm:.1}: the \
         pulses do not follow GPS time"
    )]
    Rate {
        /// Difference (10⁻⁶).
        found_ppm: f64,
        /// Largest accepted difference (10⁻⁶).
        limit_ppm: f64,
    },
}
