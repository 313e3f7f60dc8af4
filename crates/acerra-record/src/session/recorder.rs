//! Recording: the instruments' bytes into the session's log, while someone follows.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::fix_watch::FixWatch;
use super::outcome::LOG_NAME;
use super::outlet::{Item, Outlet, Shared};
use super::progress::{Health, Progress};
use super::pulse_loop::PulseLoop;
use super::radio_loop::RadioLoop;
use super::receiver_loop::{ReceiverLoop, gnss_record};
use super::record_error::RecordError;
use super::settings::{GnssSection, Session, Way};
use super::silence::SilenceWatch;
use super::tap::Tap;
use super::window_watch::WindowWatch;
use crate::driver::{Driver, RequestOptions, WatchOptions, Watched};
use crate::gnss::{ByteSource, SerialSource, Solutions, TcpSource, configuration, configure};
use crate::host::{HostClock, unix_time_s};
use crate::link::{Link, SerialLink, UdpLink};
use crate::log::{LogDamage, LogWriteError, LogWriter, Record, RecordKind};
use crate::pps::PpsSource;

/// Time that the instruments' threads have to end by themselves.
const LONGEST_END: Duration = Duration::from_secs(10);

/// The instruments to record, and the directory.
pub struct Recorder<'a> {
    /// The session.
    pub session: &'a Session,
    /// Text, kept in the log.
    pub text: &'a str,
    /// Directory.
    pub directory: &'a Path,
    /// Ends the recording when set.
    pub stop: &'a AtomicBool,
    /// Waits for the radio.
    pub requests: RequestOptions,
    /// When the radio counts as silent.
    pub watch: WatchOptions,
    /// Further receiver of the records, as they are written; the receiver then sends its own solution with
    /// each measurement.
    pub tap: Option<Tap>,
}

impl Recorder<'_> {
    /// Records until stopped, reporting progress to `follow`. An interrupted session is continued.
    ///
    /// # Errors
    /// Instruments that cannot be set up; a log that cannot be written. Data written before are kept.
    pub fn run(&self, follow: &mut dyn FnMut(Progress)) -> Result<Health, RecordError> {
        let clock = HostClock::start();
        let (mut log, damage) = self.open_log()?;
        if let Some(damage) = damage {
            follow(Progress::Note(format!(
                "going on with {LOG_NAME}; {} bytes of a torn record were cut off its end",
                damage.torn_bytes
            )));
        }
        self.write_settings(&mut log, clock)?;
        let shared = Arc::new(Shared::default());
        let (out, receive) = Outlet::new(&shared);
        let mut threads = vec![self.start_radio(clock, out.clone())?];
        if let Some(section) = &self.session.gnss {
            let pulses = start_pulses(section, clock, &out);
            match pulses.and_then(|thread| {
                threads.extend(thread);
                self.start_gnss(section, clock, out.clone())
            }) {
                Ok(thread) => threads.push(thread),
                Err(error) => {
                    // The radio does not go on without a listener.
                    end(&shared, receive, threads);
                    return Err(error);
                }
            }
        }
        drop(out);
        let mut writing = Writing {
            log,
            clock,
            shared: &shared,
            tap: self.tap.as_ref(),
            follow,
            silences: SilenceWatch::default(),
            warned: Vec::new(),
        };
        let outcome = writing.until_over(&receive, &|| self.is_over(clock));
        end(&shared, receive, threads);
        let health = writing.health();
        outcome?;
        let summary = serde_json::to_vec(&health).unwrap_or_default();
        writing.log.write(&Record {
            kind: RecordKind::End,
            at_ns: clock.now_ns(),
            payload: summary,
        })?;
        writing.log.sync()?;
        Ok(health)
    }

    fn write_settings(&self, log: &mut LogWriter, clock: HostClock) -> Result<(), LogWriteError> {
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
        log.sync()
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

    fn start_radio(&self, clock: HostClock, out: Outlet) -> Result<JoinHandle<()>, RecordError> {
        let radio = &self.session.radio;
        let link: Box<dyn Link + Send> = match radio.way()? {
            Way::Address(address) => Box::new(UdpLink::open(address, clock)?),
            Way::Serial(path) => Box::new(SerialLink::open(path, radio.baud, clock)?),
        };
        let stamped_by = link.stamped_by();
        let mut driver = Driver::new(link, self.requests);
        let status = driver.status()?;
        let watched = Watched::start(driver, radio.setup(), self.watch)?;
        let config = watched.config();
        let announced = format!(
            "radio: {}, serial number {:08X}, package {:?}, {:.1} °C; window {} to {} ps, integration index {}; \
             its messages are stamped {stamped_by}",
            status.model(),
            status.serial_number,
            status.package(),
            status.temperature_c(),
            config.scan_start_ps,
            config.scan_stop_ps,
            config.integration_index
        );
        let loop_over = RadioLoop::new(watched, 1e-3 * radio.scan_interval_ms, clock, out);
        std::thread::Builder::new()
            .name("radio".to_owned())
            .spawn(move || loop_over.run(announced))
            .map_err(RecordError::Thread)
    }

    fn solutions(&self) -> Solutions {
        match self.tap {
            Some(_) => Solutions::EachMeasurement,
            None => Solutions::EachSecond,
        }
    }

    fn start_gnss(
        &self,
        section: &GnssSection,
        clock: HostClock,
        out: Outlet,
    ) -> Result<JoinHandle<()>, RecordError> {
        let mut source: Box<dyn ByteSource> = match section.way()? {
            Way::Address(address) => Box::new(TcpSource::open(address)?),
            Way::Serial(path) => Box::new(SerialSource::open(path, section.baud)?),
        };
        let settings = configuration(section.receiver, section.rate_hz, self.solutions());
        let mut heard = Vec::new();
        configure(&mut *source, &settings, &mut |bytes| {
            heard.push(gnss_record(clock, bytes));
        })?;
        let window = WindowWatch::new(&self.session.radio, &self.session.flight);
        let loop_over = ReceiverLoop::new(source, clock, out, FixWatch::new(window));
        std::thread::Builder::new()
            .name("gnss".to_owned())
            .spawn(move || loop_over.run(heard))
            .map_err(RecordError::Thread)
    }
}

