//! The clock of a session: by times of arrival, by pulses per second and by time marks where there are any.

use acerra_radar::LoggedClock;

use super::capture::ArrivalTimes;
use super::log_content::LogContent;
use super::plausibility::shortest_interval_s;
use super::settings::{RadioSection, Session};
use crate::timing::{
    Latency, MarkedScans, Pair, Pulse, PulsedClock, Stamps, TimingError, logged_clock,
    marked_clock, pulsed_clock,
};

/// A trace of the run that is imaged.
#[derive(Clone, Copy, Debug)]
pub(super) struct TraceTime {
    /// Number and stamp (ms) of the radio.
    pub key: (u16, u32),
    /// Radar time (s, from the first trace).
    pub radar_s: f64,
}

/// The clock of a run, and remarks on the clock.
pub(super) struct SessionClock {
    /// The clock, or why there is none.
    pub clock: Result<LoggedClock, TimingError>,
    /// Source, where there are pulses or marks.
    pub remarks: Vec<String>,
}

/// Puts the traces of a run on GPS time; `None` where there are no traces.
pub(super) fn session_clock(log: &LogContent, traces: &[TraceTime]) -> Option<SessionClock> {
    let (start, stamps) = stamps_of(log, traces)?;
    let arrivals = match logged_clock(&stamps) {
        Ok(clock) => clock,
        Err(error) => {
            return Some(SessionClock {
                clock: Err(error),
                remarks: Vec::new(),
            });
        }
    };
    let mut remarks = Vec::new();
    let mut clock = arrivals;
    if log.session.gnss.as_ref().is_some_and(|g| g.pps.is_some()) || !log.pulses.is_empty() {
        let of_start = log.pulses.iter().filter(|(of, _)| *of == start);
        let pulses: Vec<Pulse> = of_start.map(|(_, pulse)| *pulse).collect();
        match pulsed_clock(&stamps, &pulses) {
            Ok(pulsed) => {
                remarks.extend(told_of_pulses(&pulsed, stamps.latency[1]));
                clock = pulsed.clock;
            }
            Err(error) => remarks.push(format!("pulses per second are not used: {error}")),
        }
    }
    if !log.marks.is_empty() {
        let radar_s: Vec<f64> = traces.iter().map(|trace| trace.radar_s).collect();
        let scans = MarkedScans {
            radar_s: &radar_s,
            marks: &log.marks,
            delay: log.session.mark_delay(),
        };
        match marked_clock(&scans, &clock) {
            Ok(marked) => {
                remarks.push(format!(
                    "trace times rest on {} hardware time marks",
                    marked.marks
                ));
                clock = marked;
            }
            Err(error) => remarks.push(format!("time marks are not used: {error}")),
        }
    }
    Some(SessionClock {
        clock: Ok(clock),
        remarks,
    })
}

/// Remarks on the pulses, including a latency that differs from the stated latency.
fn told_of_pulses(pulsed: &PulsedClock, stated: Latency) -> Vec<String> {
    let [shortest_ms, median_ms] =
        [pulsed.shortest_latency_s, pulsed.median_latency_s].map(|s| 1e3 * s);
    let mut remarks = vec![format!(
        "GPS time rests on {} pulses per second, which scatter by {:.0} µs ({} outlying, {} doubled, {} without a \
         fix): the receiver's first byte comes {shortest_ms:.1} ms after its epoch at the earliest, {median_ms:.1} ms \
         in the median",
        pulsed.clock.pulses,
        1e6 * pulsed.scatter_s,
        pulsed.outlying,
        pulsed.doubled,
        pulsed.without_fix,
    )];
    if !pulsed.is_as_stated {
        remarks.push(format!(
            "by the pulses the receiver's latency is {shortest_ms:.1} ms; [gnss] latency_ms states {:.1} ± {:.1} ms. \
             If that was measured, the kernel may stamp the pulse's other edge",
            1e3 * stated.delay_s,
            1e3 * stated.sigma_s
        ));
    }
    remarks
}

/// The stamps of the start of the recording in which most traces arrived, with its number: each start has a
/// separate host clock.
fn stamps_of(log: &LogContent, traces: &[TraceTime]) -> Option<(usize, Stamps)> {
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
    let stamps = Stamps {
        radio,
        gps: of_start.map(|epoch| (epoch.time, epoch.host_s)).collect(),
        first: traces.first()?.key,
        latency: log.session.latencies(),
    };
    Some((start, stamps))
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

impl Session {
    /// From the radio's pulse, which the receiver may stamp, to the middle of the scan.
    #[must_use]
    pub fn mark_delay(&self) -> Latency {
        let radio = &self.radio;
        within_scan(radio, radio.mark_delay_ms, radio.mark_delay_sigma_ms)
    }

    /// Latency common to all messages of the radio, and to all epochs of the receiver.
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
