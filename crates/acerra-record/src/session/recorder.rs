//! Recording: the instruments' bytes into the session's log, while someone follows.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde::Serialize;
use thiserror::Error;

use super::outcome::LOG_NAME;
use super::settings::{GnssSection, Session, SettingsError, Way};
use crate::driver::{
    Driver, DriverError, Event, LinkCounts, RequestOptions, WatchOptions, Watched,
};
use crate::gnss::{
    ByteSource, ConfigureError, SerialSource, SourceFault, TcpSource, configuration, configure,
};
use crate::host::{HostClock, unix_time_s};
use crate::link::{Arrival, Link, LinkError, SerialLink, UdpLink};
use crate::log::{LogDamage, LogWriteError, LogWriter, Record, RecordKind};

/// Records that wait for a slow disk: 12 MB of scans, 20 s of usual ones.
const QUEUE_RECORDS: usize = 8_192;
/// Time without bytes after which a receiver counts as silent.
const GNSS_SILENCE: Duration = Duration::from_secs(3);
/// Time over which lost scans are judged.
const LOSS_JUDGED_EVERY: Duration = Duration::from_secs(10);
/// Time in which bytes on their way are taken in at the end.
const LAST_BYTES: Duration = Duration::from_millis(500);
/// Modulus of a sample relative to the largest that the radio can send (2^PII × 2^15) from which
/// a scan counts as saturated.
const SATURATED_SHARE: f64 = 0.95;

