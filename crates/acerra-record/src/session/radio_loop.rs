//! The radio's thread: writes its messages to the log, and warns of faults.

use std::time::{Duration, Instant};

use super::outlet::Outlet;
use super::progress::{Health, Progress};
use crate::driver::{Event, Watched};
use crate::host::HostClock;
use crate::link::{Link, StampedBy};
use crate::log::{Record, RecordKind};

/// Time over which lost scans are judged.
const LOSS_JUDGED_EVERY: Duration = Duration::from_secs(10);
/// Modulus of a sample relative to the largest that the radio can send (2^PII × 2^15) from which
/// a scan counts as saturated.
const SATURATED_SHARE: f64 = 0.95;

/// The radio's thread.
pub(super) struct RadioLoop {
    watched: Watched<Box<dyn Link + Send>>,
    clock: HostClock,
    out: Outlet,
    interval_s: f64,
    /// Whether saturation was reported.
    is_saturated: bool,
    /// Scans made and scans not whole, when loss was last judged, and when that was.
    judged: ([u64; 2], Instant),
}

impl RadioLoop {
    /// A loop over a radio that scans, with `interval_s` if one was set.
    pub fn new(
        watched: Watched<Box<dyn Link + Send>>,
        interval_s: f64,
        clock: HostClock,
        out: Outlet,
    ) -> Self {
        Self {
            watched,
            clock,
            out,
            interval_s,
            is_saturated: false,
            judged: ([0; 2], Instant::now()),
        }
    }

    /// Warns where more than a twentieth of the last ten seconds' scans did not come whole; `false` when
    /// the recording is over.
    fn warn_of_loss(&mut self) -> bool {
        let ([made_before, missing_before], at) = self.judged;
        if at.elapsed() < LOSS_JUDGED_EVERY {
            return true;
        }
        let counts = self.watched.counts();
        let now = [
            counts.scans_made(),
            counts.lost_scans + counts.incomplete_scans,
        ];
        self.judged = (now, Instant::now());
        let (made, missing) = (now[0] - made_before, now[1].saturating_sub(missing_before));
        if made == 0 || missing * 20 <= made {
            return true;
        }
        self.out.say(Progress::Warning(format!(
            "{missing} of the last {made} scans did not come whole; is the disk slow, the link busy?"
        )))
    }

    /// Passes on messages until the recording is over, and stops the radio.
    pub fn run(mut self, announced: String) {
        let config = self.watched.config();
        let begun = self.out.say(Progress::Note(announced)) && self.config_record();
        let largest = f64::from(1_u32 << config.integration_index.min(15)) * 32_768.0;
        let mut is_slow_told = false;
        while begun && !self.out.has_ended() {
            let Some(event) = self.watched.next_event(Duration::from_millis(50)) else {
                continue;
            };
            if !self.handle(event, largest) || !self.warn_of_loss() {
                break;
            }
            let interval_s = self.watched.interval_s();
            let scans = self.watched.counts().whole_scans;
            if !is_slow_told
                && scans > 20
                && self.interval_s > 0.0
                && interval_s > 1.1 * self.interval_s
            {
                is_slow_told = true;
                self.out.say(Progress::Warning(format!(
                    "the radio makes a scan each {:.1} ms; {:.1} ms were set",
                    1e3 * interval_s,
                    1e3 * self.interval_s
                )));
            }
        }
        for event in self.watched.stop() {
            self.handle(event, largest);
        }
        self.update(|_| {});
    }

    /// Passes an event on; `false` when the recording is over.
    fn handle(&mut self, event: Event, largest: f64) -> bool {
        match event {
            Event::Message(arrival) => {
                if arrival.stamped_by == StampedBy::Kernel {
                    self.out.update(|health| health.kernel_stamped += 1);
                }
                self.out.record(Record {
                    kind: RecordKind::Radio,
                    at_ns: arrival.at_ns,
                    payload: arrival.body,
                })
            }
            Event::Scan(scan) => {
                let peak = scan.samples.iter().map(|s| s.unsigned_abs()).max();
                let is_saturated = f64::from(peak.unwrap_or(0)) >= SATURATED_SHARE * largest;
                self.update(|health| health.saturated_scans += u64::from(is_saturated));
                let is_first = is_saturated && !std::mem::replace(&mut self.is_saturated, true);
                !is_first
                    || self.out.say(Progress::Warning(
                        "scans are saturated ([radio] integration_index, transmit_gain)".to_owned(),
                    ))
            }
            Event::Status(status) => {
                self.update(|health| health.temperature_c = Some(status.temperature_c()));
                true
            }
            Event::Silent(why) => self.out.say(Progress::Warning(why)),
            Event::Resumed { after_s, restarted } => {
                let how = if restarted {
                    "; it was started again"
                } else {
                    ""
                };
                self.out.say(Progress::Note(format!(
                    "the radio scans again after {after_s:.1} s{how}"
                ))) && self.config_record()
            }
        }
    }

    fn update(&mut self, change: impl FnOnce(&mut Health)) {
        let (counts, interval_s) = (self.watched.counts(), self.watched.interval_s());
        self.out.update(|health| {
            (health.radio, health.scan_interval_s) = (counts, interval_s);
            change(health);
        });
    }

    fn config_record(&self) -> bool {
        let record = Record {
            kind: RecordKind::RadioConfig,
            at_ns: self.clock.now_ns(),
            payload: self.watched.config().to_bytes().to_vec(),
        };
        self.out.record(record)
    }
}