/// Starts the thread of the pulses per second, where there are any.
fn start_pulses(
    section: &GnssSection,
    clock: HostClock,
    out: &Outlet,
) -> Result<Option<JoinHandle<()>>, RecordError> {
    let Some(path) = &section.pps else {
        return Ok(None);
    };
    let loop_over = PulseLoop::new(PpsSource::open(Path::new(path), clock)?, out.clone());
    let thread = std::thread::Builder::new()
        .name("pps".to_owned())
        .spawn(move || loop_over.run())
        .map_err(RecordError::Thread)?;
    Ok(Some(thread))
}

/// Ends the instruments' threads.
fn end(shared: &Shared, receive: Receiver<Item>, threads: Vec<JoinHandle<()>>) {
    shared.end();
    // A full queue would hold the threads back.
    drop(receive);
    for thread in threads {
        // A thread that panicked has printed its message.
        let _ = thread.join();
    }
}

/// The log being written, and who follows.
struct Writing<'a> {
    log: LogWriter,
    clock: HostClock,
    shared: &'a Shared,
    tap: Option<&'a Tap>,
    follow: &'a mut dyn FnMut(Progress),
    silences: SilenceWatch,
    /// Silent instruments, with the time of the last warning.
    warned: Vec<(&'static str, Instant)>,
}

/// Interval between warnings of a silence that lasts.
const WARN_EVERY: Duration = Duration::from_secs(10);

impl Writing<'_> {
    /// Writes the messages of the instruments' threads until the recording is over and the threads have
    /// ended.
    fn until_over(
        &mut self,
        receive: &Receiver<Item>,
        is_over: &dyn Fn() -> bool,
    ) -> Result<(), LogWriteError> {
        let mut reported = Instant::now();
        let mut ended_since: Option<Instant> = None;
        loop {
            match receive.recv_timeout(Duration::from_millis(100)) {
                Ok(item) => self.take(item)?,
                Err(RecvTimeoutError::Timeout) => self.log.sync_if_due()?,
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
            if is_over() {
                self.shared.end();
                // The threads end by themselves; their last messages are still read.
                let since = *ended_since.get_or_insert_with(Instant::now);
                if since.elapsed() > LONGEST_END {
                    return Ok(());
                }
            } else {
                self.warn_of_silence()?;
            }
            if reported.elapsed() >= Duration::from_secs(1) {
                reported = Instant::now();
                let health = self.health();
                (self.follow)(Progress::Health(health));
            }
        }
    }

    /// Warns of each instrument that has fallen silent, and again while it is.
    fn warn_of_silence(&mut self) -> Result<(), LogWriteError> {
        let now = Instant::now();
        let silent = self.silences.silent(now);
        self.warned
            .retain(|(known, _)| silent.iter().any(|one| one.instrument == *known));
        for silence in silent {
            let known = self
                .warned
                .iter_mut()
                .find(|(known, _)| *known == silence.instrument);
            match known {
                Some((_, at)) if at.elapsed() < WARN_EVERY => continue,
                Some((_, at)) => *at = now,
                None => self.warned.push((silence.instrument, now)),
            }
            self.take(Item::Progress(Progress::Warning(silence.to_string())))?;
        }
        Ok(())
    }

    fn take(&mut self, item: Item) -> Result<(), LogWriteError> {
        let progress = match item {
            Item::Record(record) => {
                self.log.write(&record)?;
                self.silences.hear(record.kind, Instant::now());
                if let Some(tap) = self.tap {
                    tap.offer(record, self.clock);
                }
                return Ok(());
            }
            Item::Progress(progress) => progress,
        };
        let (Progress::Note(text) | Progress::Warning(text)) = &progress else {
            return Ok(());
        };
        self.log.write(&Record {
            kind: RecordKind::Note,
            at_ns: self.clock.now_ns(),
            payload: text.clone().into_bytes(),
        })?;
        (self.follow)(progress);
        Ok(())
    }

    fn health(&self) -> Health {
        let mut health = self.shared.health();
        health.elapsed_s = 1e-9 * self.clock.now_ns() as f64;
        health.log_bytes = self.log.bytes();
        health
    }
}
