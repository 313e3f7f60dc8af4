//! The thread of the pulses per second: writes each to the log, and warns of faults.

use std::time::{Duration, Instant};

use super::outlet::Outlet;
use super::progress::Progress;
use crate::log::{Record, RecordKind};
use crate::pps::{POLL_EVERY, Poll, PpsSource, PulseStamp};

/// Time without a pulse after which a warning is given.
const SILENCE: Duration = Duration::from_secs(3);

/// The thread of the pulses.
pub(super) struct PulseLoop {
    source: PpsSource,
    out: Outlet,
    latest: Instant,
    /// The fault last reported, while the fault lasts.
    trouble: Option<Trouble>,
    /// Whether a pulse without host time was reported.
    is_step_reported: bool,
    /// Whether an inverted wire was reported.
    is_inversion_reported: bool,
}

#[derive(Clone, Copy, PartialEq)]
enum Trouble {
    Silent,
    Unreadable,
}

impl PulseLoop {
    /// A loop over the pulses of a device.
    pub fn new(source: PpsSource, out: Outlet) -> Self {
        Self {
            source,
            out,
            latest: Instant::now(),
            trouble: None,
            is_step_reported: false,
            is_inversion_reported: false,
        }
    }

    /// Passes on pulses until the recording is over.
    pub fn run(mut self) {
        let path = self.source.path().display();
        let begun = format!("pulses per second are read from {path}");
        let mut goes_on = self.out.say(Progress::Note(begun));
        while goes_on && !self.out.has_ended() {
            std::thread::sleep(POLL_EVERY);
            goes_on = match self.source.poll() {
                Ok(Poll::Nothing) => self.hear_nothing(),
                Ok(Poll::Pulse {
                    stamp,
                    host_ns,
                    missed,
                }) => self.hear(stamp, host_ns, missed),
                Err(fault) => self.report(Trouble::Unreadable, fault.to_string()),
            };
        }
    }

    fn hear(&mut self, stamp: PulseStamp, host_ns: Option<u64>, missed: u32) -> bool {
        self.latest = Instant::now();
        self.out.update(|health| {
            health.pulses += 1;
            health.missed_pulses += u64::from(missed);
        });
        if self.trouble.take().is_some() {
            let message = Progress::Note("pulses per second come again".to_owned());
            if !self.out.say(message) {
                return false;
            }
        }
        if !self.is_inversion_reported
            && let Some(high) = self.source.inverted(stamp)
        {
            self.is_inversion_reported = true;
            let message = Progress::Warning(format!(
                "the pulse per second is high for {:.2} s of each second: the wire is inverted, or the wrong edge is \
                 stamped (assert_falling_edge of pps-gpio), and GPS time off by the pulse's width",
                high.as_secs_f64()
            ));
            if !self.out.say(message) {
                return false;
            }
        }
        let Some(at_ns) = host_ns else {
            return self.report_step();
        };
        self.out.record(Record {
            kind: RecordKind::Pulse,
            at_ns,
            payload: stamp.to_string().into_bytes(),
        })
    }

    /// The calendar clock, which the kernel stamps pulses by, was set.
    fn report_step(&mut self) -> bool {
        if std::mem::replace(&mut self.is_step_reported, true) {
            return true;
        }
        let text = "the computer's calendar clock is being set: pulses about that are not used";
        self.out.say(Progress::Warning(text.to_owned()))
    }

    fn hear_nothing(&mut self) -> bool {
        let since = self.latest.elapsed();
        if since <= SILENCE {
            return true;
        }
        let path = self.source.path().display();
        let text = format!("no pulse at {path} for {} s", since.as_secs());
        self.report(Trouble::Silent, text)
    }

    /// Reports a fault once.
    fn report(&mut self, trouble: Trouble, text: String) -> bool {
        let is_new = self.trouble.replace(trouble) != Some(trouble);
        !is_new || self.out.say(Progress::Warning(text))
    }
}
