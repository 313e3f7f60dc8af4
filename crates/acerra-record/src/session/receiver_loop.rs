//! The receiver's thread: writes its bytes to the log, and warns of faults.

use std::time::{Duration, Instant};

use super::fix_watch::FixWatch;
use super::outlet::Outlet;
use super::progress::Progress;
use super::silence::LEAST_SILENCE;
use crate::gnss::ByteSource;
use crate::host::HostClock;
use crate::log::{Record, RecordKind};

/// Time in which bytes in transit are read at the end.
const LAST_BYTES: Duration = Duration::from_millis(500);
/// Time between attempts to reach a receiver that is gone.
const RETRY: Duration = Duration::from_millis(500);

/// The bytes of a receiver as a record of the log.
pub(super) fn gnss_record(clock: HostClock, bytes: &[u8]) -> Record {
    Record {
        kind: RecordKind::Gnss,
        at_ns: clock.now_ns(),
        payload: bytes.to_vec(),
    }
}

/// The receiver's thread. A connection that ends is opened again for as long as it takes.
pub(super) struct ReceiverLoop {
    source: Box<dyn ByteSource>,
    clock: HostClock,
    out: Outlet,
    fix: FixWatch,
    latest: Instant,
    is_silent: bool,
}

impl ReceiverLoop {
    /// A loop over a receiver's bytes, whose fix and height `fix` watches.
    pub fn new(source: Box<dyn ByteSource>, clock: HostClock, out: Outlet, fix: FixWatch) -> Self {
        Self {
            source,
            clock,
            out,
            fix,
            latest: Instant::now(),
            is_silent: false,
        }
    }

    /// Passes on `heard`, the bytes received while the receiver was configured, and further bytes until the
    /// recording is over.
    pub fn run(mut self, heard: Vec<Record>) {
        let heard = heard.into_iter().filter(|r| !r.payload.is_empty());
        if !heard.into_iter().all(|record| self.keep(record)) {
            return;
        }
        let mut buffer = vec![0; 4096];
        let mut ended: Option<Instant> = None;
        loop {
            if self.out.has_ended() {
                // Bytes in transit are still read.
                let since = *ended.get_or_insert_with(Instant::now);
                if since.elapsed() > LAST_BYTES {
                    return;
                }
            }
            let goes_on = match self.source.read(&mut buffer) {
                Ok(0) => ended.is_none() && self.hear_nothing(),
                Ok(bytes) => self.hear(&buffer[..bytes]),
                Err(_) if ended.is_some() => false,
                Err(fault) => self.reopen(&fault.to_string()),
            };
            if !goes_on {
                return;
            }
        }
    }

    fn hear(&mut self, bytes: &[u8]) -> bool {
        self.latest = Instant::now();
        let was_silent = std::mem::take(&mut self.is_silent);
        let note = || Progress::Note("the GNSS receiver sends again".to_owned());
        (!was_silent || self.out.say(note())) && self.keep(gnss_record(self.clock, bytes))
    }

    /// Sends a record, and the fix reported in the record's bytes.
    fn keep(&mut self, record: Record) -> bool {
        let changes = self.fix.take(&record.payload, 1e-9 * record.at_ns as f64);
        let (bytes, fix) = (record.payload.len() as u64, self.fix.latest());
        self.out.update(|health| {
            health.gnss_bytes += bytes;
            health.fix = fix;
        });
        self.out.record(record) && changes.into_iter().all(|progress| self.out.say(progress))
    }

    /// Notices a silence, of which the recorder warns.
    fn hear_nothing(&mut self) -> bool {
        self.is_silent |= self.latest.elapsed() > LEAST_SILENCE;
        true
    }

    fn reopen(&mut self, fault: &str) -> bool {
        let is_told = std::mem::replace(&mut self.is_silent, true);
        if !is_told && !self.out.say(Progress::Warning(fault.to_owned())) {
            return false;
        }
        std::thread::sleep(RETRY);
        // Tried again in the next round.
        let _ = self.source.reopen();
        true
    }
}
