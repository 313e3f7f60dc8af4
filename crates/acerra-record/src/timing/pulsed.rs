//! Radar time on GPS time by pulses per second: without the receiver's latency, which they measure.

use acerra_radar::LoggedClock;
use thiserror::Error;

use super::fit::ClockLine;
use super::logged::{Latency, Lines, Stamps, TimingError};
use super::pulse::{Pulse, PulseError};
use super::pulses::PulseLine;

/// Standard deviation of the time from a pulse's edge to the kernel's stamp (s), where the stamps scatter
/// less. Interrupts of a Raspberry Pi are stamped within some microseconds (rascol.github.io, PPS-Client);
/// slower and busier boards need several times that.
const INTERRUPT_SIGMA_S: f64 = 50e-6;
/// Largest difference of a receiver's time tags from GPS time (s): receivers keep their clocks within a
/// millisecond.
const TIME_TAG_S: f64 = 1e-3;
/// Longest accepted latency of receivers that measure more often (s): they may still compute one epoch when
/// the next is measured.
const LEAST_LIMIT_S: f64 = 0.1;
/// Difference of rate that is not judged (10⁻⁶): a latency that grows with the satellites in view looks like one.
const RATE_PPM: f64 = 10.0;
/// Ratio of the ends' deviation from a line to that of the means of a recording.
const WANDER_ENDS: f64 = 3.0;
/// Share of the recording that the pulses must span.
const LEAST_SPAN: f64 = 0.5;
/// Deviations that contradict.
const SIGMAS: f64 = 5.0;

/// Reason why pulses give no clock.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PulsedClockError {
    /// There is none without them either.
    #[error(transparent)]
    Timing(#[from] TimingError),
    /// The pulses.
    #[error(transparent)]
    Pulses(#[from] PulseError),
}

/// The clock by pulses, and the pulses' statistics.
#[derive(Clone, Debug, PartialEq)]
pub struct PulsedClock {
    /// The clock.
    pub clock: LoggedClock,
    /// Shortest time from an epoch to its first byte (s of GPS time).
    pub shortest_latency_s: f64,
    /// Median (s of GPS time).
    pub median_latency_s: f64,
    /// Whether the session states this latency.
    pub is_as_stated: bool,
    /// Scatter of the pulses about their line (s).
    pub scatter_s: f64,
    /// Pulses with a fix that are not on the line.
    pub outlying: usize,
    /// Pulses before which the kernel counted more edges than seconds.
    pub doubled: usize,
    /// Pulses without a fix.
    pub without_fix: usize,
}

/// The clock of these stamps with GPS time by `pulses`, in order of arrival, instead of the receiver's times
/// of arrival.
///
/// # Errors
/// Stamps that determine no clock; pulses that are too few or contradict the receiver's epochs.
pub fn pulsed_clock(stamps: &Stamps, pulses: &[Pulse]) -> Result<PulsedClock, PulsedClockError> {
    let lines = Lines::of(stamps)?;
    let [_, stated] = stamps.latency;
    let found = PulseLine::through(pulses, &lines.gps, lines.origin, stated)?;
    let by_pulses = ClockLine {
        at_s: found.line.middle_s,
        reads_s: found.line.value_s,
        rate: found.line.slope,
        sigma_s: found.line.sigma_s,
        sigma_rate: found.line.sigma_slope,
        jitter_s: lines.gps.jitter_s,
        pairs: found.line.used,
        held_up_blocks: 0,
    };
    check_span(found.span_s, stamps)?;
    check_rate(&lines.gps, &by_pulses)?;
    let middle_s = lines.gps.at_s;
    let sigma_s = lines.gps.sigma_s.hypot(by_pulses.sigma_at_s(middle_s)) / by_pulses.rate;
    let shortest_s = (lines.gps.reads_s - by_pulses.reading_s(middle_s)) / by_pulses.rate;
    check_latency(shortest_s, sigma_s, interval_s(stamps))?;
    let of_interrupts = Latency {
        delay_s: 0.0,
        sigma_s: found
            .line
            .scatter_s
            .max(INTERRUPT_SIGMA_S)
            .hypot(WANDER_ENDS * found.line.wander_s),
    };
    let clock = lines
        .with_gps(by_pulses)
        .clock(stamps, [stamps.latency[0], of_interrupts]);
    let doubt_s = stated.sigma_s.hypot(sigma_s) + TIME_TAG_S / SIGMAS;
    Ok(PulsedClock {
        clock: LoggedClock {
            gnss_latency_s: shortest_s,
            pulses: found.line.used,
            ..clock
        },
        shortest_latency_s: shortest_s,
        median_latency_s: shortest_s + lines.gps.jitter_s / by_pulses.rate,
        is_as_stated: (shortest_s - stated.delay_s).abs() <= SIGMAS * doubt_s,
        scatter_s: found.line.scatter_s,
        outlying: found.outlying,
        doubled: found.doubled,
        without_fix: found.without_fix,
    })
}

/// Checks that the pulses cover enough of the recording.
fn check_span(found_s: f64, stamps: &Stamps) -> Result<(), PulseError> {
    let ends = stamps.gps.first().zip(stamps.gps.last());
    let recorded_s = ends.map_or(0.0, |((first, _), (last, _))| last.seconds_since(*first));
    if found_s >= LEAST_SPAN * recorded_s {
        return Ok(());
    }
    Err(PulseError::Span {
        found_s,
        recorded_s,
    })
}

fn check_rate(arrivals: &ClockLine, pulses: &ClockLine) -> Result<(), PulseError> {
    let found_ppm = 1e6 * (pulses.rate / arrivals.rate - 1.0);
    let sigma_ppm = 1e6 * arrivals.sigma_rate.hypot(pulses.sigma_rate) / arrivals.rate;
    let limit_ppm = RATE_PPM + SIGMAS * sigma_ppm;
    if found_ppm.abs() <= limit_ppm {
        return Ok(());
    }
    Err(PulseError::Rate {
        found_ppm,
        limit_ppm,
    })
}

/// Whether a receiver that measures so often may have this latency.
fn check_latency(latency_s: f64, sigma_s: f64, interval_s: f64) -> Result<(), PulseError> {
    let doubt_s = TIME_TAG_S + SIGMAS * sigma_s;
    if latency_s < -doubt_s {
        return Err(PulseError::Early { latency_s });
    }
    let limit_s = interval_s.max(LEAST_LIMIT_S);
    if latency_s <= limit_s + doubt_s {
        return Ok(());
    }
    Err(PulseError::Late { latency_s, limit_s })
}

/// Median interval between a receiver's epochs (s).
fn interval_s(stamps: &Stamps) -> f64 {
    let pairs = stamps.gps.windows(2);
    let mut intervals_s: Vec<f64> = pairs.map(|w| w[1].0.seconds_since(w[0].0)).collect();
    intervals_s.sort_by(f64::total_cmp);
    let middle = intervals_s.len() / 2;
    intervals_s.get(middle).copied().unwrap_or(0.0)
}
