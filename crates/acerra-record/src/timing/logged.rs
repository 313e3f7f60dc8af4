//! The time of each trace on GPS time, from a session's stamps.

use acerra_geo::time::GpsTime;
use acerra_radar::LoggedClock;
use thiserror::Error;

use super::fit::{ClockLine, FitError, Pair, clock_line};

/// Largest difference of a radio's clock from GPS time (10⁻⁶). The computer's may differ more: it is
/// slewed, and instruments that are emulated faster than the world make it slow.
const CLOCKS_PPM: f64 = 500.0;

/// A delay common to all messages, not observable from stamps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Latency {
    /// Length (s).
    pub delay_s: f64,
    /// Standard deviation (s).
    pub sigma_s: f64,
}

/// Reason why trace times are not known on GPS time.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TimingError {
    /// The radio's clock.
    #[error("radio clock: {0}")]
    Radio(FitError),
    /// The receiver's.
    #[error("GPS time: {0}")]
    Gps(FitError),
    /// The radio's clock and GPS time disagree by more than clocks do.
    #[error(
        "the radio's clock and GPS time differ by {found_ppm:.0} parts in a million; expected less than \
         {limit_ppm:.0}"
    )]
    Rate {
        /// Difference found (10⁻⁶).
        found_ppm: f64,
        /// Largest difference of clocks (10⁻⁶).
        limit_ppm: f64,
    },
}

/// A session's data on the times of a run of scans.
#[derive(Clone, Debug)]
pub struct Stamps {
    /// Radar time (s, from the first trace) of each trace that came, and host time of its arrival.
    pub radio: Vec<Pair>,
    /// GPS epochs and host time of their arrival.
    pub gps: Vec<(GpsTime, f64)>,
    /// Number and stamp of the first trace.
    pub first: (u16, u32),
    /// Latency common to all messages of the radio and to all epochs of the receiver.
    pub latency: [Latency; 2],
}

/// Fits both clocks over the host's and puts them together.
///
/// # Errors
/// Too few stamps of either, or clocks that differ by more than clocks do.
pub fn logged_clock(stamps: &Stamps) -> Result<LoggedClock, TimingError> {
    Ok(Lines::of(stamps)?.clock(stamps, stamps.latency))
}

/// The host's clock over both others.
pub(super) struct Lines {
    /// Host clock at arrival over radar time.
    pub radio: ClockLine,
    /// Host clock at arrival over GPS seconds after the origin.
    pub gps: ClockLine,
    /// Where GPS seconds count from.
    pub origin: GpsTime,
}

impl Lines {
    /// The lines of times of arrival.
    pub fn of(stamps: &Stamps) -> Result<Self, TimingError> {
        let radio = clock_line(&stamps.radio).map_err(TimingError::Radio)?;
        let origin = stamps
            .gps
            .first()
            .map(|(time, _)| *time)
            .ok_or(TimingError::Gps(FitError::Pairs { found: 0 }))?;
        let pairs: Vec<Pair> = stamps
            .gps
            .iter()
            .map(|(time, host_s)| Pair {
                sent_s: time.seconds_since(origin),
                arrived_s: *host_s,
            })
            .collect();
        let gps = clock_line(&pairs).map_err(TimingError::Gps)?;
        let found_ppm = 1e6 * (radio.rate / gps.rate - 1.0);
        if found_ppm.is_nan() || found_ppm.abs() > CLOCKS_PPM {
            return Err(TimingError::Rate {
                found_ppm,
                limit_ppm: CLOCKS_PPM,
            });
        }
        Ok(Self { radio, gps, origin })
    }

    /// These data with another line of GPS time.
    pub fn with_gps(&self, gps: ClockLine) -> Self {
        Self { gps, ..*self }
    }

    /// Radar time on GPS time, where both lines are late by these latencies.
    pub fn clock(&self, stamps: &Stamps, latency: [Latency; 2]) -> LoggedClock {
        let Self { radio, gps, origin } = self;
        let [radio_latency, gnss_latency] = latency;
        // Both lines give host time at arrival; the shortest latency of each is taken off there.
        let gps_since_origin_s = |radar_s: f64| {
            let host_s = radio.reading_s(radar_s) - radio_latency.delay_s + gnss_latency.delay_s;
            gps.at_s + (host_s - gps.reads_s) / gps.rate
        };
        let first_s = gps_since_origin_s(0.0);
        let (gps_week, time_offset_s) = week_and_tow(*origin, first_s);
        let middle_gps_s = gps_since_origin_s(radio.at_s);
        let sigma_stamps_s = radio.sigma_s.hypot(gps.sigma_at_s(middle_gps_s)) / gps.rate;
        LoggedClock {
            version: LoggedClock::VERSION,
            first_message_id: stamps.first.0,
            first_timestamp_ms: stamps.first.1,
            gps_week,
            time_offset_s,
            rate: radio.rate / gps.rate,
            sigma_stamps_s,
            sigma_s: sigma_stamps_s
                .hypot(radio_latency.sigma_s)
                .hypot(gnss_latency.sigma_s),
            radio_jitter_s: radio.jitter_s,
            gnss_jitter_s: gps.jitter_s,
            radio_latency_s: radio_latency.delay_s,
            gnss_latency_s: gnss_latency.delay_s,
            marks: 0,
            pulses: 0,
        }
    }
}

/// Week and seconds of week, `after_s` after `origin`; the seconds to double precision.
pub(super) fn week_and_tow(origin: GpsTime, after_s: f64) -> (i64, f64) {
    const WEEK_S: f64 = 604_800.0;
    let tow_s = origin.tow_s() + after_s;
    let weeks = (tow_s / WEEK_S).floor();
    let start_s = origin.seconds_since(GpsTime::from_week_tow(0, origin.tow_s()));
    let week = (start_s / WEEK_S).round() + weeks;
    (week as i64, tow_s - weeks * WEEK_S)
}