/// Why a recording cannot begin, or ends.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RecordError {
    /// The radio.
    #[error(transparent)]
    Radio(#[from] DriverError),
    /// The way to the radio.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// The way to the receiver.
    #[error(transparent)]
    Gnss(#[from] SourceFault),
    /// The receiver's settings.
    #[error(transparent)]
    Configure(#[from] ConfigureError),
    /// The session does not say where an instrument is.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The log.
    #[error(transparent)]
    Log(#[from] LogWriteError),
    /// The directory.
    #[error("{}: {cause}", path.display())]
    Directory {
        /// The directory.
        path: PathBuf,
        /// What the system says.
        cause: std::io::Error,
    },
    /// The system gives no thread.
    #[error("cannot start a thread: {0}")]
    Thread(std::io::Error),
}

/// What a recording tells while it goes on.
#[derive(Clone, Debug, PartialEq)]
pub enum Progress {
    /// What happened, in words.
    Note(String),
    /// Something is wrong: worth a beep.
    Warning(String),
    /// The state, about once a second.
    Health(Health),
}

/// The state of a recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Health {
    /// Seconds since its beginning.
    pub elapsed_s: f64,
    /// The account of the radio's link.
    pub radio: LinkCounts,
    /// Interval between scans by the radio's clock (s).
    pub scan_interval_s: f64,
    /// Temperature of the radio (°C), where it told it.
    pub temperature_c: Option<f64>,
    /// Bytes of the receiver.
    pub gnss_bytes: u64,
    /// Scans with saturated samples.
    pub saturated_scans: u64,
    /// Bytes of the log.
    pub log_bytes: u64,
}

/// What is recorded, and where.
pub struct Recorder<'a> {
    /// The session.
    pub session: &'a Session,
    /// Its text, kept in the log.
    pub text: &'a str,
    /// Its directory.
    pub directory: &'a Path,
    /// Ends the recording when set.
    pub stop: &'a AtomicBool,
    /// Waits for the radio.
    pub requests: RequestOptions,
    /// When the radio counts as silent.
    pub watch: WatchOptions,
}

/// What the instruments' threads send.
enum Item {
    Record(Record),
    Progress(Progress),
}

/// State that the radio's thread shares.
#[derive(Default)]
struct Shared {
    ended: AtomicBool,
    health: Mutex<Health>,
}

impl Shared {
    fn count_gnss(&self, bytes: usize) {
        let mut health = self.health.lock().unwrap_or_else(PoisonError::into_inner);
        health.gnss_bytes += bytes as u64;
    }
}

impl Recorder<'_> {
    /// Records until stopped, told to `follow`. A session that was interrupted is gone on with.
    ///
    /// # Errors
    /// Instruments that cannot be set up; a log that cannot be written. What was written before is
    /// kept.
    pub fn run(&self, follow: &mut dyn FnMut(Progress)) -> Result<Health, RecordError> {
        let clock = HostClock::start();
        let (mut log, damage) = self.open_log()?;
        if let Some(damage) = damage {
            follow(Progress::Note(format!(
                "going on with {LOG_NAME}; {} bytes of a torn record were cut off its end",
                damage.torn_bytes
            )));
        }
        let settings = format!(
            "# begun at {:.3} s since 1970\n{}",
            unix_time_s(),
            self.text
        );
        log.write(&Record {
            kind: RecordKind::Settings,
            at_ns: clock.now_ns(),
            payload: settings.into_bytes(),
        })?;
        log.sync()?;
        let (send, receive) = sync_channel(QUEUE_RECORDS);
        let shared = Arc::new(Shared::default());
        let radio = self.start_radio(clock, send.clone(), &shared)?;
        let gnss = match &self.session.gnss {
            Some(section) => match self.start_gnss(section, clock, send, &shared) {
                Ok(thread) => Some(thread),
                Err(error) => {
                    // The radio does not go on without a listener.
                    shared.ended.store(true, Ordering::SeqCst);
                    drop(receive);
                    let _ = radio.join();
                    return Err(error);
                }
            },
            None => {
                drop(send);
                None
            }
        };
        let mut outcome: Result<(), LogWriteError> = Ok(());
        let mut told = Instant::now();
        let mut ended_since: Option<Instant> = None;
        loop {
            match receive.recv_timeout(Duration::from_millis(100)) {
                Ok(Item::Record(record)) => outcome = log.write(&record),
                Ok(Item::Progress(progress)) => {
                    let (Progress::Note(text) | Progress::Warning(text)) = &progress else {
                        continue;
                    };
                    let record = Record {
                        kind: RecordKind::Note,
                        at_ns: clock.now_ns(),
                        payload: text.clone().into_bytes(),
                    };
                    outcome = log.write(&record);
                    follow(progress);
                }
                Err(RecvTimeoutError::Timeout) => outcome = log.sync_if_due(),
                Err(RecvTimeoutError::Disconnected) => break,
            }
            if outcome.is_err() || self.is_over(clock) {
                shared.ended.store(true, Ordering::SeqCst);
                // The threads end by themselves; what they still send is taken in.
                let since = *ended_since.get_or_insert_with(Instant::now);
                if outcome.is_err() || since.elapsed() > Duration::from_secs(10) {
                    break;
                }
            }
            if told.elapsed() >= Duration::from_secs(1) {
                told = Instant::now();
                follow(Progress::Health(self.health(&shared, clock, &log)));
            }
        }
        shared.ended.store(true, Ordering::SeqCst);
        // A full queue would hold the threads back.
        drop(receive);
        for thread in [Some(radio), gnss].into_iter().flatten() {
            // A thread that panicked has said so itself.
            let _ = thread.join();
        }
        let health = self.health(&shared, clock, &log);
        outcome?;
        let summary = serde_json::to_vec(&health).unwrap_or_default();
        log.write(&Record {
            kind: RecordKind::End,
            at_ns: clock.now_ns(),
            payload: summary,
        })?;
        log.sync()?;
        Ok(health)
    }

    fn is_over(&self, clock: HostClock) -> bool {
        let limit_s = self.session.flight.stop_after_s;
        self.stop.load(Ordering::SeqCst)
            || limit_s.is_some_and(|limit_s| 1e-9 * clock.now_ns() as f64 >= limit_s)
    }

    fn open_log(&self) -> Result<(LogWriter, Option<LogDamage>), RecordError> {
        std::fs::create_dir_all(self.directory).map_err(|cause| RecordError::Directory {
            path: self.directory.to_owned(),
            cause,
        })?;
        let path = self.directory.join(LOG_NAME);
        if path.exists() {
            let (log, damage) = LogWriter::resume(&path)?;
            return Ok((log, Some(damage)));
        }
        Ok((LogWriter::create(&path)?, None))
    }

    fn health(&self, shared: &Shared, clock: HostClock, log: &LogWriter) -> Health {
        let mut health = *shared.health.lock().unwrap_or_else(PoisonError::into_inner);
        health.elapsed_s = 1e-9 * clock.now_ns() as f64;
        health.log_bytes = log.bytes();
        health
    }

    fn start_radio(
        &self,
        clock: HostClock,
        send: SyncSender<Item>,
        shared: &Arc<Shared>,
    ) -> Result<std::thread::JoinHandle<()>, RecordError> {
        let radio = &self.session.radio;
        let link: Box<dyn Link + Send> = match radio.way()? {
            Way::Address(address) => Box::new(UdpLink::open(address, clock)?),
            Way::Serial(path) => Box::new(SerialLink::open(path, radio.baud, clock)?),
        };
        let mut driver = Driver::new(link, self.requests);
        let status = driver.status()?;
        let watched = Watched::start(driver, radio.setup(), self.watch)?;
        let config = watched.config();
        let announced = format!(
            "radio: {}, serial number {:08X}, package {:?}, {:.1} °C; window {} to {} ps, integration index {}",
            status.model(),
            status.serial_number,
            status.package(),
            status.temperature_c(),
            config.scan_start_ps,
            config.scan_stop_ps,
            config.integration_index
        );
        let shared = Arc::clone(shared);
        let loop_over = RadioLoop {
            watched,
            clock,
            send,
            shared,
            interval_s: 1e-3 * radio.scan_interval_ms,
            is_saturated: false,
            judged: ([0; 2], Instant::now()),
        };
        std::thread::Builder::new()
            .name("radio".to_owned())
            .spawn(move || loop_over.run(announced))
            .map_err(RecordError::Thread)
    }

    fn start_gnss(
        &self,
        section: &GnssSection,
        clock: HostClock,
        send: SyncSender<Item>,
        shared: &Arc<Shared>,
    ) -> Result<std::thread::JoinHandle<()>, RecordError> {
        let mut source: Box<dyn ByteSource> = match section.way()? {
            Way::Address(address) => Box::new(TcpSource::open(address)?),
            Way::Serial(path) => Box::new(SerialSource::open(path, section.baud)?),
        };
        let settings = configuration(section.receiver, section.rate_hz);
        let shared = Arc::clone(shared);
        let mut heard = Vec::new();
        configure(&mut *source, &settings, &mut |bytes| {
            heard.push(gnss_record(clock, bytes));
        })?;
        std::thread::Builder::new()
            .name("gnss".to_owned())
            .spawn(move || {
                let records = heard.into_iter().filter(|r| !r.payload.is_empty());
                for record in records {
                    shared.count_gnss(record.payload.len());
                    if send.send(Item::Record(record)).is_err() {
                        return;
                    }
                }
                log_gnss(source, clock, &send, &shared);
            })
            .map_err(RecordError::Thread)
    }
}

