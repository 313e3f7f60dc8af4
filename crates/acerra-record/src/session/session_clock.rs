//! The clock of a session: by times of arrival, and by time marks where there are any.

use acerra_radar::LoggedClock;

use super::capture::ArrivalTimes;
use super::log_content::LogContent;
use super::plausibility::shortest_interval_s;
use super::settings::{RadioSection, Session};
use crate::timing::{Latency, MarkedScans, Pair, Stamps, TimingError, logged_clock, marked_clock};

/// A trace of the run that is imaged.
#[derive(Clone, Copy, Debug)]
pub(super) struct TraceTime {
    /// Number and stamp (ms) of the radio.
    pub key: (u16, u32),
    /// Radar time (s, from the first trace).
    pub radar_s: f64,
}

/// The clock of a run, and what there is to say of it.
pub(super) struct SessionClock {
    /// The clock, or why there is none.
    pub clock: Result<LoggedClock, TimingError>,
    /// On what it rests, where the receiver stamped marks.
    pub remark: Option<String>,
}

/// Puts the traces of a run on GPS time; `None` where there are no traces.
pub(super) fn session_clock(log: &LogContent, traces: &[TraceTime]) -> Option<SessionClock> {
    let stamps = stamps_of(log, traces)?;
    let arrivals = match logged_clock(&stamps) {
        Ok(clock) => clock,
        Err(error) => {
            return Some(SessionClock {
                clock: Err(error),
                remark: None,
            });
        }
    };
    if log.marks.is_empty() {
        return Some(SessionClock {
            clock: Ok(arrivals),
            remark: None,
        });
    }
    let radar_s: Vec<f64> = traces.iter().map(|trace| trace.radar_s).collect();
    let scans = MarkedScans {
        radar_s: &radar_s,
        marks: &log.marks,
        delay: mark_delay(&log.session.radio),
    };
    let (clock, remark) = match marked_clock(&scans, &arrivals) {
        Ok(clock) => {
            let remark = format!("trace times rest on {} hardware time marks", clock.marks);
            (clock, remark)
        }
        Err(error) => (arrivals, format!("time marks are not used: {error}")),
    };
    Some(SessionClock {
        clock: Ok(clock),
        remark: Some(remark),
    })
}

/// The stamps of the start of the recording that most traces came in: each start has a host clock of its
/// own.
fn stamps_of(log: &LogContent, traces: &[TraceTime]) -> Option<Stamps> {
    let pairs_of = |arrivals: &ArrivalTimes| -> Vec<Pair> {
        let pair = |trace: &TraceTime| {
            let at_ns = arrivals.get(&trace.key)?;
            Some(Pair {
                sent_s: trace.radar_s,
                arrived_s: 1e-9 * *at_ns as f64,
            })
        };
        traces.iter().filter_map(pair).collect()
    };
    let starts = log.arrivals.iter().map(pairs_of).enumerate();
    let (start, radio) = starts.max_by_key(|(_, pairs)| pairs.len())?;
    let of_start = log.gps.iter().filter(|epoch| epoch.start == start);
    Some(Stamps {
        radio,
        gps: of_start.map(|epoch| (epoch.time, epoch.host_s)).collect(),
        first: traces.first()?.key,
        latency: log.session.latencies(),
    })
}

/// A time within a scan: as stated, or half the scan's duration, anywhere within it being all that is known.
fn within_scan(radio: &RadioSection, stated_ms: Option<f64>, sigma_ms: Option<f64>) -> Latency {
    let duration_s = shortest_interval_s(radio);
    Latency {
        delay_s: stated_ms.map_or(0.5 * duration_s, |ms| 1e-3 * ms),
        sigma_s: match (stated_ms, sigma_ms) {
            (_, Some(ms)) => 1e-3 * ms,
            (Some(_), None) => 0.0,
            (None, None) => duration_s / 12.0_f64.sqrt(),
        },
    }
}

/// From the radio's pulse to the middle of the scan.
fn mark_delay(radio: &RadioSection) -> Latency {
    within_scan(radio, radio.mark_delay_ms, radio.mark_delay_sigma_ms)
}

impl Session {
    /// What all messages of the radio, and all epochs of the receiver, have in common.
    #[must_use]
    pub fn latencies(&self) -> [Latency; 2] {
        let radio = &self.radio;
        let of_radio = within_scan(radio, radio.latency_ms, radio.latency_sigma_ms);
        let of_gnss = self
            .gnss
            .as_ref()
            .map_or(Latency::default(), |gnss| Latency {
                delay_s: 1e-3 * gnss.latency_ms,
                sigma_s: 1e-3 * gnss.latency_sigma_ms,
            });
        [of_radio, of_gnss]
    }
}