fn gnss_record(clock: HostClock, bytes: &[u8]) -> Record {
    Record {
        kind: RecordKind::Gnss,
        at_ns: clock.now_ns(),
        payload: bytes.to_vec(),
    }
}

/// The radio's thread.
struct RadioLoop {
    watched: Watched<Box<dyn Link + Send>>,
    clock: HostClock,
    send: SyncSender<Item>,
    shared: Arc<Shared>,
    interval_s: f64,
    /// Whether saturation was told.
    is_saturated: bool,
    /// Scans made and scans not whole, when loss was last judged, and when that was.
    judged: ([u64; 2], Instant),
}

impl RadioLoop {
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
        self.say(Progress::Warning(format!(
            "{missing} of the last {made} scans did not come whole; is the disk slow, the link busy?"
        )))
    }

    fn run(mut self, announced: String) {
        let config = self.watched.config();
        let begun = self.say(Progress::Note(announced)) && self.config_record();
        let largest = f64::from(1_u32 << config.integration_index.min(15)) * 32_768.0;
        let mut is_slow_told = false;
        while begun && !self.shared.ended.load(Ordering::SeqCst) {
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
                self.say(Progress::Warning(format!(
                    "the radio makes a scan each {:.1} ms; {:.1} ms were asked for",
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
            Event::Message(Arrival { at_ns, body, .. }) => self
                .send
                .send(Item::Record(Record {
                    kind: RecordKind::Radio,
                    at_ns,
                    payload: body,
                }))
                .is_ok(),
            Event::Scan(scan) => {
                let peak = scan.samples.iter().map(|s| s.unsigned_abs()).max();
                let is_saturated = f64::from(peak.unwrap_or(0)) >= SATURATED_SHARE * largest;
                self.update(|health| health.saturated_scans += u64::from(is_saturated));
                let is_first = is_saturated && !std::mem::replace(&mut self.is_saturated, true);
                !is_first
                    || self.say(Progress::Warning(
                        "scans are saturated ([radio] integration_index, transmit_gain)".to_owned(),
                    ))
            }
            Event::Status(status) => {
                self.update(|health| health.temperature_c = Some(status.temperature_c()));
                true
            }
            Event::Silent(why) => self.say(Progress::Warning(why)),
            Event::Resumed { after_s, restarted } => {
                let how = if restarted {
                    "; it was started anew"
                } else {
                    ""
                };
                self.say(Progress::Note(format!(
                    "the radio scans again after {after_s:.1} s{how}"
                ))) && self.config_record()
            }
        }
    }

    fn update(&mut self, change: impl FnOnce(&mut Health)) {
        let (counts, interval_s) = (self.watched.counts(), self.watched.interval_s());
        let mut health = self
            .shared
            .health
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        (health.radio, health.scan_interval_s) = (counts, interval_s);
        change(&mut health);
    }

    fn config_record(&self) -> bool {
        let record = Record {
            kind: RecordKind::RadioConfig,
            at_ns: self.clock.now_ns(),
            payload: self.watched.config().to_bytes().to_vec(),
        };
        self.send.send(Item::Record(record)).is_ok()
    }

    fn say(&self, progress: Progress) -> bool {
        self.send.send(Item::Progress(progress)).is_ok()
    }
}

/// The receiver's thread: bytes into the log; a connection that ends is opened anew for as long as
/// it takes.
fn log_gnss(
    mut source: Box<dyn ByteSource>,
    clock: HostClock,
    send: &SyncSender<Item>,
    shared: &Shared,
) {
    let mut buffer = vec![0; 4096];
    let mut latest = Instant::now();
    let mut is_silent = false;
    let say = |progress| send.send(Item::Progress(progress)).is_ok();
    let mut ended: Option<Instant> = None;
    loop {
        if shared.ended.load(Ordering::SeqCst) {
            // What is on its way is still taken in.
            let since = *ended.get_or_insert_with(Instant::now);
            if since.elapsed() > LAST_BYTES {
                return;
            }
        }
        match source.read(&mut buffer) {
            Ok(0) if ended.is_some() => return,
            Ok(0) if !is_silent && latest.elapsed() > GNSS_SILENCE => {
                is_silent = true;
                let seconds = latest.elapsed().as_secs();
                if !say(Progress::Warning(format!(
                    "no byte from the GNSS receiver for {seconds} s"
                ))) {
                    return;
                }
            }
            Ok(0) => {}
            Ok(bytes) => {
                if std::mem::take(&mut is_silent)
                    && !say(Progress::Note("the GNSS receiver sends again".to_owned()))
                {
                    return;
                }
                latest = Instant::now();
                let record = gnss_record(clock, &buffer[..bytes]);
                if send.send(Item::Record(record)).is_err() {
                    return;
                }
                shared.count_gnss(bytes);
            }
            Err(_) if ended.is_some() => return,
            Err(fault) => {
                if !std::mem::replace(&mut is_silent, true)
                    && !say(Progress::Warning(fault.to_string()))
                {
                    return;
                }
                std::thread::sleep(Duration::from_millis(500));
                // Tried again in the next round.
                let _ = source.reopen();
            }
        }
    }
}
